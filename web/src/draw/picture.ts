// A picture on a canvas: WebGL2 where there is one, else the same arithmetic in a loop.

import type { ColorTable } from "../core/core";
import { lookUp } from "../core/look-up";
import { type Draft, draftOf } from "./draft";
import { type Field, type Geometry, WALL, thicknessAt } from "./geometry";
import { VERTEX, WAYS, type Way, fragment } from "./shader";

export interface Look {
  /** Linear sRGB from XYZ, row by row, from the core. */
  rgb_from_xyz: ArrayLike<number>;
  /** What X, Y, Z are multiplied by before they are shown. */
  exposure: number;
  /** The film moves: colours to CIEDE2000 0.5 will do. */
  moving: boolean;
}

export interface Pixels {
  width: number;
  height: number;
  /** Linear, three numbers a pixel. */
  xyz: Float32Array;
  thickness_nm: Float32Array;
  angle_deg: Float32Array;
}

interface Painter {
  readonly kind: "webgl2" | "canvas";
  /** Whether the processor shades the pixels. */
  readonly software: boolean;
  setGeometry(geometry: Geometry): void;
  setTable(table: ColorTable): void;
  setField(field: Field): void;
  draw(look: Look): void;
  xyz(): Float32Array;
  dispose(): void;
}

const NO_FIELD: Field = { columns: 1, rows: 1, thickness_nm: new Float32Array(1) };

/** What is drawn, and how. */
export class Picture {
  private painter: Painter | null = null;
  /** The look that is on the canvas; nothing: something else has changed since. */
  private drawn = "";
  geometry: Geometry | null = null;
  table: ColorTable | null = null;
  field: Field = NO_FIELD;
  look: Look = { rgb_from_xyz: [1, 0, 0, 0, 1, 0, 0, 0, 1], exposure: 1, moving: false };

  /** `lost`: this canvas draws no more. It keeps its first kind of context, so that another painter needs another canvas. */
  constructor(readonly canvas: HTMLCanvasElement, lost: () => void, without = false) {
    if (without) {
      this.painter = new LoopPainter(canvas);
      return;
    }
    try {
      this.painter = new GlPainter(canvas, lost);
    } catch (error) {
      console.info(`WebGL2 cannot be used: ${error instanceof Error ? error.message : error}`);
      if (canvas.getContext("webgl2")) queueMicrotask(lost);
      else this.painter = new LoopPainter(canvas);
    }
  }

  get kind(): "webgl2" | "canvas" {
    return this.painter?.kind ?? "canvas";
  }

  get software(): boolean {
    return this.painter?.software ?? true;
  }

  setGeometry(geometry: Geometry): void {
    this.geometry = geometry;
    if (this.canvas.width !== geometry.width) this.canvas.width = geometry.width;
    if (this.canvas.height !== geometry.height) this.canvas.height = geometry.height;
    this.painter?.setGeometry(geometry);
    this.drawn = "";
  }

  setTable(table: ColorTable): void {
    if (this.table === table) return;
    this.table = table;
    this.painter?.setTable(table);
    this.drawn = "";
  }

  setField(field: Field): void {
    this.field = field;
    this.painter?.setField(field);
    this.drawn = "";
  }

  draw(): boolean {
    if (!this.geometry || !this.table || !this.painter) return false;
    const look = `${this.look.exposure} ${this.look.moving}`;
    if (look !== this.drawn) this.painter.draw(this.look);
    this.drawn = look;
    return true;
  }

  /** Thickness and angle of the front wall at a pixel; nothing where there is no film. */
  at(x: number, y: number): { thickness_nm: number; angle_deg: number; place: [number, number] } | null {
    const geometry = this.geometry;
    if (!geometry || x < 0 || y < 0 || x >= geometry.width || y >= geometry.height) return null;
    const n = (y * geometry.width + x) * WALL;
    const [u, v, angle_deg] = geometry.front.subarray(n, n + 3);
    if (angle_deg < 0) return null;
    const thickness_nm = geometry.field ? thicknessAt(this.field, u, v, geometry.repeats) : u;
    return { thickness_nm, angle_deg, place: [u, v] };
  }

