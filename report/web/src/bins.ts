/** Numbers counted in equal bins. */

export const BINS = 24;

/** Shares of the samples in equal bins between two ends. */
export function histogram(values: ArrayLike<number>, low: number, high: number, bins = BINS): number[] {
  const out = new Array<number>(bins).fill(0);
  for (let i = 0; i < values.length; i++) out[bin(values[i]!, low, high, bins)]!++;
  return out.map((n) => n / Math.max(values.length, 1));
}

const bin = (v: number, low: number, high: number, bins: number): number => Math.min(bins - 1, Math.max(0, Math.floor((bins * (v - low)) / (high - low || 1))));

/** The same of two values, row after row of the second. */
export function density(a: ArrayLike<number>, b: ArrayLike<number>, ends: [number, number, number, number], bins = BINS): Float64Array {
  const out = new Float64Array(bins * bins);
  for (let i = 0; i < a.length; i++) out[bins * bin(b[i]!, ends[2], ends[3], bins) + bin(a[i]!, ends[0], ends[1], bins)]!++;
  return out;
}
