/** Which mode of the model is which mode of the test, and how well they agree. */

import { Chart } from "../charts";
import { floats } from "../decode";
import { badge, card, choice, h, isDark, num, table, type Child } from "../dom";
import { fixed, percent, plain, probability, quoted, shorten, significant } from "../format";
import { heat } from "../heat";
import { colorBar } from "../legend";
import { makeViewer } from "../viewer";
import { painter } from "./structure";
import type { Comparison, LabelledMatrix, Modes, Pair, Structure } from "../types";

function verdict(pair: Pair): Child {
  if (pair.passes == null) return "–";
  return badge(pair.passes ? "good" : "bad", pair.passes ? "pass" : "fail");
}

function pairTable(c: Comparison, modes: Modes): HTMLElement {
  const before = c.pairs_before.length > 0;
  const find = (pair: Pair): number => c.pairs_before.findIndex((b) => b.test_mode != null ? b.test_mode === pair.test_mode : b.label === pair.label);
  const chance = c.pairs.some((p) => p.pass_probability != null), damping = c.pairs.some((p) => p.test_damping != null);
  const own = (p: Pair): number | null => (p.model_mode == null ? null : modes.model[p.model_mode]?.damping_ratio ?? null), ownDamping = c.pairs.some((p) => own(p) != null);
  return table("Paired modes", [
    { head: "Mode" }, { head: "Test Hz", numeric: true }, { head: "Model Hz", numeric: true },
    { head: "Error", numeric: true, title: "(model - test)/test: plus means that the model is too high" },
    { head: "MAC", numeric: true },
    ...(before ? [{ head: "Error before", numeric: true }, { head: "MAC before", numeric: true }] : []),
    ...(damping ? [{ head: "Test damping", numeric: true }] : []), ...(ownDamping ? [{ head: "Model damping", numeric: true }] : []),
    { head: "Criteria", title: c.criteria }, ...(chance ? [{ head: "P(pass)", numeric: true }] : []),
  ], c.pairs.map((p, i) => {
    const path = `comparison.pairs.${i}`, k = find(p), old = c.pairs_before[k];
    return [
      p.label, num(significant(p.test_hz, 4), `${path}.test_hz`), num(significant(p.model_hz, 4), `${path}.model_hz`),
      h("strong", {}, num(percent(p.error), `${path}.error`, 100)), num(fixed(p.mac, 3), `${path}.mac`),
      ...(before ? [old ? num(percent(old.error), `comparison.pairs_before.${k}.error`, 100) : "–",
        old ? num(fixed(old.mac, 3), `comparison.pairs_before.${k}.mac`) : "–"] : []),
      ...(damping ? [p.test_damping == null ? "–" : num(`${fixed(100 * p.test_damping, 2)} %`, `${path}.test_damping`, 100)] : []),
      ...(ownDamping ? [own(p) == null ? "–" : num(`${fixed(100 * own(p)!, 2)} %`, `modes.model.${p.model_mode}.damping_ratio`, 100)] : []),
      verdict(p), ...(chance ? [num(probability(p.pass_probability), `${path}.pass_probability`)] : []),
    ];
  }), { id: "pair-table" });
}

function unpaired(c: Comparison, modes: Modes): HTMLElement | null {
  const name = (m: { label: string; frequency_hz: number }): string => `${m.label} (${significant(m.frequency_hz, 4)} Hz)`;
  const test = c.unpaired_test.flatMap((i, k) => {
    const m = modes.test[i], why = c.unpaired_reasons?.[k];
    return m == null ? [] : [h("p", {}, h("strong", {}, "Test mode without a partner: "), name(m), why ? `: ${quoted(why)}` : "")];
  });
  const model = c.unpaired_model.map((i) => modes.model[i]).filter((m) => m != null);
  const others = model.length
    ? h("p", {}, h("strong", {}, "Model modes without a partner: "), model.map(name).join(", ")) : null;
  return test.length + model.length ? h("div", { class: "unpaired" }, ...test, others) : null;
}

function macCard(title: string, m: LabelledMatrix, path: string, pairs: Pair[]): HTMLElement {
  const framed = (i: number, j: number): boolean => pairs.some((p) => p.model_mode === i && p.test_mode === j);
  return h("figure", { class: "mac" }, h("figcaption", {}, title),
    heat(m, { map: "viridis", low: 0, high: 1, path: (i, j) => `${path}.values.${i}.${j}`, framed }));
}

