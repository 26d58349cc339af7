// Where the page begins, and what it offers to scripts.

import type { App } from "./app";
import "./app";
import type { Core } from "./core/core";
import { csv } from "./parts/take-away";
import { words } from "./text/words";

const app = document.querySelector("iridesce-page") as App;

function core(): Core {
  if (!app.core) throw new Error("await iridesce.ready first");
  return app.core;
}

const face = {
  /** Resolves when the first picture is drawn. */
  ready: app.ready,
  get scene() {
    return app.state.scene;
  },
  state: () => app.snapshot(),
  /** Sets any keys of the state; answers notes on what was left out. */
  set: (changes: Record<string, unknown>) => app.set(changes),
  color: (stack: string, angle_deg = 0, { illuminant = "D65", model = "exact" } = {}) =>
    Array.from(core().color(stack, [0, angle_deg], { illuminant, model })),
  reflectance: (stack: string, wavelengths: ArrayLike<number>, angle_deg = 0) =>
    Array.from(core().spectrum(stack, wavelengths, angle_deg)),
  delta_e: (lab_a: number[], lab_b: number[]) => core().difference([...lab_a, ...lab_b])[0],
  convert: (values: ArrayLike<number>, from: string, to: string, illuminant = "D65") => core().convert(values, from, to, illuminant),
  /** What is drawn, linear; NaN off films. Nothing where there is no picture. */
  pixels: () => (app.state.scene === "learn" ? null : (app.stage?.picture?.pixels() ?? null)),
  flow: () => app.flow(),
  /** X, Y, Z of the table that is drawn. */
  tableColor: (thickness_nm: number, angle_deg: number) => Array.from(app.stage?.tableColor(thickness_nm, angle_deg) ?? []),
  table: () => {
    const table = app.stage?.picture?.table;
    return table ? { max_delta_e: table.max_delta_e, rows: table.rows, columns: table.columns, range_nm: table.range_nm, range_deg: table.range_deg } : null;
  },
  drawn: () => app.drawn(),
  settled: () => app.settled(),
  follow: (fragment: string) => app.follow(fragment),
  csv: () => csv(app),
  notes: () => [...app.notes],
  stats: () => app.stats(),
  get renderer() {
    return app.stage?.picture?.kind ?? "canvas";
  },
};

declare global {
  interface Window {
    iridesce: typeof face;
  }
}

window.iridesce = face;
addEventListener("unhandledrejection", (event) => console.error(words(event.reason)));
