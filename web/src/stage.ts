// What is on the canvas: where the film lies, how thick it is, the colour table, the exposure. Each is made anew only
// when what it depends on has changed; every change ends in one draw.

import type { Core, ColorTable, TableRequest } from "./core/core";
import { Job, Tables } from "./core/jobs";
import { lookUp } from "./core/look-up";
import { CHART_DEG, aspectOf, geometryOf } from "./draw/geometry";
import { Picture } from "./draw/picture";
import { type FilmStage, LivingFilm } from "./living";
import type { Page } from "./page";
import type { Scene } from "./state/keys";
import { STORED } from "./state/stored";
import { TEXT } from "./text/strings";

/** Colours while something moves, and when it has come to rest: CIEDE2000 against the exact sums. */
const DRAFT = 0.5;
const FINE = 0.1;
/** Sides of a living picture, in pixels: fewer where a machine cannot keep up. */
const SIDES = [640, 560, 480, 416, 352, 288, 240];
/** The side where every pixel is a turn of a loop. */
const LOOP_SIDE = 288;
/** Metals and silicon are shown no brighter than this times what they mirror: their colours are those of a bright surface. */
const BRIGHTEST = 1.6;
/** Side of the pixels of a picture whose control is being moved, in those of one at rest: where the processor shades them. */
const COARSE = { software: 3, device: 2 };
/** Keys that say where the film lies (and how thick it is there, where no field holds that). */
const GEOMETRY_KEYS: Record<Scene, readonly string[]> = {
  bubble: ["preset", "environment", "walls"],
  rings: ["radius_mm", "view_mm", "thickness_nm"],
  slick: ["environment"],
  titanium: ["environment", "angle_deg", "thickness_nm"],
  wafer: ["environment", "angle_deg", "thickness_nm", "edge_nm"],
  film: ["thickest_nm"],
  learn: [],
};
/** Controls that move marks, and leave the picture as it is. */
const MARKS = ["thickness_nm", "angle_deg"];

export class Stage implements FilmStage {
  picture: Picture | null = null;
  readonly tables: Tables;
  readonly film: LivingFilm;
  /** ms after the start of the page at which the first whole picture stood; 0: not yet. */
  firstPicture = 0;
  private readonly fields: Job;
  private water: Float64Array | null = null;
  private readonly rgb: Float64Array;
  private geometryKey = "";
  private tableKey = "";
  private fieldKey = "";
  private exposureKey = "";
  private refining = "";
  private automatic = 1;
  private sideIndex = 0;
  private lost = false;

  constructor(readonly page: Page, private readonly core: Core, module: WebAssembly.Module) {
    this.tables = new Tables(module, STORED);
    this.fields = new Job(module);
    this.film = new LivingFilm(this, this.fields);
    this.rgb = transposed(core.convert([1, 0, 0, 0, 1, 0, 0, 0, 1], "xyz", "linear-srgb"));
  }

  /** Reflectance of still water by whole degrees. */
  private readonly waters = (): Float64Array =>
    (this.water ??= Float64Array.from({ length: 91 }, (_, deg) => (deg === 90 ? 1 : this.core.spectrum("air / water", [550], deg)[0])));

  // ------------------------------------------------------------------------------------------------ what is asked for

  private number(name: string): number {
    return Number(this.page.state[name]);
  }

  living(): boolean {
    return this.page.state.scene === "bubble" && this.page.state["preset"] !== "still";
  }

  private range(fine: boolean): { range_nm: [number, number]; range_deg: [number, number] } {
    // Towards grazing light colours change so fast that tables grow tenfold: beyond, the colours of the last angle are held.
    const range_deg: [number, number] = [0, fine ? 85 : 80];
    const whole = (nm: number) => Math.max(Math.ceil(nm / 500), 1) * 500;
    const thickness = this.number("thickness_nm");
    switch (this.page.state.scene) {
      case "rings": {
        const [radius, r2] = [this.number("radius_mm"), this.number("view_mm") ** 2 / 2];
        return { range_nm: [0, whole(thickness + (1e6 * r2) / (radius + Math.sqrt(radius ** 2 - r2)))], range_deg: [0, 0] };
      }
      case "slick":
        return { range_nm: [0, Math.max(thickness, 50)], range_deg };
      case "titanium":
        return { range_nm: [0, 300], range_deg };
      case "wafer":
        return { range_nm: [0, whole(Math.max(thickness, this.number("edge_nm")))], range_deg };
      case "film":
        return { range_nm: [0, this.number("thickest_nm")], range_deg: [0, CHART_DEG] };
      default: {
        let most = 1500;
        most = Math.max(most, this.film.thickest_nm);
        if (this.page.state["preset"] === "still") most = Math.max(most, 2 * thickness);
        return { range_nm: [0, Math.min(whole(most), 20000)], range_deg };
      }
    }
  }

