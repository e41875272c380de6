/** Where the sliders and switches stand, how they got there, and how that is told to others. */

import type { Live } from "../types";
import type { Extra, Point } from "./model";

export interface State {
  /** Of every parameter of the model and every size, SI; of a size also while its switch is off. */
  values: number[];
  /** Hypotheses that are on. */
  on: boolean[];
  /** Parameters (by index) and hypotheses (-1 - index), in the order in which they were first changed. */
  order: number[];
  /** What stands at nodes besides. */
  extras: Extra[];
}

export const copied = (s: State): State => ({ values: [...s.values], on: [...s.on], order: [...s.order], extras: s.extras.map((e) => ({ ...e })) });

export const equal = (a: State, b: State): boolean => JSON.stringify({ ...a, order: [] }) === JSON.stringify({ ...b, order: [] });

/** A state of one model as that of the model in another configuration: what both have by name. */
export function carried(from: Live, s: State, nodesFrom: readonly string[], to: Live, nodesTo: readonly string[]): State {
  const out = initial(to);
  const parameter = (k: number): number => to.parameters.findIndex((p, i) => p.name === from.parameters[k]!.name && owner(to, i) < 0);
  const hypothesis = (i: number): number => to.hypotheses.findIndex((h) => h.id === from.hypotheses[i]!.id);
  s.values.forEach((v, k) => {
    const j = owner(from, k) < 0 ? parameter(k) : -1;
    if (j >= 0) out.values[j] = clamp(to, j, v);
  });
  s.on.forEach((on, i) => {
    const j = hypothesis(i);
    if (j < 0) return;
    out.on[j] = on;
    from.hypotheses[i]!.sizes.forEach((k, n) => {
      const size = to.hypotheses[j]!.sizes[n];
      if (size != null) out.values[size] = clamp(to, size, s.values[k]!);
    });
  });
  out.order = s.order.flatMap((c) => {
    const j = c < 0 ? hypothesis(-1 - c) : parameter(c);
    return j < 0 ? [] : [c < 0 ? -1 - j : j];
  });
  out.extras = s.extras.flatMap((e) => {
    const node = nodesTo.indexOf(nodesFrom[e.node] ?? "");
    return node < 0 ? [] : [{ ...e, node }];
  });
  return out;
}

export function initial(live: Live): State {
  const values = live.parameters.map((p) => p.value);
  for (const h of live.hypotheses) h.sizes.forEach((k, i) => { values[k] = clamp(live, k, h.estimates[i]!); });
  return { values, on: live.hypotheses.map(() => false), order: [], extras: [] };
}

export function clamp(live: Live, k: number, value: number): number {
  const [low, high] = live.parameters[k]!.range;
  return Math.min(high, Math.max(low, value));
}

/** The hypothesis that a size belongs to, or -1. */
export function owner(live: Live, k: number): number {
  return live.hypotheses.findIndex((h) => h.sizes.includes(k));
}

/** The point at which the model is asked for a state. */
export const point = (live: Live, s: State): Point => ({ theta: theta(live, s), extras: s.extras.filter((e) => e.mass !== 0 || e.stiffness !== 0),
  faults: live.hypotheses.flatMap((h, i) => (s.on[i] && h.test ? [i] : [])) });

/** θ at a state: sizes whose switch is off are at their neutral value. */
export function theta(live: Live, s: State): Float64Array {
  const out = Float64Array.from(s.values);
  live.hypotheses.forEach((h, i) => { if (!s.on[i]) for (const k of h.sizes) out[k] = live.parameters[k]!.value; });
  return out;
}

/** What differs from the report: parameters of the model by index, hypotheses as -1 - index. */
export function changes(live: Live, s: State): number[] {
  const own = live.parameters.flatMap((p, k) => (owner(live, k) < 0 && s.values[k] !== p.value ? [k] : []));
  const all = new Set([...own, ...s.on.flatMap((on, i) => (on ? [-1 - i] : []))]);
  const known = s.order.filter((c) => all.has(c));
  return [...known, ...[...all].filter((c) => !known.includes(c))];
}

