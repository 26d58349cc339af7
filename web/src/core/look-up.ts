// The twin of the shader's look-up: a colour table at one thickness and angle, as crates/optics/src/color/color_table.rs
// interpolates it. It draws where there is no WebGL, and tells the colour under the pointer.

import type { ColorTable } from "./core";

const RADIANS = Math.PI / 180;

/** Writes X, Y, Z to `out` at `at`. Thickness and angle are held within the table. */
export function lookUp(table: ColorTable, thickness_nm: number, angle_deg: number, out: Float32Array | Float64Array, at: number): void {
  const { rows, columns, nodes } = table;
  const angle = Math.min(Math.max(angle_deg, table.range_deg[0]), table.range_deg[1]);
  let v = Math.min(Math.max(thickness_nm, table.range_nm[0]), table.range_nm[1]);
  if (table.inverse_square > 0) {
    const sine = Math.sin(angle * RADIANS);
    v *= Math.sqrt(1 - sine * sine * table.inverse_square);
  }
  const p = Math.max((v - table.first_nm) / table.step_nm, 0);
  const column = Math.min(Math.floor(p), columns - 2);
  const f = p - column;
  const rest = 1 - f;
  const a0 = (f * 2 + 1) * rest * rest;
  const a1 = f * rest * rest;
  const a2 = f * f * (3 - 2 * f);
  const a3 = -(f * f * rest);
  let row = 0;
  let weights: number[] = ONE_ROW;
  if (rows > 1) {
    const y = (angle - table.first_deg) / table.step_deg;
    row = Math.min(Math.max(Math.floor(y) - 1, 0), rows - 4);
    const a = y - row;
    const b = a - 1;
    const c = a - 2;
    const d = a - 3;
    weights = [(b * c * d) / -6, (a * c * d) / 2, (a * b * d) / -2, (a * b * c) / 6];
  }
  let x = 0;
  let y = 0;
  let z = 0;
  for (let across = 0; across < weights.length; across++) {
    const n = ((row + across) * columns + column) * 6;
    const w = weights[across];
    x += w * (a0 * nodes[n] + a1 * nodes[n + 3] + a2 * nodes[n + 6] + a3 * nodes[n + 9]);
    y += w * (a0 * nodes[n + 1] + a1 * nodes[n + 4] + a2 * nodes[n + 7] + a3 * nodes[n + 10]);
    z += w * (a0 * nodes[n + 2] + a1 * nodes[n + 5] + a2 * nodes[n + 8] + a3 * nodes[n + 11]);
  }
  out[at] = x;
  out[at + 1] = y;
  out[at + 2] = z;
}

const ONE_ROW = [1];
