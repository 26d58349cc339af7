// What can be taken away: the picture, its numbers, the link.

import type { Core } from "../core/core";
import { SPECTRUM_NM, inSteps } from "../core/wavelengths";
import type { Page } from "../page";
import { filled, writeLink } from "../state/keys";
import { TEXT } from "../text/strings";

function save(name: string, blob: Blob): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

export function savePicture(page: Page): void {
  page.stage?.draw();
  page.stage?.picture?.canvas.toBlob((blob) => blob && save(`iridesce-${page.state.scene}.png`, blob), "image/png");
}

export function saveCsv(page: Page): void {
  save(`iridesce-${page.state.scene}.csv`, new Blob([csv(page)], { type: "text/csv" }));
}

export function copyLink(page: Page): void {
  navigator.clipboard?.writeText(location.href.split("#")[0] + writeLink(page.state)).then(
    () => page.tell(TEXT.copied),
    () => {},
  );
}

/** What the scene shows, as numbers: text of the file. */
export function csv(page: Page): string {
  const { state } = page;
  const head = `# iridesce ${state.scene} ${writeLink(state)}\n`;
  switch (state.scene) {
    case "bubble":
    case "slick":
      return head + fieldRows(page);
    case "rings":
      return head + ringRows(page, page.core as Core);
    default:
      return head + spectrumRows(page, page.core as Core);
  }
}

function fieldRows(page: Page): string {
  const field = page.stage?.picture?.field;
  if (!field) return "";
  const rows = Array.from({ length: field.rows }, (_, i) =>
    Array.from(field.thickness_nm.subarray(i * field.columns, (i + 1) * field.columns), (nm) => nm.toFixed(2)).join(","),
  );
  return `# thickness_nm, row 0 on top\n${rows.join("\n")}\n`;
}

function ringRows({ state, layer }: Page, core: Core): string {
  const view = Number(state["view_mm"]);
  const radii = Array.from({ length: 401 }, (_, i) => (view * i) / 800);
  const gaps = core.call("thickness_lens_gap", "", [Number(state["radius_mm"]), Number(state["thickness_nm"]), ...radii]).result;
  const points = Float64Array.from([...gaps].flatMap((nm) => [nm, 0]));
  const xyz = core.color(String(state["stack"]), points, { layer, illuminant: String(state["illuminant"]) });
  return `radius_mm,gap_nm,X,Y,Z\n${radii.map((r, i) => [r, gaps[i], ...xyz.subarray(3 * i, 3 * i + 3)].join(",")).join("\n")}\n`;
}

function spectrumRows({ state }: Page, core: Core): string {
  const wavelengths = inSteps(SPECTRUM_NM, 1);
  const angle = Number(state["angle_deg"]);
  const now = filled(String(state["stack"]), Number(state["thickness_nm"]));
  const values = core.spectrum(now, wavelengths, angle);
  return `# ${now} at ${angle} degrees\nwavelength_nm,reflectance\n${Array.from(wavelengths, (nm, i) => `${nm},${values[i]}`).join("\n")}\n`;
}
