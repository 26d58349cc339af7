// The page's figures in headless Chromium: node web/tools/figures.mjs (after `make web`). Software graphics; times are this
// machine's, with whatever else it does meanwhile.

import { readFileSync } from "node:fs";
import { loadavg } from "node:os";
import { DIST, open, serve } from "../tests/page/browser.mjs";

const median = (values) => [...values].sort((a, b) => a - b)[values.length >> 1];
const sizes = JSON.parse(readFileSync(new URL("../node_modules/.cache/sizes.json", import.meta.url), "utf8"));
const FIRST = ["iridesce.wasm", "page.js", "worker.js", "style.css", "index.html", "tables/soap.bin"];
console.log(`first scene: ${FIRST.reduce((sum, name) => sum + sizes[name][1], 0)} bytes as brotli; one file: ${sizes["iridesce.html"][0]} bytes`);

// Isolated, so that memory can be asked for: workers and wasm are in it.
const host = await serve(DIST, 0, { "Cross-Origin-Opener-Policy": "same-origin", "Cross-Origin-Embedder-Policy": "require-corp" });
const options = { flags: ["--enable-blink-features=ForceEagerMeasureMemory"] };
const load = () => `load ${loadavg()[0].toFixed(1)}`;

for (const scene of ["film", "bubble"]) {
  const times = [];
  for (let run = 0; run < 3; run++) {
    const one = await open(`${host.url}/#v=1&scene=${scene}`, options);
    times.push(await one.page.evaluate(() => window.iridesce.stats().first_picture_ms));
    await one.close();
  }
  console.log(`first picture of ${scene}: ${times.map((ms) => (ms / 1000).toFixed(2)).join(", ")} s (${load()})`);
}

const one = await open(`${host.url}/#v=1&scene=bubble`, options);
const { page } = one;
for (const [name, preset, walls] of [
  ["free bubble, both walls", "free-bubble-preview", "2"], ["dome", "bubble-on-bath-preview", "1"], ["dome, both walls", "bubble-on-bath-preview", "2"],
]) {
  const found = await page.evaluate(async ([preset, walls]) => {
    const { iridesce } = window;
    iridesce.set({ scene: "bubble", preset, walls, playing: true });
    await new Promise((resolve) => setTimeout(resolve, 100));
    await iridesce.drawn();
    // The page looks for a size that it can keep up with first.
    await new Promise((resolve) => setTimeout(resolve, 12000));
    const [from, start] = [iridesce.flow().time_s, performance.now()];
    await new Promise((resolve) => setTimeout(resolve, 8000));
    const seconds = (performance.now() - start) / 1000;
    const { columns, rows, time_s } = iridesce.flow();
    const { pictures_per_s, step_ms } = iridesce.stats();
    return { pictures_per_s, step_ms, pace: (time_s - from) / seconds, columns, rows, width: iridesce.pixels().width };
  }, [preset, walls]);
  console.log(
    `${name}: ${found.pictures_per_s.toFixed(1)} pictures/s of ${found.width} pixels, film ${found.columns} x ${found.rows}, ` +
      `step ${found.step_ms.toFixed(1)} ms, ${found.pace.toFixed(2)} of real time (${load()})`,
  );
}

for (const [scene, key] of [["film", "thickness_nm"], ["wafer", "angle_deg"], ["titanium", "volts"], ["rings", "radius_mm"]]) {
  const waits = await page.evaluate(async ([scene, key]) => {
    const { iridesce } = window;
    iridesce.set({ scene });
    await new Promise((resolve) => setTimeout(resolve, 100));
    await iridesce.settled();
    const slider = document.querySelector(`#key-${key}`);
    const waits = [];
    for (let i = 0; i < 40; i++) {
      await new Promise((resolve) => setTimeout(resolve, 30));
      const start = performance.now();
      slider.value = String(Number(slider.value) + Number(slider.step));
      slider.dispatchEvent(new Event("input", { bubbles: true }));
      // The page draws in the next frame; this is asked for after it, and waits for the drawing itself.
      await new Promise((resolve) => requestAnimationFrame(resolve));
      const gl = document.querySelector("#picture canvas").getContext("webgl2");
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
      waits.push(performance.now() - start);
    }
    return waits;
  }, [scene, key]);
  console.log(`slider ${key} of ${scene}: median ${median(waits).toFixed(0)} ms, worst of 40 ${Math.max(...waits).toFixed(0)} ms (${load()})`);
}

const memory = () => page.evaluate(async () => (await performance.measureUserAgentSpecificMemory()).bytes / 1e6);
await page.evaluate(() => window.iridesce.set({ scene: "bubble" }));
await page.waitForTimeout(3000);
console.log(`memory with the bubble: ${(await memory()).toFixed(0)} MB`);
await page.evaluate(async () => {
  const scenes = ["rings", "slick", "titanium", "wafer", "film", "learn", "bubble"];
  for (let i = 0; i < 200; i++) {
    window.iridesce.set({ scene: scenes[i % scenes.length] });
    await new Promise((resolve) => setTimeout(resolve, 30));
  }
  window.iridesce.set({ scene: "bubble" });
  await window.iridesce.drawn();
});
await page.waitForTimeout(3000);
console.log(`memory after 200 changes of scene: ${(await memory()).toFixed(0)} MB`);
if (one.errors.length) console.log(`errors: ${one.errors.join("; ")}`);
await one.close();
host.server.close();
