// A real Chromium for the tests, or words on why there is none.

import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { chromium } from "playwright-core";
import { serve } from "../../tools/serve.mjs";

const FLAGS = [
  "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
  // Software graphics: the same on every machine.
  "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
];

export const CHROMIUM = [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find((path) => path && existsSync(path));
export const DIST = fileURLToPath(new URL("../../dist", import.meta.url));
export const FILE = pathToFileURL(join(DIST, "iridesce.html")).href;
const COMMITTED = fileURLToPath(new URL("../../../python/iridesce/page/iridesce.html", import.meta.url));
export const COMMITTED_FILE = pathToFileURL(COMMITTED).href;

/** A browser of its own profile, with a page; `errors` fills with whatever the page complains of. */
export async function open(url, { viewport = { width: 1280, height: 900 }, flags = [], ...options } = {}) {
  const profile = mkdtempSync(join(tmpdir(), "iridesce-chromium-"));
  const context = await chromium.launchPersistentContext(profile, {
    executablePath: CHROMIUM, headless: true, args: [...FLAGS, ...flags], viewport, ...options,
  });
  const page = context.pages()[0] ?? (await context.newPage());
  page.setDefaultTimeout(120000);
  const errors = [];
  const requests = [];
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  page.on("request", (request) => requests.push(request.url()));
  if (url) {
    await page.goto(url);
    await page.waitForFunction(() => window.iridesce);
    await page.evaluate(() => window.iridesce.ready);
  }
  const close = async () => {
    await context.close();
    rmSync(profile, { recursive: true, force: true });
  };
  return { page, context, errors, requests, close };
}

export { serve };
