// A colour in words, for those who do not see it (or do not trust their screen): hue by the angle in LCh(ab), and how
// light and strong it is. Boundaries between hue names after the centres of the basic colour terms in CIELAB.

import { TEXT } from "./strings";

/** Where a hue begins, in degrees of h(ab), and its name. */
const HUES: [number, string][] = [
  [0, "pink"], [15, "red"], [48, "orange"], [70, "yellow"], [108, "yellowish green"], [125, "green"],
  [172, "bluish green"], [205, "greenish blue"], [235, "blue"], [288, "violet"], [318, "purple"], [345, "pink"],
];

/** Lab (of the light's own white) in words. */
export function colorName(l: number, a: number, b: number): string {
  const chroma = Math.hypot(a, b);
  const hue = ((Math.atan2(b, a) * 180) / Math.PI + 360) % 360;
  const words = TEXT.colors;
  let name = "";
  for (const [from, word] of HUES) if (hue >= from) name = word;
  if (name === "orange" && l < 50) name = "brown";
  if (name === "yellow" && l < 45) name = "olive";
  if (name === "pink" && l < 45) name = "purplish red";
  if (l < 4) return words.black;
  if (chroma < 5) return l > 92 ? words.white : l > 70 ? words.light_grey : l > 35 ? words.grey : words.dark_grey;
  if (chroma < 13) return `${l > 75 ? words.pale : l < 25 ? words.very_dark : words.greyish} ${name}`;
  if (l < 25) return `${words.dark} ${name}`;
  if (chroma < 36) return `${l > 80 ? words.pale : words.dull} ${name}`;
  return chroma > 60 ? `${words.vivid} ${name}` : l > 82 ? `${words.light} ${name}` : name;
}

/** The order of a film's colour on Newton's scale: 2 n t cos(theta in the film) in steps of 550 nm. */
export function orderOf(path_nm: number): string {
  const order = Math.floor(path_nm / 550) + 1;
  return TEXT.order(order);
}
