// The notebook widget (anywidget): the page's own picture and charts, with numbers from Python instead of wasm.

import { html, render } from "lit";
import type { ColorTable } from "./core/core";
import { lookUp } from "./core/look-up";
import { SPECTRUM_NM } from "./core/wavelengths";
import { CHART_DEG, geometryOf } from "./draw/geometry";
import { Picture } from "./draw/picture";
import { spectrumChart } from "./parts/charts";
import { type State, LAMPS, defaults } from "./state/keys";
import { TEXT } from "./text/strings";

interface Model {
  get(name: string): unknown;
  set(name: string, value: unknown): void;
  save_changes(): void;
  on(event: string, heard: () => void): void;
  off(event: string, heard: () => void): void;
}

const SIDE = 360;
const WAIT_MS = 60;
const SPECTRUM_STEP = 2;

function floats(value: unknown): Float32Array {
  if (!(value instanceof DataView)) return new Float32Array(0);
  return new Float32Array(value.buffer.slice(value.byteOffset, value.byteOffset + value.byteLength));
}

function tableOf(model: Model): ColorTable | null {
  const head = model.get("_shape") as number[];
  const nodes = floats(model.get("_nodes"));
  if (head.length < 8 || nodes.length !== head[0] * head[1] * 6) return null;
  const [rows, columns, last_nm, last_deg, x, y, z, error] = [head[0], head[1], head[2], head[3], head[4], head[5], head[6], head[7]];
  return {
    rows, columns, first_nm: 0, step_nm: last_nm / (columns - 1), first_deg: 0, step_deg: last_deg / (rows - 1), inverse_square: 0,
    white: [x, y, z], max_delta_e: error, mean_delta_e: error, range_nm: [0, last_nm], range_deg: [0, last_deg], nodes,
  };
}

/** Linear sRGB from XYZ, from the primaries; Python sends it. */
function matrixOf(model: Model): number[] {
  return model.get("_matrix") as number[];
}

function mount({ model, el }: { model: Model; el: HTMLElement }): () => void {
  const kind = model.get("kind") as "film" | "bubble";
  const root = document.createElement("div");
  root.className = "iridesce-widget";
  el.append(root);
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = SIDE;
  canvas.setAttribute("role", "img");
  const picture = new Picture(canvas, () => paint());
  const controls = document.createElement("div");
  const chart = document.createElement("div");
  const seen = document.createElement("div");
  seen.className = "iridesce-seen";
  seen.append(picture.canvas);
  root.append(seen, controls, chart);

  const geometry = () => {
    const width = kind === "film" ? Math.round((SIDE * 4) / 3) : SIDE;
    const state: State = { ...defaults(kind === "film" ? "film" : "bubble") };
    if (kind === "film") state["thickest_nm"] = (model.get("_shape") as number[])[2] ?? 1200;
    // Places as on a sphere's map: the free bubble's.
    else state["preset"] = "free-bubble-preview";
    picture.setGeometry(geometryOf({ width, height: SIDE, state, water: () => new Float64Array(91) }));
  };

  const field = () => {
    if (kind !== "bubble") return;
    const [columns, rows] = model.get("_field_size") as number[];
    const shares = floats(model.get("_field"));
    if (shares.length !== columns * rows) return;
    const mean = model.get("thickness_nm") as number;
    picture.setField({ columns, rows, thickness_nm: shares.map((share) => share * mean) });
  };

  const paint = () => {
    if (picture.canvas.parentElement !== seen) seen.prepend(picture.canvas);
    const luminances = picture.luminances();
    const bright = luminances[Math.floor(luminances.length * (kind === "bubble" ? 0.96 : 0.995))] || 1;
    picture.look = { rgb_from_xyz: matrixOf(model), moving: false, exposure: 0.82 / bright };
    picture.draw();
    picture.canvas.setAttribute("aria-label", String(model.get("_words")));
  };

  let timer: ReturnType<typeof setTimeout> | undefined;
  const send = (name: string, value: unknown) => {
    model.set(name, value);
    clearTimeout(timer);
    timer = setTimeout(() => model.save_changes(), WAIT_MS);
  };

  const show = () => {
    const [nm, deg, lamp] = [model.get("thickness_nm") as number, model.get("angle_deg") as number, model.get("illuminant") as string];
    const last = (model.get("_shape") as number[])[2] ?? 1200;
    const lamps = (LAMPS as readonly string[]).includes(lamp) ? LAMPS : [...LAMPS, lamp];
    render(
      html`<label>${kind === "bubble" ? TEXT.keysOf["bubble thickness_nm"] : TEXT.keys["thickness_nm"]}
          <input type="range" min="0" max=${kind === "bubble" ? Math.floor(last / 2) : last} step="1" .value=${String(nm)} @input=${(e: Event) => send("thickness_nm", (e.target as HTMLInputElement).valueAsNumber)} />
          <output>${nm.toFixed(0)} nm</output></label>
        <label>${TEXT.keys["angle_deg"]}
          <input type="range" min="0" max=${CHART_DEG} step="1" .value=${String(deg)} @input=${(e: Event) => send("angle_deg", (e.target as HTMLInputElement).valueAsNumber)} />
          <output>${deg.toFixed(0)}°</output></label>
        <label>${TEXT.keys["illuminant"]}
          <select @change=${(e: Event) => send("illuminant", (e.target as HTMLSelectElement).value)}>
            ${lamps.map((name) => html`<option value=${name} ?selected=${name === lamp}>${TEXT.choices[name] ?? name}</option>`)}
          </select></label>
        <p><span class="iridesce-swatch"></span> ${model.get("_words")}</p>`,
      controls,
    );
    const swatch = controls.querySelector<HTMLElement>(".iridesce-swatch");
    if (swatch) swatch.style.backgroundColor = String(model.get("_srgb"));
    const spectrum = floats(model.get("_spectrum"));
    if (spectrum.length > 1) {
      const wavelengths = Float64Array.from(spectrum, (_, i) => SPECTRUM_NM[0] + SPECTRUM_STEP * i);
      render(spectrumChart(String(model.get("_words")), wavelengths, [{ name: TEXT.reflectance, kind: "first", values: spectrum }]), chart);
    }
  };

  const heard: [string, () => void][] = [
    ["change:_nodes", () => { load(); paint(); show(); }],
    ["change:_field", () => { field(); paint(); }],
    ["change:thickness_nm", () => { field(); paint(); show(); }],
    ["change:angle_deg", show],
    ["change:illuminant", show],
    ["change:_words", () => { show(); paint(); }],
    ["change:_spectrum", show],
  ];
  const load = () => {
    const table = tableOf(model);
    if (table) picture.setTable(table);
    geometry();
  };
  load();
  field();
  paint();
  show();
  for (const [event, what] of heard) model.on(event, what);
  return () => {
    clearTimeout(timer);
    for (const [event, what] of heard) model.off(event, what);
    picture.dispose();
    root.remove();
  };
}

/** For tests: the colour of the widget's table. */
export function colorAt(model: Model, thickness_nm: number, angle_deg: number): number[] {
  const table = tableOf(model);
  const out = new Float64Array(3);
  if (table) lookUp(table, thickness_nm, angle_deg, out, 0);
  return Array.from(out);
}

export default { render: mount };
