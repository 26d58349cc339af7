// The state of the page: one table of keys makes the reader and the writer of links, the controls and their texts.

export const SCENES = ["bubble", "rings", "slick", "titanium", "wafer", "film", "learn"] as const;
export type Scene = (typeof SCENES)[number];
export type Value = number | string | boolean;
export type State = Record<string, Value> & { scene: Scene };

export interface Key {
  name: string;
  kind: "number" | "choice" | "flag" | "stack" | "illuminant" | "whole";
  /** As it is written behind a number. */
  unit?: string;
  range?: [number, number];
  step?: number;
  choices?: readonly string[];
  default: Value;
  /** Defaults of single scenes; such a key starts anew where the scene changes. */
  of?: Partial<Record<Scene, Value>>;
  /** Scenes that have it; all if left out. */
  scenes?: readonly Scene[];
  /** Has no control of its own. */
  hidden?: boolean;
}

export const PRESETS = [
  "free-bubble-preview",
  "bubble-on-bath-preview",
  "late-preview",
  "vertical-film-preview",
  "still",
] as const;

/** Lamps offered; links may name any other of the core. */
export const LAMPS = [
  "D65", "A", "D50", "E", "FL2", "FL11", "LED-B1", "blackbody:4000", "lines:589.158*2,589.756", "lines:546.227,404.77,435.96,577.12,579.23", "laser:632.99",
] as const;

export const STACKS: Record<Scene, string> = {
  bubble: "air / soap ? / air",
  // The bloomed lens, the glass, the gap, the plate on its black base: the rings as an eye above them sees them.
  rings: "air / MgF2 99.75 / N-BK7 1e6 incoherent / air ? / N-BK7",
  slick: "air / 1.47 ? / water",
  titanium: "air / TiO2 ? / Ti",
  wafer: "air / SiO2 ? / Si",
  film: "air / soap ? / air",
  learn: "air / soap ? / air",
};

/** Anodised titanium: nm of oxide that air has made, and nm a volt (docs: published charts). */
export const OXIDE_NM = 5;
export const OXIDE_NM_PER_VOLT = 2.4;

const PICTURES = ["bubble", "rings", "slick", "titanium", "wafer"] as const;

export const KEYS: readonly Key[] = [
  { name: "stack", kind: "stack", default: STACKS.film, of: STACKS },
  {
    name: "thickness_nm", kind: "number", unit: "nm", range: [0, 5000], step: 1, default: 320,
    of: { bubble: 450, rings: 0, slick: 900, titanium: 125, wafer: 300, film: 320, learn: 320 },
    scenes: ["bubble", "rings", "slick", "titanium", "wafer", "film"],
  },
  {
    name: "angle_deg", kind: "number", unit: "°", range: [0, 80], step: 1, default: 0,
    of: { wafer: 35, film: 30, titanium: 20 },
    scenes: ["titanium", "wafer", "film"],
  },
  { name: "illuminant", kind: "illuminant", default: "D65" },
  // bubble
  { name: "preset", kind: "choice", choices: PRESETS, default: PRESETS[0], scenes: ["bubble"] },
  { name: "playing", kind: "flag", default: true, scenes: ["bubble"] },
  { name: "age_s", kind: "number", unit: "s", range: [0, 20], step: 0.1, default: 0.8, scenes: ["bubble"] },
  { name: "wind_m_s", kind: "number", unit: "m/s", range: [0, 0.5], step: 0.01, default: 0.15, scenes: ["bubble"] },
  { name: "gravity_m_s2", kind: "number", unit: "m/s²", range: [0, 25], step: 0.1, default: 9.81, scenes: ["bubble"] },
  { name: "walls", kind: "choice", choices: ["2", "1"], default: "2", scenes: ["bubble"] },
  { name: "seed", kind: "whole", range: [0, 999999], step: 1, default: 1, scenes: ["bubble", "slick"] },
  // rings
  { name: "radius_mm", kind: "number", unit: "mm", range: [300, 10000], step: 10, default: 1000, scenes: ["rings"] },
  { name: "view_mm", kind: "number", unit: "mm", range: [1, 16], step: 0.1, default: 4.8, scenes: ["rings"] },
  // titanium
  { name: "volts", kind: "number", unit: "V", range: [0, 110], step: 1, default: 50, scenes: ["titanium"] },
  // wafer
  { name: "edge_nm", kind: "number", unit: "nm", range: [0, 2000], step: 1, default: 340, scenes: ["wafer"] },
  // film
  { name: "thickest_nm", kind: "number", unit: "nm", range: [100, 5000], step: 10, default: 1200, scenes: ["film"] },
  { name: "model", kind: "choice", choices: ["exact", "two-beam"], default: "exact", scenes: ["film"] },
  // pictures
  {
    name: "environment", kind: "choice", choices: ["studio", "overcast", "uniform"], default: "studio",
    of: { slick: "overcast", titanium: "overcast", wafer: "overcast" }, scenes: ["bubble", "slick", "titanium", "wafer"],
  },
  { name: "exposure", kind: "number", unit: "stops", range: [-5, 5], step: 0.1, default: 0, scenes: PICTURES },
  // learn: a story told beside the picture (0: none); the number of a worksheet (0: none)
  { name: "story", kind: "whole", range: [0, 6], default: 0, of: {}, hidden: true },
  { name: "sheet", kind: "whole", range: [0, 999999], default: 0, of: {}, scenes: ["learn"], hidden: true },
  { name: "theme", kind: "choice", choices: ["auto", "light", "dark"], default: "auto", hidden: true },
];

