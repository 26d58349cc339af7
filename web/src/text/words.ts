// What is seen, in words: the text beside a picture, the name and the order of a film's colour.

import type { Core, FilmState, Item } from "../core/core";
import type { Page } from "../page";
import { measuredRadii } from "../parts/radii";
import { colorName, orderOf } from "./color-names";
import { TEXT } from "./strings";

export function trim(value: number): string {
  return String(Math.round(value * 100) / 100);
}

export function words(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

/** How much brighter a free film is named (and shown) than it is: the eye compares with what else it mirrors. */
const FREE_FILM = 5;

export interface Seen {
  text: string;
  xyz: Float64Array;
  name: string;
}

/** A film in words, from the exact sums. */
export function describe(page: Page, thickness_nm: number, angle_deg: number): Seen {
  const core = page.core as Core;
  const lamp = String(page.state["illuminant"]);
  const xyz = core.color(String(page.state["stack"]), [thickness_nm, angle_deg], { layer: page.layer, illuminant: lamp });
  const lab = core.convert(xyz, "xyz", "lab", lamp);
  const free = lab[0] < 60 && isFree(page.items);
  const scaled = free ? core.convert(xyz.map((v) => v * FREE_FILM), "xyz", "lab", lamp) : lab;
  const name = colorName(scaled[0], scaled[1], scaled[2]);
  return { text: TEXT.seen(trim(thickness_nm), trim(angle_deg), name, order(page, thickness_nm, angle_deg)), xyz, name };
}

/** One film between two media of one kind: one of its reflections is turned over, the other is not. */
function isFree(items: Item[]): boolean {
  return items.length === 3 && items[0].name === items[2].name;
}

/** n of a free film at 550 nm and of what is around it; nothing where the film is another, or is not clear. */
function freeIndices(page: Page): [number, number] | null {
  if (!isFree(page.items)) return null;
  const at = (name: string) => (page.core as Core).call("medium_index", name, [550]).result;
  const [[n0], [n, k]] = [at(page.items[0].name), at(page.items[1].name)];
  return k > 0.01 ? null : [n, n0];
}

/** Thicknesses at which the orders of Newton's scale end, nm. */
export function orderEnds(page: Page, to_nm: number): number[] {
  const indices = freeIndices(page);
  if (!indices) return [];
  const step = 550 / (2 * indices[0]);
  return Array.from({ length: Math.min(Math.floor(to_nm / step), 9) }, (_, i) => step * (i + 1));
}

/** The order on Newton's scale: only a free, clear film has that scale. */
function order(page: Page, thickness_nm: number, angle_deg: number): string {
  const indices = freeIndices(page);
  if (!indices) return "";
  const [n, n0] = indices;
  const sine = (n0 * Math.sin((angle_deg * Math.PI) / 180)) / n;
  return sine >= 1 ? "" : orderOf(2 * n * thickness_nm * Math.sqrt(1 - sine * sine));
}

function livingWords({ thickness_nm, time_s, ruptured_s }: FilmState): string {
  let [least, most, sum] = [Infinity, 0, 0];
  for (const nm of thickness_nm) {
    least = Math.min(least, nm);
    most = Math.max(most, nm);
    sum += nm;
  }
  const facts = TEXT.bubble_facts(time_s.toFixed(1), (sum / thickness_nm.length).toFixed(0), least.toFixed(0), most.toFixed(0));
  return Number.isNaN(ruptured_s) ? facts : `${facts} ${TEXT.burst(ruptured_s.toFixed(1))}`;
}

/** The text twin of the picture. */
export function twin(page: Page): string {
  if (!page.core) return "";
  const { state } = page;
  const film = page.stage?.film.state;
  if (film && page.stage?.living()) return livingWords(film);
  const lamp = TEXT.choices[String(state["illuminant"])] ?? String(state["illuminant"]);
  const nm = Number(state["thickness_nm"]);
  switch (state.scene) {
    case "slick":
      return TEXT.slick_seen(trim(nm), lamp);
    case "bubble":
      return TEXT.still_seen(trim(2 * nm), lamp);
    case "rings": {
      const radii = measuredRadii(page).slice(0, 4).map((r) => r.toFixed(3));
      return TEXT.rings_seen(describe(page, nm, 0).name, radii.join(", "), lamp);
    }
    default:
      return describe(page, nm, Number(state["angle_deg"])).text;
  }
}
