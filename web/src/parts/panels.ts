// What is told beside the pictures: spectra, strips, the path of a colour, radii of rings.

import { html, nothing, svg, type TemplateResult } from "lit";
import { ref } from "lit/directives/ref.js";
import type { Core } from "../core/core";
import { lookUp } from "../core/look-up";
import { SPECTRUM_NM, VISIBLE_NM, inSteps } from "../core/wavelengths";
import { CHART_DEG } from "../draw/geometry";
import type { Page } from "../page";
import { filled } from "../state/keys";
import { TEXT } from "../text/strings";
import { type Curve, diagram, spectrumChart } from "./charts";
import { orderEnds } from "../text/words";
import { measuredRadii } from "./radii";
import { brightening, paintStrip, square } from "./swatch";

const WAVELENGTHS = inSteps(SPECTRUM_NM, 2);
const STRIP = 480;

let locus: Float64Array | null = null;

function locusOf(core: Core): Float64Array {
  if (locus) return locus;
  const table = core.call("observer_table").result;
  const points: number[] = [];
  for (let nm = 390; nm <= 700; nm += 2) {
    const [x, y, z] = table.subarray(3 * (nm - VISIBLE_NM[0]), 3 * (nm - VISIBLE_NM[0]) + 3);
    points.push(x / (x + y + z), y / (x + y + z));
  }
  return (locus = Float64Array.from(points));
}

function strip(page: Page, title: string, xyz: Float64Array, marks: { share: number; label: string }[], orders: number[] = []): TemplateResult {
  return html`<figure class="strip">
    <canvas role="img" aria-label=${title} ${ref((el) => el && paintStrip(el as HTMLCanvasElement, page, xyz))}></canvas>
    <svg viewBox="0 0 480 18" aria-hidden="true">${marks.map(line)}</svg>
    ${orders.length ? html`<svg viewBox="0 0 480 16" aria-hidden="true">${orders.map((share, i) => line({ share, label: ["I", "II", "III", "IV", "V", "VI", "VII", "VIII", "IX"][i] }))}</svg>` : nothing}
  </figure>`;
}


function line(mark: { share: number; label: string }): TemplateResult {
  const x = 480 * mark.share;
  const anchor = mark.share > 0.97 ? "end" : mark.share < 0.03 ? "start" : "middle";
  return svg`<line x1=${x} x2=${x} y1="0" y2="4" class="tick"></line><text x=${x} y="16" text-anchor=${anchor}>${mark.label}</text>` as TemplateResult;
}

/** Spectrum, both models side by side, Newton's scale, all angles, the path in the CIE diagram. */
export function filmPanel(page: Page): TemplateResult {
  const core = page.core as Core;
  const { state } = page;
  const [nm, angle] = [Number(state["thickness_nm"]), Number(state["angle_deg"])];
  const [stack, lamp] = [String(state["stack"]), String(state["illuminant"])];
  const now = filled(stack, nm);
  const exact = core.spectrum(now, WAVELENGTHS, angle);
  const curves: Curve[] = [{ name: TEXT.choices["exact"], kind: "first", values: exact }];
  let compared: TemplateResult | typeof nothing = nothing;
  if (state.scene === "film") {
    try {
      const old = core.spectrum(now, WAVELENGTHS, angle, { model: "two-beam" });
      curves.push({ name: TEXT.choices["two-beam"], kind: "second", values: old });
      const [a, b] = ["exact", "two-beam"].map((model) => core.color(stack, [nm, angle], { layer: page.layer, illuminant: lamp, model }));
      const labs = [a, b].map((xyz) => core.convert(xyz, "xyz", "lab", lamp));
      const de = core.difference([...labs[0], ...labs[1]])[0];
      const scale = brightening(a[1]);
      compared = html`<section class="card"><h2>${TEXT.compare}</h2>
        <div class="pair"><figure>${square(page, a, scale, TEXT.choices["exact"])}<figcaption>${TEXT.choices["exact"]}</figcaption></figure>
        <figure>${square(page, b, scale, TEXT.choices["two-beam"])}<figcaption>${TEXT.choices["two-beam"]}</figcaption></figure></div>
        <p>${TEXT.compare_note(de.toFixed(2))}</p></section>`;
    } catch {
      compared = html`<section class="card"><h2>${TEXT.compare}</h2><p>${TEXT.no_two_beam}</p></section>`;
    }
  }
  const title = TEXT.spectrum_of(`${now}, ${angle}°`);
  return html`${compared}
    <section class="card"><h2>${TEXT.spectrum}</h2>${spectrumChart(title, WAVELENGTHS, curves)}</section>
    ${state.scene === "film" ? scales(page, core, stack, lamp, nm, angle) : nothing}`;
}

/** Newton's scale and its path in the diagram: they stay while thickness and angle move. */
let kept: { key: string; scale: Float64Array; path: Float64Array } | null = null;

function newton(core: Core, stack: string, to: number, model: string, options: { layer: number; illuminant: string }) {
  const key = [stack, to, model, options.layer, options.illuminant].join("|");
  if (kept?.key === key) return kept;
  const along = Float64Array.from({ length: 2 * STRIP }, (_, i) => (i % 2 ? 0 : ((i / 2 + 0.5) / STRIP) * to));
  let scale: Float64Array;
  try {
    scale = core.color(stack, along, { ...options, model });
  } catch {
    scale = core.color(stack, along, options);
  }
  const path: number[] = [];
  for (let i = 0; i < STRIP; i++) {
    const [x, y, z] = scale.subarray(3 * i, 3 * i + 3);
    if (x + y + z > 1e-6) path.push(x / (x + y + z), y / (x + y + z));
  }
  return (kept = { key, scale, path: Float64Array.from(path) });
}