/** What a flowing film starts from, where nobody says otherwise. */
export const OF_PRESET: Record<string, Record<string, number>> = {
  "free-bubble-preview": { thickness_nm: 450, wind_m_s: 0.15 },
  "bubble-on-bath-preview": { thickness_nm: 450, wind_m_s: 0 },
  "late-preview": { thickness_nm: 260, wind_m_s: 0 },
  "vertical-film-preview": { thickness_nm: 700, wind_m_s: 0 },
  still: { thickness_nm: 400, wind_m_s: 0 },
};

/** Widest gap that a table of rings holds, nm: beyond it even two sodium lines are far out of step. */
export const WIDEST_GAP_NM = 30000;

const BY_NAME = new Map(KEYS.map((key) => [key.name, key]));

export function keysOf(scene: Scene): Key[] {
  return KEYS.filter((key) => !key.scenes || key.scenes.includes(scene));
}

export function defaultOf(key: Key, scene: Scene): Value {
  return key.of?.[scene] ?? key.default;
}

export function defaults(scene: Scene): State {
  const state: State = { scene };
  for (const key of KEYS) state[key.name] = defaultOf(key, scene);
  return state;
}

/** The state in another scene: what belongs to scenes starts anew, the rest stays. */
export function inScene(state: State, scene: Scene): State {
  const next: State = { ...state, scene };
  for (const key of KEYS) if (key.of) next[key.name] = defaultOf(key, scene);
  return next;
}

/** Longest link that is read, in characters. */
export const LONGEST_LINK = 4096;
const LONGEST_TEXT = 300;

/** A value made fit for its key, or why it cannot be. */
export function fit(key: Key, value: unknown): { value: Value } | { why: string } {
  switch (key.kind) {
    case "number":
    case "whole": {
      const number = typeof value === "number" ? value : typeof value === "string" && value.trim() !== "" ? Number(value) : NaN;
      const [least, most] = key.range as [number, number];
      if (!(number >= least && number <= most)) return { why: `must be from ${least} to ${most}` };
      return { value: key.kind === "whole" ? Math.round(number) : number };
    }
    case "flag": {
      if (value === true || value === "1" || value === "true") return { value: true };
      if (value === false || value === "0" || value === "false") return { value: false };
      return { why: "must be 1 or 0" };
    }
    case "choice":
      if (key.choices?.includes(String(value))) return { value: String(value) };
      return { why: `must be one of ${key.choices?.join(", ")}` };
    case "illuminant":
      // A file of the user's own is out of reach here; the rest is for the core to judge.
      if (typeof value === "string" && /^[\w:.*,+ -]{1,120}$/.test(value)) return { value };
      return { why: "must be the name of an illuminant" };
    case "stack":
      if (typeof value === "string" && value.length <= LONGEST_TEXT && /^[\w+.?/() -]+$/.test(value)) return { value };
      return { why: 'must be a stack such as "air / soap 320 / air"' };
  }
}