  private request(max_delta_e: number): TableRequest {
    const { stack, illuminant } = this.page.state;
    return { stack: String(stack), layer: this.page.layer, illuminant: String(illuminant), ...this.range(max_delta_e === FINE), max_delta_e };
  }

  private wantedTable(max_delta_e: number): string {
    return Tables.key(this.request(max_delta_e));
  }

  private wantedField(): string {
    const { scene, preset, thickness_nm, seed, age_s } = this.page.state;
    if (scene === "slick") return `swirls ${thickness_nm} ${seed}`;
    if (scene !== "bubble") return "none";
    return preset === "still" ? `still ${thickness_nm}` : `flow ${preset} ${thickness_nm} ${seed} ${age_s}`;
  }

  fieldReady(): boolean {
    return this.fieldKey === this.wantedField();
  }

  /** Whether the picture shows the state as it is now. */
  isDrawn(): boolean {
    return Boolean(this.picture?.table) && this.tableKey === this.wantedTable(DRAFT) && this.fieldReady();
  }

  /** Whether its colours are as fine as they will be. */
  isSettled(): boolean {
    return !this.page.moving && Boolean(this.picture?.table) && this.picture?.table === this.tables.find(this.request(FINE));
  }

  // ------------------------------------------------------------------------------------------------ what is made

  /** Lets a film begin to flow before there is a canvas: the first picture waits for it. */
  begin(): void {
    if (this.living()) void this.film.start(this.wantedField());
  }

  /** Makes what is missing for the state as it is now, and draws. */
  update(canvas: HTMLCanvasElement): void {
    if (!this.picture || this.picture.canvas !== canvas) {
      this.picture?.dispose();
      this.picture = new Picture(canvas, () => this.lose(), this.lost || /[?&]webgl=0/.test(location.search));
      if (this.picture.kind === "canvas") {
        this.page.tell(this.lost ? TEXT.lost : TEXT.slow);
        this.film.forget();
      }
      this.geometryKey = this.tableKey = "";
      if (this.film.state && this.living()) this.picture.setField(this.film.state);
      else this.fieldKey = "";
    }
    // The workers first: they work while this thread finds out what every pixel sees.
    void this.updateField().catch((error) => this.page.fail(error));
    void this.updateTable();
    this.updateGeometry();
    this.draw();
    void this.film.live();
  }

  /** The graphics device is gone: go on without it, on another canvas. */
  private lose(): void {
    this.lost = true;
    this.page.anotherCanvas();
  }

  private updateGeometry(): void {
    const picture = this.picture as Picture;
    const { state } = this.page;
    const box = picture.canvas.parentElement as HTMLElement;
    const aspect = aspectOf(state);
    const ratio = this.living() ? 1 : Math.min(devicePixelRatio || 1, 2);
    const [loop, whole] = [picture.kind === "canvas", this.living() ? SIDES[0] : 1000];
    const most = loop ? (this.living() ? LOOP_SIDE : 480) : this.film.moving ? SIDES[this.sideIndex] : whole;
    const { moving } = this.page;
    const coarse = moving && !this.film.moving && !(state.scene === "film" && MARKS.includes(moving)) ? COARSE[picture.software ? "software" : "device"] : 1;
    const width = Math.max(64, Math.round(Math.min((box.clientWidth || 480) * ratio, most * Math.max(aspect, 1)) / coarse));
    const height = Math.round(width / aspect);
    const key = [state.scene, width, height, ...GEOMETRY_KEYS[state.scene].map((name) => state[name])].join("|");
    if (key === this.geometryKey) return;
    this.geometryKey = key;
    picture.setGeometry(geometryOf({ width, height, state, water: this.waters }));
  }

  /** The film moves off or comes to rest: as many pixels as there is time for, in sharp colours or fast ones. */
  filmMoves(): void {
    if (!this.picture || !this.living()) return;
    this.updateGeometry();
    this.draw();
  }

  /** Fewer pixels for a living film, `share` of those there are or a little less; false: there are no fewer. */
  smaller(share: number): boolean {
    const [side, last] = [SIDES[this.sideIndex], SIDES.length - 1];
    if (this.sideIndex === last) return false;
    do this.sideIndex++;
    while (this.sideIndex < last && SIDES[this.sideIndex] ** 2 > share * side ** 2);
    this.updateGeometry();
    return true;
  }

