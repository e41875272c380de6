/** What the model says now beside the test: each mode, and how the error has come down. */

import { Chart, logTicks } from "../charts";
import { h, soft } from "../dom";
import { fixed, percent, plain, shorten, significant } from "../format";
import type { Live } from "../types";
import type { Prediction } from "./model";

/** A mode whose frequency the coordinates miss by more than this in some place of the sliders is shown grey. */
export const PROMISED = 1e-3;

/** Largest relative error of the frequency of an elastic mode, with these hypotheses on. */
export function promised(live: Live, on: boolean[], mode: number): number {
  const all = [live.accuracy, ...live.hypotheses.filter((_, i) => on[i]).map((x) => x.accuracy)];
  return Math.max(...all.map((a) => a.frequency[mode] ?? 1));
}

/** The modes of the test with their partners now: a row is a button that shows its shape. */
export function table(live: Live, before: Prediction, now: Prediction, on: boolean[], chosen: number, choose: (test: number) => void): HTMLElement {
  const m = live.test.length;
  const chi = (p: Prediction, j: number): number => p.ofFrequency[j]! + p.ofShape[j]!;
  const largest = Math.max(1, ...live.test.map((_, j) => Math.max(chi(before, j), chi(now, j))));
  // Roots show what is small beside what is large.
  const width = (v: number): string => `width:${(100 * Math.sqrt(v / largest)).toFixed(1)}%`;
  const rows = live.test.map((t, j) => {
    const i = now.partner[j]!, was = before.partner[j]!, isAside = t.plan === "aside";
    const hz = i < 0 ? null : now.hz[i]!, error = hz == null ? null : hz / t.frequency_hz - 1;
    const error0 = was < 0 ? null : before.hz[was]! / t.frequency_hz - 1;
    const mac = i < 0 || !t.shape ? null : now.mac[i * m + j]!;
    const off = i < 0 ? 0 : promised(live, on, i);
    return h("tr", { class: off > PROMISED ? "unsure" : null, "aria-current": String(j === chosen), "data-test": j,
      title: off > PROMISED ? `this page computes this frequency to ${significant(100 * off, 2)} % at best: not to be relied on` : null },
      h("td", {}, h("button", { type: "button", class: "link", onclick: () => choose(j) }, soft(t.label || `mode ${j + 1}`))),
      h("td", { class: "right" }, fixed(t.frequency_hz, 3)),
      h("td", { class: "right strong", "data-now": hz == null ? "" : String(hz) }, hz == null ? (isAside ? "left aside" : "no partner") : fixed(hz, 3)),
      h("td", { class: "right nowrap", title: `as reported ${percent(error0)}` }, percent(error)),
      h("td", { class: "right", "data-mac": mac == null ? "" : String(mac) }, fixed(mac, 3)),
      h("td", { class: "right", "data-chi": String(chi(now, j)) }, significant(chi(now, j), 3)),
      h("td", { class: "bars", title: `χ² as reported ${significant(chi(before, j), 3)}` },
        h("span", { class: "bar was", style: width(chi(before, j)) }), h("span", { class: "bar is", style: width(chi(now, j)) })));
  });
  const head = (text: string, right = true, title?: string): HTMLElement => h("th", { scope: "col", class: right ? "right" : null, title: title ?? null }, text);
  return h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Modes now" }, h("table", { id: "live-table" },
    h("thead", {}, h("tr", {}, head("Mode", false), head("test, Hz"), head("now, Hz"), head("error"), head("MAC"), head("χ²", true, "frequency and shape, each over its standard deviation"),
      h("th", { scope: "col", class: "bars-head", "aria-label": "χ² as reported and now" }))),
    h("tbody", {}, rows)));
}

/** χ² after each change, from the report to now. */
export class Waterfall {
  readonly chart: Chart;
  private names: string[] = [];
  private values: (number | null)[] = [];

  constructor(private readonly floor: number) {
    this.chart = new Chart("Error after each change", (p, width) => {
      const few = Math.max(6, Math.floor((width - 80) / Math.max(this.names.length, 1) / 8));
      const x = this.names.map((n, i) => `${i ? `${i}. ` : ""}${plain(shorten(n, Math.max(8, few)))}`);
      const last = this.values.length - 1;
      return {
        data: [
          { type: "bar", x, y: this.values, marker: { color: this.values.map((_, i) => (i === 0 ? p.before : i === last ? p.model : p.soft)) }, text: this.values.map((v) => significant(v, 3)),
            textposition: "outside", cliponaxis: false, hovertemplate: "%{x}: χ² %{y:.4g}<extra></extra>" },
        ],
        layout: { showlegend: false, bargap: this.names.length < 3 ? 0.7 : 0.35, margin: { l: 56, r: 62, t: 22, b: 46 }, xaxis: { tickangle: this.names.length > 4 && width < 700 ? -35 : 0, showgrid: false, fixedrange: true },
          yaxis: { title: { text: "χ²" }, type: "log", fixedrange: true, ...logTicks([...this.values, this.floor]), ...range([...this.values, this.floor]) },
          shapes: [{ type: "line", xref: "paper", x0: 0, x1: 1, y0: this.floor, y1: this.floor, line: { color: p.good, dash: "dash", width: 2 } }],
          annotations: [{ xref: "paper", x: 1, xanchor: "left", y: Math.log10(Math.max(this.floor, 1e-12)), yanchor: "middle", showarrow: false, align: "left", text: ` noise<br> ${significant(this.floor, 3)}`, font: { color: p.good, size: 12 } }] },
      };
    }, 230, "live-error");
    this.chart.root.id = "live-waterfall";
  }

  show(names: string[], values: (number | null)[]): void {
    this.names = names;
    this.values = values;
    this.chart.refresh();
  }
}

/** A range of a logarithmic axis with room for the numbers on the bars, from a decade of its own. */
function range(values: (number | null)[]): { range?: [number, number] } {
  const all = values.filter((v): v is number => v != null && v > 0);
  if (!all.length) return {};
  const low = Math.log10(Math.min(...all)), high = Math.log10(Math.max(...all)), span = Math.max(high - low, 0.5);
  return { range: [low - 0.35 * span, high + 0.2 * span] };
}
