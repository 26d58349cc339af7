// What the parts of the page, its words and its stage see of it. Types alone: the element itself (app.ts) uses all of
// them, and none of them uses it.

import type { Core, FilmState, Item } from "./core/core";
import type { Picture } from "./draw/picture";
import type { State } from "./state/keys";

/** The page: its state, and what may be asked of it. */
export interface Page {
  state: State;
  /** Counts what has changed: each step draws the page anew. */
  version: number;
  readonly core: Core | null;
  readonly stage: Shown | null;
  /** Items of the stack; one is open. */
  readonly items: Item[];
  /** The layer that is open, counted from 0. */
  readonly layer: number;
  /** The control that is being moved; nothing: they rest. */
  readonly moving: string;
  readonly pointer: { x: number; y: number } | null;
  readonly told: string;
  readonly answerShown: boolean;
  readonly canvasNumber: number;

  set(changes: Record<string, unknown>): string[];
  move(name: string, value: unknown, done: boolean): void;
  reset(): void;
  showAnswer(): void;
  readoutsDue(): boolean;
  refresh(): void;
  fail(error: unknown): void;
  tell(what: string): void;
  anotherCanvas(): void;
  pointed(event: PointerEvent | null): void;
  choose(event: MouseEvent): void;
  breath(): void;
}

/** What is on the canvas (stage.ts). */
export interface Shown {
  readonly picture: Picture | null;
  readonly film: { readonly state: FilmState | null };
  living(): boolean;
  isDrawn(): boolean;
  draw(): void;
}
