/**
 * One step of a fit on the page: Levenberg and Marquardt within the ends of the sliders, with differences for derivatives. A value on an end
 * that the step would cross stays there.
 *
 * K. Levenberg, Quarterly of Applied Mathematics 2 (1944) 164-168; D. W. Marquardt, Journal of SIAM 11 (1963) 431-441; bounds by the
 * projection of D. P. Bertsekas, SIAM Journal on Control and Optimization 20 (1982) 221-246.
 */

import { cholesky } from "./eigen";
import type { LiveModel, Point } from "./model";

export interface FitStep { theta: Float64Array; damping: number; chiSquared: number; isDone: boolean }

const STEP = 1e-6;
/** A fit is done where a step brings less than this share of the error. */
const LITTLE = 1e-5;

/** * `free` - which parameters may move; `ranges` - of all */
export function fitStep(model: LiveModel, { theta, ...rest }: Point, free: number[], ranges: [number, number][], damping: number): FitStep {
  const residuals = (t: Float64Array): Float64Array | null => model.residuals({ theta: t, ...rest });
  const square = (r: Float64Array): number => r.reduce((s, v) => s + v * v, 0);
  const r0 = residuals(theta);
  const stay = (isDone: boolean, chi: number): FitStep => ({ theta, damping, chiSquared: chi, isDone });
  if (!r0) return stay(true, Infinity);
  const cost = square(r0), n = free.length;
  const at = free.map((k) => (theta[k]! - ranges[k]![0]) / (ranges[k]![1] - ranges[k]![0]));
  const moved = (x: ArrayLike<number>): Float64Array => {
    const out = theta.slice();
    free.forEach((k, i) => { out[k] = ranges[k]![0] + (ranges[k]![1] - ranges[k]![0]) * x[i]!; });
    return out;
  };
  const columns: Float64Array[] = at.map((x, i) => {
    const step = x + STEP > 1 ? -STEP : STEP, to = at.slice();
    to[i] = x + step;
    const r = residuals(moved(to));
    return r ? r.map((v, k) => (v - r0[k]!) / step) : new Float64Array(r0.length);
  });
  const dot = (a: Float64Array, b: Float64Array): number => {
    let s = 0;
    for (let k = 0; k < a.length; k++) s += a[k]! * b[k]!;
    return s;
  };
  const gradient = columns.map((c) => dot(c, r0));
  const open = at.map((_, i) => i).filter((i) => !(at[i]! <= 0 && gradient[i]! >= 0) && !(at[i]! >= 1 && gradient[i]! <= 0));
  const m = open.length;
  if (m === 0 || n === 0) return stay(true, cost);
  const normal = new Float64Array(m * m);
  for (let a = 0; a < m; a++) for (let b = 0; b <= a; b++) normal[a * m + b] = dot(columns[open[a]!]!, columns[open[b]!]!);
  const largest = Math.max(...open.map((_, a) => normal[a * m + a]!));
  for (let attempt = 0, mu = damping; attempt < 12; attempt++, mu *= 6) {
    const l = normal.slice();
    for (let a = 0; a < m; a++) l[a * m + a]! += mu * l[a * m + a]! + 1e-12 * largest;
    if (!cholesky(l, m)) continue;
    const step = Float64Array.from(open, (i) => -gradient[i]!);
    for (let a = 0; a < m; a++) {
      for (let b = 0; b < a; b++) step[a]! -= l[a * m + b]! * step[b]!;
      step[a]! /= l[a * m + a]!;
    }
    for (let a = m - 1; a >= 0; a--) {
      for (let b = a + 1; b < m; b++) step[a]! -= l[b * m + a]! * step[b]!;
      step[a]! /= l[a * m + a]!;
    }
    const to = at.slice();
    open.forEach((i, a) => { to[i] = Math.min(1, Math.max(0, at[i]! + step[a]!)); });
    const next = moved(to), r = residuals(next), chi = r ? square(r) : Infinity;
    if (chi < cost) return { theta: next, damping: Math.max(mu / 6, 1e-9), chiSquared: chi, isDone: cost - chi < LITTLE * cost };
  }
  return stay(true, cost);
}