  pixels(): Pixels | null {
    const geometry = this.geometry;
    if (!geometry || !this.table || !this.painter) return null;
    const count = geometry.width * geometry.height;
    const [thickness_nm, angle_deg] = [new Float32Array(count).fill(NaN), new Float32Array(count).fill(NaN)];
    for (let i = 0; i < count; i++) {
      const n = i * WALL;
      if (geometry.front[n + 2] < 0) continue;
      angle_deg[i] = geometry.front[n + 2];
      thickness_nm[i] = geometry.field
        ? thicknessAt(this.field, geometry.front[n], geometry.front[n + 1], geometry.repeats)
        : geometry.front[n];
    }
    return { width: geometry.width, height: geometry.height, xyz: this.painter.xyz(), thickness_nm, angle_deg };
  }

  /** Luminances of some thousand pixels that show film, sorted. */
  luminances(): number[] {
    const { geometry, table } = this;
    if (!geometry || !table) return [];
    const found: number[] = [];
    const one = new Float32Array(3);
    const count = geometry.width * geometry.height;
    const stride = Math.max(1, Math.floor(count / 4000)) | 1;
    for (let i = 0; i < count; i += stride) {
      if (geometry.front[i * WALL + 2] < 0) continue;
      shade(geometry, table, this.field, i, one, 0);
      found.push(one[1]);
    }
    return found.sort((a, b) => a - b);
  }

  dispose(): void {
    this.painter?.dispose();
  }
}

// ------------------------------------------------------------------------------------------------------------ WebGL2

/** Textures of the shader, each in the unit of its place here. */
const SAMPLERS = ["front", "back", "behind", "field", "values", "slopes", "draft"] as const;
type Sampler = (typeof SAMPLERS)[number];
type Four = [number, number, number, number];

class GlPainter implements Painter {
  readonly kind = "webgl2";
  readonly software: boolean;
  private readonly gl: WebGL2RenderingContext;
  /** By what they were compiled for. */
  private readonly programs = new Map<string, Program>();
  private readonly textures = new Map<Sampler, WebGLTexture>();
  /** Width, height and channels of what each holds: another picture of that kind needs no other memory. */
  private readonly held = new Map<string, string>();
  private corners = new Float32Array(0);
  private geometry: Geometry | null = null;
  private table: ColorTable | null = null;
  /** The table that the draft on the device was made of. */
  private drafted: ColorTable | null = null;
  private hasDraft = false;
  private draftAxes: Four = [0, 1, 0, 1];
  private readonly lost: (event: Event) => void;

  constructor(private readonly canvas: HTMLCanvasElement, lost: () => void) {
    // Not in step with the rest of the page, which would all be put together anew for each picture of a living film.
    const gl = canvas.getContext("webgl2", { antialias: false, alpha: false, preserveDrawingBuffer: true, desynchronized: true });
    if (!gl) throw new Error("no WebGL2 here");
    this.gl = gl;
    const named = gl.getExtension("WEBGL_debug_renderer_info")?.UNMASKED_RENDERER_WEBGL ?? gl.RENDERER;
    this.software = /swiftshader|llvmpipe|softpipe|basic render/i.test(String(gl.getParameter(named)));
    // A device that cannot have the plainest of them is no use: better to know at once.
    this.program([]);
    SAMPLERS.forEach((name, unit) => {
      const texture = gl.createTexture();
      if (!texture) throw new Error("no texture");
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      for (const parameter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) {
        gl.texParameteri(gl.TEXTURE_2D, parameter, gl.NEAREST);
      }
      this.textures.set(name, texture);
    });
    this.setField(NO_FIELD);
    this.lost = (event) => {
      event.preventDefault();
      lost();
    };
    canvas.addEventListener("webglcontextlost", this.lost);
  }