export interface Read {
  state: State;
  /** What was dropped, and why: names of keys and rules only, never text of the link. */
  notes: string[];
}

/** Reads a link's fragment. What is unknown or out of range falls back to its default, with a note. */
export function readLink(fragment: string, base: State | null = null): Read {
  const notes: string[] = [];
  let text = fragment.replace(/^#/, "");
  if (text.length > LONGEST_LINK) {
    notes.push(`the link is longer than ${LONGEST_LINK} characters; it was left out`);
    text = "";
  }
  const given = new Map<string, string>();
  for (const [name, value] of new URLSearchParams(text)) given.set(name, value);
  const version = given.get("v");
  if (version !== undefined && version !== "1") notes.push("v must be 1; the link may come from a newer page");
  const asked = given.get("scene");
  const known = SCENES.find((scene) => scene === asked);
  if (asked !== undefined && !known) notes.push(`scene must be one of ${SCENES.join(", ")}`);
  const scene = known ?? base?.scene ?? "bubble";
  const state = base && base.scene === scene ? { ...base } : base ? inScene(base, scene) : defaults(scene);
  given.delete("v");
  given.delete("scene");
  apply(state, given, notes);
  return { state, notes };
}

/** Sets what is given, in place. */
export function apply(state: State, given: Iterable<[string, unknown]>, notes: string[]): void {
  let unknown = 0;
  const before = state["preset"];
  const names = new Set<string>();
  for (const [name, value] of given) {
    const key = BY_NAME.get(name);
    if (!key) {
      unknown += 1;
      continue;
    }
    const fitted = fit(key, value);
    if ("why" in fitted) notes.push(`${name} ${fitted.why}`);
    else {
      state[name] = fitted.value;
      names.add(name);
    }
  }
  if (state["preset"] !== before) {
    for (const [name, value] of Object.entries(OF_PRESET[String(state["preset"])] ?? {})) {
      if (!names.has(name)) state[name] = value;
    }
  }
  if (state.scene === "titanium") {
    if (names.has("thickness_nm") && !names.has("volts")) {
      state["volts"] = Math.min(Math.max((Number(state["thickness_nm"]) - OXIDE_NM) / OXIDE_NM_PER_VOLT, 0), 110);
    }
    state["thickness_nm"] = round(OXIDE_NM + OXIDE_NM_PER_VOLT * Number(state["volts"]));
  }
  if (state.scene === "rings") {
    const room = WIDEST_GAP_NM - Number(state["thickness_nm"]);
    const widest = Math.floor(Math.sqrt(4e-6 * room * Number(state["radius_mm"])) * 10) / 10;
    if (Number(state["view_mm"]) > widest) {
      state["view_mm"] = widest;
      notes.push(`view_mm must be at most ${widest} for this lens`);
    }
  }
  if (unknown > 0) notes.push(`${unknown} unknown ${unknown === 1 ? "key was" : "keys were"} left out`);
}

function round(nm: number): number {
  return Math.round(nm * 1e6) / 1e6;
}

/** The fragment of a state: what differs from the defaults of its scene. */
export function writeLink(state: State): string {
  const words = new URLSearchParams({ v: "1", scene: state.scene });
  for (const key of keysOf(state.scene)) {
    const value = state[key.name];
    const own = OF_PRESET[String(state["preset"])]?.[key.name];
    const usual = state.scene === "bubble" && own !== undefined ? own : defaultOf(key, state.scene);
    if (value === usual || (state.scene === "titanium" && key.name === "thickness_nm")) continue;
    words.set(key.name, typeof value === "boolean" ? (value ? "1" : "0") : String(value));
  }
  return `#${words.toString()}`;
}

/** The stack with its open layer filled in, as the command line takes it. */
export function filled(stack: string, thickness_nm: number): string {
  return stack.replace(/\?/g, String(thickness_nm));
}
