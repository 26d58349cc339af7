// A scene: its picture with its text twin, its controls, what is told beside it.

import { html, noChange, nothing, type TemplateResult } from "lit";
import { keyed } from "lit/directives/keyed.js";
import type { App } from "../app";
import { CHART_DEG } from "../draw/geometry";
import { storyPanel } from "../learn/pages";
import { STORIES } from "../learn/stories";
import { keysOf } from "../state/keys";
import { TEXT } from "../text/strings";
import { describe, twin, words } from "../text/words";
import { control } from "./controls";
import { filmPanel, ringsPanel, tickMarks } from "./panels";
import { swatch } from "./swatch";
import { copyLink, saveCsv, savePicture } from "./take-away";

/** Share of the width of the titanium scene's picture at which its bar begins and ends (draw/geometry.ts). */
const BAR = [0.04, 0.96];

export function scenePage(app: App): TemplateResult {
  const { state, stage } = app;
  const { scene } = state;
  const number = Number(state["story"]);
  const story = STORIES[number - 1];
  const living = Boolean(stage?.living());
  const table = stage?.picture?.table;
  const said = twin(app);
  return html`
    <h1>${TEXT.scenes[scene]}</h1>
    ${story ? storyPanel(app, story, number) : html`<p class="about">${TEXT.about[scene]}</p>`}
    <div class="stage">
      <section class="seen" aria-label=${TEXT.scenes[scene]}>
        <div id="picture" class=${living ? "living" : ""}>
          ${keyed(app.canvasNumber, html`<canvas width="64" height="64" role="img" aria-label=${`${TEXT.scenes[scene]}. ${said}`}
            @pointermove=${(e: PointerEvent) => app.pointed(e)}
            @pointerleave=${() => app.pointed(null)}
            @click=${(e: MouseEvent) => app.choose(e)}></canvas>`)}
          ${scene === "film" ? html`<div class="cross" aria-hidden="true"></div>` : nothing}
          ${scene === "film" ? html`<div class="angles" aria-hidden="true">${[0, 20, 40, 60].map((deg) => html`<span data-share=${deg / CHART_DEG}>${deg}°</span>`)}</div>` : nothing}
          ${scene === "rings" ? html`<div class="scale" aria-hidden="true"><span></span>1 mm</div>` : nothing}
          ${scene === "titanium" ? html`<div class="volts" aria-hidden="true">${[0, 20, 40, 60, 80, 100].map((v) => html`<span data-share=${v / 110}>${v} V</span>`)}</div>` : nothing}
        </div>
        ${scene === "film" ? html`<p class="axis" aria-hidden="true">${tickMarks(Number(state["thickest_nm"])).map(({ share, label }) => html`<span data-share=${share}>${label}</span>`)}</p>` : nothing}
        <p class="twin" id="twin" aria-live=${living ? "off" : "polite"}>${said}</p>
        <p class="tools">
          ${living
            ? html`<button type="button" class="main" @click=${() => app.set({ playing: !state["playing"] })}>${state["playing"] ? TEXT.pause : TEXT.play}</button>
                <button type="button" @click=${() => app.breath()}>${TEXT.blow}</button>
                <button type="button" @click=${() => app.set({ seed: (Number(state["seed"]) + 1) % 1000000 })}>${TEXT.again}</button>`
            : nothing}
          <button type="button" @click=${() => savePicture(app)}>${TEXT.save_picture}</button>
          <button type="button" @click=${() => saveCsv(app)}>${TEXT.save_csv}</button>
          <button type="button" @click=${() => copyLink(app)}>${TEXT.copy_link}</button>
        </p>
        <p class="small" id="told" role="status">${app.told}</p>
        <p class="small">${table ? TEXT.table_error(table.max_delta_e.toFixed(2)) : ""} ${stage?.picture ? TEXT.renderer[stage.picture.kind] : ""}</p>
      </section>
      <section class="controls" aria-label=${TEXT.controls}>
        <h2>${TEXT.controls}</h2>
        ${keysOf(scene).filter((key) => !key.hidden).map((key) => control(app, key))}
        <p><button type="button" @click=${() => app.reset()}>${TEXT.reset}</button></p>
      </section>
    </div>
    ${app.readoutsDue() ? readouts(app) : noChange}`;
}

function readouts(app: App): TemplateResult | typeof nothing {
  if (!app.core || app.core.broken) return nothing;
  const { scene } = app.state;
  const pointed = app.pointer && app.stage?.picture?.at(app.pointer.x, app.pointer.y);
  const own = scene === "titanium" || scene === "wafer" || scene === "film"
    ? { thickness_nm: Number(app.state["thickness_nm"]), angle_deg: Number(app.state["angle_deg"]) }
    : null;
  const here = pointed ?? own;
  try {
    return html`<div class="readouts">
      ${here
        ? html`<section class="card" aria-label=${pointed ? TEXT.pointer : TEXT.film_here}><h2>${pointed ? TEXT.pointer : TEXT.film_here}</h2>
            ${swatch(app, describe(app, here.thickness_nm, here.angle_deg))}</section>`
        : nothing}
      ${scene === "rings" ? ringsPanel(app) : nothing}
      ${own ? filmPanel(app) : nothing}
    </div>`;
  } catch (error) {
    return html`<p class="failure" role="alert">${TEXT.cannot(words(error))}</p>`;
  }
}

/** Places marks on the picture: the page's policy allows no inline styles. */
export function placeMarks(app: App): void {
  const { state } = app;
  const of = (name: string) => Number(state[name]);
  const cross = app.querySelector<HTMLElement>(".cross");
  if (cross) {
    cross.style.left = `${Math.min((100 * of("thickness_nm")) / of("thickest_nm"), 100)}%`;
    cross.style.top = `${(100 * of("angle_deg")) / CHART_DEG}%`;
  }
  const bar = app.querySelector<HTMLElement>(".scale span");
  if (bar) bar.style.width = `${((app.querySelector("#picture")?.clientWidth ?? 0) / of("view_mm")).toFixed(1)}px`;
  for (const mark of app.querySelectorAll<HTMLElement>(".axis span")) {
    const share = Number(mark.dataset["share"]);
    mark.style.left = `${100 * share}%`;
    mark.style.transform = `translateX(-${share < 0.03 ? 0 : share > 0.97 ? 100 : 50}%)`;
  }
  for (const mark of app.querySelectorAll<HTMLElement>(".angles span")) mark.style.top = `${100 * Number(mark.dataset["share"])}%`;
  for (const mark of app.querySelectorAll<HTMLElement>(".volts span")) {
    mark.style.left = `${100 * (BAR[0] + (BAR[1] - BAR[0]) * Number(mark.dataset["share"]))}%`;
  }
}
