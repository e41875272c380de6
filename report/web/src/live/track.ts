/** Where the modes go on the straight line between two states: which mode of the model is which mode of the test, and where that changes. */

import { Chart } from "../charts";
import { categories, parseHex } from "../color";
import { card, isDark } from "../dom";
import { fixed, plain, shorten } from "../format";
import type { Live } from "../types";
import type { Partners } from "./questions";

export class Track {
  readonly root: HTMLElement;
  private readonly chart: Chart;
  private points: (Partners | null)[] = [];

  constructor(private readonly live: Live, private readonly from: string) {
    this.chart = new Chart("Frequencies of the partners of the test modes on the way", (_, width) => {
      const x = this.points.map((_, i) => i / Math.max(1, this.points.length - 1)), palette = categories(isDark());
      const lines = live.test.map((t, j) => {
        const name = plain(shorten(t.label || `mode ${j + 1}`, 24)), color = palette[j % palette.length]!;
        // Beside the line of the test a partner that nothing supports is pale.
        const alpha = (q: Partners | null): string => { const [r, g, b] = parseHex(color); return `rgba(${r},${g},${b},${q && q.mac[j]! > 0 ? Math.max(0.25, q.mac[j]!).toFixed(2) : 0.25})`; };
        return [
          { type: "scatter", mode: "lines+markers", name, legendgroup: name, x, y: this.points.map((q) => (q && q.partner[j]! >= 0 ? q.hz[j]! : null)), line: { color, width: 2 },
            marker: { size: 7, color: this.points.map(alpha) }, text: this.points.map((q) => (q && q.partner[j]! >= 0 ? `mode ${q.partner[j]! + 1} of the model, MAC ${fixed(q.mac[j], 3)}` : "")),
            hovertemplate: "%{y:.3f} Hz: %{text}<extra>" + name + "</extra>" },
          { type: "scatter", mode: "lines", legendgroup: name, showlegend: false, x: [0, 1], y: [t.frequency_hz, t.frequency_hz], line: { color, width: 1, dash: "dot" }, hovertemplate: "test %{y:.3f} Hz<extra>" + name + "</extra>" },
        ];
      }).flat();
      return { data: lines, layout: { hovermode: "closest", showlegend: width > 500, legend: { orientation: "v", x: 1.02, y: 1, xanchor: "left", yanchor: "top" }, margin: { t: 10 },
        xaxis: { tickvals: [0, 0.25, 0.5, 0.75, 1], ticktext: [this.from, "", "half way", "", "now"], fixedrange: true }, yaxis: { title: { text: "frequency, Hz" }, fixedrange: true } } };
    }, 320, "modes-on-the-way");
    this.chart.root.id = "live-track";
    this.root = card("Modes on the way", `the partner of each test mode as all values go in step from ${from === "first version" ? "the first version" : "the report"} to now; pale: low MAC; dotted: the test`, this.chart.root);
    this.root.hidden = true;
  }

  show(points: (Partners | null)[]): void {
    this.points = points;
    this.root.hidden = points.length === 0 || this.live.test.length === 0;
    this.chart.refresh();
  }
}
