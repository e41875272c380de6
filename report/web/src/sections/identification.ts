/** How modes came out of functions: the stabilisation diagram over the indicator function, with poles to click. */

import { Chart, logTicks, type Palette } from "../charts";
import { floats } from "../decode";
import { card, choice, h, num, table, toggle, type Child } from "../dom";
import { fixed, plain, significant } from "../format";
import { autoMacCard } from "./pairs";
import type { Diagram, Identification, Modes } from "../types";

/** A pole that was clicked. */
interface Picked { diagram: number; pole: number }

const MARKS = [
  { name: "new", symbol: "x-thin-open", size: 6 }, { name: "stable frequency", symbol: "circle-open", size: 6 },
  { name: "and damping", symbol: "diamond-open", size: 8 }, { name: "and participation", symbol: "diamond", size: 9 },
] as const;

const colors = (p: Palette): string[] => [p.soft, p.before, p.test, p.model];

/** The poles of a column, by order. */
export function column(d: Diagram, pole: number): number[] {
  const own = d.column[pole];
  return d.column.flatMap((c, i) => (c === own ? [i] : [])).sort((a, b) => d.order[a]! - d.order[b]!);
}

export function identificationSection(x: Identification, modes: Modes): HTMLElement {
  const lines = Array.from(floats(x.frequency_hz)), values = x.cmif.map((c) => Array.from(floats(c)));
  const hz = x.diagrams.map((d) => floats(d.hz)), damping = x.diagrams.map((d) => floats(d.damping));
  let remainder = false, stable = false, picked: Picked | null = null;
  const isShown = (d: number, i: number): boolean => (remainder || !x.diagrams[d]!.name.endsWith("remainder")) && (!stable || x.diagrams[d]!.mark[i]! > 0);
  /** Trace and point of the chart as diagram and pole. */
  let drawn: Picked[][] = [];
  const chart = new Chart("Stabilisation diagram over the complex mode indicator function", (p) => {
    drawn = MARKS.map(() => []);
    x.diagrams.forEach((d, k) => d.mark.forEach((m, i) => { if (isShown(k, i)) drawn[m]!.push({ diagram: k, pole: i }); }));
    const poles = drawn.map((list, m) => ({
      type: "scatter", mode: "markers", name: MARKS[m]!.name, x: list.map((q) => hz[q.diagram]![q.pole]), y: list.map((q) => x.diagrams[q.diagram]!.order[q.pole]),
      marker: { symbol: MARKS[m]!.symbol, size: MARKS[m]!.size, color: colors(p)[m], line: { width: 1.4, color: colors(p)[m] } },
      text: list.map((q) => `${fixed(100 * damping[q.diagram]![q.pole]!, 3)} %`), hovertemplate: "%{x:.4f} Hz, %{text}, order %{y}<extra>" + MARKS[m]!.name + "</extra>",
    }));
    const curves = values.map((y, k) => ({ type: "scatter", mode: "lines", name: `CMIF ${k + 1}`, x: lines, y, yaxis: "y2", line: { color: k ? p.soft : p.ink, width: k ? 1 : 1.5 }, opacity: 0.6, hoverinfo: "skip" }));
    const own = picked && x.diagrams[picked.diagram] ? column(x.diagrams[picked.diagram]!, picked.pole).map((i) => ({ x: hz[picked!.diagram]![i], y: x.diagrams[picked!.diagram]!.order[i] })) : [];
    return {
      data: [...poles, ...curves, { type: "scatter", mode: "lines", name: "chosen", showlegend: false, hoverinfo: "skip", x: own.map((q) => q.x), y: own.map((q) => q.y), line: { color: p.accent, width: 9 }, opacity: 0.35 }],
      layout: {
        margin: { l: 56, r: 70 }, hovermode: "closest", xaxis: { title: { text: "frequency, Hz" } }, yaxis: { title: { text: "order of the polynomial" }, rangemode: "tozero", zeroline: false },
        yaxis2: { title: { text: plain(`CMIF, ${x.unit}`) }, type: "log", overlaying: "y", side: "right", showgrid: false, ...logTicks(values.flatMap((v) => [Math.max(...v), Math.min(...v.filter((a) => a > 0))])) },
        shapes: x.modes.map((m) => ({ type: "line", x0: m.hz, x1: m.hz, y0: 0, y1: 1, yref: "paper", line: { color: p.good, width: 1, dash: "dot" } })),
      },
    };
  }, 460, "stabilisation-diagram");
  chart.root.id = "stabilisation-chart";
  const detail = h("div", { id: "pole-detail", "aria-live": "polite" }, h("p", { class: "note" }, "Click a pole to see it at every order. Dotted lines: the modes."));
  const show = (q: Picked): void => {
    picked = q;
    const d = x.diagrams[q.diagram]!, all = column(d, q.pole), f = hz[q.diagram]!, z = damping[q.diagram]!;
    const near = d.discarded.find((r) => Math.abs(r.hz / f[q.pole]! - 1) < 0.01);
    const fate = d.chosen.includes(d.column[q.pole]!) ? (near ? `taken for a candidate, and rejected: ${near.reason}` : "its column was taken for a mode") : "its column was not taken for a mode";
    detail.replaceChildren(h("h4", {}, `${fixed(f[q.pole], 4)} Hz, ${fixed(100 * z[q.pole]!, 3)} % at order ${d.order[q.pole]}`), h("p", { class: "note" }, `${d.name}: ${fate}.`),
      table("The pole at every order", [{ head: "Order", numeric: true }, { head: "Hz", numeric: true }, { head: "Damping", numeric: true }, { head: "Stable in" }],
        all.map((i): Child[] => [num(String(d.order[i]), `identification.diagrams.${q.diagram}.order.${i}`), h("span", { class: "num" }, fixed(f[i], 4)), h("span", { class: "num" }, `${fixed(100 * z[i]!, 3)} %`),
          ["–", "frequency", "frequency, damping", "frequency, damping, participation"][d.mark[i]!]!]), { id: "pole-table" }));
    chart.refresh();
  };
  let listening = false;
  new MutationObserver(() => {
    const plot = chart.root as unknown as { on?: (event: string, heard: (e: { points: { curveNumber: number; pointNumber: number }[] }) => void) => void };
    if (listening || !plot.on) return;
    listening = true;
    plot.on("plotly_click", (e) => {
      const at = e.points[0], q = at && drawn[at.curveNumber]?.[at.pointNumber];
      if (q) show(q);
    });
  }).observe(chart.root, { attributes: true, attributeFilter: ["data-ready"] });

  // The same without a pointer: the pole of each mode at the highest order that has it.
  const nearest = (f: number): Picked | null => {
    let best: Picked | null = null, least = 0.01;
    x.diagrams.forEach((d, k) => d.hz && hz[k]!.forEach((v, i) => {
      const off = Math.abs(v / f - 1) + 1e-6 * (1000 - d.order[i]!);
      if (d.mark[i]! > 1 && off < least) [best, least] = [{ diagram: k, pole: i }, off];
    }));
    return best;
  };
  const rows = x.modes.map((m, i): Child[] => {
    const q = nearest(m.hz), path = `identification.modes.${i}`;
    const name = num(fixed(m.hz, 4), `${path}.hz`);
    return [String(i + 1), q ? h("button", { type: "button", class: "link", onclick: () => show(q) }, name) : name, num(significant(m.hz_sd, 2), `${path}.hz_sd`),
      m.damping == null ? "–" : num(`${fixed(100 * m.damping, 3)} %`, `${path}.damping`, 100), m.damping_sd == null ? "–" : num(`${fixed(100 * m.damping_sd, 3)} %`, `${path}.damping_sd`, 100),
      m.mpc == null ? "–" : num(fixed(m.mpc, 3), `${path}.mpc`), num(String(m.orders), `${path}.orders`), m.remark];
  });
  const rejected = x.diagrams.flatMap((d) => d.discarded);
  const hasRemainder = x.diagrams.some((d) => d.name.endsWith("remainder") && d.hz.length > 0);
  return h("div", { class: "stack" },
    card("Stabilisation diagram", "poles of polynomials of rising order, over the complex mode indicator function: a physical pole comes back at every order",
      h("div", { class: "toolbar" }, hasRemainder ? toggle("Poles of what the first modes leave", false, (on) => { remainder = on; chart.refresh(); }) : null,
        choice("Which poles", [{ value: "all", text: "all poles" }, { value: "stable", text: "stable ones" }], "all", (v) => { stable = v === "stable"; chart.refresh(); })),
      chart.root, detail),
    card("Modes", `${x.method}; MPC is the modal phase collinearity: 1 is a real shape`,
      table("Modes", [{ head: "#", numeric: true }, { head: "Hz", numeric: true }, { head: "± sd", numeric: true }, { head: "Damping", numeric: true }, { head: "± sd", numeric: true },
        { head: "MPC", numeric: true }, { head: "Orders", numeric: true, title: "orders at which its pole came back" }, { head: "" }], rows, { id: "identified-table" })),
    rejected.length ? card("Candidates that are not modes", null, table("Candidates that are not modes", [{ head: "Hz", numeric: true }, { head: "Damping", numeric: true }, { head: "Why" }],
      rejected.map((r): Child[] => [h("span", { class: "num" }, fixed(r.hz, 3)), h("span", { class: "num" }, `${fixed(100 * r.damping, 2)} %`), r.reason]))) : null,
    autoMacCard({ model: [], test: modes.test }, 0));
}
