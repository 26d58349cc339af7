// The page as an element: its state, what changes it, and the frame around the scenes. What is on the canvas is in
// stage.ts, what stands beside it in parts/.

import { LitElement, html, nothing, type TemplateResult } from "lit";
import { Core, type Item } from "./core/core";
import { loadModule } from "./core/load";
import { CHART_DEG } from "./draw/geometry";
import { learnPage } from "./learn/pages";
import type { Page } from "./page";
import { placeMarks, scenePage } from "./parts/scene-page";
import { paintSwatches } from "./parts/swatch";
import { Stage } from "./stage";
import { KEYS, SCENES, type Scene, type State, type Value, apply, defaults, filled, inScene, keysOf, readLink, writeLink } from "./state/keys";
import { openStack } from "./state/stack";
import { TEXT } from "./text/strings";
import { words } from "./text/words";

export interface Stats {
  /** From the start of the page to its first whole picture. */
  first_picture_ms: number;
  pictures_per_s: number;
  /** Median of a step of the living film. */
  step_ms: number;
  tables: { key: string; seconds: number }[];
  /** Requests to other hosts. */
  external: number;
}

/** Whether motion is not wanted. */
const calm = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

/** A control that has not moved for so long rests, held or not, ms. */
const REST_MS = 250;

/** Time between two states of the charts beside a control that moves, ms. */
const READOUTS_MS = 200;

/** Longest wait for a picture that a script asked for, ms. */
const PATIENCE_MS = 60_000;

export class App extends LitElement implements Page {
  static properties = { version: { state: true } };

  /** Counts what has changed, for Lit. */
  declare version: number;
  state: State = defaults("bubble");
  notes: string[] = [];
  core: Core | null = null;
  stage: Stage | null = null;
  /** Items of the stack; one is open. */
  items: Item[] = [];
  /** The control that is being moved; nothing: they rest, and the picture is refined. */
  moving = "";
  pointer: { x: number; y: number } | null = null;
  /** What happened, for the reader. */
  told = "";
  answerShown = false;
  /** A canvas whose graphics device was lost draws no more: the next number is another element. */
  canvasNumber = 0;
  ready: Promise<void>;
  private failure = "";
  private pending = false;
  private stackChecked = "";
  private lampChecked = "";
  private begun!: () => void;
  private resting = 0;
  private told_ms = 0;

  constructor() {
    super();
    this.version = 0;
    this.ready = new Promise((resolve) => (this.begun = resolve));
  }

  // The page's own style sheet reaches everything: no shadow.
  protected createRenderRoot(): HTMLElement {
    return this;
  }

