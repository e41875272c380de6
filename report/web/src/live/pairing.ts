/** Pairs of modes by the rules of the library (`src/correlation/pairing.rs`), on likenesses that were computed before. */

import type { LivePairing, LivePlan } from "../types";

export interface Side { frequencies: ArrayLike<number>; families: (string | null)[] }

const TIE_BREAK = 1e-9;
/** MAC that shapes may cost together for the order of the frequencies to decide. */
const SAME_SHAPE = 0.01;

/** How near two frequencies are, in (0, 1]: one within an octave. */
function nearness(a: number, b: number): number {
  const beyond = Math.log2(Math.max(a, b) / Math.min(a, b)) - 1;
  return beyond > 0 ? Math.max(Math.exp(-2 * beyond * beyond), 1e-6) : 1;
}

const byFrequency = (f: ArrayLike<number>): number[] => Array.from(f, (_, i) => i).sort((i, j) => f[i]! - f[j]!);

/**
 * The assignment of the shorter side into the longer with the least total cost: shortest augmenting paths with dual prices (R. Jonker,
 * A. Volgenant, Computing 38, 1987, 325-340). Returns the column of every row, or -1.
 */
export function assign(rows: number, columns: number, cost: (i: number, j: number) => number): number[] {
  if (rows > columns) {
    const of = new Array<number>(rows).fill(-1);
    assign(columns, rows, (i, j) => cost(j, i)).forEach((row, column) => { of[row] = column; });
    return of;
  }
  const rowPrice = new Float64Array(rows), columnPrice = new Float64Array(columns);
  const rowOf = new Int32Array(columns).fill(-1);
  for (let start = 0; start < rows; start++) {
    const distance = new Float64Array(columns).fill(Infinity), previous = new Int32Array(columns).fill(-1);
    const done = new Uint8Array(columns);
    let row = start, from = -1, travelled = 0, sink = -1;
    while (sink < 0) {
      let nearest = -1;
      for (let j = 0; j < columns; j++) {
        if (done[j]) continue;
        const through = travelled + cost(row, j) - rowPrice[row]! - columnPrice[j]!;
        if (through < distance[j]!) {
          distance[j] = through;
          previous[j] = from;
        }
        if (nearest < 0 || distance[j]! < distance[nearest]!) nearest = j;
      }
      done[nearest] = 1;
      travelled = distance[nearest]!;
      from = nearest;
      if (rowOf[nearest]! < 0) sink = nearest;
      else row = rowOf[nearest]!;
    }
    rowPrice[start]! += travelled;
    for (let j = 0; j < columns; j++) {
      if (!done[j] || j === sink) continue;
      columnPrice[j]! += distance[j]! - travelled;
      if (rowOf[j]! >= 0) rowPrice[rowOf[j]!]! += travelled - distance[j]!;
    }
    let j = sink;
    while (previous[j]! >= 0) {
      rowOf[j] = rowOf[previous[j]!]!;
      j = previous[j]!;
    }
    rowOf[j] = start;
  }
  const out = new Array<number>(rows).fill(-1);
  rowOf.forEach((row, j) => { if (row >= 0) out[row] = j; });
  return out;
}

/**
 * The elastic mode of every test mode, or -1.
 *
 * * `likeness` - by rows, (n_model x n_test)
 */
