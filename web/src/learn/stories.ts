// Six stories: a state of the page, a question, an answer. Numbers in them are asked of the core when they are shown.

import type { Core } from "../core/core";

export interface Story {
  title: string;
  /** The fragment that shows it. */
  link: string;
  /** What to look at, and for. */
  look: string;
  question: string;
  answer: (core: Core) => string;
}

const SOAP = "air / soap ? / air";

/** Reflectance at one wavelength, in percent. */
function percent(core: Core, stack: string, nm: number, angle_deg = 0): string {
  return (100 * core.spectrum(stack, [nm], angle_deg)[0]).toPrecision(2);
}

/** The wavelength (nm) of visible light that a stack reflects most or least. */
export function extreme(core: Core, stack: string, angle_deg: number, most: boolean): number {
  const wavelengths = Float64Array.from({ length: 381 }, (_, i) => 390 + i);
  const values = core.spectrum(stack, wavelengths, angle_deg);
  let best = 0;
  for (let i = 1; i < values.length; i++) if (most ? values[i] > values[best] : values[i] < values[best]) best = i;
  return wavelengths[best];
}

export const STORIES: Story[] = [
  {
    title: "Why a bubble has colours, and a black film is black",
    link: "#v=1&scene=bubble&preset=late-preview&age_s=6&story=1",
    look: "An old dome: bands of colour sink, and black places open in the film where it is thinnest.",
    question: "Both faces of the film mirror light. Why does the thinnest film mirror almost none?",
    answer: (core) =>
      "The two reflections meet again, and what counts is the way that the second one is longer: 2 n t. " +
      "The reflection at the outer face is turned over by half a wave, the one at the inner face is not. " +
      `With no way between them they cancel for every colour: 12 nm of soap film reflect ${percent(core, "air / soap 12 / air", 550)} % ` +
      `of green light. At 103 nm the extra way makes up for the turn, and it is ${percent(core, "air / soap 103 / air", 550)} %.`,
  },
  {
    title: "Why these are not the colours of the rainbow",
    link: "#v=1&scene=film&thickness_nm=413&angle_deg=0&story=2",
    look: "The spectrum of the film, its swatch, and its path in the CIE diagram. Rainbow colours lie on the curved line around.",
    question: "At 413 nm the film is purple. There is no purple in the rainbow. Where does it come from?",
    answer: (core) =>
      `A film takes one band out of white light instead of picking one: at 413 nm it is ${extreme(core, "air / soap 413 / air", 0, false)} nm, ` +
      "green, that is missing. Red and blue remain, and the eye calls both together purple. So its path in the diagram winds " +
      "inside the curved line, and never reaches it.",
  },
  {
    title: "Why rings, and why they crowd",
    link: "#v=1&scene=rings&illuminant=lines%3A589.158*2%2C589.756&view_mm=8&story=3",
    look: "Sodium light: rings without colours. Compare the radii of the formula with those measured, below the picture.",
    question: "The first dark ring has a radius of 0.77 mm. Where is the fourth: at four times that? Why do the rings crowd outwards?",
    answer: () =>
      "The gap under a lens grows with the square of the distance, r^2 / 2R. Dark rings come at every half wave of gap, " +
      "so r = √(m λ R): radii go as 1, 1.41, 1.73, 2. With R = 1 m and sodium light: 0.768, 1.086, 1.330 and 1.535 mm, the fourth at twice the first. " +
      "From the first to the second it is 0.318 mm, from the ninth to the tenth 0.125 mm.",
  },
  {
    title: "What the angle does",
    link: "#v=1&scene=wafer&thickness_nm=300&edge_nm=300&angle_deg=60&story=4",
    look: "A wafer with the same oxide everywhere. Move the angle of view from 0 to 80 degrees.",
    question: "Seen from the side the way through the film is longer. Do colours then move towards red, or towards blue?",
    answer: (core) =>
      "Towards blue, as if the film were thinner. The way inside is longer, but so is the lead of the light that never went in; " +
      "what is left is 2 n t cos(theta), with theta the angle inside the film. " +
      `300 nm of oxide on silicon reflect most at ${extreme(core, "air / SiO2 300 / Si", 0, true)} nm from straight above, ` +
      `at ${extreme(core, "air / SiO2 300 / Si", 60, true)} nm from 60 degrees.`,
  },
  {
    title: "What lamps do",
    link: "#v=1&scene=film&thickness_nm=1000&angle_deg=0&illuminant=FL11&thickest_nm=3000&story=5",
    look: "A thick film. Change the lamp: daylight, a three-band tube, sodium.",
    question: "In daylight a film of 3000 nm has no colour. Why does it show bands under sodium light, and tints under a tube?",
    answer: () =>
      "A thick film has many bright and dark bands between violet and red. Under daylight the eye adds them all up to white. " +
      "Sodium light has one colour (two lines, 0.6 nm apart): with nothing to add up, bright and dark stay as far as the lines keep step. " +
      "A three-band tube lies between: three narrow bands, each with fringes of its own.",
  },
  {
    title: "From colour to thickness",
    link: "#v=1&scene=film&thickness_nm=260&angle_deg=0&story=6",
    look: "Newton's scale below: colours come back as the film thickens, a little different each time.",
    question: "You see magenta. How thick is the film? How could you know the order?",
    answer: (core) => {
      const swatch = (nm: number) => {
        const xyz = core.color(SOAP, [nm, 0], { layer: 0 });
        const lab = core.convert(xyz, "xyz", "lab");
        return `${nm} nm (L ${lab[0].toFixed(0)}, C ${Math.hypot(lab[1], lab[2]).toFixed(0)})`;
      };
      return (
        `Magenta comes near ${swatch(213)}, ${swatch(413)} and ${swatch(615)}: one colour alone does not tell. ` +
        "But the film is a landscape: count bands from black, where it is nothing, or look at how strong the colour is, or tilt it " +
        "and see how far the bands move. A spectrum tells it outright: `iridesce fit`."
      );
    },
  },
];
