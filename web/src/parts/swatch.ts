// A colour beside its numbers and its name.

import { html, type TemplateResult } from "lit";
import { shown } from "../draw/picture";
import type { Page } from "../page";
import type { Seen } from "../text/words";

/** A square of colour; the style is set by paintSwatches, as the page's policy allows no inline styles. */
export function square(page: Page, xyz: ArrayLike<number>, scale: number, label: string): TemplateResult {
  const core = page.core;
  if (!core) return html``;
  const srgb = core.convert(Array.from(xyz, (v) => v * scale), "xyz", "srgb", "", "hue");
  const color = `rgb(${Array.from(srgb, (v) => Math.round(255 * Math.min(Math.max(v, 0), 1))).join(" ")})`;
  return html`<span class="swatch" role="img" aria-label=${label} data-color=${color}></span>`;
}

export function paintSwatches(root: ParentNode): void {
  for (const one of root.querySelectorAll<HTMLElement>("[data-color]")) {
    if (one.style.backgroundColor !== one.dataset["color"]) one.style.backgroundColor = one.dataset["color"] ?? "";
  }
}

/** How much brighter a swatch is shown than it is: free films mirror little. */
export function brightening(y: number): number {
  return y > 0.35 ? 1 : y > 0.12 ? 2 : 5;
}

export function swatch(page: Page, film: Seen): TemplateResult {
  const core = page.core;
  if (!core) return html``;
  const lab = core.convert(film.xyz, "xyz", "lab", String(page.state["illuminant"]));
  const scale = brightening(film.xyz[1]);
  const sum = film.xyz[0] + film.xyz[1] + film.xyz[2];
  return html`<div class="swatches">${square(page, film.xyz, scale, film.name)}
    <dl>
      <div><dt>${film.text}</dt></div>
      <div><dt>XYZ</dt><dd>${Array.from(film.xyz, (v) => v.toFixed(4)).join(" ")}</dd></div>
      <div><dt>xy</dt><dd>${sum > 0 ? `${(film.xyz[0] / sum).toFixed(4)} ${(film.xyz[1] / sum).toFixed(4)}` : "-"}</dd></div>
      <div><dt>Lab</dt><dd>${Array.from(lab, (v) => v.toFixed(1)).join(" ")}</dd></div>
      ${scale > 1 ? html`<div><dt>shown</dt><dd>${scale} × brighter</dd></div>` : ""}
    </dl></div>`;
}

/** Colours in a row, drawn as a strip. `xyz`: three numbers each. */
export function paintStrip(canvas: HTMLCanvasElement, page: Page, xyz: Float64Array): void {
  const count = xyz.length / 3;
  canvas.width = count;
  canvas.height = 1;
  const context = canvas.getContext("2d");
  const look = page.stage?.picture?.look;
  if (!context || !look) return;
  let most = 0;
  for (let i = 0; i < count; i++) most = Math.max(most, xyz[3 * i + 1]);
  const image = context.createImageData(count, 1);
  const bright = { rgb_from_xyz: look.rgb_from_xyz, moving: false, exposure: most > 0 ? 0.82 / most : 1 };
  for (let i = 0; i < count; i++) {
    shown(xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2], bright, image.data, 4 * i);
    image.data[4 * i + 3] = 255;
  }
  context.putImageData(image, 0, 0);
}
