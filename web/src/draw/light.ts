// Where light comes from: radiance by direction, grey. Numbers of the studio are those of the package's own
// (crates/scene/src/studio.rs); the overcast sky is that of the CIE, L = Lz (1 + 2 sin(elevation)) / 3.

export type Vector = [number, number, number];
export type Radiance = (x: number, y: number, z: number) => number;

function smooth(from: number, to: number, x: number): number {
  const t = Math.min(Math.max((x - from) / (to - from), 0), 1);
  return t * t * (3 - 2 * t);
}

class Panel {
  private readonly normal: Vector;
  private readonly right: Vector;
  private readonly up: Vector;

  constructor(
    azimuth_deg: number, elevation_deg: number,
    readonly half_width: number, readonly half_height: number, private readonly soft: number,
  ) {
    const a = (azimuth_deg * Math.PI) / 180;
    const e = (elevation_deg * Math.PI) / 180;
    this.normal = [Math.cos(e) * Math.sin(a), Math.sin(e), Math.cos(e) * Math.cos(a)];
    this.right = [Math.cos(a), 0, -Math.sin(a)];
    this.up = [-Math.sin(e) * Math.sin(a), Math.cos(e), -Math.sin(e) * Math.cos(a)];
  }

  /** How much of it a direction meets; `at` takes where, -1 to 1 across and up. */
  meet(x: number, y: number, z: number, at: [number, number]): number {
    const [n, r, u] = [this.normal, this.right, this.up];
    const ahead = x * n[0] + y * n[1] + z * n[2];
    if (ahead < 0.05) return 0;
    const across = (x * r[0] + y * r[1] + z * r[2]) / ahead;
    const up = (x * u[0] + y * u[1] + z * u[2]) / ahead;
    at[0] = across / this.half_width;
    at[1] = up / this.half_height;
    return (
      smooth(-this.soft, this.soft, this.half_width - Math.abs(across)) *
      smooth(-this.soft, this.soft, this.half_height - Math.abs(up))
    );
  }
}

function glass(x: number, panes: number, half: number): number {
  const place = ((x + 1) / 2) * panes;
  const nearest = Math.round(place);
  if (nearest < 0.5 || nearest > panes - 0.5) return 1;
  return smooth(0.023, 0.033, (Math.abs(place - nearest) * 2 * half) / panes);
}

const WINDOW = new Panel(-44, 26, 0.66, 0.8, 0.01);
const SOFT_BOX = new Panel(60, 12, 0.6, 1, 0.12);
const OTHERS: [Panel, number][] = [
  [new Panel(-120, 6, 0.24, 1.2, 0.12), 2.6],
  [new Panel(118, 6, 0.28, 1.2, 0.12), 3.4],
  [new Panel(10, 78, 0.75, 0.26, 0.08), 5],
  [new Panel(0, -60, 1.1, 0.4, 0.25), 0.9],
];

const at: [number, number] = [0, 0];

export const studio: Radiance = (x, y, z) => {
  let light = 0.008 + 0.03 * smooth(0.5, 1, -z - 0.25 * y) + 0.75 * smooth(0.3, 1, 0.5 + 0.5 * z) * (0.65 + 0.35 * y);
  let share = WINDOW.meet(x, y, z, at);
  if (share > 0) {
    const panes = glass(at[0], 2, WINDOW.half_width) * glass(at[1], 3, WINDOW.half_height);
    light += share * panes * (7 + 2.5 * at[1]);
  }
  share = SOFT_BOX.meet(x, y, z, at);
  if (share > 0) light += share * (3.4 - 0.8 * at[0]);
  for (const [panel, radiance] of OTHERS) light += panel.meet(x, y, z, at) * radiance;
  return light;
};

export const overcast: Radiance = (_x, y) => (1 + 2 * Math.max(y, 0)) / 3;

export const uniform: Radiance = () => 1;

export function radianceOf(name: string): Radiance {
  return name === "studio" ? studio : name === "overcast" ? overcast : uniform;
}
