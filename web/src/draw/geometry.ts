// What the eye meets: for every pixel up to two film walls (where on the film, at which angle, what light they mirror)
// and what is behind them. No colour is known here; the colours come from the tables of the core.

import { type Radiance, radianceOf, uniform } from "./light";
import { OXIDE_NM, OXIDE_NM_PER_VOLT, type State } from "../state/keys";

/** Numbers a pixel and wall: place on the film (or thickness in nm and 0), angle in degrees (< 0: no film), radiance. */
export const WALL = 4;

export interface Geometry {
  width: number;
  height: number;
  /** Whether walls hold places on a field of thickness, or the thickness itself. */
  field: boolean;
  /** Whether the field goes round downwards too (it always does across). */
  repeats: boolean;
  /** Whether light passes the walls; if not, one wall is all there is. */
  passes: boolean;
  front: Float32Array;
  back: Float32Array;
  /** Radiance behind (or beside) the film, and the share of the pixel that film covers. */
  behind: Float32Array;
}

export interface View {
  width: number;
  height: number;
  state: State;
  /** Reflectance of still water by whole degrees, from the core; asked for where there is water. */
  water: () => Float64Array;
}

const DEGREES = 180 / Math.PI;

function blank(width: number, height: number, field: boolean, passes: boolean, repeats = false): Geometry {
  const pixels = width * height;
  const geometry = {
    width, height, field, repeats, passes,
    front: new Float32Array(pixels * WALL),
    back: new Float32Array(pixels * WALL),
    behind: new Float32Array(pixels * 2),
  };
  for (let i = 2; i < geometry.front.length; i += WALL) geometry.front[i] = geometry.back[i] = -1;
  return geometry;
}

function put(wall: Float32Array, pixel: number, u: number, v: number, cos: number, radiance: number): void {
  const n = pixel * WALL;
  wall[n] = u;
  wall[n + 1] = v;
  wall[n + 2] = Math.acos(Math.min(Math.max(cos, 0), 1)) * DEGREES;
  wall[n + 3] = radiance;
}

/** Calls `pixel(i, dx, dy, dz)` with the direction of the ray through every pixel of a pinhole camera. */
function rays(
  width: number, height: number, eye: number[], target: number[], fov_deg: number,
  pixel: (i: number, x: number, y: number, z: number) => void,
): void {
  const f = norm([target[0] - eye[0], target[1] - eye[1], target[2] - eye[2]]);
  const r = norm([-f[2], 0, f[0]]);
  const u = [r[1] * f[2] - r[2] * f[1], r[2] * f[0] - r[0] * f[2], r[0] * f[1] - r[1] * f[0]];
  // The full angle belongs to the shorter side, so that nothing is cut off on an upright phone.
  const tan = Math.tan(fov_deg / 2 / DEGREES) / (Math.min(width, height) / 2);
  for (let j = 0; j < height; j++) {
    const b = (height / 2 - j - 0.5) * tan;
    for (let i = 0; i < width; i++) {
      const a = (i + 0.5 - width / 2) * tan;
      const x = f[0] + a * r[0] + b * u[0];
      const y = f[1] + a * r[1] + b * u[1];
      const z = f[2] + a * r[2] + b * u[2];
      const s = 1 / Math.sqrt(x * x + y * y + z * z);
      pixel(j * width + i, x * s, y * s, z * s);
    }
  }
}

function norm(v: number[]): number[] {
  const s = 1 / Math.hypot(v[0], v[1], v[2]);
  return v.map((x) => x * s);
}

/** Place on a flowing film's grid: azimuth from +x towards -z, polar angle from +y over that of the rim. */
export function placeOnSphere(x: number, y: number, z: number, rim: number): [number, number] {
  const turn = Math.atan2(-z, x) / (2 * Math.PI);
  return [turn < 0 ? turn + 1 : turn, Math.acos(Math.min(Math.max(y, -1), 1)) / rim];
}

const BUBBLE_EYE = 16;
const BUBBLE_RADIUS = 4;
const DOME_RADIUS = 2.5;