/** Likeness of shapes with each other: a large value off the diagonal says that the sensors cannot tell two modes apart. */
function autoMac(title: string, axis: string, list: { label: string; frequency_hz: number; at_sensors?: string; at_sensors_imag?: string }[]): LabelledMatrix | null {
  const shapes = list.filter((m) => m.at_sensors).map((m) => ({ m, re: floats(m.at_sensors), im: m.at_sensors_imag ? floats(m.at_sensors_imag) : null }));
  if (shapes.length < 2) return null;
  type Complex = (typeof shapes)[number];
  const product = (a: Complex, b: Complex): number => {
    let re = 0, im = 0, na = 0, nb = 0;
    for (let k = 0; k < a.re.length; k++) {
      const ar = a.re[k]!, ai = a.im?.[k] ?? 0, br = b.re[k]!, bi = b.im?.[k] ?? 0;
      if (!Number.isFinite(ar + ai + br + bi)) continue;
      re += ar * br + ai * bi;
      im += ar * bi - ai * br;
      na += ar * ar + ai * ai;
      nb += br * br + bi * bi;
    }
    return na > 0 && nb > 0 ? Math.min(1, (re * re + im * im) / na / nb) : 0;
  };
  const names = shapes.map(({ m }) => `${m.label} ${fixed(m.frequency_hz, 2).replace("−", "-")}`);
  return { title, row_axis: axis, column_axis: axis, rows: names, columns: names, values: shapes.map((a) => shapes.map((b) => product(a, b))) };
}

export function autoMacCard(modes: Modes, rows: number): HTMLElement | null {
  const all = [autoMac("autoMAC of the test", "test", modes.test), autoMac("autoMAC of the model", "model", modes.model.slice(0, Math.max(rows, 2)))].filter((m) => m != null);
  return all.length ? card("autoMAC", "shapes of one side with each other at the sensors: what is large off the diagonal, these sensors cannot tell apart",
    h("div", { class: macColumns(all) }, all.map((m) => h("figure", { class: "mac" }, h("figcaption", {}, m.title), heat(m, { map: "viridis", low: 0, high: 1 }))))) : null;
}

/** Moduli: the sign of an entry off the diagonal is that of two arbitrary scales. */
function orthogonalityCard(c: Comparison): HTMLElement | null {
  const all = ([["cross_orthogonality", c.cross_orthogonality], ["auto_orthogonality", c.auto_orthogonality]] as const).flatMap(([key, m]) => (m ? [{ key, m }] : []));
  return all.length ? card("Orthogonality", `shapes at the sensors in the mass of the model: 1 on the diagonal, and customarily below 0.1 beside it. ${c.orthogonality_note ?? ""}`,
    h("div", { class: macColumns(all.map((x) => x.m)) }, all.map(({ key, m }) => h("figure", { class: "mac" }, h("figcaption", {}, m.title),
      heat(m, { map: "diverging", low: -1, high: 1, path: (i, j) => `comparison.${key}.values.${i}.${j}` })))), colorBar("diverging", "−1", "+1", "orthogonality", undefined, "0")) : null;
}

/** Side by side while they have room. */
const macColumns = (all: LabelledMatrix[]): string => (all.length > 1 && all.every((m) => m.columns.length <= 8) ? "columns" : "stack");

function frequencyChart(c: Comparison): HTMLElement {
  const band = c.frequency_band || 0.05;
  const chart = new Chart("Frequency of the model against frequency of the test", (p) => {
    const all = [...c.pairs, ...c.pairs_before].flatMap((x) => [x.test_hz, x.model_hz]).filter(Number.isFinite);
    const high = Math.max(...all, 1) * 1.06;
    const points = (list: Pair[], name: string, color: string, symbol: string) => ({
      type: "scatter", mode: "markers", name, x: list.map((x) => x.test_hz), y: list.map((x) => x.model_hz),
      text: list.map((x) => `${plain(x.label)}<br>test ${significant(x.test_hz)} Hz, model ${significant(x.model_hz)} Hz<br>error ${percent(x.error)}`),
      hoverinfo: "text", marker: { color, symbol, size: 11, line: { width: 2, color } },
    });
    return {
      data: [
        { type: "scatter", mode: "lines", name: `±${fixed(100 * band, 0)} %`, x: [0, high, high, 0], y: [0, high * (1 + band), high * (1 - band), 0],
          fill: "toself", fillcolor: p.dark ? "rgba(140,160,180,0.22)" : "rgba(90,110,130,0.16)", line: { width: 0 }, hoverinfo: "skip" },
        { type: "scatter", mode: "lines", x: [0, high], y: [0, high], line: { color: p.soft, width: 1 }, hoverinfo: "skip", showlegend: false },
        ...(c.pairs_before.length ? [points(c.pairs_before, "before", p.before, "circle-open")] : []),
        points(c.pairs, c.pairs_before.length ? "after" : "model", p.model, "diamond"),
      ],
      layout: {
        xaxis: { title: { text: "test, Hz" }, range: [0, high] }, yaxis: { title: { text: "model, Hz" }, range: [0, high], scaleanchor: null },
        hovermode: "closest",
      },
    };
  }, 400, "frequency-frequency");
  chart.root.id = "frequency-chart";
  return chart.root;
}

