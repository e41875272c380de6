/** The update: how the cost fell, where the parameters went, what the data cannot tell. */

import { Chart, logTicks } from "../charts";
import { badge, card, choice, h, num, s, soft, table, type Child } from "../dom";
import { fixed, minuses, plain, shorten, significant, unit } from "../format";
import { heat } from "../heat";
import { colorBar } from "../legend";
import type { MassProperty, Parameter, Update } from "../types";

/** Whether there is anything to show of an update. */
export function hasUpdate(u: Update): boolean {
  return u.histories.length + u.parameters.length + u.mass_properties.length + u.sensitivities.length > 0;
}

/** The name of the section: what it has. */
export function updateName(u: Update): string {
  return u.histories.length ? "Update" : u.parameters.length + u.sensitivities.length ? "Parameters" : "Mass";
}

/** Best cost of a run after so many evaluations. */
function costAt(run: Update["histories"][number], evaluations: number): number | null {
  let best: number | null = null;
  run.evaluations.forEach((e, i) => { if (e <= evaluations) best = run.best_cost[i] ?? best; });
  return best;
}

function costChart(u: Update): HTMLElement {
  let scale: "log" | "linear" = "log", across: "log" | "linear" = "linear";
  const last = Math.max(...u.histories.flatMap((run) => run.evaluations), 1);
  let at = last;
  const bestAt = (n: number): number | null => u.histories.map((run) => costAt(run, n)).filter((v): v is number => v != null).reduce<number | null>((a, b) => (a == null || b < a ? b : a), null);
  const first = Math.max(...u.histories.slice(0, 1).map((run) => run.best_cost[0] ?? 0)), end = bestAt(last);
  const readout = h("p", { class: "readout", id: "cost-readout", "aria-live": "polite" });
  const say = (): void => {
    const now = bestAt(at);
    const share = now == null || end == null || first <= end ? "" : `: ${fixed((100 * (first - now)) / (first - end), 1)} % of the whole fall`;
    readout.textContent = `after ${at} evaluations the best cost is ${significant(now, 5)}${share}`;
  };
  const slider = h("input", { type: "range", id: "cost-at", min: 0, max: 1000, value: 1000, "aria-label": "Evaluations", oninput: () => {
    const t = Number(slider.value) / 1000;
    at = Math.round(across === "log" ? Math.expm1(t * Math.log1p(last)) : t * last);
    say();
    chart.refresh();
  } });
  const chart = new Chart("Best cost against evaluations", (p) => {
    const colors = [p.model, p.test, p.accent, p.soft];
    const dashes = ["solid", "dash", "dot", "dashdot"];
    return {
      data: u.histories.map((run, i) => ({
        type: "scatter", mode: run.evaluations.length < 60 ? "lines+markers" : "lines", name: plain(shorten(run.name, 40)), x: run.evaluations, y: run.best_cost,
        line: { color: colors[i % 4], dash: dashes[Math.floor(i / 4) % 4], width: 2.4, shape: "hv" }, marker: { size: 5 },
        hovertemplate: "%{x} evaluations: %{y:.5g}<extra>" + plain(shorten(run.name, 40)) + "</extra>",
      })),
      layout: { xaxis: { title: { text: "evaluations of the model" }, type: across, ...(across === "linear" ? { rangemode: "tozero" } : logTicks(u.histories.flatMap((run) => run.evaluations))), exponentformat: "none", separatethousands: true },
        yaxis: { title: { text: "best cost" }, type: scale, ...(scale === "log" ? logTicks(u.histories.flatMap((run) => run.best_cost)) : {}) }, showlegend: u.histories.length > 1, hovermode: "closest",
        shapes: at < last ? [{ type: "line", x0: Math.max(at, 1), x1: Math.max(at, 1), y0: 0, y1: 1, yref: "paper", line: { color: p.accent, width: 1.5, dash: "dot" } }] : [] },
    };
  }, 340, "cost-history");
  chart.root.id = "cost-chart";
  say();
  return card("Cost", [u.objective, u.termination].filter(Boolean).join("; "),
    h("div", { class: "toolbar" }, choice("Cost axis", [{ value: "log", text: "log" }, { value: "linear", text: "linear" }], scale, (v) => { scale = v; chart.refresh(); }),
      choice("Evaluations axis", [{ value: "linear", text: "evaluations linear" }, { value: "log", text: "log" }], across, (v) => { across = v; chart.refresh(); })),
    chart.root, h("label", { class: "field slider wide" }, "Follow ", slider), readout);
}

