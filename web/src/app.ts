// The page: state, picture, controls, readouts. What it draws comes from draw/, what it knows from core/.

import { LitElement, html, nothing, type TemplateResult } from "lit";
import { Core, type FilmState, type Item, type Table, type TableRequest } from "./core/core";
import { Job, Tables } from "./core/jobs";
import { loadModule } from "./core/load";
import { lookUp } from "./core/look-up";
import { CHART_DEG, aspectOf, geometryOf } from "./draw/geometry";
import { Picture } from "./draw/picture";
import { STORIES } from "./learn/stories";
import { worksheet } from "./learn/worksheet";
import { filmPanel, measuredRadii, ringsPanel } from "./parts/panels";
import { paintSwatches, swatch } from "./parts/swatch";
import {
  type Key, LAMPS, OXIDE_NM, OXIDE_NM_PER_VOLT, PRESETS, SCENES, type Scene, type State, type Value, apply, defaults,
  filled, inScene, keysOf, readLink, writeLink,
} from "./state/keys";
import { STORED } from "./state/stored";
import { colorName, orderOf } from "./text/color-names";
import { TEXT } from "./text/strings";

/** Colours while something moves, and when it has come to rest: CIEDE2000 against the exact sums. */
const DRAFT = 0.5;
const FINE = 0.1;
/** A step of film that a picture may wait for, s. */
const LONGEST_STEP_S = 0.1;
/** Sides of a living picture, in pixels: fewer where a machine cannot keep up. */
const SIDES = [640, 560, 480, 416, 352, 288];
const WANTED_PER_S = 30;
/** Metals and silicon are shown no brighter than this times what they mirror: their colours are those of a bright surface. */
const BRIGHTEST = 1.6;

export interface Stats {
  first_picture_ms: number;
  pictures_per_s: number;
  step_ms: number;
  tables: { key: string; seconds: number }[];
  external: number;
}

export class App extends LitElement {
  static properties = { version: { state: true } };

  declare version: number;
  state: State = defaults("bubble");
  notes: string[] = [];
  core: Core | null = null;
  picture: Picture | null = null;
  ready: Promise<void>;
  private told = "";
  private failure = "";
  private module: WebAssembly.Module | null = null;
  private tables: Tables | null = null;
  private flowJob: Job | null = null;
  private film: FilmState | null = null;
  private filmKey = "";
  private filmBusy = false;
  private flowed = 0;
  private geometryKey = "";
  private tableKey = "";
  private fieldKey = "";
  private exposureKey = "";
  private automatic = 1;
  private dragging = false;
  private pending = false;
  private pointer: { x: number; y: number } | null = null;
  private lastStir: { place: [number, number]; time: number } | null = null;
  private sideIndex = 0;
  private times: number[] = [];
  private stepMs: number[] = [];
  private firstPicture = 0;
  private water: Float64Array = new Float64Array(91);
  private rgb: Float64Array = new Float64Array(9);
  private items: Item[] = [];
  private itemsKey = "";
  private lampChecked = "";
  private answerShown = false;
  private begun!: () => void;

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
    if (matchMedia("(prefers-reduced-motion: reduce)").matches && !/[#&]playing=/.test(location.hash)) {
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
      this.module = await loadModule();
      this.core = await Core.from(this.module);
      this.tables = new Tables(this.module, STORED);
      this.flowJob = new Job(this.module);
      this.rgb = transposed(this.core.convert([1, 0, 0, 0, 1, 0, 0, 0, 1], "xyz", "linear-srgb"));
      this.water = Float64Array.from({ length: 91 }, (_, deg) =>
        deg === 90 ? 1 : (this.core as Core).spectrum("air / water", [550], deg)[0],
      );
      this.settle();
      this.refresh();
      await this.drawn();
    } catch (error) {
      this.failure = TEXT.no_start(words(error));
    }
    this.version++;
    this.begun();
  }

  /** Resolves with the first picture that shows the state as it is now. */
  async drawn(): Promise<void> {
    for (let i = 0; i < 2000; i++) {
      if (this.failure || this.state.scene === "learn") return;
      if (!this.pending && this.picture?.table && this.tableKey === this.wantedTable(DRAFT) && this.fieldReady()) return;
      await new Promise((resolve) => setTimeout(resolve, 10));
    }
  }

  /** Resolves when the colours are as fine as they will be. */
  async settled(): Promise<void> {
    await this.drawn();
    for (let i = 0; i < 2000; i++) {
      if (this.failure || this.state.scene === "learn" || (this.picture?.table && this.picture.table === this.fine())) return;
      await new Promise((resolve) => setTimeout(resolve, 10));
    }
  }

  private fine(): Table | undefined {
    return this.tables?.find(this.request(FINE));
  }

  // ------------------------------------------------------------------------------------------------ state

