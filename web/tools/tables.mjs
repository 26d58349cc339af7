// Colour tables that come with the page: those that its scenes begin with, so that the first picture waits for none.
// Each: twelve float64 (crates/web: color_table), then the nodes as float16.

import { openCore } from "./core.mjs";

/** name: stack, layer, illuminant, range in nm, range in degrees; as src/app.ts asks for them in a scene's own state. */
const STORED = {
  soap: ["air / soap ? / air", 0, "D65", [0, 1500], [0, 80]],
};
const DRAFT = 0.5;

export function half(value) {
  const f32 = new Float32Array([value]);
  const bits = new Uint32Array(f32.buffer)[0];
  const sign = (bits >>> 16) & 0x8000;
  const magnitude = Math.abs(f32[0]);
  if (magnitude >= 65504) return sign | 0x7bff;
  if (magnitude < 2 ** -14) return sign | Math.round(magnitude * 2 ** 24);
  const exponent = ((bits >>> 23) & 255) - 127;
  const fraction = magnitude / 2 ** exponent - 1;
  // Rounding up may carry into the exponent, which is right.
  return sign | (((exponent + 15) << 10) + Math.round(fraction * 1024));
}

export async function storedTables(wasm) {
  const core = await openCore(wasm);
  return Object.entries(STORED).map(([name, [stack, layer, illuminant, range_nm, range_deg]]) => {
    const numbers = [layer, ...range_nm, ...range_deg, DRAFT];
    const { result } = core.call("color_table", [stack, illuminant, "", "", ""].join("\n"), numbers);
    const head = Buffer.from(result.slice(0, 12).buffer);
    const nodes = Buffer.from(Uint16Array.from(result.subarray(12), half).buffer);
    const key = [stack, layer, illuminant, range_nm, range_deg, DRAFT].join("|");
    return { name, key, bytes: Buffer.concat([head, nodes]) };
  });
}