/** A whole bubble: the front wall mirrors the room upright, the back wall upside down. */
function bubble({ width, height, state }: View): Geometry {
  const light = radianceOf(String(state["environment"]));
  const still = state["preset"] === "still";
  const two = state["walls"] === "2";
  const geometry = blank(width, height, true, two);
  const bare = state["environment"] === "uniform";
  const edge = (Math.tan(35 / 2 / DEGREES) / (Math.min(width, height) / 2)) * BUBBLE_EYE;
  rays(width, height, [0, 0, BUBBLE_EYE], [0, 0, 0], 35, (i, x, y, z) => {
    geometry.behind[2 * i] = two ? light(x, y, z) : bare ? 0 : light(x, y, z);
    const b = BUBBLE_EYE * z; // the ray starts at (0, 0, eye)
    const miss = Math.sqrt(Math.max(BUBBLE_EYE * BUBBLE_EYE - b * b, 0));
    const cover = Math.min(Math.max((BUBBLE_RADIUS - miss) / edge + 0.5, 0), 1);
    if (cover <= 0) return;
    geometry.behind[2 * i + 1] = cover;
    const root = Math.sqrt(Math.max(BUBBLE_RADIUS * BUBBLE_RADIUS - miss * miss, 0));
    for (const [wall, t] of [[geometry.front, -b - root], [geometry.back, -b + root]] as const) {
      const px = (x * t) / BUBBLE_RADIUS;
      const py = (y * t) / BUBBLE_RADIUS;
      const pz = (BUBBLE_EYE + z * t) / BUBBLE_RADIUS;
      const dot = x * px + y * py + z * pz;
      const mirrored = light(x - 2 * dot * px, y - 2 * dot * py, z - 2 * dot * pz);
      const [u, v] = still ? [0.5, (1 - py) / 2] : placeOnSphere(px, py, pz, Math.PI);
      put(wall, i, u, v, Math.abs(dot), mirrored);
      if (!two) break;
    }
  });
  return geometry;
}

/** A dome on water, which mirrors it. */
function dome({ width, height, state, water }: View): Geometry {
  const light = radianceOf(String(state["environment"]));
  const two = state["walls"] === "2";
  const geometry = blank(width, height, true, two);
  const eye = [0, 4.2, 11];
  const fov = 31;
  const edge = (Math.tan(fov / 2 / DEGREES) / (Math.min(width, height) / 2)) * Math.hypot(...eye);
  /** First and second wall above the water from a point along a direction. */
  const meet = (o: number[], x: number, y: number, z: number): [number, number, number] => {
    const b = o[0] * x + o[1] * y + o[2] * z;
    const miss = Math.sqrt(Math.max(o[0] * o[0] + o[1] * o[1] + o[2] * o[2] - b * b, 0));
    const root = Math.sqrt(Math.max(DOME_RADIUS * DOME_RADIUS - miss * miss, 0));
    return [-b - root, -b + root, miss];
  };
  const wall = (to: Float32Array, i: number, o: number[], x: number, y: number, z: number, t: number, share: number) => {
    const px = (o[0] + x * t) / DOME_RADIUS;
    const py = (o[1] + y * t) / DOME_RADIUS;
    const pz = (o[2] + z * t) / DOME_RADIUS;
    const dot = x * px + y * py + z * pz;
    const [u, v] = placeOnSphere(px, py, pz, Math.PI / 2);
    put(to, i, u, v, Math.abs(dot), share * lit(x - 2 * dot * px, y - 2 * dot * py, z - 2 * dot * pz));
  };
  /** Light from a direction, where the water below gives back some of the sky. */
  const lit: Radiance = (x, y, z) => (y >= 0 ? light(x, y, z) : mirror(-y) * light(x, -y, z));
  const still = water();
  const mirror = (cos: number) => still[Math.round(Math.acos(Math.min(cos, 1)) * DEGREES)];
  rays(width, height, eye, [0, 0.95, 0], fov, (i, x, y, z) => {
    const [t0, t1, miss] = meet(eye, x, y, z);
    const cover = Math.min(Math.max((DOME_RADIUS - miss) / edge + 0.5, 0), 1);
    geometry.behind[2 * i] = two || state["environment"] !== "uniform" ? lit(x, y, z) : 0;
    const above = eye[1] + y * t0 >= 0;
    if (cover > 0 && t0 > 0 && above) {
      geometry.behind[2 * i + 1] = cover;
      wall(geometry.front, i, eye, x, y, z, t0, 1);
      // Behind it: the back wall, or the water inside.
      if (two && eye[1] + y * t1 >= 0) wall(geometry.back, i, eye, x, y, z, t1, 1);
      return;
    }
    if (y >= 0 || !two) return;
    // On the water: what it mirrors of the dome.
    const t = -eye[1] / y;
    const o = [eye[0] + x * t, 0, eye[2] + z * t];
    const [m0, , missed] = meet(o, x, -y, z);
    const share = Math.min(Math.max((DOME_RADIUS - missed) / edge + 0.5, 0), 1);
    if (share <= 0 || m0 <= 0 || -y * m0 < 0) return;
    geometry.behind[2 * i + 1] = share;
    wall(geometry.front, i, o, x, -y, z, m0, mirror(-y));
  });
  return geometry;
}