  private program(ways: readonly Way[]): Program {
    const key = ways.join(" ");
    let program = this.programs.get(key);
    if (!program) {
      program = new Program(this.gl, ways);
      this.programs.set(key, program);
    }
    return program;
  }

  private fill(name: Sampler, width: number, height: number, channels: number, data: Float32Array): void {
    const gl = this.gl;
    const most = gl.getParameter(gl.MAX_TEXTURE_SIZE) as number;
    if (width > most || height > most) throw new Error(`${name} needs ${width} x ${height}, ${most} is the most`);
    const [internal, format] = (
      [[gl.R32F, gl.RED], [gl.RG32F, gl.RG], [gl.RGB32F, gl.RGB], [gl.RGBA32F, gl.RGBA]] as const
    )[channels - 1];
    gl.activeTexture(gl.TEXTURE0 + SAMPLERS.indexOf(name));
    gl.bindTexture(gl.TEXTURE_2D, this.textures.get(name) as WebGLTexture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
    const kind = `${width} ${height} ${channels}`;
    if (this.held.get(name) === kind) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, format, gl.FLOAT, data);
    else gl.texImage2D(gl.TEXTURE_2D, 0, internal, width, height, 0, format, gl.FLOAT, data);
    this.held.set(name, kind);
  }

  setGeometry(geometry: Geometry): void {
    const gl = this.gl;
    this.geometry = geometry;
    this.fill("front", geometry.width, geometry.height, WALL, geometry.front);
    if (geometry.passes) this.fill("back", geometry.width, geometry.height, WALL, geometry.back);
    else this.fill("back", 1, 1, WALL, new Float32Array(WALL));
    this.fill("behind", geometry.width, geometry.height, 2, geometry.behind);
    gl.viewport(0, 0, geometry.width, geometry.height);
  }

  private fillDraft({ rows, columns, texels, axes }: Draft): void {
    const gl = this.gl;
    gl.activeTexture(gl.TEXTURE0 + SAMPLERS.indexOf("draft"));
    gl.bindTexture(gl.TEXTURE_2D, this.textures.get("draft") as WebGLTexture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32UI, columns, rows, 0, gl.RGBA_INTEGER, gl.UNSIGNED_INT, texels);
    this.draftAxes = [axes[0], 1 / axes[1], axes[2], 1 / axes[3]];
  }

  /** Whether there is a draft of the table. It is made when first asked for: most pictures stand still. */
  private draftReady(): boolean {
    if (this.drafted === this.table || !this.table) return this.hasDraft;
    this.drafted = this.table;
    const draft = draftOf(this.table);
    this.hasDraft = Boolean(draft);
    if (draft) this.fillDraft(draft);
    return this.hasDraft;
  }

  setTable(table: ColorTable): void {
    this.table = table;
    const { rows, columns, nodes } = table;
    const count = rows * columns;
    const [values, slopes] = [new Float32Array(count * 3), new Float32Array(count * 3)];
    for (let i = 0; i < count; i++) {
      for (let k = 0; k < 3; k++) {
        values[3 * i + k] = nodes[6 * i + k];
        slopes[3 * i + k] = nodes[6 * i + 3 + k];
      }
    }
    this.fill("values", columns, rows, 3, values);
    this.fill("slopes", columns, rows, 3, slopes);
  }

  setField(field: Field): void {
    const { columns, rows, thickness_nm } = field;
    if (this.corners.length !== columns * rows * 4) this.corners = new Float32Array(columns * rows * 4);
    const { corners } = this;
    for (let row = 0; row < rows; row++) {
      // The first row after the last, for fields that repeat downwards: others never look there.
      const [here, below] = [row * columns, ((row + 1) % rows) * columns];
      for (let column = 0; column < columns; column++) {
        const next = column + 1 < columns ? column + 1 : 0;
        const n = 4 * (here + column);
        corners[n] = thickness_nm[here + column];
        corners[n + 1] = thickness_nm[here + next];
        corners[n + 2] = thickness_nm[below + column];
        corners[n + 3] = thickness_nm[below + next];
      }
    }
    this.fill("field", columns, rows, 4, corners);
  }