/** Most parameters that are steps of their own on the way to a state. */
const STEPS = 6;

interface Step { name: string; changes: number[]; extra?: Extra }

/** The changes as steps: each hypothesis and each parameter, or all parameters together where they are many; then what stands at nodes. */
export function steps(live: Live, s: State, nodeName: (node: number) => string = String): Step[] {
  const all = changes(live, s), own = all.filter((c) => c >= 0), together = own.length > STEPS;
  const name = (c: number): string => (c < 0 ? live.hypotheses[-1 - c]!.id : live.parameters[c]!.name);
  const found = all.flatMap((c): Step[] =>
    (c < 0 || !together ? [{ name: name(c), changes: [c] }] : c === own[0] ? [{ name: `${own.length} parameters`, changes: own }] : []));
  return [...found, ...point(live, s).extras.map((extra) => ({ name: `at ${nodeName(extra.node)}`, changes: [], extra }))];
}

/** The points after each step but the last. */
export function way(live: Live, s: State): Point[] {
  const at: State = { values: [...s.values], on: live.hypotheses.map(() => false), order: [], extras: [] };
  live.parameters.forEach((p, k) => { if (owner(live, k) < 0) at.values[k] = p.value; });
  return steps(live, s).slice(0, -1).map((step) => {
    for (const c of step.changes) {
      if (c < 0) at.on[-1 - c] = true;
      else at.values[c] = s.values[c]!;
    }
    if (step.extra) at.extras.push(step.extra);
    return point(live, at);
  });
}

/** Pieces of the line between two states. */
const PIECES = 24;

/** Points of the line, both ends among them; none where the ends are one. What stands at nodes grows with it. */
export function between(from: Point, to: Point): Point[] {
  const same = to.extras.length + (to.faults ?? []).length === 0 && from.theta.every((v, k) => v === to.theta[k]);
  return same ? [] : Array.from({ length: PIECES + 1 }, (_, i) => {
    const t = i / PIECES;
    return { ...to, theta: from.theta.map((v, k) => v + t * (to.theta[k]! - v)), extras: to.extras.map((e) => ({ ...e, mass: t * e.mass, stiffness: t * e.stiffness })) };
  });
}

/** The state as part of an address: `E=5.2e10;point-mass@n8=0.1`. */
export function written(live: Live, s: State, nodes: string[]): string {
  const parts = changes(live, s).map((c) => {
    if (c >= 0) return `${encodeURIComponent(live.parameters[c]!.name)}=${number(s.values[c]!)}`;
    const h = live.hypotheses[-1 - c]!;
    return `${encodeURIComponent(h.id)}=${h.sizes.map((k) => number(s.values[k]!)).join(",")}`;
  });
  return [...parts, ...s.extras.map((e) => `at:${encodeURIComponent(nodes[e.node] ?? "")}=${number(e.mass)},${number(e.stiffness)}`)].join(";");
}

const number = (v: number): string => String(Number(v.toPrecision(9)));

/** The state that an address tells; names that the page does not know are passed over. */
export function read(live: Live, text: string, nodes: string[]): State {
  const s = initial(live);
  for (const part of text.split(";")) {
    const at = part.lastIndexOf("=");
    if (at <= 0) continue;
    let name: string;
    try {
      name = decodeURIComponent(part.slice(0, at));
    } catch {
      continue;
    }
    const values = part.slice(at + 1).split(",").map(Number);
    if (!values.every(Number.isFinite)) continue;
    const node = name.startsWith("at:") ? nodes.indexOf(name.slice(3)) : -1;
    if (node >= 0 && values.length === 2 && values.every((v) => v >= 0)) {
      s.extras = [...s.extras.filter((e) => e.node !== node), { node, mass: values[0]!, stiffness: values[1]! }];
      continue;
    }
    const h = live.hypotheses.findIndex((x) => x.id === name);
    if (h >= 0) {
      s.on[h] = true;
      s.order.push(-1 - h);
      live.hypotheses[h]!.sizes.forEach((k, i) => { if (values[i] != null) s.values[k] = clamp(live, k, values[i]!); });
      continue;
    }
    const k = live.parameters.findIndex((p, i) => p.name === name && owner(live, i) < 0);
    if (k < 0 || values.length !== 1) continue;
    s.values[k] = clamp(live, k, values[0]!);
    s.order.push(k);
  }
  return s;
}

