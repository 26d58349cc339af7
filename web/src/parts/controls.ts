// A control for each key of the state: native inputs with their labels and units.

import { html, nothing, type TemplateResult } from "lit";
import type { Page } from "../page";
import { type Key, LAMPS, OXIDE_NM, OXIDE_NM_PER_VOLT, type Scene } from "../state/keys";
import { TEXT } from "../text/strings";
import { trim } from "../text/words";

/** Sliders reach as far as is useful; the number beside them takes everything allowed. */
function sliderRange(key: Key, scene: Scene): [number, number] {
  if (key.name === "thickness_nm") return scene === "rings" ? [0, 2000] : scene === "bubble" ? [50, 1200] : [0, scene === "film" ? 3000 : 1500];
  if (key.name === "seed") return [1, 100];
  return key.range as [number, number];
}

export function control(page: Page, key: Key): TemplateResult {
  const { scene } = page.state;
  const label = TEXT.keysOf[`${scene} ${key.name}`] ?? TEXT.keys[key.name] ?? key.name;
  const id = `key-${key.name}`;
  const value = page.state[key.name];
  const help = TEXT.help[key.name];
  const helpId = help ? `${id}-help` : nothing;
  const set = (v: unknown) => page.set({ [key.name]: v });
  switch (key.kind) {
    case "number":
    case "whole": {
      if (scene === "titanium" && key.name === "thickness_nm") {
        return html`<p class="fact">${label}: ${trim(Number(value))} nm = ${OXIDE_NM} + ${OXIDE_NM_PER_VOLT} × V</p>`;
      }
      const [least, most] = sliderRange(key, scene);
      return html`<div class="control">
        <label for=${id}>${label}</label>
        <input type="range" id=${id} min=${least} max=${most} step=${key.step ?? 1} .value=${String(value)} aria-describedby=${helpId}
          aria-valuetext=${`${trim(Number(value))} ${key.unit ?? ""}`}
          @input=${(e: Event) => page.move(key.name, (e.target as HTMLInputElement).valueAsNumber, false)}
          @change=${(e: Event) => page.move(key.name, (e.target as HTMLInputElement).valueAsNumber, true)} />
        <input type="number" class="number" aria-label=${`${label}, ${key.unit ?? ""}`} min=${key.range?.[0] ?? 0} max=${key.range?.[1] ?? 0} step="any" .value=${trim(Number(value))}
          @change=${(e: Event) => set((e.target as HTMLInputElement).value)} /><span class="unit">${key.unit ?? ""}</span>
        ${help ? html`<p class="small" id=${`${id}-help`}>${help}</p>` : nothing}
      </div>`;
    }
    case "flag":
      return html`<div class="control flag"><label><input type="checkbox" id=${id} .checked=${Boolean(value)} @change=${(e: Event) => set((e.target as HTMLInputElement).checked)} /> ${label}</label></div>`;
    case "stack":
      if (scene !== "film") return html`<p class="fact">${label}: <code>${value}</code></p>`;
      return html`<div class="control wide"><label for=${id}>${label}</label>
        <input type="text" id=${id} spellcheck="false" autocomplete="off" maxlength="300" .value=${String(value)} aria-describedby=${helpId}
          @change=${(e: Event) => set((e.target as HTMLInputElement).value)} />
        <p class="small" id=${`${id}-help`}>${help}</p></div>`;
    default: {
      const choices: readonly string[] = key.kind === "illuminant" ? LAMPS : (key.choices as readonly string[]);
      const all = choices.includes(String(value)) ? choices : [...choices, String(value)];
      return html`<div class="control"><label for=${id}>${label}</label>
        <select id=${id} @change=${(e: Event) => set((e.target as HTMLSelectElement).value)}>
          ${all.map((name) => html`<option value=${name} ?selected=${name === value}>${TEXT.choices[name] ?? name}</option>`)}
        </select></div>`;
    }
  }
}