/** All angles of one thickness: from the table that is drawn, where it holds them. */
function allAngles(page: Page, core: Core, stack: string, nm: number, options: { layer: number; illuminant: string }): Float64Array {
  const angle = (i: number) => (i / STRIP) * CHART_DEG;
  const table = page.stage?.isDrawn() && page.stage.picture?.table;
  if (!table || nm > table.range_nm[1] || table.range_deg[1] < CHART_DEG) {
    return core.color(stack, Float64Array.from({ length: 2 * STRIP }, (_, i) => (i % 2 ? angle((i - 1) / 2) : nm)), options);
  }
  const xyz = new Float64Array(3 * STRIP);
  for (let i = 0; i < STRIP; i++) lookUp(table, nm, angle(i), xyz, 3 * i);
  return xyz;
}

/** Where a scale of thickness is marked: even steps, the first with the unit. */
export function tickMarks(to: number): { share: number; label: string }[] {
  const step = to > 2000 ? 500 : to > 600 ? 200 : 100;
  return Array.from({ length: Math.floor(to / step) + 1 }, (_, i) => ({ share: (i * step) / to, label: i ? `${i * step}` : "0 nm" }));
}

function scales(page: Page, core: Core, stack: string, lamp: string, nm: number, angle: number): TemplateResult {
  const to = Number(page.state["thickest_nm"]);
  const model = String(page.state["model"]);
  const options = { layer: page.layer, illuminant: lamp };
  const { scale, path } = newton(core, stack, to, model, options);
  const angles = allAngles(page, core, stack, nm, options);
  const here = core.color(stack, [nm, angle], options);
  const sum = here[0] + here[1] + here[2];
  const marks = tickMarks(to);
  const points = marks.slice(1, 5).map(({ share, label }) => {
    const [x, y, z] = core.color(stack, [share * to, 0], options);
    return { x: x / (x + y + z), y: y / (x + y + z), label };
  });
  return html`
    <section class="card"><h2>${TEXT.newton}</h2><p class="small">${TEXT.newton_of(to)}${model === "two-beam" ? `: ${TEXT.choices[model]}` : ""}</p>
      ${strip(page, TEXT.newton_of(to), scale, marks, orderEnds(page, to).map((nm) => nm / to))}</section>
    <section class="card"><h2>${TEXT.strip}</h2><p class="small">${TEXT.strip_of(nm)}</p>
      ${strip(page, TEXT.strip_of(nm), angles, [0, 15, 30, 45, 60, 75].map((deg) => ({ share: deg / CHART_DEG, label: `${deg}°` })))}</section>
    <section class="card"><h2>${TEXT.diagram}</h2><p class="small">${TEXT.diagram_of(to)}</p>
      ${diagram(TEXT.diagram_of(to), locusOf(core), path, points, sum > 1e-9 ? [here[0] / sum, here[1] / sum] : null)}</section>`;
}

/** Radii of dark rings: by the formula, and where luminance along a radius of this picture is least. */
export function ringsPanel(page: Page): TemplateResult {
  const core = page.core as Core;
  const { state } = page;
  const lamp = core.illuminant(String(state["illuminant"]));
  // Only light of few lines, or of one colour, has rings that one wavelength tells.
  const power = lamp.lines.reduce((sum, [, p]) => sum + p, 0);
  const mean = power > 0 ? lamp.lines.reduce((sum, [nm, p]) => sum + nm * p, 0) / power : 0;
  const spread = lamp.lines.length ? Math.max(...lamp.lines.map(([nm]) => nm)) - Math.min(...lamp.lines.map(([nm]) => nm)) : Infinity;
  const single = spread < 5;
  const wavelength = single ? mean : 550;
  const [radius, contact, view] = ["radius_mm", "thickness_nm", "view_mm"].map((name) => Number(state[name]));
  const measured = measuredRadii(page);
  const rows: TemplateResult[] = [];
  const first = Math.ceil((2 * contact) / wavelength - 1e-9);
  for (let m = Math.max(first, 1); rows.length < 8; m++) {
    const gap = (m * wavelength) / 2 - contact;
    const told = Math.sqrt(gap * 1e-6 * (2 * radius - gap * 1e-6));
    if (told > view / 2) break;
    const near = measured.reduce((best, r) => (Math.abs(r - told) < Math.abs(best - told) ? r : best), NaN);
    const found = measured.find((r) => r === near) ?? [...measured].sort((a, b) => Math.abs(a - told) - Math.abs(b - told))[0];
    rows.push(html`<tr><th scope="row">${m}</th><td>${told.toFixed(3)}</td><td>${found !== undefined && Math.abs(found - told) < 0.1 * told ? found.toFixed(3) : "-"}</td></tr>`);
  }
  return html`<section class="card"><h2>${TEXT.rings_measured}</h2>
    <table><caption>${TEXT.rings_table}${single ? "" : "; λ = 550 nm stands for white light, which holds for the first few rings"}</caption>
    <thead><tr><th scope="col">${TEXT.ring}</th><th scope="col">${TEXT.told}</th><th scope="col">${TEXT.measured}</th></tr></thead><tbody>${rows}</tbody></table></section>`;
}