/** A film in an upright frame that mirrors one soft box. */
function frame({ width, height }: View): Geometry {
  const geometry = blank(width, height, true, false);
  const half = [5, 3];
  const bar = 0.14;
  rays(width, height, [0, 0, 20], [0, 0, 0], 2 * Math.atan(3.4 / 20) * DEGREES * Math.max(1, (5.3 / 3.4) * Math.min(height / width, 1)), (i, x, y, z) => {
    const t = -20 / z;
    const [px, py] = [x * t, y * t];
    const [ax, ay] = [Math.abs(px), Math.abs(py)];
    if (ax > half[0] + bar || ay > half[1] + bar) geometry.behind[2 * i] = 0.004;
    else if (ax > half[0] || ay > half[1]) geometry.behind[2 * i] = 0.03;
    else {
      put(geometry.front, i, (px / half[0] + 1) / 2, (1 - py / half[1]) / 2, -z, 1);
      geometry.behind[2 * i + 1] = 1;
    }
  });
  return geometry;
}

/** Newton's rings, straight from above: the gap under the lens. `gap(mm)` is the core's. */
function rings({ width, height, state }: View): Geometry {
  const geometry = blank(width, height, false, false);
  const side = Number(state["view_mm"]);
  const [radius, contact] = [Number(state["radius_mm"]), Number(state["thickness_nm"])];
  const scale = side / Math.min(width, height);
  for (let j = 0; j < height; j++) {
    for (let i = 0; i < width; i++) {
      const square = (((i + 0.5 - width / 2) * scale) ** 2) + (((j + 0.5 - height / 2) * scale) ** 2);
      // R - sqrt(R^2 - r^2) without taking the difference of two numbers that are nearly the same.
      const gap = contact + (1e6 * square) / (radius + Math.sqrt(radius * radius - square));
      const pixel = j * width + i;
      put(geometry.front, pixel, gap, 0, 1, 1);
      geometry.behind[2 * pixel + 1] = 1;
    }
  }
  return geometry;
}

/** Oil on still water under an open sky. */
function slick({ width, height, state }: View): Geometry {
  const light = radianceOf(String(state["environment"]));
  const geometry = blank(width, height, true, false, true);
  const eye = [0, 0.5, 0.62];
  rays(width, height, eye, [0, 0, 0.06], 40, (i, x, y, z) => {
    geometry.behind[2 * i] = light(x, y, z);
    if (y > -0.02) return;
    const t = -eye[1] / y;
    put(geometry.front, i, x * t * 0.8 + 0.5, (z * t + eye[2]) * 0.8 + 0.5, -y, light(x, -y, z));
    geometry.behind[2 * i + 1] = 1;
  });
  return geometry;
}

/** The room for an eye that looks down: what hangs behind the camera hangs overhead. */
function fromAbove(name: string): Radiance {
  const light = radianceOf(name);
  return name === "studio" ? (x, y, z) => light(x, -z, y) : light;
}

/** A domed coin at the chosen voltage, above a bar drawn slowly out of the bath: 0 to 110 V from left to right. */
function titanium({ width, height, state }: View): Geometry {
  const light = fromAbove(String(state["environment"]));
  const geometry = blank(width, height, false, false);
  const tilt = Number(state["angle_deg"]) / DEGREES;
  // One unit is the height of the view; the eye is far away and leans back by the angle.
  const scale = 1 / Math.min(width / 1.25, height);
  const own = Number(state["thickness_nm"]);
  // The bar lies under an even light, so that its colours can be read off.
  const even = state["environment"] === "studio" ? 2.2 : 1;
  const [dx, dy, dz] = [0, -Math.cos(tilt), -Math.sin(tilt)];
  const pixel = scale;
  for (let j = 0; j < height; j++) {
    for (let i = 0; i < width; i++) {
      const n = j * width + i;
      const x = (i + 0.5 - width / 2) * scale;
      const y = (height / 2 - j - 0.5) * scale;
      geometry.behind[2 * n] = 0.03;
      const [cx, cy] = [x, y - 0.13];
      const r = Math.hypot(cx, cy);
      const coin = Math.min(Math.max((0.33 - r) / pixel + 0.5, 0), 1);
      const bar = Math.min(
        Math.max((0.575 - Math.abs(x)) / pixel + 0.5, 0), Math.max((0.085 - Math.abs(y + 0.36)) / pixel + 0.5, 0), 1,
      );
      if (coin <= 0 && bar <= 0) continue;
      // Normals: the coin is a cap of a sphere, the bar is flat.
      const bend = coin > 0 ? 0.75 : 0;
      const [nx, nz] = [cx * bend, -cy * bend];
      const ny = Math.sqrt(1 - nx * nx - nz * nz);
      const dot = dx * nx + dy * ny + dz * nz;
      const mirrored = light(dx - 2 * dot * nx, dy - 2 * dot * ny, dz - 2 * dot * nz);
      const volts = Math.min(Math.max((x / 0.575 + 1) / 2, 0), 1) * 110;
      put(geometry.front, n, coin > 0 ? own : OXIDE_NM + OXIDE_NM_PER_VOLT * volts, 0, -dot, coin > 0 ? mirrored : even);
      geometry.behind[2 * n + 1] = Math.max(coin, bar);
    }
  }
  return geometry;
}

