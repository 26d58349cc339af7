// Charts as SVG, with a text twin in their title and a table of their numbers under them.

import { html, svg, type TemplateResult } from "lit";
import { TEXT } from "../text/strings";

export interface Curve {
  name: string;
  /** Class of its line: told apart by dashes too. */
  kind: "first" | "second";
  values: ArrayLike<number>;
}

const BOX = { width: 360, height: 190, left: 42, right: 8, top: 10, bottom: 30 };

function nice(most: number): number {
  const power = 10 ** Math.floor(Math.log10(Math.max(most, 1e-4)));
  return [1, 2, 2.5, 5, 10].map((m) => m * power).find((m) => m >= most) ?? most;
}

/** Reflectance over wavelength. */
export function spectrumChart(title: string, wavelengths: ArrayLike<number>, curves: Curve[]): TemplateResult {
  const [from, to] = [wavelengths[0], wavelengths[wavelengths.length - 1]];
  let most = 0;
  for (const curve of curves) for (let i = 0; i < curve.values.length; i++) most = Math.max(most, curve.values[i]);
  const top = nice(most);
  const x = (nm: number) => BOX.left + ((nm - from) / (to - from)) * (BOX.width - BOX.left - BOX.right);
  const y = (r: number) => BOX.height - BOX.bottom - (r / top) * (BOX.height - BOX.top - BOX.bottom);
  const path = (values: ArrayLike<number>) =>
    Array.from(values, (r, i) => `${i ? "L" : "M"}${x(wavelengths[i]).toFixed(1)} ${y(r).toFixed(1)}`).join("");
  const ticks = [400, 500, 600, 700, 800].filter((nm) => nm >= from && nm <= to);
  const marks = [0, 0.25, 0.5, 0.75, 1].map((share) => share * top);
  return html`<figure class="chart">
    <svg viewBox="0 0 ${BOX.width} ${BOX.height}" role="img" aria-label=${title}>
      <defs>
        <linearGradient id="rainbow">
          ${RAINBOW.map(([nm, color]) => svg`<stop offset=${(nm - from) / (to - from)} stop-color=${color}></stop>`)}
        </linearGradient>
      </defs>
      <rect x=${BOX.left} y=${BOX.height - BOX.bottom} width=${BOX.width - BOX.left - BOX.right} height="5" fill="url(#rainbow)"></rect>
      ${marks.map(
        (r) => svg`<line class="grid" x1=${BOX.left} x2=${BOX.width - BOX.right} y1=${y(r)} y2=${y(r)}></line>
          <text x=${BOX.left - 5} y=${y(r) + 4} text-anchor="end">${String(Number((100 * r).toPrecision(3)))}%</text>`,
      )}
      ${ticks.map((nm) => svg`<text x=${x(nm)} y=${BOX.height - 8} text-anchor="middle">${nm} nm</text>`)}
      ${curves.map((curve) => svg`<path class="curve ${curve.kind}" d=${path(curve.values)}></path>`)}
    </svg>
    ${curves.length > 1
      ? html`<figcaption>${curves.map((curve) => html`<span class="key ${curve.kind}">${curve.name}</span>`)}</figcaption>`
      : ""}
    <details>
      <summary>${TEXT.table_under}</summary>
      <table>
        <caption>${title}</caption>
        <thead><tr><th scope="col">nm</th>${curves.map((curve) => html`<th scope="col">${curve.name}</th>`)}</tr></thead>
        <tbody>
          ${Array.from(wavelengths)
            .map((nm, i) => [nm, i] as const)
            .filter(([nm]) => Math.abs(nm % 20) < 1e-9)
            .map(([nm, i]) => html`<tr><th scope="row">${nm}</th>${curves.map((curve) => html`<td>${curve.values[i].toFixed(4)}</td>`)}</tr>`)}
        </tbody>
      </table>
    </details>
  </figure>`;
}

/** For the eye only: roughly where which colour is. */
const RAINBOW: [number, string][] = [
  [390, "#2a0052"], [430, "#3300cc"], [470, "#0066ff"], [500, "#00b386"], [530, "#1fb800"], [570, "#c8c800"], [600, "#ff8000"],
  [640, "#e60000"], [700, "#8c0000"], [770, "#2e0000"],
];

/** The path of a colour in the CIE 1931 diagram. `path`: x, y pairs; `marks`: a label at each. */
export function diagram(
  title: string, locus: Float64Array, path: Float64Array, marks: { x: number; y: number; label: string }[], here: [number, number] | null,
): TemplateResult {
  const size = 260;
  const x = (v: number) => 20 + (v / 0.8) * (size - 30);
  const y = (v: number) => size - 20 - (v / 0.9) * (size - 30);
  const line = (points: Float64Array) => {
    let d = "";
    for (let i = 0; i < points.length; i += 2) d += `${i ? "L" : "M"}${x(points[i]).toFixed(1)} ${y(points[i + 1]).toFixed(1)}`;
    return d;
  };
  return html`<figure class="chart square">
    <svg viewBox="0 0 ${size} ${size}" role="img" aria-label=${title}>
      ${[0, 0.2, 0.4, 0.6, 0.8].map(
        (v) => svg`<line class="grid" x1=${x(v)} x2=${x(v)} y1=${y(0)} y2=${y(0.9)}></line>
          <line class="grid" x1=${x(0)} x2=${x(0.8)} y1=${y(v)} y2=${y(v)}></line>
          <text x=${x(v)} y=${size - 6} text-anchor="middle">${v || "0"}</text>
          ${v ? svg`<text x="2" y=${y(v) + 4}>${v}</text>` : ""}`,
      )}
      <path class="locus" d="${line(locus)}Z"></path>
      <path class="curve first" d=${line(path)}></path>
      ${marks.map((m) => {
        // Labels stand outside the loops: away from white.
        const [dx, dy] = [x(m.x) - x(1 / 3), y(m.y) - y(1 / 3)];
        const away = 13 / Math.max(Math.hypot(dx, dy), 1);
        return svg`<circle class="mark" cx=${x(m.x)} cy=${y(m.y)} r="2.2"></circle><text class="small" text-anchor="middle" x=${x(m.x) + away * dx} y=${y(m.y) + away * dy + 4}>${m.label}</text>`;
      })}
      ${here ? svg`<circle class="here" cx=${x(here[0])} cy=${y(here[1])} r="5"></circle>` : ""}
    </svg>
  </figure>`;
}
