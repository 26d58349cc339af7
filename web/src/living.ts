// The film that lives: a worker lets it flow, each step as long as the last picture took, while the step before is drawn;
// a finger stirs it.

import type { FilmState } from "./core/core";
import { Job, type Reply } from "./core/jobs";
import type { Page, Shown } from "./page";
import { PRESETS, type State } from "./state/keys";

const WANTED_PER_S = 30;
/** Pictures a second at which none is made smaller: what else a machine does now and then must not take one below those wanted. */
const EASY_PER_S = 33;
/** The most film a picture may wait for, s. Where the core cannot keep up the film is slow, and still moves smoothly. */
const LONGEST_STEP_S = 1 / WANTED_PER_S;
/** The most time the film may be behind and still make good, s: what a picture that came late has left. */
const MOST_OWED_S = 3 * LONGEST_STEP_S;
/** Pictures after which it is known how fast they come. */
const PACE_PICTURES = 20;
/** Pictures after which they may be made larger, and over which their pace is told. */
const LONG_PICTURES = 90;

/** Where a film lies, m: radius and angle of the rim of a sphere (crates/flow: presets), or sides of a frame. */
const SHAPES: Record<string, { radius: number; rim: number } | { across: number; down: number }> = {
  "free-bubble-preview": { radius: 0.03, rim: Math.PI },
  "bubble-on-bath-preview": { radius: 0.025, rim: Math.PI / 2 },
  "late-preview": { radius: 0.025, rim: Math.PI / 2 },
  "vertical-film-preview": { across: 0.1, down: 0.06 },
};

/** Changes that reach a film while it flows. */
const LIVE = ["wind_m_s", "gravity_m_s2"] as const;

type FilmReply = Extract<Reply, { kind: "film" }>;

/** What the film asks of the stage that shows it. */
export interface FilmStage extends Shown {
  readonly page: Page;
  fieldReady(): boolean;
  fieldCame(key: string): void;
  filmMoves(): void;
  smaller(share: number): boolean;
  larger(share: number): boolean;
}

export class LivingFilm {
  state: FilmState | null = null;
  /** Where it is thickest, nm; 0: there is none. */
  thickest_nm = 0;
  private key = "";
  private aged = false;
  private busy = false;
  /** Whether another picture comes in a moment. */
  moving = false;
  /** When the last step was asked for; 0: it stood still. */
  private flowed = 0;
  /** Time that has passed and has not flowed yet, s. */
  private owed = 0;
  private sent: Record<string, number> = {};
  private times: number[] = [];
  private steps: number[] = [];
  private lastStir: { place: [number, number]; time: number } | null = null;

  constructor(private readonly stage: FilmStage, private readonly job: Job) {}

  private get keys(): State {
    return this.stage.page.state;
  }

  /** Another film will be begun: this one was for another kind of canvas. */
  forget(): void {
    this.key = "";
  }

  /** Begins the film that `wanted` names, unless it flows already. */
  async start(wanted: string): Promise<void> {
    if (this.key === wanted) {
      if (!this.aged || !this.state) return;
      // Another scene was on the canvas meanwhile.
      this.flowed = 0;
      this.show(this.state);
      this.stage.fieldCame(wanted);
      void this.live();
      return;
    }
    this.key = wanted;
    this.aged = false;
    if (this.job.busy) this.job.stop();
    this.busy = this.moving = false;
    this.keep(null);
    const { preset, thickness_nm, seed } = this.keys;
    const changes: Record<string, number> = { thickness_nm: Number(thickness_nm) };
    for (const name of LIVE) changes[name] = Number(this.keys[name]);
    const small = this.stage.picture?.kind === "canvas" && PRESETS.includes(preset as never) && /free-bubble|on-bath/.test(String(preset));
    const name = small ? String(preset).replace("-preview", "-small-preview") : String(preset);
    try {
      if (changes["thickness_nm"] <= 0) throw new Error("a film that flows needs a thickness");
      const reply = await this.job.ask<"film">({ kind: "flow-start", id: 0, preset: name, changes, columns: 0, seed: Number(seed), time_s: 0 });
      if (this.key !== wanted) return;
      this.sent = changes;
      await this.age(wanted, reply.film);
    } catch (error) {
      if (this.key === wanted) this.stage.page.fail(error);
    }
  }

  /** Lets it grow as old as it should be, in sight. */
  private async age(wanted: string, first: FilmState): Promise<void> {
    let film = first;
    const until = Number(this.keys["age_s"]);
    for (;;) {
      this.show(film);
      if (film.time_s >= until || !Number.isNaN(film.ruptured_s)) break;
      const time_s = Math.min(until, film.time_s + 0.2);
      film = (await this.job.ask<"film">({ kind: "flow-advance", id: 0, time_s })).film;
      if (this.key !== wanted) return;
    }
    this.aged = true;
    this.flowed = 0;
    if (!this.stage.living()) return;
    this.stage.fieldCame(wanted);
    void this.live();
  }

