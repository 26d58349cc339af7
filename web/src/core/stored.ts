// Colour tables that come with the page: which there are, and how they are packed (web/tools/tables.mjs makes them).

import type { ColorTable, TableRequest } from "./core";

export interface StoredTable extends TableRequest {
  name: string;
}

const CHANNELS = 6;
const HEAD = 13;

/** A stored table that holds what is asked for. */
export function storedFor(stored: readonly StoredTable[], request: TableRequest): StoredTable | undefined {
  const inside = (a: [number, number], b: [number, number]) => a[0] >= b[0] && a[1] <= b[1];
  return stored.find(
    (one) =>
      one.stack === request.stack && one.layer === request.layer && one.illuminant === request.illuminant &&
      one.max_delta_e <= request.max_delta_e && inside(request.range_nm, one.range_nm) && inside(request.range_deg, one.range_deg),
  );
}

/** Its shape and the size of a step as float64, least significant byte first, then each channel's high bytes and low bytes. */
export function unpackTable(bytes: ArrayBuffer, { range_nm, range_deg }: StoredTable): ColorTable {
  const [rows, columns, first_nm, step_nm, first_deg, step_deg, inverse_square, x, y, z, max, mean, step] = new Float64Array(bytes.slice(0, 8 * HEAD));
  const packed = new Uint8Array(bytes, 8 * HEAD);
  const count = rows * columns;
  const nodes = new Float32Array(count * CHANNELS);
  const own = new Int32Array(count);
  for (let k = 0; k < CHANNELS; k++) {
    for (let i = 0; i < count; i++) {
      const zigzag = (packed[2 * count * k + i] << 8) | packed[2 * count * k + count + i];
      const foretold = i >= 2 * columns ? 2 * own[i - columns] - own[i - 2 * columns] : i >= columns ? own[i - columns] : i ? own[i - 1] : 0;
      own[i] = ((foretold + ((zigzag >> 1) ^ -(zigzag & 1))) << 16) >> 16;
      nodes[CHANNELS * i + k] = own[i] * step;
    }
  }
  return {
    rows, columns, first_nm, step_nm, first_deg, step_deg, inverse_square,
    white: [x, y, z], max_delta_e: max, mean_delta_e: mean, range_nm, range_deg, nodes,
  };
}
