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

/** A unit with raised digits: `kg m2` is kg m². */
export function unit(text: string): string {
  return text.replace(/(?<=[A-Za-z])[234](?![\w.])/g, (d) => ({ 2: "²", 3: "³", 4: "⁴" })[Number(d)]!);
}

/** Powers of ten as they are written: 10^300 is 10³⁰⁰. */
export function powers(text: string): string {
  return text.replace(/\b10\^(-?\d+)/g, (_, n: string) => `10${[...n].map((c) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(c)]).join("")}`);
}

/** Names that a terminal has between backticks, between the quotes of a page. */
export function quoted(text: string): string {
  return text.replace(/`([^`]+)`/g, "“$1”");
}

/** A formula in words with minus signs in place of hyphens. */
export function minuses(text: string): string {
  return text.replace(/(^|[\s(;])-(?=[\d\s])/g, `$1${MINUS}`);
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

/** `Sym 1st Vertical Bending` as engineers write it, S1VB; `mode 4` as 4; null for a name of another form. */
export function shortMode(label: string): string | null {
  const plain = /^mode (\d+)$/.exec(label);
  if (plain) return plain[1]!;
  const found = /^(?:(sym|anti)[a-z]* )?(\d+)(?:st|nd|rd|th)((?: [a-z]+(?:-[a-z]+)*)+)$/i.exec(label);
  if (!found) return null;
  const initials = found[3]!.trim().split(" ").map((word) => word[0]!.toUpperCase()).join("");
  return `${found[1]?.[0]?.toUpperCase() ?? ""}${found[2]!}${initials}`;
}

/** Lines of at most `length` characters, broken after blanks and the signs that join the parts of a name. */
export function folded(text: string, length: number): string[] {
  const lines: string[] = [];
  for (const part of text.split(/(?<=[ @+_:/-]|\.(?=[A-Za-z]))/)) {
    const last = lines.length - 1;
    if (last >= 0 && (lines[last]! + part).trimEnd().length <= length) lines[last] += part;
    else lines.push(part);
  }
  return lines.map((line) => line.trim());
}

/** Bytes of a file name for a download. */
export function slug(text: string): string {
  return text.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-+|-+$/g, "").slice(0, 60) || "report";
}
