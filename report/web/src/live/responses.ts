/** A frequency response of the model as it is set now, beside that of the report and the measured one. */

import { Chart, logTicks } from "../charts";
import { floats, polar, type Polar } from "../decode";
import { h } from "../dom";
import { plain } from "../format";
import type { Frfs, Live, Sensor } from "../types";
import { initial, point } from "./state";
import type { Question } from "./questions";
import type { Curve, Line } from "./response";

const ORDERS: Record<string, number> = { receptance: 0, mobility: 1, accelerance: 2 };
const LINES = 500;

interface Choice { name: string; line: Line; measured: Polar | null }

/** Lines from half of the lowest to 1.3 times the highest frequency of the test. */
function ownLines(live: Live): Float64Array {
  const all = live.test.map((t) => t.frequency_hz), low = 0.5 * Math.min(...all), high = 1.3 * Math.max(...all);
  return Float64Array.from({ length: LINES }, (_, i) => low + ((high - low) * i) / (LINES - 1));
}

export class Responses {
  readonly root: HTMLElement;
  private readonly chart: Chart;
  private readonly choices: (() => Choice)[];
  private readonly names: string[];
  private readonly known = new Map<number, Choice>();
  private current = 0;
  private now: Curve | undefined;
  private base: Curve | undefined;
  private isOpen = false;
  private readonly reported;

  constructor(live: Live, sensors: Sensor[], set: Frfs | undefined, changed: () => void) {
    this.reported = point(live, initial(live));
    const measured = (set?.channels ?? []).flatMap((c) => (c.sensor != null && c.exciter != null && c.sign != null ? [{ c, response: c.sensor, reference: c.exciter, sign: c.sign }] : []));
    const quantity = measured.length ? set!.quantity : "accelerance", unit = measured.length ? set!.unit : "(m/s²)/N", order = ORDERS[quantity] ?? 2;
    if (measured.length) {
      const hz = Float64Array.from(floats(set!.frequency_hz));
      this.names = measured.map(({ c }) => `${c.response} / ${c.reference}`);
      this.choices = measured.map(({ c, response, reference, sign }) => () => ({ name: c.response, line: { response, reference, sign, order, hz }, measured: c.measured ? polar(c.measured) : null }));
    } else {
      // Without measured functions, the driving point of each sensor.
      const hz = live.test.length ? ownLines(live) : new Float64Array(0);
      const own = sensors.flatMap((s, i) => (s.is_rotation ? [] : [{ s, i }]));
      this.names = own.map(({ s }) => `${s.name} / ${s.name}`);
      this.choices = own.map(({ s, i }) => () => ({ name: s.name, line: { response: i, reference: i, sign: 1, order, hz }, measured: null }));
    }
    this.chart = new Chart("Frequency response now", (p) => {
      const { line, measured } = this.choice()!, x = Array.from(line.hz);
      const one = (y: ArrayLike<number> | undefined, name: string, color: string, dash: string, width: number) =>
        (y ? [{ type: "scatter", mode: "lines", name, x, y: Array.from(y), line: { color, dash, width }, hovertemplate: "%{x:.3f} Hz: %{y:.4g}<extra>" + name + "</extra>" }] : []);
      const ends = [measured?.amplitude, this.base?.amplitude, this.now?.amplitude].flatMap((y) => (y ? [y.reduce((a, b) => (b > 0 && b < a ? b : a), Infinity), y.reduce((a, b) => (b > a ? b : a), 0)] : []));
      return { data: [...one(this.base?.amplitude, "as reported", p.before, "dot", 1.6), ...one(measured?.amplitude, set?.origin === "synthetic" ? "test (synthetic)" : "test", p.test, "solid", 2.2), ...one(this.now?.amplitude, "now", p.model, "dash", 2)],
        layout: { margin: { l: 72 }, xaxis: { title: { text: "frequency, Hz" } }, yaxis: { title: { text: plain(`|${quantity}|, ${unit}`) }, type: "log", ...logTicks(ends.filter(Number.isFinite)) } } };
    }, 300, "response-now");
    this.chart.root.id = "live-response";
    const select = h("select", { id: "live-channel", "aria-label": "Response and reference", onchange: () => { this.current = Number(select.value); changed(); } },
      this.names.map((n, i) => h("option", { value: i }, n)));
    const details = h("details", { class: "card", id: "live-responses", ontoggle: () => { this.isOpen = details.open; if (details.open) changed(); } },
      h("summary", {}, "Frequency response"),
      h("p", { class: "note" }, `Sum of all modes of the page's model, with the measured damping of paired modes and ${(100 * live.damping).toFixed(2)} % for all others.`),
      h("div", { class: "toolbar" }, h("label", { class: "field" }, "Response / reference ", select)), this.chart.root);
    this.root = this.names.length && (measured.length || live.test.length) ? details : h("span", { hidden: true });
  }

  private choice(): Choice | null {
    const make = this.choices[this.current];
    if (!make) return null;
    if (!this.known.has(this.current)) this.known.set(this.current, make());
    return this.known.get(this.current)!;
  }

  /** What is to be asked, while the card is open. */
  question(): Pick<Question, "line" | "base"> {
    const choice = this.isOpen ? this.choice() : null;
    return choice ? { line: choice.line, base: this.reported } : {};
  }

  show(now: Curve | undefined, base: Curve | undefined): void {
    if (!now) return;
    [this.now, this.base] = [now, base ?? this.base];
    this.chart.redraw();
  }
}
