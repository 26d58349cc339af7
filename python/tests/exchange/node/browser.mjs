// Runs functions of a page in a real Chromium. Question: {chromium, html, scripts: [source, ...], call, argument}.
import { createRequire } from "node:module";
import { mkdtempSync, writeFileSync, rmSync, readFileSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { join, extname } from "node:path";

const modules = process.argv[2];
const require = createRequire(join(modules, "x.js"));
const { chromium } = require("playwright-core");
const question = JSON.parse(readFileSync(0, "utf8"));

const folder = mkdtempSync(join(tmpdir(), "iridesce-"));
const types = { ".js": "text/javascript", ".mjs": "text/javascript", ".html": "text/html", ".json": "application/json" };
// Only what this test serves: the page, the modules beside it, and the files of the question.
const server = createServer((request, response) => {
  const path = decodeURIComponent(request.url.split("?")[0]);
  try {
    const file = path.startsWith("/node_modules/") ? join(modules, path.slice(14)) : join(question.folder ?? folder, path);
    const body = path === "/" ? question.html ?? "<!doctype html><title>test</title>" : readFileSync(file);
    response.writeHead(200, { "content-type": path === "/" ? "text/html" : types[extname(path)] ?? "application/octet-stream" });
    response.end(body);
  } catch {
    response.writeHead(404).end();
  }
});
await new Promise((done) => server.listen(0, "127.0.0.1", done));
const browser = await chromium.launchPersistentContext(folder, {
  executablePath: question.chromium,
  headless: true,
  args: ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", ...(question.flags ?? [])],
});
let failed = null;
try {
  const page = await browser.newPage();
  page.setDefaultTimeout(300000);
  page.on("pageerror", (error) => { failed = String(error); });
  const said = [];
  page.on("console", (message) => said.push(message.text()));
  await page.goto(`http://127.0.0.1:${server.address().port}/`);
  for (const source of question.scripts ?? []) await page.addScriptTag({ content: source });
  if (question.ready) await page.waitForFunction(question.ready, null, { timeout: 60000 });
  const answer = await page.evaluate(`(${question.call})(${JSON.stringify(question.argument ?? null)})`);
  if (failed) throw new Error(failed + "\n" + said.join("\n"));
  process.stdout.write(JSON.stringify({ answer, said, version: browser.browser()?.version() ?? "" }));
} finally {
  await browser.close();
  server.close();
  rmSync(folder, { recursive: true, force: true });
}