function track(p: Parameter): SVGSVGElement | string {
  const { lower, upper } = p;
  if (lower == null || upper == null || upper <= lower) return "";
  const W = 220, H = 26, x = (v: number): number => 8 + (W - 16) * Math.min(1.02, Math.max(-0.02, (v - lower) / (upper - lower)));
  const value = p.after ?? p.before;
  return s("svg", { viewBox: `0 0 ${W} ${H}`, class: "track", role: "img",
    "aria-label": `${p.name} at ${fixed((100 * (value - lower)) / (upper - lower), 0)} % of its range` },
    s("line", { x1: 8, x2: W - 8, y1: 13, y2: 13, class: "rail" }),
    s("line", { x1: 8, x2: 8, y1: 7, y2: 19, class: "rail" }), s("line", { x1: W - 8, x2: W - 8, y1: 7, y2: 19, class: "rail" }),
    p.interval ? s("line", { x1: x(p.interval[0]), x2: x(p.interval[1]), y1: 13, y2: 13, class: "interval" }) : null,
    s("circle", { cx: x(p.before), cy: 13, r: 5, class: "was" }),
    p.after == null ? null : s("path", { d: `M${x(p.after)} 5 l6 8 l-6 8 l-6 -8 z`, class: p.at_bound ? "is bound" : "is" }));
}

function parameters(u: Update): HTMLElement {
  const interval = u.parameters.find((p) => p.interval)?.interval_label ?? "";
  const determined = u.parameters.some((p) => p.determined != null);
  const anyInterval = u.parameters.some((p) => p.interval), anyAfter = u.parameters.some((p) => p.after != null);
  return card("Parameters", anyAfter ? "circle: before; diamond: after; thick line: interval of the estimate; ends: bounds" : "circle: the value; ends: bounds",
    table("Parameters", [
      { head: "Parameter" }, { head: "Unit" }, { head: anyAfter ? "Before" : "Value", numeric: true }, ...(anyAfter ? [{ head: "After", numeric: true }] : []),
      { head: "Lower", numeric: true }, { head: "Within its bounds" }, { head: "Upper", numeric: true },
      ...(anyInterval ? [{ head: interval ? `${interval} interval` : "Interval", numeric: true }] : []),
      ...(determined ? [{ head: "Determined", numeric: true, title: "share of the prior variance that the data removed" }] : []), { head: "" },
    ], u.parameters.map((p, i): Child[] => {
      const path = `update.parameters.${i}`;
      return [
        h("strong", {}, soft(p.name)), h("span", { class: "nowrap" }, unit(p.unit)), num(significant(p.before, 4), `${path}.before`),
        ...(anyAfter ? [h("strong", {}, num(significant(p.after, 4), `${path}.after`))] : []),
        num(significant(p.lower, 4), `${path}.lower`), track(p), num(significant(p.upper, 4), `${path}.upper`),
        ...(anyInterval ? [p.interval ? h("span", { class: "nowrap" }, num(significant(p.interval[0], 3), `${path}.interval.0`), " … ", num(significant(p.interval[1], 3), `${path}.interval.1`)) : "–"] : []),
        ...(determined ? [p.determined == null ? "–" : num(`${fixed(100 * p.determined, 0)} %`, `${path}.determined`, 100)] : []),
        p.at_bound ? badge("warning", `at ${p.at_bound} bound`) : "",
      ];
    }), { id: "parameter-table" }));
}

function mass(m: MassProperty, i: number, before: boolean, targets: boolean): Child[] {
  const path = `update.mass_properties.${i}`;
  return [
    m.name, h("span", { class: "nowrap" }, unit(m.unit)),
    ...(targets ? [m.target == null ? "–" : h("span", { class: "nowrap" }, num(significant(m.target, 4), `${path}.target`), m.tolerance == null ? "" : [" ± ", num(significant(m.tolerance, 2), `${path}.tolerance`)])] : []),
    ...(before ? [num(significant(m.before, 4), `${path}.before`)] : []), h("strong", {}, num(significant(m.after, 4), `${path}.after`)),
    ...(targets ? [m.within == null ? "–" : badge(m.within ? "good" : "bad", m.within ? "within" : "outside"), m.source] : []),
  ];
}