export function pair(likeness: Float64Array, model: Side, test: Side, options: LivePairing, plans: LivePlan[]): Int32Array {
  const n = model.frequencies.length, m = test.frequencies.length;
  const fixed = new Set(plans.flatMap((p) => (typeof p === "object" && "fixed" in p ? [p.fixed] : [])));
  const isFree = (j: number): boolean => plans[j] === "free";
  const window = options.frequency_window;
  const isNear = (i: number, j: number): boolean => {
    const a = model.frequencies[i]!, x = test.frequencies[j]!;
    return window == null || Math.max(a, x) <= (1 + window) * Math.min(a, x);
  };
  const isSame = (i: number, j: number): boolean => {
    const a = model.families[i], x = test.families[j];
    return a == null || x == null || a === x;
  };
  const isAllowed = (i: number, j: number): boolean => {
    const l = likeness[i * m + j]!;
    return isFree(j) && !fixed.has(i) && l > 0 && l >= options.min_mac && isNear(i, j) && (!options.same_family_only || isSame(i, j));
  };
  const weight = (i: number, j: number): number => {
    if (!isAllowed(i, j)) return 0;
    const a = model.frequencies[i]!, x = test.frequencies[j]!;
    const closeness = a > 0 && x > 0 ? Math.min(a, x) / Math.max(a, x) : 0;
    return likeness[i * m + j]! * (options.by === "near-mac" ? nearness(a, x) : 1) + TIE_BREAK * closeness;
  };
  const order = byFrequency(test.frequencies), rank = new Int32Array(m);
  order.forEach((j, k) => { rank[j] = k; });
  const rows = byFrequency(model.frequencies);
  let pairs: [number, number][] = [];
  if (options.by === "mac" || options.by === "near-mac") {
    assign(n, m, (i, j) => -weight(i, j)).forEach((j, i) => { if (j >= 0 && isAllowed(i, j)) pairs.push([i, j]); });
  } else if (options.by === "order") pairs = inOrder();
  pairs.sort((a, b) => rank[a[1]]! - rank[b[1]]!);
  if (options.by === "near-mac") uncross(pairs);
  planned();
  const out = new Int32Array(m).fill(-1);
  for (const [i, j] of pairs) out[j] = i;
  return out;

  /** Test modes of a known family first, each with the next model mode of its family; then the others with what is left. */
  function inOrder(): [number, number][] {
    const gated = options.same_family_only, taken = new Set<number>(), partner = new Map<number, number>();
    for (const known of [true, false]) {
      for (const j of order) {
        const own = test.families[j] ?? null;
        const fits = (i: number): boolean => known ? gated && own != null && model.families[i] === own : !gated || isSame(i, j);
        if (partner.has(j) || !isFree(j)) continue;
        const i = rows.find((k) => !taken.has(k) && !fixed.has(k) && fits(k));
        if (i == null) continue;
        taken.add(i);
        partner.set(j, i);
      }
    }
    return order.flatMap((j) => (partner.has(j) ? [[partner.get(j)!, j] as [number, number]] : []));
  }

  /** Exchanges partners whose order is opposite in model and test, where that costs less than shapes can tell. */
  function uncross(list: [number, number][]): void {
    let done = false;
    while (!done) {
      done = true;
      for (let p = 1; p < list.length; p++) {
        for (let q = 0; q < p; q++) {
          const [a, x] = list[q]!, [b, y] = list[p]!;
          const first = weight(b, x), second = weight(a, y);
          if (first > 0 && second > 0 && model.frequencies[a]! > model.frequencies[b]!
            && first + second > weight(a, x) + weight(b, y) - SAME_SHAPE) {
            list[q]![0] = b;
            list[p]![0] = a;
            done = false;
          }
        }
      }
    }
  }

  /** What is settled about the partners of some test modes. */
  function planned(): void {
    const taken = new Set(pairs.map((p) => p[0]));
    plans.forEach((plan, j) => {
      if (typeof plan === "object" && "fixed" in plan && plan.fixed < n) {
        taken.add(plan.fixed);
        pairs.push([plan.fixed, j]);
      }
    });
    const byRule = new Set(pairs.map((p) => p[0]));
    plans.forEach((plan, j) => {
      if (typeof plan !== "object" || !("ranked" in plan)) return;
      const left = rows.filter((i) => !byRule.has(i) && (!options.same_family_only || isSame(i, j)));
      const i = left.slice(plan.ranked).find((k) => !taken.has(k));
      if (i == null) return;
      taken.add(i);
      pairs.push([i, j]);
    });
  }
}