  /** A link was followed, here or by the buttons of the browser. */
  follow(fragment: string): void {
    if (fragment === writeLink(this.state)) return;
    const theme = this.state["theme"];
    const read = readLink(fragment);
    if (!/[#&]theme=/.test(fragment)) read.state["theme"] = theme;
    this.state = read.state;
    this.notes = read.notes;
    this.answerShown = false;
    this.settle();
    this.refresh();
  }

  set(changes: Record<string, unknown>, done = true): string[] {
    const { scene, ...rest } = changes;
    this.notes = [];
    if (scene !== undefined) {
      if (SCENES.includes(scene as Scene)) this.state = inScene(this.state, scene as Scene);
      else this.notes.push(`scene must be one of ${SCENES.join(", ")}`);
    } else this.state = { ...this.state };
    apply(this.state, Object.entries(rest), this.notes);
    this.settle();
    this.remember(done);
    this.refresh();
    return this.notes;
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
    this.state["stack"] = this.checkedStack(String(this.state["stack"]));
  }

  private checkedStack(stack: string): string {
    const core = this.core as Core;
    if (stack === this.itemsKey) return stack;
    const usual = defaults(this.state.scene)["stack"] as string;
    try {
      let items = core.describe(stack);
      if (!items.some((item) => item.open)) {
        // The first coherent layer is the one that varies.
        const which = items.findIndex((item) => item.kind === "coherent");
        if (which < 0) throw new Error("it has no layer that could vary");
        this.state["thickness_nm"] = Math.min(items[which].thickness_nm as number, 5000);
        stack = stack
          .trim()
          .split(/\s+\/\s+/)
          .map((item, i) => (i === which ? `${item.split(/\s+/)[0]} ?` : item))
          .join(" / ");
        items = core.describe(stack);
      }
      if (items.filter((item) => item.open).length > 1) throw new Error("more than one layer is left open");
      core.color(stack, [100, 0], { layer: items.findIndex((item) => item.open) - 1 });
      this.items = items;
    } catch (error) {
      this.notes.push(`stack: ${words(error)}`);
      stack = usual;
      this.items = core.describe(stack);
    }
    this.itemsKey = stack;
    return stack;
  }

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

  // ------------------------------------------------------------------------------------------------ drawing

  refresh(): void {
    document.documentElement.dataset["theme"] = String(this.state["theme"]);
    document.title = `${TEXT.scenes[this.state.scene]} - ${TEXT.title}`;
    this.version++;
    if (this.pending) return;
    this.pending = true;
    // A hidden page gets no frames; what scripts ask for is drawn all the same.
    const go = () => {
      this.pending = false;
      try {
        this.update_picture();
      } catch (error) {
        this.failure = TEXT.cannot(words(error));
        this.version++;
      }
    };
    if (document.hidden) setTimeout(go, 0);
    else requestAnimationFrame(go);
  }

  private canvas(): HTMLCanvasElement | null {
    return this.querySelector("#picture canvas");
  }

  private range(fine: boolean): { range_nm: [number, number]; range_deg: [number, number] } {
    // Towards grazing light colours change so fast that tables grow tenfold: beyond, the colours of the last angle are held.
    const range_deg: [number, number] = [0, fine ? 85 : 80];
    const of = (name: string) => Number(this.state[name]);
    switch (this.state.scene) {
      case "rings": {
        const r2 = of("view_mm") ** 2 / 2;
        const gap = of("thickness_nm") + (1e6 * r2) / (of("radius_mm") + Math.sqrt(of("radius_mm") ** 2 - r2));
        return { range_nm: [0, Math.ceil(gap / 500) * 500], range_deg: [0, 0] };
      }
      case "slick":
        return { range_nm: [0, Math.max(of("thickness_nm"), 50)], range_deg };
      case "titanium":
        return { range_nm: [0, 300], range_deg };
      case "wafer":
        return { range_nm: [0, Math.max(Math.ceil(Math.max(of("thickness_nm"), of("edge_nm")) / 500), 1) * 500], range_deg };
      case "film":
        return { range_nm: [0, of("thickest_nm")], range_deg: [0, CHART_DEG] };
      default: {
        let most = 1500;
        if (this.film) for (const nm of this.film.thickness_nm) if (nm > most) most = nm;
        if (this.state["preset"] === "still") most = Math.max(most, 2 * of("thickness_nm"));
        return { range_nm: [0, Math.min(Math.ceil(most / 500) * 500, 20000)], range_deg };
      }
    }
  }

  request(max_delta_e: number): TableRequest {
    const stack = String(this.state["stack"]);
    return { stack, layer: this.layer, illuminant: String(this.state["illuminant"]), ...this.range(max_delta_e === FINE), max_delta_e };
  }

  private wantedTable(max_delta_e: number): string {
    return Tables.key(this.request(max_delta_e));
  }

  private fieldReady(): boolean {
    return this.fieldKey === this.wantedField();
  }

  private wantedField(): string {
    const { scene } = this.state;
    if (scene === "slick") return `swirls ${this.state["thickness_nm"]} ${this.state["seed"]}`;
    if (scene !== "bubble") return "none";
    if (this.state["preset"] === "still") return `still ${this.state["thickness_nm"]}`;
    return `flow ${this.state["preset"]} ${this.state["thickness_nm"]} ${this.state["seed"]} ${this.state["age_s"]}`;
  }

  private living(): boolean {
    return this.state.scene === "bubble" && this.state["preset"] !== "still";
  }

  private update_picture(): void {
    const { scene } = this.state;
    if (!this.core || scene === "learn") return;
    const canvas = this.canvas();
    if (!canvas) return;
    if (!this.picture || this.picture.canvas !== canvas) {
      this.picture?.dispose();
      const without = /[#&?]webgl=0/.test(location.search);
      this.picture = new Picture(canvas, () => {
        this.told = TEXT.lost;
        this.version++;
      }, without);
      if (this.picture.kind === "canvas") this.told = TEXT.slow;
      this.geometryKey = this.tableKey = "";
      if (this.film && this.living()) this.picture.setField(this.film);
      else this.fieldKey = "";
    }
    this.updateGeometry();
    void this.updateField();
    void this.updateTable();
    this.draw();
    void this.live();
  }

  private updateGeometry(): void {
    const picture = this.picture as Picture;
    const box = picture.canvas.parentElement as HTMLElement;
    const aspect = aspectOf(this.state);
    const ratio = this.living() ? 1 : Math.min(devicePixelRatio || 1, 2);
    const most = this.living() ? SIDES[picture.kind === "canvas" ? SIDES.length - 1 : this.sideIndex] : picture.kind === "canvas" ? 480 : 1000;
    const width = Math.max(64, Math.round(Math.min((box.clientWidth || 480) * ratio, most * Math.max(aspect, 1))));
    const height = Math.round(width / aspect);
    const names = ["preset", "environment", "walls", "radius_mm", "view_mm", "angle_deg", "edge_nm", "thickest_nm"];
    if (scene_has_own_thickness(this.state.scene)) names.push("thickness_nm");
    const key = [this.state.scene, width, height, ...names.map((name) => this.state[name])].join("|");
    if (key === this.geometryKey) return;
    this.geometryKey = key;
    picture.setGeometry(geometryOf({ width, height, state: this.state, water: this.water }));
  }

  private async updateField(): Promise<void> {
    const wanted = this.wantedField();
    if (wanted === this.fieldKey) return;
    const picture = this.picture as Picture;
    if (this.state.scene === "slick") {
      const [max_nm, seed] = [Math.max(Number(this.state["thickness_nm"]), 21), Number(this.state["seed"])];
      if (this.fieldKey === `asked ${wanted}`) return;
      this.fieldKey = `asked ${wanted}`;
      const { values, columns, rows } = await (this.flowJob as Job).ask<"swirls">({ kind: "swirls", id: 0, min_nm: 20, max_nm, seed });
      if (this.wantedField() !== wanted) return;
      picture.setField({ columns, rows, thickness_nm: values });
    } else if (wanted.startsWith("still")) {
      const mean = Number(this.state["thickness_nm"]);
      picture.setField({ columns: 1, rows: 512, thickness_nm: Float32Array.from({ length: 512 }, (_, i) => (2 * mean * (i + 0.5)) / 512) });
    } else if (wanted.startsWith("flow")) {
      void this.startFilm();
      return;
    }
    this.fieldKey = wanted;
    this.exposureKey = "";
    this.draw();
  }

  private async updateTable(): Promise<void> {
    const tables = this.tables as Tables;
    const wanted = this.wantedTable(DRAFT);
    if (this.tableKey === wanted) {
      if (!this.dragging && this.picture?.table && this.picture.table !== this.fine()) await this.refine();
      return;
    }
    const ready = this.fine() ?? tables.find(this.request(DRAFT));
    try {
      const table = ready ?? (await tables.get(this.request(DRAFT)));
      if (!table || this.wantedTable(DRAFT) !== wanted) return;
      this.failure = "";
      this.tableKey = wanted;
      this.exposureKey = "";
      this.picture?.setTable(table);
      this.draw();
      this.version++;
      if (!this.dragging) await this.refine();
    } catch (error) {
      this.failure = TEXT.cannot(words(error));
      this.version++;
    }
  }

  private refining = "";

  /** Finer colours, once nothing moves. */
  private async refine(): Promise<void> {
    const key = this.wantedTable(FINE);
    if (this.refining === key) return;
    this.refining = key;
    try {
      const table = await (this.tables as Tables).get(this.request(FINE));
      if (table && this.wantedTable(FINE) === key) {
        this.picture?.setTable(table);
        this.draw();
        this.version++;
      }
    } catch {
      // The coarser table stands; its error is told under the picture.
    } finally {
      if (this.refining === key) this.refining = "";
    }
  }

  private draw(): void {
    const picture = this.picture;
    if (!picture || !picture.table || !picture.geometry) return;
    const key = `${this.geometryKey}|${this.tableKey}|${this.fieldKey}`;
    if (key !== this.exposureKey) {
      // Bright parts just fit: the lightest 2 % of the film may be whiter than white.
      const luminances = picture.luminances();
      const bright = luminances[Math.floor(luminances.length * (this.living() || this.state["environment"] === "studio" ? 0.96 : 0.995))] ?? 1;
      const most = this.state.scene === "wafer" || this.state.scene === "titanium" ? BRIGHTEST : Infinity;
      this.automatic = bright > 0 ? Math.min(0.82 / bright, most) : 1;
      if (this.fieldReady()) this.exposureKey = key;
    }
    const stops = this.state.scene === "film" ? 0 : Number(this.state["exposure"]);
    picture.look = { rgb_from_xyz: this.rgb, exposure: this.automatic * 2 ** stops };
    if (picture.draw() && this.fieldReady() && !this.firstPicture) this.firstPicture = performance.now();
  }

  // ------------------------------------------------------------------------------------------------ the living film

  private async startFilm(): Promise<void> {
    const wanted = this.wantedField();
    const job = this.flowJob as Job;
    if (this.filmKey === wanted) return;
    this.filmKey = wanted;
    if (job.busy) job.stop();
    this.filmBusy = false;
    this.film = null;
    const { preset, thickness_nm, wind_m_s, gravity_m_s2, seed } = this.state;
    const changes = { thickness_nm: Number(thickness_nm), wind_m_s: Number(wind_m_s), gravity_m_s2: Number(gravity_m_s2) };
    const small = this.picture?.kind === "canvas" && PRESETS.includes(preset as never) && /free-bubble|on-bath/.test(String(preset));
    const name = small ? String(preset).replace("-preview", "-small-preview") : String(preset);
    try {
      if (changes.thickness_nm <= 0) throw new Error("a film that flows needs a thickness");
      const reply = await job.ask<"film">({ kind: "flow-start", id: 0, preset: name, changes, columns: 0, seed: Number(seed), time_s: 0 });
      if (this.filmKey !== wanted) return;
      this.sentWind = changes.wind_m_s;
      this.sentGravity = changes.gravity_m_s2;
      await this.age(wanted, reply.film);
    } catch (error) {
      if (this.filmKey === wanted) this.failure = TEXT.cannot(words(error));
      this.version++;
    }
  }

  private sentWind = 0;
  private sentGravity = 0;

  /** Lets it grow as old as it should be, in sight. */
  private async age(wanted: string, first: FilmState): Promise<void> {
    let film = first;
    const until = Number(this.state["age_s"]);
    for (;;) {
      this.show(film);
      if (film.time_s >= until || !Number.isNaN(film.ruptured_s)) break;
      const time_s = Math.min(until, film.time_s + 0.2);
      film = (await (this.flowJob as Job).ask<"film">({ kind: "flow-advance", id: 0, time_s })).film;
      if (this.filmKey !== wanted) return;
    }
    this.fieldKey = wanted;
    this.exposureKey = "";
    this.draw();
    this.flowed = 0;
    this.version++;
    void this.live();
  }

  private show(film: FilmState): void {
    this.film = film;
    this.picture?.setField(film);
    this.draw();
  }

  /** One step after the other, as long as it should flow: each as long as the last picture took. */
  private async live(): Promise<void> {
    if (this.filmBusy || !this.living() || !this.fieldReady() || !this.film) return;
    const job = this.flowJob as Job;
    if (this.state["wind_m_s"] !== this.sentWind) {
      this.sentWind = Number(this.state["wind_m_s"]);
      job.send({ kind: "flow-change", name: "wind_m_s", value: this.sentWind });
    }
    if (this.state["gravity_m_s2"] !== this.sentGravity) {
      this.sentGravity = Number(this.state["gravity_m_s2"]);
      job.send({ kind: "flow-change", name: "gravity_m_s2", value: this.sentGravity });
    }
    if (!this.state["playing"] || document.hidden || !Number.isNaN(this.film.ruptured_s)) {
      this.flowed = 0;
      return;
    }
    this.filmBusy = true;
    const wanted = this.filmKey;
    try {
      const now = performance.now();
      const passed = this.flowed ? (now - this.flowed) / 1000 : 1 / 30;
      this.flowed = now;
      const time_s = this.film.time_s + Math.min(Math.max(passed, 1 / 120), LONGEST_STEP_S);
      const reply = await job.ask<"film">({ kind: "flow-advance", id: 0, time_s });
      if (this.filmKey !== wanted) return;
      this.stepMs.push(1000 * reply.seconds);
      if (this.stepMs.length > 120) this.stepMs.shift();
      await new Promise((resolve) => requestAnimationFrame(resolve));
      if (this.filmKey !== wanted) return;
      this.show(reply.film);
      this.keepPace();
    } catch (error) {
      if (this.filmKey === wanted) this.failure = TEXT.cannot(words(error));
      this.version++;
      return;
    } finally {
      this.filmBusy = false;
    }
    void this.live();
  }

  /** Smaller pictures where they come too slowly. */
  private keepPace(): void {
    const now = performance.now();
    this.times.push(now);
    if (this.times.length % 30 === 0) this.version++;
    if (this.times.length <= 45) return;
    if (this.times.length > 90) this.times.shift();
    const per_s = this.perSecond();
    if (per_s < WANTED_PER_S * 0.97 && this.sideIndex < SIDES.length - 1) {
      this.sideIndex++;
      this.times = [];
      this.updateGeometry();
    }
  }

  private perSecond(): number {
    const { times } = this;
    return times.length > 1 ? ((times.length - 1) * 1000) / (times[times.length - 1] - times[0]) : 0;
  }

  stats(): Stats {
    const sorted = [...this.stepMs].sort((a, b) => a - b);
    const external = performance.getEntriesByType("resource").filter((e) => !e.name.startsWith(location.origin) && !/^(blob|data):/.test(e.name)).length;
    return {
      first_picture_ms: this.firstPicture,
      pictures_per_s: this.perSecond(),
      step_ms: sorted[sorted.length >> 1] ?? 0,
      tables: this.tables?.made ?? [],
      external,
    };
  }

  flow(): { time_s: number; thickness_nm: Float32Array; columns: number; rows: number } | null {
    if (!this.film || !this.living()) return null;
    const { time_s, thickness_nm, columns, rows } = this.film;
    return { time_s, thickness_nm: thickness_nm.slice(), columns, rows };
  }

  private stir(event: PointerEvent): void {
    if (!this.living() || !this.film || !(event.buttons & 1)) {
      this.lastStir = null;
      return;
    }
    const found = this.pixelOf(event);
    const at = found && this.picture?.at(found.x, found.y);
    if (!at) {
      this.lastStir = null;
      return;
    }
    const now = performance.now();
    const last = this.lastStir;
    this.lastStir = { place: at.place, time: now };
    if (!last || now - last.time < 1) return;
    this.blow(at.place, [at.place[0] - last.place[0], at.place[1] - last.place[1]], (now - last.time) / 1000);
  }

  /** Drags the film along: `moved` in shares of the field, within so many seconds. */
  private blow(place: [number, number], moved: [number, number], seconds: number): void {
    const { columns, rows } = this.film as FilmState;
    const plane = this.state["preset"] === "vertical-film-preview";
    const whole = this.state["preset"] === "free-bubble-preview";
    const [radius, rim] = whole ? [0.03, Math.PI] : [0.025, Math.PI / 2];
    const [across, down] = plane ? [0.1, 0.06] : [2 * Math.PI * radius * Math.sin(place[1] * rim), rim * radius];
    const turn = moved[0] - Math.round(moved[0]);
    const held = (v: number) => Math.min(Math.max(v / seconds, -1), 1);
    const row = Math.min(Math.max(place[1] * rows - 0.5, -0.5), rows - 0.5);
    (this.flowJob as Job).send({
      kind: "flow-stir", place: [row, place[0] * columns - 0.5], speed: [held(moved[1] * down), held(turn * across)], radius_m: 6e-3,
    });
  }

  private pixelOf(event: MouseEvent): { x: number; y: number } | null {
    const canvas = this.picture?.canvas;
    if (!canvas) return null;
    const box = canvas.getBoundingClientRect();
    const x = Math.floor(((event.clientX - box.left) / box.width) * canvas.width);
    const y = Math.floor(((event.clientY - box.top) / box.height) * canvas.height);
    return { x, y };
  }

  private choose(event: MouseEvent): void {
    if (this.state.scene !== "film" || !this.picture) return;
    const found = this.pixelOf(event);
    if (!found) return;
    const { width, height } = this.picture.canvas;
    this.set({
      thickness_nm: Math.round(((found.x + 0.5) / width) * Number(this.state["thickest_nm"])),
      angle_deg: Math.min(Math.max(Math.round(((found.y + 0.5) / height) * CHART_DEG), 0), CHART_DEG),
    });
  }

  // ------------------------------------------------------------------------------------------------ words

  /** A film in words, from the exact sums. */
  describe(thickness_nm: number, angle_deg: number): { text: string; xyz: Float64Array; name: string } {
    const core = this.core as Core;
    const lamp = String(this.state["illuminant"]);
    const xyz = core.color(String(this.state["stack"]), [thickness_nm, angle_deg], { layer: this.layer, illuminant: lamp });
    const lab = core.convert(xyz, "xyz", "lab", lamp);
    // A free film mirrors little; the eye compares with what else it mirrors, as the picture's exposure does.
    const free = lab[0] < 60 && this.isFree();
    const scaled = free ? core.convert(xyz.map((v) => v * 5), "xyz", "lab", lamp) : lab;
    const name = colorName(scaled[0], scaled[1], scaled[2]);
    return { text: TEXT.seen(trim(thickness_nm), trim(angle_deg), name, this.order(thickness_nm, angle_deg)), xyz, name };
  }

  isFree(): boolean {
    return this.items.length === 3 && this.items[0].name === this.items[2].name;
  }

  /** The order on Newton's scale; only where the film is clear and both faces are like those of a free film. */
  /** Thicknesses at which the orders of Newton's scale end, nm. */
  orderEnds(to_nm: number): number[] {
    const core = this.core as Core;
    if (!this.isFree()) return [];
    const [n, k] = Array.from(core.call("medium_index", this.items[1].name, [550]).result);
    if (k > 0.01) return [];
    const step = 550 / (2 * n);
    return Array.from({ length: Math.min(Math.floor(to_nm / step), 9) }, (_, i) => step * (i + 1));
  }

  private order(thickness_nm: number, angle_deg: number): string {
    if (!this.isFree()) return "";
    const core = this.core as Core;
    const at = (name: string) => core.call("medium_index", name, [550]).result;
    const [n0, [n, k]] = [at(this.items[0].name)[0], Array.from(at(this.items[1].name))];
    if (k > 0.01) return "";
    const sine = (n0 * Math.sin((angle_deg * Math.PI) / 180)) / n;
    if (sine >= 1) return "";
    return orderOf(2 * n * thickness_nm * Math.sqrt(1 - sine * sine));
  }

  private twin(): string {
    if (!this.core) return "";
    const { scene } = this.state;
    if (scene === "bubble" && this.film && this.living()) {
      const { thickness_nm, time_s, ruptured_s } = this.film;
      let [least, most, sum] = [Infinity, 0, 0];
      for (const nm of thickness_nm) {
        least = Math.min(least, nm);
        most = Math.max(most, nm);
        sum += nm;
      }
      const facts = TEXT.bubble_facts(time_s.toFixed(1), (sum / thickness_nm.length).toFixed(0), least.toFixed(0), most.toFixed(0));
      return Number.isNaN(ruptured_s) ? facts : `${facts} ${TEXT.burst(ruptured_s.toFixed(1))}`;
    }
    const lamp = TEXT.choices[String(this.state["illuminant"])] ?? String(this.state["illuminant"]);
    const nm = Number(this.state["thickness_nm"]);
    if (scene === "slick") return TEXT.slick_seen(trim(nm), lamp);
    if (scene === "bubble") return TEXT.still_seen(trim(2 * nm), lamp);
    if (scene === "rings") {
      const radii = measuredRadii(this, Number(this.state["view_mm"])).slice(0, 4).map((r) => r.toFixed(3));
      return TEXT.rings_seen(this.describe(nm, 0).name, radii.join(", "), lamp);
    }
    return this.describe(Number(this.state["thickness_nm"]), Number(this.state["angle_deg"])).text;
  }

  // ------------------------------------------------------------------------------------------------ page

  render(): TemplateResult {
    const { scene } = this.state;
    return html`
      <a class="skip" href="#picture" @click=${(e: Event) => { e.preventDefault(); this.querySelector<HTMLElement>("main")?.focus(); }}>${TEXT.skip}</a>
      <header>
        <p class="brand"><span class="mark" aria-hidden="true"></span><b>${TEXT.title}</b> <span>${TEXT.tagline}</span></p>
        <nav aria-label="Scenes">
          ${SCENES.map(
            (name) => html`<a href=${writeLink(inScene({ ...this.state, story: 0 } as State, name))} aria-current=${name === scene ? "page" : nothing}
              @click=${(e: MouseEvent) => this.go(e, name)}>${TEXT.scenes[name]}</a>`,
          )}
        </nav>
      </header>
      <main tabindex="-1" class=${`scene-${scene}`}>
        ${this.failure ? html`<p class="failure" role="alert">${this.failure}</p>` : nothing}
        ${this.notes.length
          ? html`<div class="notes" role="status"><p>${TEXT.left_out}</p><ul>${this.notes.map((note) => html`<li>${note}</li>`)}</ul></div>`
          : nothing}
        ${scene === "learn" ? this.learnPage() : this.scenePage()}
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

  private scenePage(): TemplateResult {
    const { scene } = this.state;
    const story = STORIES[Number(this.state["story"]) - 1];
    const living = this.living();
    const table = this.picture?.table;
    return html`
      <h1>${TEXT.scenes[scene]}</h1>
      ${story ? this.storyPanel(story, Number(this.state["story"])) : html`<p class="about">${TEXT.about[scene]}</p>`}
      <div class="stage">
        <section class="seen" aria-label=${TEXT.scenes[scene]}>
          <div id="picture" class=${living ? "living" : ""}>
            <canvas width="64" height="64" role="img" aria-label=${`${TEXT.scenes[scene]}. ${this.twin()}`}
              @pointermove=${(e: PointerEvent) => { this.stir(e); this.pointer = this.pixelOf(e); if (!living) this.version++; }}
              @pointerleave=${() => { this.pointer = null; this.version++; }}
              @click=${(e: MouseEvent) => this.choose(e)}></canvas>
            ${scene === "film" ? html`<div class="cross" aria-hidden="true"></div>` : nothing}
            ${scene === "rings" ? html`<div class="scale" aria-hidden="true"><span></span>1 mm</div>` : nothing}
            ${scene === "titanium" ? html`<div class="volts" aria-hidden="true">${[0, 20, 40, 60, 80, 100].map((v) => html`<span data-share=${v / 110}>${v} V</span>`)}</div>` : nothing}
          </div>
          ${scene === "film" ? html`<p class="axes" aria-hidden="true"><span>0 nm, 0° on top</span><span>${this.state["thickest_nm"]} nm, ${CHART_DEG}° below</span></p>` : nothing}
          <p class="twin" id="twin" aria-live=${living ? "off" : "polite"}>${this.twin()}</p>
          <p class="tools">
            ${living
              ? html`<button type="button" class="main" @click=${() => this.set({ playing: !this.state["playing"] })}>${this.state["playing"] ? TEXT.pause : TEXT.play}</button>
                  <button type="button" @click=${() => this.breath()}>${TEXT.blow}</button>
                  <button type="button" @click=${() => this.set({ seed: (Number(this.state["seed"]) + 1) % 1000000 })}>${TEXT.again}</button>`
              : nothing}
            <button type="button" @click=${() => this.savePicture()}>${TEXT.save_picture}</button>
            <button type="button" @click=${() => this.saveCsv()}>${TEXT.save_csv}</button>
            <button type="button" @click=${() => this.copyLink()}>${TEXT.copy_link}</button>
          </p>
          <p class="small" id="told" role="status">${this.told}</p>
          <p class="small">${table ? TEXT.table_error(table.max_delta_e.toFixed(2), "") : ""} ${this.picture ? TEXT.renderer[this.picture.kind] : ""}</p>
        </section>
        <section class="controls" aria-label=${TEXT.controls}>
          <h2>${TEXT.controls}</h2>
          ${keysOf(scene).filter((key) => !key.hidden).map((key) => this.control(key))}
          <p><button type="button" @click=${() => { this.state = defaults(scene); this.settle(); this.remember(true); this.refresh(); }}>${TEXT.reset}</button></p>
        </section>
      </div>
      ${this.readouts()}`;
  }

  private readouts(): TemplateResult | typeof nothing {
    if (!this.core || this.core.broken) return nothing;
    const { scene } = this.state;
    const pointed = this.pointer && this.picture?.at(this.pointer.x, this.pointer.y);
    const own = scene === "titanium" || scene === "wafer" || scene === "film"
      ? { thickness_nm: Number(this.state["thickness_nm"]), angle_deg: Number(this.state["angle_deg"]) }
      : null;
    const here = pointed ?? own;
    try {
      return html`<div class="readouts">
        ${here
          ? html`<section class="card" aria-label=${pointed ? TEXT.pointer : TEXT.film_here}><h2>${pointed ? TEXT.pointer : TEXT.film_here}</h2>
              ${swatch(this, this.describe(here.thickness_nm, here.angle_deg))}</section>`
          : nothing}
        ${scene === "rings" ? ringsPanel(this) : nothing}
        ${own ? filmPanel(this) : nothing}
      </div>`;
    } catch (error) {
      return html`<p class="failure" role="alert">${TEXT.cannot(words(error))}</p>`;
    }
  }

  protected updated(): void {
    paintSwatches(this);
    const { scene } = this.state;
    const cross = this.querySelector<HTMLElement>(".cross");
    if (cross && scene === "film") {
      cross.style.left = `${Math.min((100 * Number(this.state["thickness_nm"])) / Number(this.state["thickest_nm"]), 100)}%`;
      cross.style.top = `${(100 * Number(this.state["angle_deg"])) / CHART_DEG}%`;
    }
    const bar = this.querySelector<HTMLElement>(".scale span");
    if (bar) bar.style.width = `${((this.querySelector("#picture")?.clientWidth ?? 0) / Number(this.state["view_mm"])).toFixed(1)}px`;
    for (const mark of this.querySelectorAll<HTMLElement>(".volts span")) mark.style.left = `${4 + 92 * Number(mark.dataset["share"])}%`;
  }

  private control(key: Key): TemplateResult {
    const { scene } = this.state;
    const label = TEXT.keysOf[`${scene} ${key.name}`] ?? TEXT.keys[key.name] ?? key.name;
    const id = `key-${key.name}`;
    const value = this.state[key.name];
    const help = TEXT.help[key.name];
    const helpId = help ? `${id}-help` : nothing;
    const set = (v: unknown, done: boolean) => {
      this.dragging = !done;
      this.set({ [key.name]: v }, done);
    };
    if (key.kind === "number" || key.kind === "whole") {
      if (scene === "titanium" && key.name === "thickness_nm") return html`<p class="fact">${label}: ${trim(Number(value))} nm = ${OXIDE_NM} + ${OXIDE_NM_PER_VOLT} × V</p>`;
      const [least, most] = sliderRange(key, scene);
      return html`<div class="control">
        <label for=${id}>${label}</label>
        <input type="range" id=${id} min=${least} max=${most} step=${key.step ?? 1} .value=${String(value)} aria-describedby=${helpId}
          aria-valuetext=${`${trim(Number(value))} ${key.unit ?? ""}`}
          @input=${(e: Event) => set((e.target as HTMLInputElement).valueAsNumber, false)}
          @change=${(e: Event) => set((e.target as HTMLInputElement).valueAsNumber, true)} />
        <input type="number" class="number" aria-label=${`${label}, ${key.unit ?? ""}`} min=${key.range?.[0] ?? 0} max=${key.range?.[1] ?? 0} step="any" .value=${trim(Number(value))}
          @change=${(e: Event) => set((e.target as HTMLInputElement).value, true)} /><span class="unit">${key.unit ?? ""}</span>
        ${help ? html`<p class="small" id=${`${id}-help`}>${help}</p>` : nothing}
      </div>`;
    }
    if (key.kind === "flag") {
      return html`<div class="control flag"><label><input type="checkbox" id=${id} .checked=${Boolean(value)} @change=${(e: Event) => set((e.target as HTMLInputElement).checked, true)} /> ${label}</label></div>`;
    }
    if (key.kind === "stack") {
      if (scene !== "film") return html`<p class="fact">${label}: <code>${value}</code></p>`;
      return html`<div class="control wide"><label for=${id}>${label}</label>
        <input type="text" id=${id} spellcheck="false" autocomplete="off" maxlength="300" .value=${String(value)} aria-describedby=${helpId}
          @change=${(e: Event) => set((e.target as HTMLInputElement).value, true)} />
        <p class="small" id=${`${id}-help`}>${help}</p></div>`;
    }
    const choices: readonly string[] = key.kind === "illuminant" ? LAMPS : (key.choices as readonly string[]);
    const all = choices.includes(String(value)) ? choices : [...choices, String(value)];
    return html`<div class="control"><label for=${id}>${label}</label>
      <select id=${id} @change=${(e: Event) => set((e.target as HTMLSelectElement).value, true)}>
        ${all.map((name) => html`<option value=${name} ?selected=${name === value}>${TEXT.choices[name] ?? name}</option>`)}
      </select></div>`;
  }

  // ------------------------------------------------------------------------------------------------ learning

  private storyPanel(story: (typeof STORIES)[number], number: number): TemplateResult {
    return html`<section class="story" aria-label=${story.title}>
      <h2>${number}. ${story.title}</h2>
      <p><b>${TEXT.learn.look}:</b> ${story.look}</p>
      <p><b>${TEXT.learn.question}:</b> ${story.question}</p>
      ${this.answerShown && this.core
        ? html`<p class="answer" role="status"><b>${TEXT.learn.answer}:</b> ${story.answer(this.core)}</p>`
        : html`<p><button type="button" class="main" @click=${() => { this.answerShown = true; this.version++; }}>${TEXT.learn.show}</button></p>`}
      <p class="tools">
        ${number > 1 ? html`<a href=${STORIES[number - 2].link}>${TEXT.learn.before}</a>` : nothing}
        ${number < STORIES.length ? html`<a href=${STORIES[number].link}>${TEXT.learn.next}</a>` : nothing}
        <a href="#v=1&scene=learn">${TEXT.scenes["learn"]}</a>
      </p>
    </section>`;
  }

  private learnPage(): TemplateResult {
    const sheet = Number(this.state["sheet"]);
    if (sheet > 0 && this.core) {
      const exercises = worksheet(this.core, sheet);
      return html`<article class="sheet">
        <h1>${TEXT.learn.sheet_title}</h1>
        <p class="name">${TEXT.learn.sheet_name}: ............................................ <span class="no">${sheet}</span></p>
        <ol>${exercises.map((e) => html`<li>${e.question}<div class="lines" aria-hidden="true"></div></li>`)}</ol>
        <section class="key"><h2>${TEXT.learn.sheet_key} <span class="no">${sheet}</span></h2><ol>${exercises.map((e) => html`<li>${e.answer}</li>`)}</ol>
        <p class="small">${TEXT.learn.sheet_for}</p></section>
        <p class="tools screen"><button type="button" class="main" @click=${() => print()}>${TEXT.learn.sheet_print}</button>
          <button type="button" @click=${() => this.set({ sheet: (sheet % 999999) + 1 })}>${TEXT.learn.sheet_new}</button>
          <a href="#v=1&scene=learn">${TEXT.learn.sheet_back}</a></p>
      </article>`;
    }
    return html`<h1>${TEXT.scenes["learn"]}</h1><p class="about">${TEXT.about["learn"]}</p>
      <ol class="stories">${STORIES.map((story) => html`<li><a href=${story.link}><b>${story.title}</b><span>${story.question}</span></a></li>`)}</ol>
      <p><a class="button" href="#v=1&scene=learn&sheet=1">${TEXT.learn.sheet}</a></p>`;
  }

  // ------------------------------------------------------------------------------------------------ taken away

  private breath(): void {
    if (!this.film || !this.picture?.geometry) return;
    const { width, height } = this.picture.geometry;
    const at = this.picture.at(width >> 1, Math.floor(height * 0.45));
    if (at) this.blow(at.place, [0.06, 0], 0.06);
  }

  private save(name: string, blob: Blob): void {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  }

  private savePicture(): void {
    this.draw();
    this.picture?.canvas.toBlob((blob) => blob && this.save(`iridesce-${this.state.scene}.png`, blob), "image/png");
  }

  /** What the scene shows, as numbers: text of the file. */
  csv(): string {
    const core = this.core as Core;
    const { scene } = this.state;
    const head = `# iridesce ${scene} ${writeLink(this.state)}\n`;
    if (scene === "bubble" || scene === "slick") {
      const field = this.picture?.field;
      if (!field) return head;
      const rows = Array.from({ length: field.rows }, (_, i) =>
        Array.from(field.thickness_nm.subarray(i * field.columns, (i + 1) * field.columns), (nm) => nm.toFixed(2)).join(","),
      );
      return `${head}# thickness_nm, row 0 on top\n${rows.join("\n")}\n`;
    }
    const lamp = String(this.state["illuminant"]);
    const stack = String(this.state["stack"]);
    if (scene === "rings") {
      const view = Number(this.state["view_mm"]);
      const radii = Array.from({ length: 401 }, (_, i) => (view * i) / 800);
      const gaps = core.call("thickness_lens_gap", "", [Number(this.state["radius_mm"]), Number(this.state["thickness_nm"]), ...radii]).result;
      const xyz = core.color(stack, Float64Array.from([...gaps].flatMap((nm) => [nm, 0])), { layer: this.layer, illuminant: lamp });
      return `${head}radius_mm,gap_nm,X,Y,Z\n${radii.map((r, i) => [r, gaps[i], ...xyz.subarray(3 * i, 3 * i + 3)].join(",")).join("\n")}\n`;
    }
    const wavelengths = Float64Array.from({ length: 401 }, (_, i) => 380 + i);
    const angle = Number(this.state["angle_deg"]);
    const now = filled(stack, Number(this.state["thickness_nm"]));
    const values = core.spectrum(now, wavelengths, angle);
    return `${head}# ${now} at ${angle} degrees\nwavelength_nm,reflectance\n${Array.from(wavelengths, (nm, i) => `${nm},${values[i]}`).join("\n")}\n`;
  }

  private saveCsv(): void {
    this.save(`iridesce-${this.state.scene}.csv`, new Blob([this.csv()], { type: "text/csv" }));
  }

  private copyLink(): void {
    navigator.clipboard?.writeText(location.href.split("#")[0] + writeLink(this.state)).then(
      () => {
        this.told = TEXT.copied;
        this.version++;
      },
      () => {},
    );
  }

  /** XYZ of the picture's table, as it is drawn. */
  tableColor(thickness_nm: number, angle_deg: number): Float64Array {
    const out = new Float64Array(3);
    if (this.picture?.table) lookUp(this.picture.table, thickness_nm, angle_deg, out, 0);
    return out;
  }
}

function scene_has_own_thickness(scene: Scene): boolean {
  return scene === "rings" || scene === "titanium" || scene === "wafer";
}

/** Sliders reach as far as is useful; the number beside them takes everything allowed. */
function sliderRange(key: Key, scene: Scene): [number, number] {
  const [least, most] = key.range as [number, number];
  if (key.name === "thickness_nm") return scene === "rings" ? [0, 2000] : scene === "bubble" ? [50, 1200] : [0, scene === "film" ? 3000 : 1500];
  if (key.name === "seed") return [1, 100];
  return [least, most];
}

export function trim(value: number): string {
  return String(Math.round(value * 100) / 100);
}

export function words(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

function transposed(columns: Float64Array): Float64Array {
  // The core answers what X, Y and Z become, one after the other: columns of the matrix.
  return Float64Array.from({ length: 9 }, (_, i) => columns[3 * (i % 3) + Math.floor(i / 3)]);
}

customElements.define("iridesce-page", App);
