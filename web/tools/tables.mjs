// Colour tables that come with the page: those that its scenes begin with, so that no first picture waits for one.
// A file: twelve float64 (crates/web: color_table), the size of a step, then the nodes in such steps as 16-bit whole
// numbers, packed by `pack` (src/core/stored.ts unpacks them).

import { openCore } from "./core.mjs";

const DEG = [0, 80];
/** As src/stage.ts asks for them in a scene's own state; the scene `film` begins with a part of `soap`. */
const STORED = {
  soap: ["air / soap ? / air", 0, [0, 1500], DEG],
  rings: ["air / MgF2 99.75 / N-BK7 1e6 incoherent / air ? / N-BK7", 2, [0, 6000], [0, 0]],
  slick: ["air / 1.47 ? / water", 0, [0, 900], DEG],
  titanium: ["air / TiO2 ? / Ti", 0, [0, 300], DEG],
  wafer: ["air / SiO2 ? / Si", 0, [0, 500], DEG],
};
/** What a draft may be off (src/stage.ts), and what of it is left for rounding. */
const DRAFT = 0.5;
const BUILT = 0.45;
const CHANNELS = 6;

/** Channel by channel, each number less what the two above (in angle) foretell, high bytes before low ones: half the size of
 * plain numbers once a host compresses them. */
export function pack(numbers, columns) {
  const count = numbers.length / CHANNELS;
  const bytes = Buffer.alloc(numbers.length * 2);
  for (let k = 0; k < CHANNELS; k++) {
    const own = Int32Array.from({ length: count }, (_, i) => numbers[CHANNELS * i + k]);
    for (let i = 0; i < count; i++) {
      const d = ((own[i] - foretold(own, i, columns)) << 16) >> 16;
      const z = ((d << 1) ^ (d >> 31)) & 0xffff;
      bytes[2 * count * k + i] = z >> 8;
      bytes[2 * count * k + count + i] = z & 255;
    }
  }
  return bytes;
}

export function foretold(own, i, columns) {
  if (i >= 2 * columns) return 2 * own[i - columns] - own[i - 2 * columns];
  return i >= columns ? own[i - columns] : i ? own[i - 1] : 0;
}

/** Greatest CIEDE2000 between the colours of the nodes and what steps make of them. */
function roundedBy(core, nodes, steps, step) {
  const at = (values) => Float64Array.from(values.filter((_, i) => i % CHANNELS < 3));
  const lab = (xyz) => core.call("color_convert", "xyz\nlab\nD65\n", xyz).result;
  const [exact, rounded] = [lab(at(nodes)), lab(at(Float64Array.from(steps, (v) => v * step)))];
  const pairs = new Float64Array(2 * exact.length);
  for (let i = 0; i < exact.length; i += 3) pairs.set([...exact.subarray(i, i + 3), ...rounded.subarray(i, i + 3)], 2 * i);
  return Math.max(...core.call("color_difference", "", pairs).result);
}

export async function storedTables(wasm) {
  const core = await openCore(wasm);
  return Object.entries(STORED).map(([name, [stack, layer, range_nm, range_deg]]) => {
    const { result } = core.call("color_table", [stack, "D65", "", "", ""].join("\n"), [layer, ...range_nm, ...range_deg, BUILT]);
    const [head, nodes] = [result.slice(0, 12), result.subarray(12)];
    const step = nodes.reduce((most, v) => Math.max(most, Math.abs(v)), 0) / 32767;
    const steps = Int16Array.from(nodes, (v) => Math.round(v / step));
    head[10] += roundedBy(core, nodes, steps, step);
    if (!(head[10] <= DRAFT)) throw new Error(`${name}: colours are off by CIEDE2000 ${head[10]}`);
    const entry = { name, stack, layer, illuminant: "D65", range_nm, range_deg, max_delta_e: DRAFT };
    return { name, entry, bytes: Buffer.concat([Buffer.from(Float64Array.of(...head, step).buffer), pack(steps, head[1])]) };
  });
}
