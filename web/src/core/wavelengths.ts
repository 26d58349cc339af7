// The ranges of wavelengths of the core and of Python (python/iridesce/optics/wavelengths.py): a test there compares them.

/** What colour sums run over, and where the table of the observer begins and ends, nm. */
export const VISIBLE_NM = [360, 830] as const;

/** A spectrum where nobody names a range, nm. */
export const SPECTRUM_NM = [380, 780] as const;

/** Wavelengths from the first of a range to its last. */
export function inSteps([first, last]: readonly [number, number], step: number): Float64Array {
  return Float64Array.from({ length: (last - first) / step + 1 }, (_, i) => first + step * i);
}
