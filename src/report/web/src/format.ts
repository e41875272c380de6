/** Numbers as people read them. */

import type { Num } from "./types";

export const MISSING = "–";
const MINUS = "−";

function finish(text: string): string {
  return text.replace(/-/g, MINUS);
}

/** Fixed number of decimals. */
export function fixed(value: Num | undefined, decimals: number): string {
  if (value == null || !Number.isFinite(value)) return MISSING;
  const text = value.toFixed(decimals);
  return finish(Number(text) === 0 ? text.replace("-", "") : text);
}

/** `digits` significant digits; powers of ten outside 1e-3 .. 1e6. */
export function significant(value: Num | undefined, digits = 4): string {
  if (value == null || !Number.isFinite(value)) return MISSING;
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e-3 || size >= 1e6) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split("e") as [string, string];
    return finish(`${mantissa}e${Number(exponent)}`);
  }
  const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  return finish(value.toFixed(decimals));
}

/** A fraction as a signed percentage: plus is written. */
export function percent(fraction: Num | undefined, decimals = 1): string {
  if (fraction == null || !Number.isFinite(fraction)) return MISSING;
  const text = (100 * fraction).toFixed(decimals);
  const zero = Number(text) === 0;
  return `${fraction > 0 && !zero ? "+" : ""}${finish(zero ? text.replace("-", "") : text)} %`;
}

/** A frequency with its unit. */
export function hertz(value: Num | undefined): string {
  return value == null || !Number.isFinite(value) ? MISSING : `${significant(value, 4)} Hz`;
}

/** A probability: two decimals, never a rounded 0 or 1. */
export function probability(value: Num | undefined): string {
  if (value == null || !Number.isFinite(value)) return MISSING;
  if (value < 0.005) return "< 0.01";
  if (value < 1 && value > 0.995) return "> 0.99";
  return fixed(value, 2);
}

/** Text for a chart: plotly reads a few tags in labels, names from files must not be read as such. */
export function plain(text: string): string {
  return text.replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
}

/** At most `length` characters, cut in the middle. */
export function shorten(text: string, length: number): string {
  const letters = [...text];
  if (letters.length <= length) return text;
  const head = Math.ceil((length - 1) / 2);
  return letters.slice(0, head).join("") + "…" + letters.slice(letters.length - (length - 1 - head)).join("");
}

/** Bytes of a file name for a download. */
export function slug(text: string): string {
  return text.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-+|-+$/g, "").slice(0, 60) || "report";
}
