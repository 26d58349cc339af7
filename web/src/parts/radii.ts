// Dark rings as the picture has them.

import type { ColorTable } from "../core/core";
import { lookUp } from "../core/look-up";
import type { Page } from "../page";

/** Points along a radius; a ring is then found by the parabola through three of them. */
const POINTS = 2400;

let last: { table: ColorTable; view: string; radii: number[] } | null = null;

/** Radii in mm at which the drawn table is darkest. */
export function measuredRadii(page: Page): number[] {
  const { stage, state } = page;
  const table = stage?.picture?.table;
  if (!table) return [];
  const [radius, contact, view] = ["radius_mm", "thickness_nm", "view_mm"].map((name) => Number(state[name]));
  const asked = `${radius} ${contact} ${view}`;
  if (last?.table === table && last.view === asked) return last.radii;
  const xyz = new Float64Array(3);
  const y = Float64Array.from({ length: POINTS }, (_, i) => {
    const r = (view * i) / (2 * POINTS);
    const gap = contact + (1e6 * r * r) / (radius + Math.sqrt(radius * radius - r * r));
    lookUp(table, gap, 0, xyz, 0);
    return xyz[1];
  });
  const found: number[] = [];
  for (let i = 1; i < POINTS - 1; i++) {
    if (y[i] < y[i - 1] && y[i] <= y[i + 1]) {
      const bend = y[i - 1] - 2 * y[i] + y[i + 1];
      found.push((view * (i + (0.5 * (y[i - 1] - y[i + 1])) / bend)) / (2 * POINTS));
    }
  }
  last = { table, view: asked, radii: found };
  return found;
}
