// Where the core and the worker come from: files beside the page, or texts inside the one file.

function embedded(id: string): string | null {
  return document.getElementById(id)?.textContent?.trim() || null;
}

function bytesOf(base64: string): Uint8Array<ArrayBuffer> {
  const binary = atob(base64);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

async function unpacked(bytes: Uint8Array<ArrayBuffer>): Promise<ArrayBuffer> {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

/** The core, compiled once and shared with the workers. */
export async function loadModule(): Promise<WebAssembly.Module> {
  const inside = embedded("iridesce-core");
  if (inside) return WebAssembly.compile(await unpacked(bytesOf(inside)));
  const response = await fetch("./iridesce.wasm");
  if (!response.ok) throw new Error(`iridesce.wasm: ${response.status} ${response.statusText}`);
  // Compiled while it comes, unless the host serves .wasm under another type.
  if (response.headers.get("content-type") === "application/wasm") return WebAssembly.compileStreaming(response);
  return WebAssembly.compile(await response.arrayBuffer());
}

/** A stored table (web/tools/build.mjs), or nothing. */
export async function loadStored(name: string): Promise<ArrayBuffer | null> {
  const inside = embedded(`iridesce-table-${name}`);
  if (inside) return unpacked(bytesOf(inside));
  if (embedded("iridesce-core")) return null;
  const response = await fetch(`./tables/${name}.bin`);
  return response.ok ? response.arrayBuffer() : null;
}

export function makeWorker(): Worker {
  const inside = embedded("iridesce-worker");
  if (!inside) return new Worker("./worker.js");
  const url = URL.createObjectURL(new Blob([inside], { type: "text/javascript" }));
  const worker = new Worker(url);
  URL.revokeObjectURL(url);
  return worker;
}
