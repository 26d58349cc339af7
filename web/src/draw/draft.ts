// A colour table as a graphics device is given it for films that move: one texel a place instead of sixteen.

import type { ColorTable } from "../core/core";
import { lookUp } from "../core/look-up";

export interface Draft {
  rows: number;
  columns: number;
  /** A texel a node: X, Y, Z of it and of the next along the row as six halves, two in a number. */
  texels: Uint32Array;
  /** First reduced thickness and step, nm; first angle and step, degrees. */
  axes: [number, number, number, number];
}

/** Steps of a draft: a straight line along 2 nm is off by 1e-3 of a fringe, the nearest of 512 angles by 4e-3 towards grazing. */
const DRAFT_NM = 2;
const DRAFT_ROWS = 512;
const DRAFT_COLUMNS = 2048;

/** A table to read with one fetch a place, to CIEDE2000 0.5; null: too many columns, read the table itself. */
export function draftOf(table: ColorTable): Draft | null {
  const [least, most] = [table.first_nm, table.first_nm + (table.columns - 1) * table.step_nm];
  const columns = Math.ceil((most - least) / DRAFT_NM) + 1;
  if (columns > DRAFT_COLUMNS) return null;
  const [from, to] = table.range_deg;
  const rows = table.rows === 1 || from === to ? 1 : DRAFT_ROWS;
  const step_deg = rows === 1 ? 1 : (to - from) / (rows - 1);
  const texels = new Uint32Array(rows * columns * 4);
  const color = new Float32Array(3);
  // Rows are reduced thickness: that of light at right angles is the thickness itself.
  const flat: ColorTable = { ...table, inverse_square: 0, range_nm: [least, most] };
  for (let row = 0; row < rows; row++) {
    let after = [0, 0, 0];
    for (let column = columns - 1; column >= 0; column--) {
      lookUp(flat, least + column * DRAFT_NM, from + row * step_deg, color, 0);
      const [x, y, z] = [half(color[0]), half(color[1]), half(color[2])];
      const [nextX, nextY, nextZ] = column === columns - 1 ? [x, y, z] : after;
      const n = 4 * (row * columns + column);
      texels[n] = x | (y << 16);
      texels[n + 1] = z | (nextX << 16);
      texels[n + 2] = nextY | (nextZ << 16);
      after = [x, y, z];
    }
  }
  return { rows, columns, texels, axes: [least, DRAFT_NM, from, step_deg] };
}

const float = new Float32Array(1);
const bits = new Uint32Array(float.buffer);

/** The bits of the nearest half float of a number from 0 to 65504; below 6e-5: 0. */
function half(value: number): number {
  float[0] = Math.min(Math.max(value, 0), 65504);
  const rounded = bits[0] + 0x1000;
  return rounded < 0x38800000 ? 0 : (rounded - 0x38000000) >> 13;
}