/** An oxidised wafer, tilted; its oxide is thicker (or thinner) towards the edge. */
function wafer({ width, height, state }: View): Geometry {
  const light = fromAbove(String(state["environment"]));
  const geometry = blank(width, height, false, false);
  const angle = Number(state["angle_deg"]) / DEGREES;
  const [middle, edge] = [Number(state["thickness_nm"]), Number(state["edge_nm"])];
  const radius = 5;
  const distance = 40;
  const eye = [0, distance * Math.cos(angle), distance * Math.sin(angle) + 1e-6];
  const pixel = (Math.tan(17 / 2 / DEGREES) / (Math.min(width, height) / 2)) * distance;
  rays(width, height, eye, [0, 0, 0], 17, (i, x, y, z) => {
    geometry.behind[2 * i] = 0.02;
    const t = -eye[1] / y;
    const [px, pz] = [x * t, eye[2] + z * t];
    const r = Math.hypot(px, pz);
    // The flat that tells how the crystal lies.
    const cover = Math.min(Math.max((Math.min(radius - r, 4.68 - pz)) / pixel + 0.5, 0), 1);
    if (cover <= 0) return;
    put(geometry.front, i, middle + (edge - middle) * (r / radius) ** 2, 0, -y, light(x, -y, z));
    geometry.behind[2 * i + 1] = cover;
  });
  return geometry;
}

/** Every thickness across, every angle downwards. */
function chart({ width, height, state }: View): Geometry {
  const geometry = blank(width, height, false, false);
  const thickest = Number(state["thickest_nm"]);
  for (let j = 0; j < height; j++) {
    const cos = Math.cos(((j + 0.5) / height) * CHART_DEG / DEGREES);
    for (let i = 0; i < width; i++) {
      const pixel = j * width + i;
      put(geometry.front, pixel, ((i + 0.5) / width) * thickest, 0, cos, uniform(0, 1, 0));
      geometry.behind[2 * pixel + 1] = 1;
    }
  }
  return geometry;
}

/** The last angle of the chart of a film. */
export const CHART_DEG = 80;

export function geometryOf(view: View): Geometry {
  switch (view.state.scene) {
    case "rings":
      return rings(view);
    case "slick":
      return slick(view);
    case "titanium":
      return titanium(view);
    case "wafer":
      return wafer(view);
    case "film":
      return chart(view);
    default:
      switch (view.state["preset"]) {
        case "bubble-on-bath-preview":
        case "late-preview":
          return dome(view);
        case "vertical-film-preview":
          return frame(view);
        default:
          return bubble(view);
      }
  }
}

/** Width over height of the picture of a scene. */
export function aspectOf(state: State): number {
  switch (state.scene) {
    case "slick":
      return 4 / 3;
    case "titanium":
      return 1.25;
    case "wafer":
    case "film":
      return 4 / 3;
    case "bubble":
      return state["preset"] === "vertical-film-preview" ? 1.5 : state["preset"] === "still" || state["preset"] === "free-bubble-preview" ? 1 : 4 / 3;
    default:
      return 1;
  }
}

/** Thicknesses on a grid, row 0 on top. */
export interface Field {
  columns: number;
  rows: number;
  thickness_nm: Float32Array;
}

/** Thickness at a place: bilinear between the middles of cells; across it goes round, downwards it is held or goes round. */
export function thicknessAt(field: Field, u: number, v: number, repeats: boolean): number {
  const { columns, rows, thickness_nm } = field;
  const x = u * columns - 0.5;
  const y = repeats ? v * rows - 0.5 : Math.min(Math.max(v * rows - 0.5, 0), rows - 1);
  const [i, j] = [Math.floor(x), Math.floor(y)];
  const [a, b] = [x - i, y - j];
  const left = mod(i, columns);
  const right = mod(i + 1, columns);
  const above = (repeats ? mod(j, rows) : Math.min(j, rows - 1)) * columns;
  const below = (repeats ? mod(j + 1, rows) : Math.min(j + 1, rows - 1)) * columns;
  const top = thickness_nm[above + left] * (1 - a) + thickness_nm[above + right] * a;
  const bottom = thickness_nm[below + left] * (1 - a) + thickness_nm[below + right] * a;
  return top * (1 - b) + bottom * b;
}

function mod(a: number, n: number): number {
  return ((a % n) + n) % n;
}