export function updateSection(u: Update): HTMLElement {
  const massBefore = u.mass_properties.some((m) => m.before != null), targets = u.mass_properties.some((m) => m.target != null);
  const atBound = u.parameters.filter((p) => p.at_bound);
  const facts: [string, Child][] = [
    ["optimiser", u.optimizer || null], ["evaluations", u.evaluations == null ? null : num(String(u.evaluations), "update.evaluations")],
    ["cost", u.cost_before == null || u.cost_after == null ? null
      : h("span", {}, num(significant(u.cost_before, 4), "update.cost_before"), " → ", num(significant(u.cost_after, 4), "update.cost_after"))],
    ["χ², twice the cost", u.cost_before == null || u.cost_after == null || !/least squares/i.test(u.objective) ? null
      : h("span", { class: "num" }, `${significant(2 * u.cost_before, 4)} → ${significant(2 * u.cost_after, 4)}`)],
    ["on a bound", u.histories.length + u.parameters.filter((p) => p.after != null).length === 0 ? null : atBound.length ? `${atBound.length} of ${u.parameters.length} parameters` : "none"],
  ];
  return h("div", { class: "stack" },
    u.parameters.length + u.histories.length === 0 ? null : h("div", { class: "stats" }, facts.filter(([, v]) => v).map(([name, value]) => h("div", { class: "stat" }, h("span", { class: "stat-name" }, name), h("span", { class: "stat-value" }, value)))),
    u.histories.length ? costChart(u) : null,
    u.parameters.length ? parameters(u) : null,
    u.unidentifiable.length ? card("What the data cannot separate", "along these combinations the prediction hardly changes: trust the combination that is fixed, not the single values",
      h("ul", { class: "combinations" }, u.unidentifiable.map((c, i) => h("li", {},
        h("div", { class: "weights" }, c.weights.slice(0, 6).map(([name, weight], k) => h("span", { class: "weight" },
          h("span", { class: "weight-bar", style: `width:${Math.round(64 * Math.min(1, Math.abs(weight)))}px` }), num(fixed(weight, 2), `update.unidentifiable.${i}.weights.${k}.1`), " ", name)),
          c.weights.length > 6 ? h("span", { class: "note" }, `and ${c.weights.length - 6} smaller`) : null),
        c.meaning ? h("p", {}, minuses(c.meaning)) : null,
        c.relative_singular_value == null ? null : h("p", { class: "note" }, "singular value relative to the largest: ", num(significant(c.relative_singular_value, 2), `update.unidentifiable.${i}.relative_singular_value`)))))) : null,
    u.correlation ? card("Correlation of the estimates", "near ±1: the data fix the sum or the difference of the two, not each; blank: a parameter held by a bound or not seen alone has none",
      heat(u.correlation, { map: "diverging", low: -1, high: 1, path: (i, j) => `update.correlation.values.${i}.${j}`, blank: "not known: held by a bound, or not seen alone" }), colorBar("diverging", "−1", "+1", "correlation", undefined, "0")) : null,
    u.sensitivities.length ? card("Sensitivity", "what changes when a parameter moves through a tenth of the range between its bounds",
      u.sensitivities.map((m, k) => {
        const values = m.values.flat().filter((v): v is number => v != null && Number.isFinite(v));
        const size = Math.max(...values.map(Math.abs), 1e-12), signed = values.some((v) => v < 0);
        const map = signed ? "diverging" as const : "cividis" as const, low = signed ? -size : 0;
        return h("figure", { class: "mac" }, h("figcaption", {}, m.title), heat(m, { map, low, high: size, path: (i, j) => `update.sensitivities.${k}.values.${i}.${j}`, decimals: size < 2 ? 2 : 1 }),
          colorBar(map, significant(low, 2), significant(size, 2), m.title, undefined, signed ? "0" : undefined));
      })) : null,
    u.mass_properties.length ? card(targets ? "Mass properties against targets" : "Mass properties of the model", null, table("Mass properties", [
      { head: "Quantity" }, { head: "Unit" }, ...(targets ? [{ head: "Target", numeric: true }] : []), ...(massBefore ? [{ head: "Before", numeric: true }] : []),
      { head: massBefore ? "After" : "Model", numeric: true }, ...(targets ? [{ head: "" }, { head: "Source" }] : []),
    ], u.mass_properties.map((m, i) => mass(m, i, massBefore, targets)), { id: "mass-table" })) : null);
}
