/** The error falling: how much each step explains, and whether data that the fit did not see agree. */

import { Chart, logTicks } from "../charts";
import { card, choice, h, num, soft, table } from "../dom";
import { fixed, folded, plain, shorten, significant } from "../format";
import { heat } from "../heat";
import type { Steps } from "../types";

/** A fall in percent, with as many digits as tell it from all. */
function share(part: number): string {
  const rest = 100 * (1 - part);
  return fixed(100 * part, rest >= 1 || rest <= 0 ? 0 : Math.min(3, Math.ceil(-Math.log10(rest))));
}

export function stepsSection(w: Steps): HTMLElement {
  let scale: "linear" | "log" = "log";
  const held = w.steps.some((s) => s.held_out != null);
  const chart = new Chart("Misfit after every step", (p, width) => {
    // Slanted labels take one line; level ones as many as the width of a bar asks for.
    const letters = Math.max(10, Math.floor((width - 90) / w.steps.length / 8.4));
    const names = w.steps.map((s, i) => width < 700 ? `${i + 1}. ${plain(shorten(s.name, 18))}`
      : folded(`${i + 1}. ${shorten(s.name, 3 * letters)}`, letters).map(plain).join("<br>"));
    const values = w.steps.map((s) => s.misfit);
    const fall = values.map((v, i) => (i === 0 ? 0 : Math.max(0, values[i - 1]! - v)));
    const log = scale === "log";
    const tops = w.steps.map((s, i) => Math.max(s.misfit, i && !log ? values[i - 1]! : 0, s.held_out ?? 0));
    // A number stands on its bar; where the mark of the held-out data would cover it, above the mark.
    const labels = w.steps.map((s, i) => {
      const bar = Math.max(s.misfit, i && !log ? values[i - 1]! : 0), mark = s.held_out ?? -Infinity, span = Math.max(...tops);
      if (log) return mark > 0.8 * bar && mark < 2.5 * bar ? mark * 1.12 : bar;
      return mark > bar - 0.03 * span && mark < bar + 0.12 * span ? mark + 0.03 * span : bar;
    });
    const data: Record<string, unknown>[] = [
      { type: "bar", name: "misfit", x: names, y: values, marker: { color: p.model }, hovertemplate: "%{x}: %{y:.4g}<extra>misfit</extra>" },
    ];
    if (!log) data.push({ type: "bar", name: "explained by the step", x: names, y: fall, base: values,
      marker: { color: p.dark ? "rgba(150,165,180,0.22)" : "rgba(90,110,130,0.13)", line: { color: p.soft, width: 1 } }, hovertemplate: "%{x}: −%{y:.4g}<extra></extra>" });
    data.push({ type: "scatter", mode: "text", x: names, y: labels, textposition: "top center", showlegend: false, hoverinfo: "skip", cliponaxis: false,
      text: values.map((v, i) => `<b>${significant(v, 3)}</b>${i && fall[i]! > 0 ? `${width < 700 ? "<br>" : "  "}−${share(fall[i]! / values[i - 1]!)} %` : ""}`) });
    if (held) data.push({ type: "scatter", mode: "lines+markers", name: "held-out data", x: names, y: w.steps.map((s) => s.held_out),
      line: { color: p.test, dash: "dot", width: 2 }, marker: { symbol: "diamond", size: 11, color: p.test, line: { width: 1.5, color: p.surface } }, hovertemplate: "%{x}: %{y:.4g}<extra>held out</extra>" });
    // The line itself is a shape: over the bars, from edge to edge.
    const floor = { color: p.good, dash: "dash", width: 2 };
    if (w.noise_floor != null) data.push({ type: "scatter", mode: "lines", name: `noise floor (${significant(w.noise_floor, 3)})`, x: [names[0]], y: [null],
      line: floor, hoverinfo: "skip" });
    return {
      data,
      layout: { barmode: "overlay", bargap: 0.35, yaxis: { title: { text: "misfit" }, type: scale, ...(log ? logTicks([...values, ...w.steps.map((s) => s.held_out), w.noise_floor]) : { range: [0, 1.17 * Math.max(...tops, 1e-12)], ...(Math.max(...tops) < 1e7 ? { exponentformat: "none", separatethousands: true } : {}) }) },
        shapes: w.noise_floor == null ? [] : [{ type: "line", xref: "paper", x0: 0, x1: 1, y0: w.noise_floor, y1: w.noise_floor, line: floor }],
        xaxis: { tickangle: width < 700 ? -35 : 0, showgrid: false } },
    };
  }, 440, "error-falling");
  chart.root.id = "waterfall-chart";
  const modal = w.mode_labels.length && w.steps.some((s) => s.per_mode.length);
  const largest = Math.max(...w.steps.flatMap((s) => s.per_mode.map((v) => v ?? 0)), 0);
  return h("div", { class: "stack" },
    card("The error falling", w.measure,
      h("div", { class: "toolbar" }, choice("Axis", [{ value: "log", text: "log" }, { value: "linear", text: "linear" }], scale, (v) => { scale = v; chart.refresh(); })),
      chart.root,
      table("Steps", [{ head: "Step" }, { head: "Misfit", numeric: true }, ...(held ? [{ head: "Held out", numeric: true }] : []), { head: "" }],
        w.steps.map((s, i) => [h("strong", {}, soft(s.name)), num(significant(s.misfit, 4), `steps.steps.${i}.misfit`),
          ...(held ? [num(significant(s.held_out, 4), `steps.steps.${i}.held_out`)] : []), soft(s.note)]), { id: "step-table" })),
    modal ? card("Per mode", "the same misfit, mode by mode",
      heat({ title: "Misfit per mode", row_axis: "step", column_axis: "mode", rows: w.steps.map((s) => s.name), columns: w.mode_labels,
        values: w.steps.map((s) => w.mode_labels.map((_, j) => s.per_mode[j] ?? null)) },
      { map: "cividis", low: 0, high: largest || 1, path: (i, j) => `steps.steps.${i}.per_mode.${j}`, digits: 3 })) : null,
    modal && w.steps.some((s) => s.held_out_per_mode?.length) ? card("Held out, per mode", "the error of every mode predicted from the others",
      heat({ title: "Held-out error per mode", row_axis: "step", column_axis: "mode", rows: w.steps.map((s) => s.name), columns: w.mode_labels,
        values: w.steps.map((s) => w.mode_labels.map((_, j) => s.held_out_per_mode?.[j] ?? null)) },
      { map: "cividis", low: 0, high: Math.max(...w.steps.flatMap((s) => (s.held_out_per_mode ?? []).map((v) => v ?? 0)), 0) || 1,
        path: (i, j) => `steps.steps.${i}.held_out_per_mode.${j}`, digits: 3 })) : null);
}
