// A static host for tests and for looking: node web/tools/serve.mjs [folder] [port]. Answers GET only, keeps a list of what was asked.

import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { extname, join, normalize } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

const TYPES = { ".html": "text/html; charset=utf-8", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm", ".bin": "application/octet-stream", ".json": "application/json" };

export function serve(folder, port = 0, headers = {}) {
  const asked = [];
  const server = createServer(async (request, response) => {
    const path = decodeURIComponent(new URL(request.url, "http://localhost").pathname);
    asked.push(path);
    try {
      const body = await readFile(join(folder, normalize(path === "/" ? "/index.html" : path)));
      response.writeHead(200, { ...headers, "content-type": TYPES[extname(path === "/" ? ".html" : path)] ?? TYPES[".html"] });
      response.end(body);
    } catch {
      response.writeHead(404).end("not found");
    }
  });
  return new Promise((resolve) => server.listen(port, "127.0.0.1", () => resolve({ server, asked, url: `http://localhost:${server.address().port}` })));
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const folder = process.argv[2] ?? fileURLToPath(new URL("../dist", import.meta.url));
  const { url } = await serve(folder, Number(process.argv[3] ?? 8000));
  console.log(url);
}
