// Builds the page: web/dist/ (a folder for any static host) and web/dist/iridesce.html (one file, from disk).
// The core comes from `make web` (cargo, wasm32-unknown-unknown); WASM=path takes another.

import { createHash } from "node:crypto";
import { existsSync, mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { execFileSync } from "node:child_process";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { brotliCompressSync, constants, gzipSync } from "node:zlib";
import { build } from "vite";

const web = dirname(dirname(fileURLToPath(import.meta.url)));
const dist = join(web, "dist");
const raw = process.env.WASM ?? join(web, "..", "target", "wasm32-unknown-unknown", "web", "iridesce_web.wasm");

/** wasm-opt of the npm package binaryen; its answer is kept beside its question. */
function optimised(path) {
  const bytes = readFileSync(path);
  const digest = createHash("sha256").update(bytes).digest("hex").slice(0, 16);
  const kept = join(web, "node_modules", ".cache", `iridesce-${digest}.wasm`);
  if (existsSync(kept)) return readFileSync(kept);
  mkdirSync(dirname(kept), { recursive: true });
  const tool = join(web, "node_modules", "binaryen", "bin", "wasm-opt");
  const features = ["--enable-simd", "--enable-bulk-memory", "--enable-sign-ext", "--enable-nontrapping-float-to-int", "--enable-mutable-globals", "--enable-reference-types", "--enable-multivalue"];
  // No --fast-math and the like: digits must stay.
  execFileSync(process.execPath, [tool, ...features, "-O3", "--strip-debug", "--strip-producers", path, "-o", kept], { stdio: "inherit" });
  return readFileSync(kept);
}

async function bundle(entry, name, define, format = "iife") {
  const result = await build({
    root: web,
    configFile: false,
    logLevel: "warn",
    define: { "process.env.NODE_ENV": '"production"', ...define },
    build: {
      write: false,
      target: "es2022",
      minify: true,
      lib: { entry: join(web, "src", entry), formats: [format], name },
      rollupOptions: { output: { extend: true } },
    },
  });
  const [{ output }] = [result].flat();
  return output.find((chunk) => chunk.type === "chunk").code.trim();
}

const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;
/** A script's text may not end its element. */
const inside = (code) => code.replaceAll("</script", "<\\/script");
const brotli = (data) => brotliCompressSync(data, { params: { [constants.BROTLI_PARAM_QUALITY]: 11 } }).length;

mkdirSync(join(web, "node_modules", ".cache"), { recursive: true });
const wasm = process.env.IRIDESCE_NO_WASM_OPT ? readFileSync(raw) : optimised(raw);
const tables = await import("./tables.mjs").then((module) => module.storedTables(wasm));
const define = { __STORED__: JSON.stringify(tables.map(({ entry }) => entry)) };
const script = await bundle("main.ts", "iridescePage", define);
const worker = await bundle("worker.ts", "iridesceWorker", {});
const css = readFileSync(join(web, "src", "style.css"), "utf8").replace(/\s*\n\s*/g, "\n").trim();
const page = readFileSync(join(web, "index.html"), "utf8");

function fill(parts) {
  let text = page.replace(/\n\n+/g, "\n"); // (not afterwards: the hashes are those of the scripts as they stand)
  for (const [name, value] of Object.entries(parts)) text = text.replace(`%${name}%`, () => value);
  return text;
}

rmSync(dist, { recursive: true, force: true });
mkdirSync(join(dist, "tables"), { recursive: true });
writeFileSync(join(dist, "iridesce.wasm"), wasm);
writeFileSync(join(dist, "page.js"), script);
writeFileSync(join(dist, "worker.js"), worker);
writeFileSync(join(dist, "style.css"), css);
for (const { name, bytes } of tables) writeFileSync(join(dist, "tables", `${name}.bin`), bytes);
writeFileSync(
  join(dist, "index.html"),
  fill({
    CSP: "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; connect-src 'self'; img-src 'self' data: blob:; style-src 'self'; base-uri 'none'; form-action 'none'",
    STYLE: '<link rel="stylesheet" href="./style.css">',
    DATA: "",
    SCRIPT: '<script type="module" src="./page.js"></script>',
  }),
);

const one = inside(script);
const data = (id, bytes) => `<script type="application/octet-stream" id="${id}">${gzipSync(bytes, { level: 9 }).toString("base64")}</script>`;
const single = fill({
  CSP: `default-src 'none'; script-src ${hash(one)} 'wasm-unsafe-eval'; worker-src blob:; img-src data: blob:; style-src ${hash(css)}; base-uri 'none'; form-action 'none'`,
  STYLE: `<style>${css}</style>`,
  DATA: [
    data("iridesce-core", wasm),
    ...tables.map(({ name, bytes }) => data(`iridesce-table-${name}`, bytes)),
    `<script type="text/plain" id="iridesce-worker">${inside(worker)}</script>`,
  ].join("\n"),
  SCRIPT: `<script>${one}</script>`,
});
writeFileSync(join(dist, "iridesce.html"), single);

const sizes = {
  "iridesce.wasm": [wasm.length, brotli(wasm)],
  "page.js": [script.length, brotli(script)],
  "worker.js": [worker.length, brotli(worker)],
  "style.css": [css.length, brotli(css)],
  "index.html": [page.length, brotli(page)],
  ...Object.fromEntries(tables.map(({ name, bytes }) => [`tables/${name}.bin`, [bytes.length, brotli(bytes)]])),
  "iridesce.html": [Buffer.byteLength(single), null],
};
writeFileSync(join(web, "node_modules", ".cache", "sizes.json"), JSON.stringify(sizes, null, 1));
for (const [name, [plain, packed]] of Object.entries(sizes)) {
  console.log(`${name.padEnd(28)} ${String(plain).padStart(9)} bytes${packed === null ? "" : `, ${packed} as brotli`}`);
}
