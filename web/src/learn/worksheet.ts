// A printable sheet: six exercises with numbers drawn anew, and their answers by the core.

import type { Core } from "../core/core";
import { colorName, orderOf } from "../text/color-names";
import { extreme } from "./stories";

export interface Exercise {
  question: string;
  answer: string;
}

/** SplitMix64 on 32 bits: the same sheet for the same number. */
function draws(seed: number): () => number {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x9e3779b9) >>> 0;
    let z = state;
    z = Math.imul(z ^ (z >>> 16), 0x85ebca6b);
    z = Math.imul(z ^ (z >>> 13), 0xc2b2ae35);
    return ((z ^ (z >>> 16)) >>> 0) / 2 ** 32;
  };
}

export function nameOf(core: Core, stack: string, angle_deg: number): string {
  const lab = core.convert(core.color(stack, [0, angle_deg]), "xyz", "lab");
  return colorName(lab[0], lab[1], lab[2]);
}

export function worksheet(core: Core, seed: number): Exercise[] {
  const draw = draws(seed);
  const pick = (from: number, to: number, step: number) => from + step * Math.floor(draw() * ((to - from) / step + 1));
  const n = 1.333;
  const bright = pick(480, 640, 10);
  const thick = pick(220, 600, 10);
  const tilted = pick(30, 70, 5);
  const ring = pick(2, 9, 1);
  const radius = pick(500, 2000, 100);
  const volts = pick(20, 100, 5);
  const oxide = 5 + 2.4 * volts;
  const soap = `air / soap ${thick} / air`;
  const inside = Math.cos(Math.asin(Math.sin((tilted * Math.PI) / 180) / n));
  return [
    {
      question: `How thick is the thinnest soap film (n = ${n}) that reflects light of ${bright} nm most strongly, seen straight on?`,
      answer: `2 n t = lambda / 2 (the half wave lost at one face must be made up): t = lambda / 4n = ${(bright / 4 / n).toFixed(1)} nm. ` +
        `The core gives a reflectance of ${(100 * core.spectrum(`air / soap ${bright / 4 / n} / air`, [bright], 0)[0]).toFixed(2)} % there.`,
    },
    {
      question: `A soap film is ${thick} nm thick. Which order of Newton's scale is it, and what colour has it in daylight, seen straight on?`,
      answer: `2 n t = ${(2 * n * thick).toFixed(0)} nm; orders end at 550, 1100, 1650 nm: ${orderOf(2 * n * thick)}, ${nameOf(core, soap, 0)}.`,
    },
    {
      question: `The same film of ${thick} nm is seen at ${tilted} degrees. What is 2 n t cos(theta) now, and which colour of visible light does it reflect most?`,
      answer: `cos(theta in the film) = ${inside.toFixed(4)}, path ${(2 * n * thick * inside).toFixed(0)} nm; the reflectance is greatest at ` +
        `${extreme(core, soap, tilted, true)} nm (straight on at ${extreme(core, soap, 0, true)} nm). It looks ${nameOf(core, soap, tilted)}.`,
    },
    {
      question: `A lens of ${radius} mm radius lies on a flat glass under sodium light (589.36 nm on the mean). What is the radius of dark ring number ${ring}?`,
      answer: `r = sqrt(m lambda R) = ${Math.sqrt(ring * 589.36e-6 * radius).toFixed(3)} mm.`,
    },
    {
      question: `Titanium is anodised at ${volts} V; its oxide is 5 nm + 2.4 nm a volt. How thick is it, and what colour has the piece seen straight on?`,
      answer: `${oxide.toFixed(0)} nm; ${nameOf(core, `air / TiO2 ${oxide} / Ti`, 0)}.`,
    },
    {
      question: "Why is the thinnest part of a soap film black, and that of the oxide on titanium not?",
      answer: "In a soap film one of the two reflections is turned over and the other is not (air to soap, soap to air): without a way between them they cancel. " +
        `Metal reflects strongly and with a phase of its own: bare titanium reflects ${(100 * core.spectrum("air / Ti", [550], 0)[0]).toFixed(0)} % of green light, ` +
        `12 nm of soap film ${(100 * core.spectrum("air / soap 12 / air", [550], 0)[0]).toFixed(2)} %.`,
    },
  ];
}