  connectedCallback(): void {
    super.connectedCallback();
    const read = readLink(location.hash);
    this.state = read.state;
    this.notes = read.notes;
    if (calm() && !/[#&]playing=/.test(location.hash)) {
      this.state["playing"] = false;
    }
    addEventListener("hashchange", () => this.follow(location.hash));
    addEventListener("popstate", () => this.follow(location.hash));
    addEventListener("resize", () => this.refresh());
    document.addEventListener("visibilitychange", () => this.refresh());
    void this.start();
  }

  private async start(): Promise<void> {
    try {
      const module = await loadModule();
      this.core = await Core.from(module);
      this.stage = new Stage(this, this.core, module);
      this.settle();
      this.stage.begin();
      this.refresh();
      await this.drawn();
    } catch (error) {
      this.failure = TEXT.no_start(words(error));
    }
    this.version++;
    this.begun();
  }

  private async until(done: () => boolean): Promise<void> {
    const end = performance.now() + PATIENCE_MS;
    while (!this.failure && this.state.scene !== "learn" && !done() && performance.now() < end) {
      await new Promise((resolve) => setTimeout(resolve, 10));
    }
  }

  /** Resolves with the first picture that shows the state as it is now. */
  drawn(): Promise<void> {
    return this.until(() => !this.pending && Boolean(this.stage?.isDrawn()));
  }

  /** Resolves when the colours are as fine as they will be. */
  async settled(): Promise<void> {
    await this.drawn();
    await this.until(() => !this.pending && Boolean(this.stage?.isSettled()));
  }

  // ------------------------------------------------------------------------------------------------ state

  /** A link was followed, here or by the buttons of the browser. */
  follow(fragment: string): void {
    if (fragment === writeLink(this.state)) return;
    const theme = this.state["theme"];
    const read = readLink(fragment);
    if (!/[#&]theme=/.test(fragment)) read.state["theme"] = theme;
    // A link holds what belongs to its scene. The rest stays as it was, and so does a film that was stopped where motion is
    // not wanted.
    const given = new URLSearchParams(fragment.replace(/^#/, ""));
    const own = new Set(keysOf(read.state.scene).map((key) => key.name));
    if (calm()) own.delete("playing");
    for (const { name } of KEYS) if (!own.has(name) && !given.has(name)) read.state[name] = this.state[name];
    this.state = read.state;
    this.notes = read.notes;
    this.answerShown = false;
    this.settle();
    this.refresh();
  }

  /** Sets keys of the state, a step in the browser's history; answers notes on what was left out. */
  set(changes: Record<string, unknown>): string[] {
    return this.change(changes, true);
  }

  private change(changes: Record<string, unknown>, done: boolean): string[] {
    const { scene, ...rest } = changes;
    this.notes = [];
    if (scene !== undefined && !SCENES.includes(scene as Scene)) this.notes.push(`scene must be one of ${SCENES.join(", ")}`);
    const other = SCENES.includes(scene as Scene) && scene !== this.state.scene;
    this.state = other ? inScene(this.state, scene as Scene) : { ...this.state };
    apply(this.state, Object.entries(rest), this.notes);
    this.settle();
    if (done) this.remember(true);
    this.refresh();
    return this.notes;
  }

  /** Charts follow a moving control a little later than the picture, which must not wait for them. */
  readoutsDue(): boolean {
    const now = performance.now();
    if (this.moving && now - this.told_ms < READOUTS_MS) return false;
    this.told_ms = now;
    return true;
  }

  /** A control was moved a little. */
  move(name: string, value: unknown, done: boolean): void {
    clearTimeout(this.resting);
    this.moving = name;
    this.change({ [name]: value }, done);
    this.resting = window.setTimeout(() => {
      this.moving = "";
      this.remember(false);
      this.refresh();
    }, REST_MS);
  }

  reset(): void {
    this.state = { ...defaults(this.state.scene), theme: this.state["theme"] };
    this.notes = [];
    this.settle();
    this.remember(true);
    this.refresh();
  }

  showAnswer(): void {
    this.answerShown = true;
    this.version++;
  }

  private remember(done: boolean): void {
    const link = writeLink(this.state);
    if (link === location.hash) return;
    try {
      if (done) history.pushState(null, "", link);
      else history.replaceState(null, "", link);
    } catch {
      // Some browsers count changes of the address and refuse after a hundred in half a minute: the next one will do.
    }
  }

  /** Asks the core what only it can judge: lamps and stacks. */
  private settle(): void {
    const core = this.core;
    if (!core) return;
    const lamp = String(this.state["illuminant"]);
    if (lamp !== this.lampChecked) {
      try {
        core.illuminant(lamp);
        this.lampChecked = lamp;
      } catch {
        this.notes.push("illuminant is not one that the core knows");
        this.state["illuminant"] = "D65";
      }
    }
    const stack = String(this.state["stack"]);
    if (stack === this.stackChecked) return;
    let opened;
    try {
      opened = openStack(core, stack, this.state, this.stackChecked);
    } catch (error) {
      this.notes.push(`stack: ${words(error)}`);
      opened = openStack(core, defaults(this.state.scene)["stack"] as string, this.state, "");
    }
    if (opened.thickness_nm !== null) this.state["thickness_nm"] = opened.thickness_nm;
    this.items = opened.items;
    this.state["stack"] = this.stackChecked = opened.stack;
  }

  /** The layer that is open, counted from 0. */
  get layer(): number {
    return this.items.findIndex((item) => item.open) - 1;
  }

  /** The state as scripts see it: the stack as the command line takes it. */
  snapshot(): Record<string, Value> {
    const { scene } = this.state;
    const known: Record<string, Value> = { scene };
    for (const key of keysOf(scene)) known[key.name] = this.state[key.name];
    for (const name of ["thickness_nm", "angle_deg", "illuminant", "preset", "playing"]) known[name] = this.state[name];
    known["stack"] = filled(String(this.state["stack"]), Number(this.state["thickness_nm"]));
    return known;
  }

  // ------------------------------------------------------------------------------------------------ picture

  refresh(): void {
    document.documentElement.dataset["theme"] = String(this.state["theme"]);
    document.title = `${TEXT.scenes[this.state.scene]} - ${TEXT.title}`;
    this.version++;
    if (this.pending) return;
    this.pending = true;
    const go = () => {
      this.pending = false;
      const canvas = this.querySelector<HTMLCanvasElement>("#picture canvas");
      if (!this.stage || !canvas || this.state.scene === "learn") return;
      try {
        this.stage.update(canvas);
      } catch (error) {
        this.fail(error);
      }
    };
    // A hidden page gets no frames; what scripts ask for is drawn all the same.
    if (document.hidden) setTimeout(go, 0);
    else requestAnimationFrame(go);
  }

  /** Says why there is no picture; null: there is one again. */
  fail(error: unknown): void {
    this.failure = error === null ? "" : TEXT.cannot(words(error));
    this.version++;
  }

  anotherCanvas(): void {
    this.canvasNumber++;
    this.refresh();
  }

  tell(what: string): void {
    this.told = what;
    this.version++;
  }

  stats(): Stats {
    const external = performance.getEntriesByType("resource").filter((e) => !e.name.startsWith(location.origin) && !/^(blob|data):/.test(e.name)).length;
    const film = this.stage?.film;
    return {
      first_picture_ms: this.stage?.firstPicture ?? 0,
      pictures_per_s: film?.perSecond() ?? 0,
      step_ms: film?.stepMs() ?? 0,
      tables: this.stage?.tables.made ?? [],
      external,
    };
  }

  flow(): { time_s: number; thickness_nm: Float32Array; columns: number; rows: number } | null {
    const film = this.stage?.living() ? this.stage.film.state : null;
    if (!film) return null;
    const { time_s, thickness_nm, columns, rows } = film;
    return { time_s, thickness_nm: thickness_nm.slice(), columns, rows };
  }

  // ------------------------------------------------------------------------------------------------ pointer

  private pixelOf(event: MouseEvent): { x: number; y: number } | null {
    const canvas = this.stage?.picture?.canvas;
    if (!canvas) return null;
    const box = canvas.getBoundingClientRect();
    const x = Math.floor(((event.clientX - box.left) / box.width) * canvas.width);
    const y = Math.floor(((event.clientY - box.top) / box.height) * canvas.height);
    return { x, y };
  }

  /** The pointer is over the picture, or has left it. */
  pointed(event: PointerEvent | null): void {
    this.pointer = event && this.pixelOf(event);
    const stage = this.stage;
    if (event && stage) stage.film.stir(event, (this.pointer && stage.picture?.at(this.pointer.x, this.pointer.y)?.place) ?? null);
    if (!event || !stage?.living()) this.version++;
  }

  /** A place of the chart of a film was chosen. */
  choose(event: MouseEvent): void {
    const found = this.state.scene === "film" && this.pixelOf(event);
    if (!found || !this.stage?.picture) return;
    const { width, height } = this.stage.picture.canvas;
    this.set({
      thickness_nm: Math.round(((found.x + 0.5) / width) * Number(this.state["thickest_nm"])),
      angle_deg: Math.min(Math.max(Math.round(((found.y + 0.5) / height) * CHART_DEG), 0), CHART_DEG),
    });
  }

  /** A breath across the middle of the picture, for those who do not drag. */
  breath(): void {
    const picture = this.stage?.picture;
    if (!picture?.geometry) return;
    const { width, height } = picture.geometry;
    const at = picture.at(width >> 1, Math.floor(height * 0.45));
    if (at) this.stage?.film.blow(at.place, [0.06, 0], 0.06);
  }

  // ------------------------------------------------------------------------------------------------ page

  render(): TemplateResult {
    const { scene } = this.state;
    return html`
      <a class="skip" href="#main" @click=${(e: Event) => { e.preventDefault(); this.querySelector<HTMLElement>("main")?.focus(); }}>${TEXT.skip}</a>
      <header>
        <p class="brand"><span class="mark" aria-hidden="true"></span><b>${TEXT.title}</b> <span>${TEXT.tagline}</span></p>
        <nav aria-label=${TEXT.scenes_of}>
          ${SCENES.map(
            (name) => html`<a href=${writeLink(inScene({ ...this.state, story: 0, sheet: 0 } as State, name))} aria-current=${name === scene ? "page" : nothing}
              @click=${(e: MouseEvent) => this.go(e, name)}>${TEXT.scenes[name]}</a>`,
          )}
        </nav>
      </header>
      <main id="main" tabindex="-1" class=${`scene-${scene}`}>
        ${this.failure ? html`<p class="failure" role="alert">${this.failure}</p>` : nothing}
        ${this.notes.length
          ? html`<div class="notes" role="status"><p>${TEXT.left_out}</p><ul>${this.notes.map((note) => html`<li>${note}</li>`)}</ul></div>`
          : nothing}
        ${scene === "learn" ? learnPage(this) : scenePage(this)}
      </main>
      <footer><p>${TEXT.footer}</p>
        <label>${TEXT.theme} <select id="theme" @change=${(e: Event) => this.set({ theme: (e.target as HTMLSelectElement).value })}>
          ${["auto", "light", "dark"].map((name) => html`<option value=${name} ?selected=${this.state["theme"] === name}>${TEXT.choices[name]}</option>`)}
        </select></label>
      </footer>`;
  }

  private go(event: MouseEvent, scene: Scene): void {
    if (event.ctrlKey || event.metaKey || event.shiftKey || event.button !== 0) return;
    event.preventDefault();
    this.set({ scene, story: 0, sheet: 0 });
  }

  protected updated(): void {
    paintSwatches(this);
    placeMarks(this);
  }
}

customElements.define("iridesce-page", App);
