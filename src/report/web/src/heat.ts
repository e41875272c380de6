/** Matrices as coloured tables: values to read, colours to see; a picture when they are too large for text. */

import { css, ink, parseHex, sample, type MapName } from "./color";
import { h, num } from "./dom";
import { fixed, MISSING, shorten, significant } from "./format";
import type { LabelledMatrix, Num } from "./types";

export interface HeatOptions {
  map: MapName; low: number; high: number;
  /** Where the cell's number stands in the data. */
  path: (row: number, column: number) => string;
  decimals?: number; digits?: number;
  /** Cells to frame, such as the pairs. */
  framed?: (row: number, column: number) => boolean;
}

const LARGEST_TABLE = 40;

function position(value: Num, o: HeatOptions): number {
  return value == null || !Number.isFinite(value) || o.high === o.low ? NaN : (value - o.low) / (o.high - o.low);
}

/** One matrix. */
export function heat(m: LabelledMatrix, o: HeatOptions): HTMLElement {
  return m.rows.length > LARGEST_TABLE || m.columns.length > LARGEST_TABLE ? picture(m, o) : cells(m, o);
}

function cells(m: LabelledMatrix, o: HeatOptions): HTMLElement {
  const dense = Math.max(m.columns.length, m.rows.length) > 12;
  const tall = dense || m.columns.some((c) => c.length > 12);
  const show = (v: Num): string => (o.digits ? significant(v, o.digits) : fixed(v, o.decimals ?? 2));
  return h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": m.title },
    h("table", { class: `heat${dense ? " dense" : ""}${tall ? " tall" : ""}` },
      h("caption", {}, h("span", {}, `rows: ${m.row_axis}`), h("span", {}, `columns: ${m.column_axis}`)),
      h("thead", {}, h("tr", {}, h("td", {}),
        m.columns.map((c) => h("th", { scope: "col", title: c }, h("span", {}, shorten(c, tall ? 24 : 14)))))),
      h("tbody", {}, m.rows.map((name, i) => h("tr", {},
        h("th", { scope: "row", title: name }, shorten(name, 26)),
        m.columns.map((column, j) => {
          const value = m.values[i]?.[j] ?? null;
          const rgb = sample(o.map, position(value, o));
          const empty = value == null;
          return h("td", {
            style: empty ? null : `background:${css(rgb)};color:${ink(rgb)}`,
            class: o.framed?.(i, j) ? "framed" : null, title: `${name} × ${column}: ${show(value)}`,
          }, empty ? MISSING : num(show(value), o.path(i, j)));
        }))))));
}

/** One pixel a cell, scaled up, with the value under the pointer written below. */
function picture(m: LabelledMatrix, o: HeatOptions): HTMLElement {
  const canvas = h("canvas", { width: m.columns.length, height: m.rows.length, class: "heat-picture", role: "img", "aria-label": m.title });
  const context = canvas.getContext("2d")!;
  const image = context.createImageData(m.columns.length, m.rows.length);
  m.rows.forEach((_, i) => m.columns.forEach((_, j) => {
    const value = m.values[i]?.[j] ?? null;
    const rgb = value == null ? parseHex("#888888") : sample(o.map, position(value, o));
    image.data.set([...rgb, 255], 4 * (i * m.columns.length + j));
  }));
  context.putImageData(image, 0, 0);
  const readout = h("p", { class: "note", role: "status" }, `${m.rows.length} × ${m.columns.length}: point at a cell to read it`);
  canvas.addEventListener("pointermove", (e) => {
    const box = canvas.getBoundingClientRect();
    const j = Math.floor(((e.clientX - box.left) / box.width) * m.columns.length);
    const i = Math.floor(((e.clientY - box.top) / box.height) * m.rows.length);
    const row = m.rows[i], column = m.columns[j];
    if (row != null && column != null) readout.textContent = `${row} × ${column}: ${fixed(m.values[i]?.[j], o.decimals ?? 2)}`;
  });
  return h("div", {}, canvas, readout);
}
