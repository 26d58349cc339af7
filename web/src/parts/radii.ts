// Dark rings as the picture has them.

import type { App } from "../app";

/** Points along a radius; a ring is then found by the parabola through three of them. */
const POINTS = 2400;

/** Radii in mm at which the drawn table is darkest. */
export function measuredRadii(app: App): number[] {
  const { stage, state } = app;
  if (!stage?.picture?.table) return [];
  const [radius, contact, view] = ["radius_mm", "thickness_nm", "view_mm"].map((name) => Number(state[name]));
  const y = Float64Array.from({ length: POINTS }, (_, i) => {
    const r = (view * i) / (2 * POINTS);
    const gap = contact + (1e6 * r * r) / (radius + Math.sqrt(radius * radius - r * r));
    return stage.tableColor(gap, 0)[1];
  });
  const found: number[] = [];
  for (let i = 1; i < POINTS - 1; i++) {
    if (y[i] < y[i - 1] && y[i] <= y[i + 1]) {
      const bend = y[i - 1] - 2 * y[i] + y[i + 1];
      found.push((view * (i + (0.5 * (y[i - 1] - y[i + 1])) / bend)) / (2 * POINTS));
    }
  }
  return found;
}