  private run(look: Look, answer: boolean): void {
    const { gl, table } = this;
    const geometry = this.geometry as Geometry;
    if (!table) return;
    const asked: Record<Way, boolean> = {
      FIELD: geometry.field, REPEATS: geometry.repeats, PASSES: geometry.passes, DRAFT: look.moving && this.draftReady(), ANSWER: answer,
    };
    const program = this.program(WAYS.filter((way) => asked[way]));
    program.use();
    gl.uniform2i(program.place("size"), table.columns, table.rows);
    gl.uniform4f(program.place("axes"), table.first_nm, table.step_nm, table.first_deg, table.step_deg);
    gl.uniform4f(program.place("limits"), ...table.range_nm, ...table.range_deg);
    gl.uniform1f(program.place("inverse_square"), table.inverse_square);
    const [x, y, z] = table.white;
    gl.uniform3f(program.place("white"), x, y, z);
    gl.uniform3f(program.place("over_white"), 1 / x, 1 / y, 1 / z);
    gl.uniform4f(program.place("draft_axes"), ...this.draftAxes);
    gl.uniformMatrix3fv(program.place("rgb_from_xyz"), true, Float32Array.from(look.rgb_from_xyz));
    gl.uniform1f(program.place("exposure"), look.exposure);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  draw(look: Look): void {
    if (this.geometry) this.run(look, false);
  }

  /** Drawn into a target of floats and read from there: a canvas has eight bits. Colours are the table's, moving or not. */
  xyz(): Float32Array {
    const gl = this.gl;
    const { width, height } = this.geometry as Geometry;
    if (!gl.getExtension("EXT_color_buffer_float")) throw new Error("this device draws no floats");
    const target = gl.createRenderbuffer();
    const frame = gl.createFramebuffer();
    gl.bindRenderbuffer(gl.RENDERBUFFER, target);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.RGBA32F, width, height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, target);
    this.run({ rgb_from_xyz: [1, 0, 0, 0, 1, 0, 0, 0, 1], exposure: 1, moving: false }, true);
    const four = new Float32Array(width * height * 4);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, four);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.deleteFramebuffer(frame);
    gl.deleteRenderbuffer(target);
    const xyz = new Float32Array(width * height * 3);
    for (let i = 0; i < width * height; i++) xyz.set(four.subarray(4 * i, 4 * i + 3), 3 * i);
    return xyz;
  }

  dispose(): void {
    this.canvas.removeEventListener("webglcontextlost", this.lost);
    for (const texture of this.textures.values()) this.gl.deleteTexture(texture);
    for (const program of this.programs.values()) program.dispose();
  }
}

/** The shader, compiled for some ways of drawing. */
class Program {
  private readonly program: WebGLProgram;
  private readonly places = new Map<string, WebGLUniformLocation | null>();

  constructor(private readonly gl: WebGL2RenderingContext, ways: readonly Way[]) {
    this.program = link(gl, fragment(ways));
    gl.useProgram(this.program);
    SAMPLERS.forEach((name, unit) => gl.uniform1i(this.place(name), unit));
  }

  use(): void {
    this.gl.useProgram(this.program);
  }

  /** Where a uniform is; null: this program has no use for it, and it may be set in vain. */
  place(name: string): WebGLUniformLocation | null {
    if (!this.places.has(name)) this.places.set(name, this.gl.getUniformLocation(this.program, name));
    return this.places.get(name) ?? null;
  }

  dispose(): void {
    this.gl.deleteProgram(this.program);
  }
}

function link(gl: WebGL2RenderingContext, source: string): WebGLProgram {
  const program = gl.createProgram();
  if (!program) throw new Error("no program");
  for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, source]] as const) {
    const shader = gl.createShader(kind);
    if (!shader) throw new Error("no shader");
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader) ?? "a shader");
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) ?? "the program");
  return program;
}

// ------------------------------------------------------------------------------------------------------------ a loop

