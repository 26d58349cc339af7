// A stack of the state: one layer is open (`?`), and its thickness is the key `thickness_nm`.

import type { Core, Item } from "../core/core";
import { type State, STACKS, filled } from "./keys";

export interface Opened {
  /** With its open layer written as `?`. */
  stack: string;
  items: Item[];
  /** Thickness that the text gave to the layer that is open now. */
  thickness_nm: number | null;
}

/** Thickest film of the state, nm. */
const MOST_NM = 5000;

/** The stack with the layer `which` open. */
function open(stack: string, which: number): string {
  return stack
    .trim()
    .split(/\s+\/\s+/)
    .map((item, i) => (i === which ? `${item.split(/\s+/)[0]} ?` : item))
    .join(" / ");
}

/** Reads a stack as a link or a script gives it. A stack without `?` opens the layer that is open in the stack shown now or
 * in that of the scene, if it is such a stack; else one as thick as the state's thickness; else its first coherent layer.
 * Throws words on what is wrong. */
export function openStack(core: Core, text: string, state: State, shown: string): Opened {
  let stack = text;
  let items = core.describe(stack);
  let thickness_nm: number | null = null;
  if (!items.some((item) => item.open)) {
    const layers = items.flatMap((item, i) => (item.kind === "coherent" ? [i] : []));
    if (!layers.length) throw new Error("it has no layer that could vary");
    const same = (i: number) => [shown, STACKS[state.scene]].some((known) => filled(known, items[i].thickness_nm as number) === stack);
    const asThick = (i: number) => items[i].thickness_nm === state["thickness_nm"];
    const which = layers.find(same) ?? layers.find(asThick) ?? layers[0];
    thickness_nm = Math.min(items[which].thickness_nm as number, MOST_NM);
    stack = open(stack, which);
    items = core.describe(stack);
  }
  if (items.filter((item) => item.open).length > 1) throw new Error("more than one layer is left open");
  core.color(stack, [100, 0], { layer: items.findIndex((item) => item.open) - 1 });
  return { stack, items, thickness_nm };
}