const plain = /^[A-Za-z_][\w.-]*$/;
const key = (name: string): string => (plain.test(name) ? name : JSON.stringify(name));

/** A value in the unit that people read it in, to nine digits. */
export function shown(live: Live, k: number, si: number): string {
  const p = live.parameters[k]!;
  return `${number(si / p.unit_factor)}${p.unit && p.unit !== "1" ? ` ${p.unit}` : ""}`;
}

const AXES = ["ux", "uy", "uz"];

/** The parameters, and what stands at nodes, as blocks of the model file. */
export function yaml(live: Live, s: State, nodes: string[]): string {
  const line = (k: number): string => {
    const p = live.parameters[k]!, [low, high] = p.range;
    const bounds = low < high ? `, bounds: [${shown(live, k, low)}, ${shown(live, k, high)}]` : "";
    return `  ${key(p.name)}: {value: ${shown(live, k, s.values[k]!)}${bounds}}`;
  };
  const own = live.parameters.flatMap((_, k) => (owner(live, k) < 0 ? [k] : []));
  const sizes = live.hypotheses.flatMap((h, i) => (s.on[i] && !h.test ? h.sizes : []));
  const entry = (e: Extra, what: string): string => `  what_if_${what}_at_${nodes[e.node]?.replace(/\W/g, "_")}: {node: ${key(nodes[e.node] ?? "")}, `;
  const masses = s.extras.filter((e) => e.mass > 0).map((e) => `${entry(e, "mass")}mass: ${number(e.mass)} kg}`);
  const springs = s.extras.filter((e) => e.stiffness > 0).map((e) => `${entry(e, "spring")}k: {${AXES.map((axis) => `${axis}: ${number(e.stiffness)} N/m`).join(", ")}}}`);
  return ["parameters:", ...own.map(line),
    ...(sizes.length ? ["  # of what `retune add` has put into the file:", ...sizes.map(line)] : []),
    ...(masses.length ? ["masses:", ...masses] : []), ...(springs.length ? ["springs: # along the axes in which the model moves", ...springs] : [])].join("\n") + "\n";
}

/** The commands that make the model file of a state, before its values are put into it, and compare it. */
export function commands(live: Live, s: State, nodes: string[], model: string, test: string): string {
  const quoted = (text: string): string => (/^[\w./@+:,=-]+$/.test(text) ? text : `'${text.replace(/'/g, "'\\''")}'`);
  const on = live.hypotheses.filter((_, i) => s.on[i]), ids = on.filter((h) => !h.test).map((h) => h.id);
  const faults = on.flatMap((h) => (h.test ? [`# in the test, ${h.id}${h.sizes.map((k) => ` = ${shown(live, k, s.values[k]!)}`).join("")}: ${h.test.remedy.replace(/\s+/g, " ")}`] : []));
  const changed = "changed.yaml";
  const lines = ids.map((id, i) => `retune add ${quoted(i ? changed : model)} ${quoted(id)} -o ${changed}${i ? " --force" : ""}`);
  if (!ids.length) lines.push(`cp ${quoted(model)} ${changed}`);
  return [...lines, `# put these into its blocks:`, ...yaml(live, s, nodes).trimEnd().split("\n").map((l) => `#   ${l}`),
    ...faults, `retune compare ${changed} ${quoted(test)}`].join("\n") + "\n";
}