  /** More pixels for a living film, if `share` of those there are is enough for the next size; false: it is not, or there are none. */
  larger(share: number): boolean {
    if (this.sideIndex === 0 || SIDES[this.sideIndex - 1] ** 2 > share * SIDES[this.sideIndex] ** 2) return false;
    this.sideIndex--;
    this.updateGeometry();
    return true;
  }

  private async updateField(): Promise<void> {
    const wanted = this.wantedField();
    if (wanted === this.fieldKey || this.fieldKey === `asked ${wanted}`) return;
    const picture = this.picture as Picture;
    if (wanted.startsWith("flow")) {
      await this.film.start(wanted);
      return;
    }
    if (wanted.startsWith("swirls")) {
      this.fieldKey = `asked ${wanted}`;
      const [max_nm, seed] = [Math.max(this.number("thickness_nm"), 21), this.number("seed")];
      const { values, columns, rows } = await this.fields.ask<"swirls">({ kind: "swirls", id: 0, min_nm: 20, max_nm, seed });
      if (this.wantedField() !== wanted) return;
      picture.setField({ columns, rows, thickness_nm: values });
    } else if (wanted.startsWith("still")) {
      const mean = this.number("thickness_nm");
      picture.setField({ columns: 1, rows: 512, thickness_nm: Float32Array.from({ length: 512 }, (_, i) => (2 * mean * (i + 0.5)) / 512) });
    }
    this.fieldCame(wanted);
  }

  /** The field that was wanted is there. */
  fieldCame(key: string): void {
    this.fieldKey = key;
    this.exposureKey = "";
    this.draw();
    this.page.version++;
  }

  private async updateTable(): Promise<void> {
    const wanted = this.wantedTable(DRAFT);
    if (this.tableKey === wanted) {
      if (!this.page.moving && this.picture?.table && !this.isSettled()) await this.refine();
      return;
    }
    const ready = this.tables.find(this.request(FINE)) ?? this.tables.find(this.request(DRAFT));
    try {
      const table = ready ?? (await this.tables.get(this.request(DRAFT)));
      if (!table || this.wantedTable(DRAFT) !== wanted) return;
      this.page.fail(null);
      this.tableKey = wanted;
      this.exposureKey = "";
      this.tableCame(table);
      if (!this.page.moving) await this.refine();
    } catch (error) {
      this.page.fail(error);
    }
  }

  /** Finer colours, once nothing moves. */
  private async refine(): Promise<void> {
    const key = this.wantedTable(FINE);
    if (this.refining === key) return;
    this.refining = key;
    try {
      const table = await this.tables.get(this.request(FINE));
      if (table && this.wantedTable(FINE) === key) this.tableCame(table);
    } catch {
      // The coarser table stands; its error is told under the picture.
    } finally {
      if (this.refining === key) this.refining = "";
    }
  }

  private tableCame(table: ColorTable): void {
    this.picture?.setTable(table);
    this.draw();
    this.page.version++;
  }

  /** Share of the picture that must not be whiter than white: a window may be, and so may grazing light in a chart. */
  private within(): number {
    const { scene } = this.page.state;
    if (scene === "film") return 0.8;
    return scene !== "rings" && (this.living() || this.page.state["environment"] === "studio") ? 0.96 : 0.995;
  }

  draw(): void {
    const picture = this.picture;
    if (!picture || !picture.table || !picture.geometry) return;
    const { state } = this.page;
    // While a film grows as old as it should be its first exposure stands.
    const key = [this.geometryKey, this.tableKey, this.fieldKey, this.fieldReady(), this.film.state === null].join("|");
    if (key !== this.exposureKey) {
      const luminances = picture.luminances();
      const bright = luminances[Math.floor(luminances.length * this.within())] ?? 1;
      const most = state.scene === "wafer" || state.scene === "titanium" ? BRIGHTEST : Infinity;
      this.automatic = bright > 0 ? Math.min(0.82 / bright, most) : 1;
      this.exposureKey = key;
    }
    const stops = state.scene === "film" ? 0 : this.number("exposure");
    picture.look = { rgb_from_xyz: this.rgb, exposure: this.automatic * 2 ** stops, moving: this.living() && this.film.moving };
    if (picture.draw() && this.fieldReady() && !this.firstPicture) this.firstPicture = performance.now();
  }

  /** XYZ of the table that is drawn. */
  tableColor(thickness_nm: number, angle_deg: number): Float64Array {
    const out = new Float64Array(3);
    if (this.picture?.table) lookUp(this.picture.table, thickness_nm, angle_deg, out, 0);
    return out;
  }
}

function transposed(columns: Float64Array): Float64Array {
  // The core answers what X, Y and Z become, one after the other: columns of the matrix.
  return Float64Array.from({ length: 9 }, (_, i) => columns[3 * (i % 3) + Math.floor(i / 3)]);
}