function errorChart(c: Comparison): HTMLElement {
  const chart = new Chart("Frequency error of every pair", (p) => {
    const rows = c.pairs.map((_, i) => i);
    const names = c.pairs.map((x) => plain(shorten(x.label, 28)));
    const bars = (list: Pair[], name: string, color: string) => ({
      type: "bar", orientation: "h", name, y: rows,
      x: c.pairs.map((x) => { const o = list.find((b) => (b.test_mode != null ? b.test_mode === x.test_mode : b.label === x.label)); return o ? 100 * o.error : null; }),
      marker: { color }, text: names, textposition: "none", hovertemplate: "%{text}: %{x:.2f} %<extra></extra>",
    });
    const band = 100 * (c.frequency_band || 0.05);
    return {
      data: [...(c.pairs_before.length ? [bars(c.pairs_before, "before", p.before)] : []), bars(c.pairs, c.pairs_before.length ? "after" : "model", p.model)],
      layout: {
        barmode: "group", bargap: 0.3, xaxis: { title: { text: "(model − test)/test, %" }, zeroline: true, zerolinecolor: p.soft },
        yaxis: { autorange: "reversed", tickvals: rows, ticktext: names, zeroline: false }, legend: { traceorder: "normal" },
        shapes: [{ type: "rect", x0: -band, x1: band, y0: 0, y1: 1, yref: "paper", fillcolor: p.dark ? "rgba(140,160,180,0.22)" : "rgba(90,110,130,0.16)", line: { width: 0 }, layer: "below" }],
      },
    };
  }, Math.max(400, 60 + 30 * c.pairs.length), "frequency-errors");
  return chart.root;
}

function comac(c: Comparison, s: Structure): HTMLElement | null {
  if (!c.comac) return null;
  const after = floats(c.comac), before = c.comac_before ? floats(c.comac_before) : null;
  const viewer = makeViewer(s, { label: "COMAC on the structure", pickable: true,
    describe: (hit) => hit.kind === "sensor" ? `${s.sensors[hit.index]!.name}: COMAC ${fixed(values[hit.index], 3)}` : "" });
  for (const layer of ["nodes", "masses"] as const) viewer.show(layer, false);
  let values = after;
  const list = h("ol", { class: "worst" });
  const comacBar = h("div", {});
  const apply = (): void => {
    comacBar.replaceChildren(colorBar("viridis", "0", "1", "COMAC", { dark: isDark() }));
    viewer.paint({ sensors: painter(values, { low: 0, high: 1, map: "viridis", at: (v) => v }) });
    const order = Array.from(values, (value, i) => ({ value, i })).filter((x) => Number.isFinite(x.value)).sort((a, b) => a.value - b.value).slice(0, 6);
    list.replaceChildren(...order.map(({ value, i }) => h("li", {}, h("button", { type: "button", class: "link",
      onclick: () => viewer.highlight({ text: "", on_mesh: "", nodes: [], elements: [], sensors: [i] }) }, s.sensors[i]?.name ?? String(i)), ` ${fixed(value, 3)}`)));
  };
  apply();
  document.addEventListener("retheme", apply);
  return card("COMAC on the structure", "agreement of each sensor over all pairs; a low value points at a place or a channel",
    h("div", { class: "split tight" }, h("div", { class: "stage-small" }, viewer.root),
      h("div", {}, before ? choice("Which model", [{ value: "after", text: "after" }, { value: "before", text: "before" }], "after", (v) => {
        values = v === "after" ? after : before;
        apply();
      }) : null, comacBar, h("h4", { class: "list-title" }, "Lowest"), list)));
}

export function pairsSection(c: Comparison, modes: Modes, s: Structure | undefined): HTMLElement {
  const macs = [
    c.mac_before ? macCard("before", c.mac_before, "comparison.mac_before", c.pairs_before) : null,
    c.mac ? macCard(c.mac_before ? "after" : c.mac.title || "MAC", c.mac, "comparison.mac", c.pairs) : null,
  ].filter((m) => m != null);
  return h("div", { class: "stack" },
    card("Paired modes", c.criteria ? `error = (model − test)/test; criteria: ${c.criteria}` : "error = (model − test)/test", pairTable(c, modes), unpaired(c, modes)),
    macs.length ? card("MAC", "1: the shapes are parallel at the sensors, 0: nothing in common; pairs are framed",
      h("div", { class: macColumns([c.mac_before, c.mac].filter((m) => m != null)) }, macs), colorBar("viridis", "0", "1", "MAC")) : null,
    autoMacCard(modes, c.mac?.rows.length ?? 12),
    orthogonalityCard(c),
    c.pairs.length ? h("div", { class: "columns" },
      card("Frequency against frequency", null, frequencyChart(c)), card("Frequency error", null, errorChart(c))) : null,
    s ? comac(c, s) : null);
}
