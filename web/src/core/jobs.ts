// Work in workers: one makes tables, one lets a film flow. The newest request wins; what takes too long is ended with
// its worker, which comes back in some ten milliseconds.

import type { FilmState, ColorTable, TableRequest } from "./core";
import { loadStored, makeWorker } from "./load";
import { type StoredTable, storedFor, unpackTable } from "./stored";

export type Request =
  | { kind: "module"; module: WebAssembly.Module }
  | { kind: "table"; id: number; request: TableRequest }
  | { kind: "swirls"; id: number; min_nm: number; max_nm: number; seed: number }
  | { kind: "flow-start"; id: number; preset: string; changes: Record<string, number>; columns: number; seed: number; time_s: number }
  | { kind: "flow-advance"; id: number; time_s: number }
  | { kind: "flow-change"; name: string; value: number }
  | { kind: "flow-stir"; place: [number, number]; speed: [number, number]; radius_m: number };

export type Reply =
  | { kind: "table"; id: number; table: ColorTable; seconds: number }
  | { kind: "swirls"; id: number; values: Float32Array; columns: number; rows: number }
  | { kind: "film"; id: number; film: FilmState; seconds: number }
  | { kind: "error"; id: number; message: string; broken: boolean };

interface Waiting {
  resolve: (reply: Reply) => void;
  reject: (error: Error) => void;
}

/** One worker with the core in it. */
export class Job {
  private worker: Worker | null = null;
  private waiting = new Map<number, Waiting>();
  private next = 1;

  constructor(private readonly module: WebAssembly.Module) {}

  private started(): Worker {
    if (this.worker) return this.worker;
    const worker = makeWorker();
    worker.onmessage = (event: MessageEvent<Reply>) => {
      const reply = event.data;
      const waiting = this.waiting.get(reply.id);
      this.waiting.delete(reply.id);
      if (reply.kind === "error") {
        if (reply.broken) this.stop();
        waiting?.reject(new Error(reply.message));
      } else waiting?.resolve(reply);
    };
    worker.onerror = (event) => {
      const failed = [...this.waiting.values()];
      this.stop();
      for (const waiting of failed) waiting.reject(new Error(event.message || "a worker stopped"));
    };
    worker.postMessage({ kind: "module", module: this.module } satisfies Request);
    this.worker = worker;
    return worker;
  }

  get busy(): boolean {
    return this.waiting.size > 0;
  }

  /** Ends what is being done; nobody hears of it again. */
  stop(): void {
    this.worker?.terminate();
    this.worker = null;
    this.waiting.clear();
  }

  send(request: Request): void {
    this.started().postMessage(request);
  }

  ask<K extends Reply["kind"]>(request: Request & { id: number }): Promise<Extract<Reply, { kind: K }>> {
    const id = this.next++;
    const promise = new Promise<Reply>((resolve, reject) => this.waiting.set(id, { resolve, reject }));
    this.started().postMessage({ ...request, id });
    return promise as Promise<Extract<Reply, { kind: K }>>;
  }
}

/** Tables kept: a page goes back and forth between a few lamps and films. */
const KEPT = 16;

/** Colour tables: those kept, those that came with the page, those made now. */
export class Tables {
  private kept = new Map<string, ColorTable>();
  private job: Job;
  /** Every table that was made: what it was and how long it took. */
  made: { key: string; seconds: number }[] = [];

  constructor(module: WebAssembly.Module, private readonly stored: readonly StoredTable[]) {
    this.job = new Job(module);
  }

  static key(request: TableRequest): string {
    const { stack, layer, illuminant, range_nm, range_deg, max_delta_e } = request;
    return [stack, layer, illuminant, range_nm, range_deg, max_delta_e].join("|");
  }

  find(request: TableRequest): ColorTable | undefined {
    return this.kept.get(Tables.key(request));
  }

  /** The table asked for; an earlier request that is still being worked at is given up. */
  async get(request: TableRequest): Promise<ColorTable | null> {
    const key = Tables.key(request);
    const kept = this.kept.get(key);
    if (kept) return kept;
    const stored = storedFor(this.stored, request);
    if (stored) {
      const bytes = await loadStored(stored.name);
      if (bytes) return this.keep(key, unpackTable(bytes, stored));
    }
    if (this.job.busy) this.job.stop();
    const reply = await this.job.ask<"table">({ kind: "table", id: 0, request });
    this.made.push({ key, seconds: reply.seconds });
    return this.keep(key, reply.table);
  }

  private keep(key: string, table: ColorTable): ColorTable {
    this.kept.set(key, table);
    while (this.kept.size > KEPT) this.kept.delete(this.kept.keys().next().value as string);
    return table;
  }
}
