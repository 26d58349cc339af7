// A scene: its picture with its text twin, its controls, what is told beside it.

import { html, noChange, nothing, type TemplateResult } from "lit";
import { keyed } from "lit/directives/keyed.js";
import { CHART_DEG } from "../draw/geometry";
import { storyPanel } from "../learn/pages";
import { STORIES } from "../learn/stories";
import type { Page } from "../page";
import { keysOf } from "../state/keys";
import { TEXT } from "../text/strings";
import { describe, twin, words } from "../text/words";
import { control } from "./controls";
import { filmPanel, ringsPanel, tickMarks } from "./panels";
import { swatch } from "./swatch";
import { copyLink, saveCsv, savePicture } from "./take-away";

/** Share of the width of the titanium scene's picture at which its bar begins and ends (draw/geometry.ts). */
const BAR = [0.04, 0.96];

export function scenePage(page: Page): TemplateResult {
  const { state, stage } = page;
  const { scene } = state;
  const number = Number(state["story"]);
  const story = STORIES[number - 1];
  const living = Boolean(stage?.living());
  const table = stage?.picture?.table;
  const said = twin(page);
  return html`
    <h1>${TEXT.scenes[scene]}</h1>
    ${story ? storyPanel(page, story, number) : html`<p class="about">${TEXT.about[scene]}</p>`}
    <div class="stage">
      <section class="seen" aria-label=${TEXT.scenes[scene]}>
        <div id="picture" class=${living ? "living" : ""}>
          ${keyed(page.canvasNumber, html`<canvas width="64" height="64" role="img" aria-label=${`${TEXT.scenes[scene]}. ${said}`}
            @pointermove=${(e: PointerEvent) => page.pointed(e)}
            @pointerleave=${() => page.pointed(null)}
            @click=${(e: MouseEvent) => page.choose(e)}></canvas>`)}
          ${scene === "film" ? html`<div class="cross" aria-hidden="true"></div>` : nothing}
          ${scene === "film" ? html`<div class="angles" aria-hidden="true">${[0, 20, 40, 60].map((deg) => html`<span data-share=${deg / CHART_DEG}>${deg}°</span>`)}</div>` : nothing}
          ${scene === "rings" ? html`<div class="scale" aria-hidden="true"><span></span>1 mm</div>` : nothing}
          ${scene === "titanium" ? html`<div class="volts" aria-hidden="true">${[0, 20, 40, 60, 80, 100].map((v) => html`<span data-share=${v / 110}>${v} V</span>`)}</div>` : nothing}
        </div>
        ${scene === "film" ? html`<p class="axis" aria-hidden="true">${tickMarks(Number(state["thickest_nm"])).map(({ share, label }) => html`<span data-share=${share}>${label}</span>`)}</p>` : nothing}
        <p class="twin" id="twin" aria-live=${living ? "off" : "polite"}>${said}</p>
        <p class="tools">
          ${living
            ? html`<button type="button" class="main" @click=${() => page.set({ playing: !state["playing"] })}>${state["playing"] ? TEXT.pause : TEXT.play}</button>
                <button type="button" @click=${() => page.breath()}>${TEXT.blow}</button>
                <button type="button" @click=${() => page.set({ seed: (Number(state["seed"]) + 1) % 1000000 })}>${TEXT.again}</button>`
            : nothing}
          <button type="button" @click=${() => savePicture(page)}>${TEXT.save_picture}</button>
          <button type="button" @click=${() => saveCsv(page)}>${TEXT.save_csv}</button>
          <button type="button" @click=${() => copyLink(page)}>${TEXT.copy_link}</button>
        </p>
        <p class="small" id="told" role="status">${page.told}</p>
        <p class="small">${table ? TEXT.table_error(table.max_delta_e.toFixed(2)) : ""} ${stage?.picture ? TEXT.renderer[stage.picture.kind] : ""}</p>
      </section>
      <section class="controls" aria-label=${TEXT.controls}>
        <h2>${TEXT.controls}</h2>
        ${keysOf(scene).filter((key) => !key.hidden).map((key) => control(page, key))}
        <p><button type="button" @click=${() => page.reset()}>${TEXT.reset}</button></p>
      </section>
    </div>
    ${page.readoutsDue() ? readouts(page) : noChange}`;
}

function readouts(page: Page): TemplateResult | typeof nothing {
  if (!page.core || page.core.broken) return nothing;
  const { scene } = page.state;
  const pointed = page.pointer && page.stage?.picture?.at(page.pointer.x, page.pointer.y);
  const own = scene === "titanium" || scene === "wafer" || scene === "film"
    ? { thickness_nm: Number(page.state["thickness_nm"]), angle_deg: Number(page.state["angle_deg"]) }
    : null;
  const here = pointed ?? own;
  try {
    return html`<div class="readouts">
      ${here
        ? html`<section class="card" aria-label=${pointed ? TEXT.pointer : TEXT.film_here}><h2>${pointed ? TEXT.pointer : TEXT.film_here}</h2>
            ${swatch(page, describe(page, here.thickness_nm, here.angle_deg))}</section>`
        : nothing}
      ${scene === "rings" ? ringsPanel(page) : nothing}
      ${own ? filmPanel(page) : nothing}
    </div>`;
  } catch (error) {
    return html`<p class="failure" role="alert">${TEXT.cannot(words(error))}</p>`;
  }
}

/** Places marks on the picture: the page's policy allows no inline styles. */
export function placeMarks(page: Page & ParentNode): void {
  const { state } = page;
  const of = (name: string) => Number(state[name]);
  const cross = page.querySelector<HTMLElement>(".cross");
  if (cross) {
    cross.style.left = `${Math.min((100 * of("thickness_nm")) / of("thickest_nm"), 100)}%`;
    cross.style.top = `${(100 * of("angle_deg")) / CHART_DEG}%`;
  }
  const bar = page.querySelector<HTMLElement>(".scale span");
  if (bar) bar.style.width = `${((page.querySelector("#picture")?.clientWidth ?? 0) / of("view_mm")).toFixed(1)}px`;
  for (const mark of page.querySelectorAll<HTMLElement>(".axis span")) {
    const share = Number(mark.dataset["share"]);
    mark.style.left = `${100 * share}%`;
    mark.style.transform = `translateX(-${share < 0.03 ? 0 : share > 0.97 ? 100 : 50}%)`;
  }
  for (const mark of page.querySelectorAll<HTMLElement>(".angles span")) mark.style.top = `${100 * Number(mark.dataset["share"])}%`;
  for (const mark of page.querySelectorAll<HTMLElement>(".volts span")) {
    mark.style.left = `${100 * (BAR[0] + (BAR[1] - BAR[0]) * Number(mark.dataset["share"]))}%`;
  }
}
