/** Matrices as coloured tables: values to read, colours to see; a picture when they are too large for text. */

import { css, ink, parseHex, sample, themed, type MapName } from "./color";
import { csvButton, h, isDark, num } from "./dom";
import { fixed, shorten, shortMode, significant } from "./format";
import type { LabelledMatrix, Num } from "./types";

export interface HeatOptions {
  map: MapName; low: number; high: number;
  /** Where the cell's number stands in the data; without it the page has computed the number. */
  path?: (row: number, column: number) => string;
  decimals?: number; digits?: number;
  /** Cells to frame, such as the pairs. */
  framed?: (row: number, column: number) => boolean;
  /** What a blank cell means. */
  blank?: string;
}

const LARGEST_TABLE = 40;

function position(value: Num, o: HeatOptions): number {
  return value == null || !Number.isFinite(value) || o.high === o.low ? NaN : (value - o.low) / (o.high - o.low);
}

/** One matrix. */
export function heat(m: LabelledMatrix, o: HeatOptions): HTMLElement {
  return m.rows.length > LARGEST_TABLE || m.columns.length > LARGEST_TABLE ? picture(m, o) : cells(m, o);
}

/** `Sym 1st Bending 5.67` in two lines: S1B, 5.67; null where a label has no such form. */
function stacked(label: string): [string, string] | null {
  const found = /^(.+) (\d+(?:\.\d+)?)$/.exec(label);
  const short = found ? shortMode(found[1]!) : null;
  return found && short ? [short, found[2]!] : null;
}

function cells(m: LabelledMatrix, o: HeatOptions): HTMLElement {
  const size = Math.max(m.columns.length, m.rows.length), dense = size > 12, tiny = size > 20;
  // A name may carry its own remark: `m1: held by a bound`.
  const own = (name: string): string => (m.row_axis === "parameter" ? name.split(": ")[0]! : name);
  const heads = m.columns.map((c) => stacked(c) ?? (shortMode(c) ? [shortMode(c)!] : null));
  const short = heads.every((x) => x != null);
  // Many columns leave no room for long names of rows where short ones stand above the columns.
  const compact = short && m.columns.length > 6;
  const tall = !short && (dense || m.columns.some((c) => own(c).length > 12));
  const show = (v: Num): string => {
    const text = o.digits ? significant(v, o.digits) : fixed(v, o.decimals ?? 2);
    return tiny && !o.digits ? text.replace(/^(−?)0\./, "$1.") : text;
  };
  const painted: { cell: HTMLElement; value: Num }[] = [];
  const head = (c: string, j: number): HTMLElement => h("th", { scope: "col", title: c, "data-csv": c },
    short ? heads[j]!.map((part, k) => h("span", { class: k ? "hz" : "mode" }, part)) : h("span", {}, shorten(own(c), tall ? 24 : 14)));
  const row = (name: string, i: number): HTMLElement => {
    const brief = stacked(name);
    return h("tr", {},
      h("th", { scope: "row", title: name, "data-csv": name }, brief && compact ? brief.join(" ") : brief ? [h("span", { class: "long" }, shorten(name, 26)), h("span", { class: "short", "aria-hidden": "true" }, brief.join(" "))] : shorten(own(name), 26)),
      m.columns.map((column, j) => {
        const value = m.values[i]?.[j] ?? null;
        if (value == null || !Number.isFinite(value)) return h("td", { class: "blank", title: `${name} × ${column}: ${o.blank ?? "not known"}` });
        const cell = h("td", { class: o.framed?.(i, j) ? "framed" : null, title: `${name} × ${column}: ${show(value)}`, "data-csv": String(value) }, o.path ? num(show(value), o.path(i, j)) : h("span", { class: "num" }, show(value)));
        painted.push({ cell, value });
        return cell;
      }));
  };
  const table = h("table", { class: `heat${dense ? " dense" : ""}${tiny ? " tiny" : ""}${tall ? " tall" : ""}` },
    h("caption", {}, h("span", {}, `rows: ${m.row_axis}`), h("span", {}, `columns: ${m.column_axis}`)),
    h("thead", {}, h("tr", {}, h("td", {}), m.columns.map(head))),
    h("tbody", {}, m.rows.map(row)));
  const paint = (): void => {
    const map = themed(o.map, isDark());
    for (const { cell, value } of painted) {
      const rgb = sample(map, position(value, o));
      cell.style.background = css(rgb);
      cell.style.color = ink(rgb);
    }
  };
  paint();
  if (o.map === "diverging") document.addEventListener("retheme", paint);
  return h("div", { class: "tabled" }, csvButton(m.title, () => table),
    h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": m.title }, table));
}

/** One pixel a cell, scaled up, with the value under the pointer written below. */
function picture(m: LabelledMatrix, o: HeatOptions): HTMLElement {
  const canvas = h("canvas", { width: m.columns.length, height: m.rows.length, class: "heat-picture", role: "img", "aria-label": m.title });
  const context = canvas.getContext("2d")!;
  const paint = (): void => {
    const image = context.createImageData(m.columns.length, m.rows.length), map = themed(o.map, isDark());
    m.rows.forEach((_, i) => m.columns.forEach((_, j) => {
      const value = m.values[i]?.[j] ?? null;
      const rgb = value == null ? parseHex("#888888") : sample(map, position(value, o));
      image.data.set([...rgb, 255], 4 * (i * m.columns.length + j));
    }));
    context.putImageData(image, 0, 0);
  };
  paint();
  if (o.map === "diverging") document.addEventListener("retheme", paint);
  const readout = h("p", { class: "note", role: "status" }, `${m.rows.length} × ${m.columns.length}: point at a cell to read it`);
  canvas.addEventListener("pointermove", (e) => {
    const box = canvas.getBoundingClientRect();
    const j = Math.floor(((e.clientX - box.left) / box.width) * m.columns.length);
    const i = Math.floor(((e.clientY - box.top) / box.height) * m.rows.length);
    const row = m.rows[i], column = m.columns[j];
    if (row != null && column != null) readout.textContent = `${row} × ${column}: ${fixed(m.values[i]?.[j], o.decimals ?? 2)}`;
  });
  const ends = (axis: string, names: string[]): HTMLElement =>
    h("span", {}, `${axis}: ${names[0] ?? ""} … ${names.at(-1) ?? ""}`);
  return h("div", {}, canvas, h("p", { class: "note picture-ends" }, ends(`across, ${m.column_axis}`, m.columns), ends(`down, ${m.row_axis}`, m.rows)), readout);
}
