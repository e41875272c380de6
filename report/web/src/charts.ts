/** Plotly in the page's colours: drawn when first seen, drawn again when the theme or the size changes. */

import Plotly, { type Layout, type Trace } from "plotly.js-basic-dist-min";
import { h } from "./dom";

export interface Palette {
  ink: string; soft: string; grid: string; test: string; model: string; before: string; accent: string; good: string; bad: string;
  surface: string; dark: boolean;
}
export interface Figure { data: Trace[]; layout: Layout }
export type Draw = (palette: Palette, width: number) => Figure;

export function palette(): Palette {
  const style = getComputedStyle(document.documentElement);
  const of = (name: string): string => style.getPropertyValue(name).trim();
  return {
    ink: of("--ink"), soft: of("--soft"), grid: of("--grid"), test: of("--test"), model: of("--model"),
    before: of("--before"), accent: of("--accent"), good: of("--good"), bad: of("--bad"), surface: of("--surface"),
    dark: of("--scheme") === "dark",
  };
}

function merge(base: Layout, over: Layout): Layout {
  const out: Layout = { ...base };
  for (const [key, value] of Object.entries(over)) {
    const old = out[key];
    out[key] = old && value && typeof old === "object" && typeof value === "object" && !Array.isArray(value)
      ? merge(old as Layout, value as Layout) : value;
  }
  return out;
}

function axis(p: Palette): Layout {
  return {
    gridcolor: p.grid, zerolinecolor: p.grid, linecolor: p.soft, tickcolor: p.soft, ticks: "outside", ticklen: 4,
    automargin: true, title: { font: { size: 13, color: p.soft }, standoff: 8 }, exponentformat: "power",
  };
}

/** Axes that a figure of one or more panels needs. */
function base(p: Palette): Layout {
  return {
    font: { family: "system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif", size: 13, color: p.ink },
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", margin: { l: 56, r: 18, t: 14, b: 46 },
    hoverlabel: { bgcolor: p.surface, bordercolor: p.grid, font: { color: p.ink, size: 13 } },
    legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom", font: { size: 13 }, bgcolor: "rgba(0,0,0,0)" },
    xaxis: axis(p), yaxis: axis(p),
  };
}

/** What stands at a tick of a logarithmic axis: a plain number where it is short, else a power of ten. */
export function tickText(value: number): string {
  const exponent = Math.round(Math.log10(value));
  const isPower = Math.abs(Math.log10(value) - exponent) < 1e-9;
  if (value >= 1e-3 && value < 1e5) {
    const text = String(Number(value.toPrecision(1)));
    return value >= 1e4 ? text.replace(/(\d)(?=(\d{3})+$)/g, "$1\u2009") : text;
  }
  return isPower ? `10<sup>${String(exponent).replace("-", "−")}</sup>` : "";
}

/** Ticks of a logarithmic axis with their numbers: 1, 2, 5 over few decades, powers of ten beyond; at least two of them in sight. */
export function logTicks(values: Iterable<number | null | undefined>): { tickmode: "array"; tickvals: number[]; ticktext: string[] } {
  let low = Infinity, high = 0;
  for (const v of values) {
    if (v != null && v > 0) [low, high] = [Math.min(low, v), Math.max(high, v)];
  }
  if (!(high > 0)) return { tickmode: "array", tickvals: [], ticktext: [] };
  const decades = Math.log10(high / low);
  const parts = decades > 2.2 ? [1] : [1, 2, 5], every = Math.max(1, Math.ceil(decades / 8));
  const tickvals: number[] = [];
  for (let e = Math.floor(Math.log10(low)) - 2; e <= Math.ceil(Math.log10(high)) + 2; e++) {
    if (e % every === 0) for (const part of parts) tickvals.push(Number(`${part}e${e}`));
  }
  return { tickmode: "array", tickvals, ticktext: tickvals.map(tickText) };
}

export class Chart {
  readonly root: HTMLElement;
  private seen = false;
  private width = 0;

  constructor(label: string, private readonly draw: Draw, private height: number, private readonly file: string) {
    this.root = h("div", { class: "chart", role: "img", "aria-label": label, style: `height:${height}px` });
    new ResizeObserver(() => {
      const width = this.root.clientWidth;
      if (width > 0 && (!this.seen || Math.abs(width - this.width) > 1)) this.redraw();
    }).observe(this.root);
    charts.push(this);
  }

  setHeight(height: number): void {
    this.height = height;
    this.root.style.height = `${height}px`;
  }

  redraw(width = this.root.clientWidth): void {
    if (width === 0) return;
    this.seen = true;
    this.width = width;
    const p = palette();
    const { data, layout } = this.draw(p, width);
    const whole = merge(base(p), layout);
    for (const key of ["xaxis2", "yaxis2", "yaxis3"]) {
      if (layout[key]) whole[key] = merge(axis(p), layout[key] as Layout);
    }
    void Plotly.react(this.root, data, { ...whole, width, height: this.height }, {
      displaylogo: false, displayModeBar: width > 500 ? "hover" : false, responsive: false,
      modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d", "toggleSpikelines"],
      toImageButtonOptions: { format: "svg", filename: this.file },
    }).then(() => (this.root.dataset["ready"] = "true"));
  }

  /** Draws again with what has changed, if it has been seen before. */
  refresh(): void {
    if (this.seen) this.redraw();
  }
}

export const charts: Chart[] = [];