  private keep(film: FilmState | null): void {
    this.state = film;
    this.thickest_nm = film ? film.thickness_nm.reduce((most, nm) => Math.max(most, nm), 0) : 0;
  }

  private show(film: FilmState): void {
    this.keep(film);
    if (!this.stage.living()) return;
    this.stage.picture?.setField(film);
    this.stage.draw();
  }

  /** One step after the other, as long as it should flow: the next one is computed while the last is drawn. */
  async live(): Promise<void> {
    if (this.busy) return;
    this.busy = true;
    const wanted = this.key;
    try {
      let next = this.step();
      if (next) this.move(true);
      while (next) {
        const reply = await next;
        if (this.key !== wanted) return;
        this.steps.push(1000 * reply.seconds);
        if (this.steps.length > 120) this.steps.shift();
        this.keep(reply.film);
        next = this.step();
        await new Promise((resolve) => requestAnimationFrame(resolve));
        if (this.key !== wanted) {
          // Another film was asked for meanwhile: its start stopped this step.
          next?.catch(() => undefined);
          return;
        }
        this.show(reply.film);
        this.keepPace();
      }
    } catch (error) {
      if (this.key === wanted) this.stage.page.fail(error);
    } finally {
      if (this.key === wanted) {
        this.busy = false;
        this.move(false);
      }
    }
  }

  private move(moving: boolean): void {
    if (this.moving === moving) return;
    this.moving = moving;
    this.times = [];
    this.stage.filmMoves();
  }

  /** Asks for the film a moment later; null: it stands still. */
  private step(): Promise<FilmReply> | null {
    if (!this.stage.living() || !this.stage.fieldReady() || !this.state) return null;
    for (const name of LIVE) {
      const value = Number(this.keys[name]);
      if (value === this.sent[name]) continue;
      this.sent[name] = value;
      this.job.send({ kind: "flow-change", name, value });
    }
    if (!this.keys["playing"] || document.hidden || !Number.isNaN(this.state.ruptured_s)) {
      this.flowed = 0;
      return null;
    }
    const now = performance.now();
    // A picture that comes late is not a longer step, and what it leaves is not lost: the next steps make it good.
    this.owed = this.flowed ? Math.min(this.owed + (now - this.flowed) / 1000, MOST_OWED_S) : LONGEST_STEP_S;
    this.flowed = now;
    const step_s = Math.min(Math.max(this.owed, 1 / 120), LONGEST_STEP_S);
    this.owed = Math.max(this.owed - step_s, 0);
    return this.job.ask<"film">({ kind: "flow-advance", id: 0, time_s: this.state.time_s + step_s });
  }

  /** Smaller pictures where they come too slowly, unless it is the film that they wait for; larger ones where there is time. */
  private keepPace(): void {
    this.times.push(performance.now());
    if (this.times.length % 30 === 0) this.stage.page.version++;
    if (this.times.length <= PACE_PICTURES) return;
    const share = this.perSecond() / EASY_PER_S;
    const isDrawing = this.stepMs() < 900 / this.perSecond();
    if (share < 1 ? isDrawing && this.stage.smaller(share) : this.times.length > LONG_PICTURES && this.stage.larger(share)) this.times = [];
    if (this.times.length > LONG_PICTURES) this.times.shift();
  }

  perSecond(): number {
    const { times } = this;
    return times.length > 1 ? ((times.length - 1) * 1000) / (times[times.length - 1] - times[0]) : 0;
  }

  /** Median time of a step, ms. */
  stepMs(): number {
    const sorted = [...this.steps].sort((a, b) => a - b);
    return sorted[sorted.length >> 1] ?? 0;
  }

  /** The pointer moved with its button down. */
  stir(event: PointerEvent, place: [number, number] | null): void {
    if (!this.stage.living() || !this.state || !(event.buttons & 1) || !place) {
      this.lastStir = null;
      return;
    }
    const now = performance.now();
    const last = this.lastStir;
    this.lastStir = { place, time: now };
    if (!last || now - last.time < 1) return;
    this.blow(place, [place[0] - last.place[0], place[1] - last.place[1]], (now - last.time) / 1000);
  }

  /** Drags the film along: `moved` in shares of the field, within so many seconds. */
  blow(place: [number, number], moved: [number, number], seconds: number): void {
    const shape = SHAPES[String(this.keys["preset"])];
    if (!this.state || !shape) return;
    const { columns, rows } = this.state;
    const [across, down] = "radius" in shape
      ? [2 * Math.PI * shape.radius * Math.sin(place[1] * shape.rim), shape.rim * shape.radius]
      : [shape.across, shape.down];
    const turn = moved[0] - Math.round(moved[0]);
    const held = (v: number) => Math.min(Math.max(v / seconds, -1), 1);
    const row = Math.min(Math.max(place[1] * rows - 0.5, -0.5), rows - 0.5);
    this.job.send({
      kind: "flow-stir", place: [row, place[0] * columns - 0.5], speed: [held(moved[1] * down), held(turn * across)], radius_m: 6e-3,
    });
  }
}
