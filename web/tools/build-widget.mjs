// Builds the notebook widget: one ES module as a text, with its style, into python/iridesce/notebooks/.

import { readFileSync, writeFileSync, mkdirSync } from "node:fs";
import { join, dirname } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "vite";

const web = dirname(dirname(fileURLToPath(import.meta.url)));
const out = process.argv[2] ?? join(web, "..", "python", "iridesce", "notebooks");
const result = await build({
  root: web,
  configFile: false,
  logLevel: "warn",
  define: { "process.env.NODE_ENV": '"production"' },
  build: { write: false, target: "es2022", minify: true, lib: { entry: join(web, "src", "widget.ts"), formats: ["es"] } },
});
const [{ output }] = [result].flat();
mkdirSync(out, { recursive: true });
// Without the lines that name the sources, by ways of the machine that builds.
const code = output.find((chunk) => chunk.type === "chunk").code.replace(/^\/\/ \S+\.[jt]s\n/gm, "");
writeFileSync(join(out, "widget.js"), code.trim() + "\n");
writeFileSync(join(out, "widget.css"), readFileSync(join(web, "src", "widget.css"), "utf8"));
