// Makes docs/images/living-bubble.webp: the bubble of the page as it lives, for the README (after `make web`).
// node web/tools/living-bubble.mjs [file]. Pictures are taken at even times of the film, however slow the machine is.

import { writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { DIST, open, serve } from "../tests/page/browser.mjs";

const OUT = process.argv[2] ?? fileURLToPath(new URL("../../docs/images/living-bubble.webp", import.meta.url));
const [FRAMES, PER_S, SIDE, QUALITY] = [24, 12, 360, 0.72];

function u24(value) {
  return [value & 255, (value >> 8) & 255, (value >> 16) & 255];
}

function chunk(name, ...parts) {
  const body = Buffer.concat(parts.map((part) => Buffer.from(part)));
  const head = Buffer.alloc(8);
  head.write(name, "latin1");
  head.writeUInt32LE(body.length, 4);
  return Buffer.concat([head, body, Buffer.alloc(body.length % 2)]);
}

/** Chunks of a still WebP that hold its picture. */
function pictureOf(file) {
  const found = [];
  for (let at = 12; at + 8 <= file.length; ) {
    const [name, size] = [file.toString("latin1", at, at + 4), file.readUInt32LE(at + 4)];
    const end = at + 8 + size + (size % 2);
    if (["VP8 ", "VP8L", "ALPH"].includes(name)) found.push(file.subarray(at, end));
    at = end;
  }
  return Buffer.concat(found);
}

const host = await serve(DIST);
const one = await open(`${host.url}/#v=1&scene=bubble&age_s=1.2&seed=3`);
const frames = await one.page.evaluate(
  async ([count, per_s, side, quality]) => {
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = side;
    const context = canvas.getContext("2d");
    context.imageSmoothingQuality = "high";
    const first = window.iridesce.flow().time_s;
    const frames = [];
    while (frames.length < count) {
      await new Promise((resolve) => requestAnimationFrame(resolve));
      if (window.iridesce.flow().time_s < first + frames.length / per_s) continue;
      context.drawImage(document.querySelector("#picture canvas"), 0, 0, side, side);
      const blob = await new Promise((resolve) => canvas.toBlob(resolve, "image/webp", quality));
      frames.push(Array.from(new Uint8Array(await blob.arrayBuffer())));
    }
    return frames;
  },
  [FRAMES, PER_S, SIDE, QUALITY],
);
await one.close();
host.server.close();

const size = [...u24(SIDE - 1), ...u24(SIDE - 1)];
const body = Buffer.concat([
  Buffer.from("WEBP"),
  chunk("VP8X", [2, 0, 0, 0], size), // 2: animated
  chunk("ANIM", [0, 0, 0, 255, 0, 0]), // black behind; for ever
  ...frames.map((bytes) => chunk("ANMF", [0, 0, 0, 0, 0, 0], size, u24(Math.round(1000 / PER_S)), [2], pictureOf(Buffer.from(bytes)))),
]);
const head = Buffer.alloc(8);
head.write("RIFF");
head.writeUInt32LE(body.length, 4);
writeFileSync(OUT, Buffer.concat([head, body]));
console.log(`${OUT}: ${FRAMES} pictures, ${body.length + 8} bytes`);
