// The Rust core in wasm: one instance, and typed words for its calls (crates/web/src/lib.rs).

/** What every export looks like from here. */
interface Exports {
  memory: WebAssembly.Memory;
  [name: string]: unknown;
}

export interface Answer {
  /** A copy: the place in wasm memory is used again by the next call. */
  result: Float64Array;
  message: string;
}

/** What the core refuses, in its own words. */
export class CoreError extends Error {}
/** The core broke; the instance is of no more use. */
export class CoreBroken extends Error {}

export interface TableGrid {
  rows: number;
  columns: number;
  first_nm: number;
  step_nm: number;
  first_deg: number;
  step_deg: number;
  /** 1/m^2 of the reduced thickness t sqrt(1 - sin^2/m^2); 0 where it is the thickness itself. */
  inverse_square: number;
  white: [number, number, number];
  max_delta_e: number;
  mean_delta_e: number;
}

/** Colours of one stack over thickness and angle, exact at its nodes: X, Y, Z and their slopes, row by row. */
export interface ColorTable extends TableGrid {
  range_nm: [number, number];
  range_deg: [number, number];
  nodes: Float32Array;
}

export interface TableRequest {
  stack: string;
  layer: number;
  illuminant: string;
  range_nm: [number, number];
  range_deg: [number, number];
  max_delta_e: number;
}

export interface FilmState {
  time_s: number;
  columns: number;
  rows: number;
  film: number;
  evaporated: number;
  swallowed: number;
  blackened: number;
  drained: number;
  ruptured_s: number;
  thickness_nm: Float32Array;
}

export interface Item {
  name: string;
  thickness_nm: number | null;
  kind: "" | "coherent" | "incoherent";
  open: boolean;
}

export const SHAPE_NUMBERS = 12;

export class Core {
  private readonly exports: Exports;
  broken = false;

  constructor(instance: WebAssembly.Instance) {
    this.exports = instance.exports as unknown as Exports;
    (this.exports["begin"] as () => void)();
  }

  static async from(module: WebAssembly.Module): Promise<Core> {
    return new Core(await WebAssembly.instantiate(module, {}));
  }

  private export(name: string): (...values: number[]) => number {
    return this.exports[name] as (...values: number[]) => number;
  }

  private words(pointer: string, length: string): string {
    const bytes = new Uint8Array(this.exports.memory.buffer, this.export(pointer)(), this.export(length)());
    return new TextDecoder().decode(bytes.slice());
  }

  call(name: string, text = "", numbers: ArrayLike<number> = []): Answer {
    if (this.broken) throw new CoreBroken("the core stopped after an error; load the page again");
    try {
      const bytes = new TextEncoder().encode(text);
      const place = this.export("text")(bytes.length);
      const values = this.export("numbers")(numbers.length);
      // Views are taken after the calls: memory may have grown, which detaches older ones.
      new Uint8Array(this.exports.memory.buffer, place, bytes.length).set(bytes);
      new Float64Array(this.exports.memory.buffer, values, numbers.length).set(numbers);
      const failed = this.export(name)();
      const message = this.words("message", "message_length");
      if (failed) throw new CoreError(message);
      const count = this.export("result_length")();
      const result = new Float64Array(this.exports.memory.buffer, this.export("result")(), count).slice();
      return { result, message };
    } catch (error) {
      if (error instanceof CoreError) throw error;
      this.broken = true;
      const words = this.words("panic_message", "panic_length");
      throw new CoreBroken(words || String(error));
    }
  }

  /** X, Y, Z of each pair of thickness (of `layer`; -1: as the stack says) and angle. */
  color(
    stack: string,
    points: ArrayLike<number>,
    { layer = -1, illuminant = "", quantity = "", model = "", polarization = "" } = {},
  ): Float64Array {
    const numbers = new Float64Array(points.length + 1);
    numbers[0] = layer;
    numbers.set(points, 1);
    return this.call("stack_color", [stack, illuminant, quantity, model, polarization].join("\n"), numbers).result;
  }

  spectrum(
    stack: string,
    wavelengths: ArrayLike<number>,
    angle_deg: number,
    { quantity = "", polarization = "", model = "" } = {},
  ): Float64Array {
    const numbers = new Float64Array(wavelengths.length + 1);
    numbers[0] = angle_deg;
    numbers.set(wavelengths, 1);
    return this.call("stack_spectrum", [stack, quantity, polarization, model].join("\n"), numbers).result;
  }

  describe(stack: string): Item[] {
    const lines = this.call("stack_describe", stack).message.trimEnd().split("\n");
    return lines.map((line) => {
      const [name, nm, kind] = line.split("\t");
      const open = nm === "?";
      return { name, thickness_nm: nm === "" || open ? null : Number(nm), kind: kind as Item["kind"], open };
    });
  }

  convert(values: ArrayLike<number>, from: string, to: string, illuminant = "", gamut = ""): Float64Array {
    return this.call("color_convert", [from, to, illuminant, gamut].join("\n"), values).result;
  }

  difference(pairs: ArrayLike<number>): Float64Array {
    return this.call("color_difference", "", pairs).result;
  }

  illuminant(name: string): { first: number; white: number[]; power: Float64Array; lines: [number, number][] } {
    const { result, message } = this.call("illuminant_describe", name);
    const lines = message.split("\n").filter(Boolean);
    return {
      first: result[0],
      white: Array.from(result.slice(2, 5)),
      power: result.slice(5),
      lines: lines.map((line) => line.split("\t").map(Number) as [number, number]),
    };
  }

  names(what: "media_list" | "illuminant_list" | "flow_presets"): string[] {
    return this.call(what).message.trimEnd().split("\n").map((line) => line.split("\t")[0]);
  }

  table(request: TableRequest): ColorTable {
    const text = [request.stack, request.illuminant, "", "", ""].join("\n");
    const numbers = [request.layer, ...request.range_nm, ...request.range_deg, request.max_delta_e];
    return tableOf(this.call("color_table", text, numbers).result, request.range_nm, request.range_deg);
  }

  flowStart(preset: string, changes: Record<string, number>, columns: number, seed: number): FilmState {
    const lines = Object.entries(changes).map(([name, value]) => `${name}=${value}`);
    return filmState(this.call("flow_start", [preset, ...lines].join("\n"), [columns, seed]).result);
  }

  flowAdvance(time_s: number): FilmState {
    return filmState(this.call("flow_advance", "", [time_s]).result);
  }
}

export function tableOf(result: Float64Array, range_nm: [number, number], range_deg: [number, number]): ColorTable {
  const [rows, columns, first_nm, step_nm, first_deg, step_deg, inverse_square, x, y, z, max, mean] = result;
  return {
    rows, columns, first_nm, step_nm, first_deg, step_deg, inverse_square,
    white: [x, y, z],
    max_delta_e: max,
    mean_delta_e: mean,
    range_nm,
    range_deg,
    nodes: Float32Array.from(result.subarray(SHAPE_NUMBERS)),
  };
}

function filmState(result: Float64Array): FilmState {
  const [time_s, columns, rows, film, evaporated, swallowed, blackened, drained, ruptured_s] = result;
  const thickness_nm = Float32Array.from(result.subarray(9));
  return { time_s, columns, rows, film, evaporated, swallowed, blackened, drained, ruptured_s, thickness_nm };
}
