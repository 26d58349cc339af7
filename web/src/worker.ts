// A worker with the core in it: tables, swirls, films that flow.

import { Core, CoreBroken } from "./core/core";
import type { Reply, Request } from "./core/jobs";

const scope = self as unknown as {
  onmessage: ((event: MessageEvent<Request>) => void) | null;
  postMessage(message: Reply, transfer: Transferable[]): void;
};

let core: Promise<Core> | null = null;
/** Swirls are 512 x 512 and smooth: every other place is enough for a picture. */
const SWIRLS = 512;

function seconds(since: number): number {
  return (performance.now() - since) / 1000;
}

async function work(request: Request): Promise<void> {
  if (request.kind === "module") {
    core = Core.from(request.module);
    return;
  }
  if (!core) throw new Error("the worker has no core yet");
  const own = await core;
  const start = performance.now();
  switch (request.kind) {
    case "table": {
      const table = own.table(request.request);
      scope.postMessage({ kind: "table", id: request.id, table, seconds: seconds(start) }, [table.nodes.buffer]);
      break;
    }
    case "swirls": {
      const numbers = [request.min_nm, request.max_nm, request.seed];
      const values = Float32Array.from(own.call("thickness_swirls", "", numbers).result);
      scope.postMessage({ kind: "swirls", id: request.id, values, columns: SWIRLS, rows: SWIRLS }, [values.buffer]);
      break;
    }
    case "flow-start": {
      let film = own.flowStart(request.preset, request.changes, request.columns, request.seed);
      if (request.time_s > 0) film = own.flowAdvance(request.time_s);
      scope.postMessage({ kind: "film", id: request.id, film, seconds: seconds(start) }, [film.thickness_nm.buffer]);
      break;
    }
    case "flow-advance": {
      const film = own.flowAdvance(request.time_s);
      scope.postMessage({ kind: "film", id: request.id, film, seconds: seconds(start) }, [film.thickness_nm.buffer]);
      break;
    }
    case "flow-change":
      own.call("flow_change", request.name, [request.value]);
      break;
    case "flow-stir":
      own.call("flow_stir", "", [...request.place, ...request.speed, request.radius_m]);
      break;
  }
}

scope.onmessage = (event) => {
  const request = event.data;
  work(request).catch((error: unknown) => {
    const message = error instanceof Error ? error.message : String(error);
    const id = "id" in request ? request.id : 0;
    scope.postMessage({ kind: "error", id, message, broken: error instanceof CoreBroken }, []);
  });
};