const mirrored = new Float64Array(3);
const inner = new Float64Array(3);

/** One pixel's X, Y, Z: the twin of the shader's main. */
function shade(geometry: Geometry, table: ColorTable, field: Field, pixel: number, out: Float32Array, at: number): void {
  const { front, back, behind, passes } = geometry;
  const n = pixel * WALL;
  const [rest, cover] = [behind[2 * pixel], behind[2 * pixel + 1]];
  const near = front[n + 2] >= 0;
  const far = near && passes && back[n + 2] >= 0;
  if (near) wallColor(geometry, table, field, front, n, mirrored);
  if (far) wallColor(geometry, table, field, back, n, inner);
  for (let k = 0; k < 3; k++) {
    const white = table.white[k];
    let xyz = white * rest;
    if (near) {
      let seen = mirrored[k] * front[n + 3];
      if (passes) {
        const through = 1 - mirrored[k] / white;
        let beyond = white * rest;
        if (far) beyond = beyond * (1 - inner[k] / white) + inner[k] * through * back[n + 3];
        seen += beyond * through;
      }
      xyz += (seen - xyz) * cover;
    }
    out[at + k] = xyz;
  }
}

function wallColor(geometry: Geometry, table: ColorTable, field: Field, wall: Float32Array, n: number, out: Float64Array): void {
  const nm = geometry.field ? thicknessAt(field, wall[n], wall[n + 1], geometry.repeats) : wall[n];
  lookUp(table, nm, wall[n + 2], out, 0);
}

/** Linear RGB made to fit, then the sRGB curve: 0 to 255. */
export function shown(x: number, y: number, z: number, look: Look, out: Uint8ClampedArray, at: number): void {
  const m = look.rgb_from_xyz;
  const e = look.exposure;
  const rgb = [0, 3, 6].map((row) => (m[row] * x + m[row + 1] * y + m[row + 2] * z) * e);
  const luminance = Math.min(Math.max(y * e, 0), 1);
  const least = Math.min(...rgb);
  const low = least < 0 ? luminance / Math.max(luminance - least, 1e-9) : 1;
  const raised = rgb.map((c) => luminance + (c - luminance) * low);
  const most = Math.max(...raised);
  const high = most > 1 ? (1 - luminance) / Math.max(most - luminance, 1e-9) : 1;
  for (let k = 0; k < 3; k++) {
    const c = Math.min(Math.max(luminance + (raised[k] - luminance) * high, 0), 1);
    out[at + k] = 255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055);
  }
}

class LoopPainter implements Painter {
  readonly kind = "canvas";
  readonly software = true;
  private readonly context: CanvasRenderingContext2D;
  private geometry: Geometry | null = null;
  private table: ColorTable | null = null;
  private field: Field = NO_FIELD;

  constructor(canvas: HTMLCanvasElement) {
    const context = canvas.getContext("2d");
    if (!context) throw new Error("this browser has no canvas");
    this.context = context;
  }

  setGeometry(geometry: Geometry): void {
    this.geometry = geometry;
  }

  setTable(table: ColorTable): void {
    this.table = table;
  }

  setField(field: Field): void {
    this.field = field;
  }

  draw(look: Look): void {
    if (!this.geometry || !this.table) return;
    const { width, height } = this.geometry;
    const image = this.context.createImageData(width, height);
    const one = new Float32Array(3);
    for (let i = 0; i < width * height; i++) {
      shade(this.geometry, this.table, this.field, i, one, 0);
      shown(one[0], one[1], one[2], look, image.data, 4 * i);
      image.data[4 * i + 3] = 255;
    }
    this.context.putImageData(image, 0, 0);
  }

  xyz(): Float32Array {
    const geometry = this.geometry as Geometry;
    const count = geometry.width * geometry.height;
    const xyz = new Float32Array(count * 3);
    for (let i = 0; i < count; i++) shade(geometry, this.table as ColorTable, this.field, i, xyz, 3 * i);
    return xyz;
  }

  dispose(): void {
    this.geometry = null;
  }
}
