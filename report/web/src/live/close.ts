/** Modes so close that only the space which they span is determined, turned to the test (`src/objective/close_modes.rs`). */

import { symmetricEigen } from "./eigen";

const CLOSE = 0.005, DOUBLE = 1e-6, OCTAVE = 2, SEEN = 1e-3, EXPLAINED = 0.5;
const ROUNDS = 30, STILL = 1e-12, MOST_TURN = 0.3;

/** Runs of neighbouring modes that are so close. */
export function clusters(hz: ArrayLike<number>, test: ArrayLike<number>, hasShapes: boolean, isAlike: (i: number, j: number) => boolean): number[][] {
  const all = Array.from(test), gap = hasShapes ? CLOSE : DOUBLE;
  const from = Math.min(...all) / OCTAVE, to = Math.max(...all, 0) * OCTAVE;
  const out: number[][] = [];
  for (let i = 1; i < hz.length; i++) {
    const lower = hz[i - 1]!, upper = hz[i]!, d = upper - lower;
    if (!(lower >= from && upper <= to && (d < DOUBLE * upper || (d < gap * upper && isAlike(i - 1, i))))) continue;
    const last = out[out.length - 1];
    if (last && last[last.length - 1] === i - 1) last.push(i);
    else out.push([i - 1, i]);
  }
  return out;
}

const dot = (a: ArrayLike<number>, b: ArrayLike<number>): number => {
  let s = 0;
  for (let i = 0; i < a.length; i++) s += a[i]! * b[i]!;
  return s;
};

/** Inverse and inverse root of a small positive matrix by rows, and the ratio of the roots of its ends. */
function roots(gram: Float64Array, n: number): { inverse: Float64Array; inverseRoot: Float64Array; ratio: number; least: number } {
  const d = new Float64Array(n), v = new Float64Array(n * n), inverse = new Float64Array(n * n), inverseRoot = new Float64Array(n * n);
  symmetricEigen(gram, n, d, v);
  for (let k = 0; k < n; k++) {
    for (let i = 0; i < n; i++) {
      for (let j = 0; j < n; j++) {
        const f = v[k * n + i]! * v[k * n + j]!;
        inverse[i * n + j]! += f / d[k]!;
        inverseRoot[i * n + j]! += f / Math.sqrt(d[k]!);
      }
    }
  }
  const least = Math.sqrt(Math.max(0, d[0] ?? 0)), most = Math.sqrt(Math.max(0, d[n - 1] ?? 0));
  return { inverse, inverseRoot, ratio: most > 0 ? least / most : 0, least };
}

function gramOf(columns: ArrayLike<number>[]): Float64Array {
  const n = columns.length, out = new Float64Array(n * n);
  for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) out[i * n + j] = dot(columns[i]!, columns[j]!);
  return out;
}

/** Slope and curvature in θ, at zero, of what the best scale leaves of a test shape: f = -(x·v)²/(vᵀ G v), v = a cos θ + b sin θ. */
function slopes(cross: Float64Array, gram: Float64Array, a: Float64Array, b: Float64Array): [number, number] {
  const n = a.length, by = (v: Float64Array): Float64Array => v.map((_, i) => dot(gram.subarray(i * n, (i + 1) * n), v));
  const ga = by(a), d = dot(a, ga), ab = dot(b, ga), bb = dot(b, by(b)), x = dot(cross, a), dx = dot(cross, b);
  if (d <= 0) return [0, 0];
  const dd = 2 * ab, ddd = 2 * (bb - d), top = x * x, dtop = 2 * x * dx, ddtop = 2 * (dx * dx - x * x);
  const slope = (dtop * d - top * dd) / (d * d);
  return [-slope, -((ddtop * d - top * ddd) / (d * d) - (2 * dd * slope) / d)];
}

/** Turns columns on to where the shapes fit best, their scales free; the first belong to the products, in their order. */
function settle(columns: Float64Array[], products: { cross: Float64Array; gram: Float64Array }[]): void {
  for (let round = 0; round < ROUNDS; round++) {
    let largest = 0;
    for (let k = 0; k < products.length; k++) {
      for (let l = k + 1; l < columns.length; l++) {
        const a = columns[k]!, b = columns[l]!, own = products[k]!, other = products[l];
        const [f, g] = slopes(own.cross, own.gram, a, b), [p, q] = other ? slopes(other.cross, other.gram, b, a.map((v) => -v)) : [0, 0];
        const step = g + q > 0 ? -(f + p) / (g + q) : -Math.sign(f + p) * MOST_TURN;
        const angle = Number.isFinite(step) ? Math.min(MOST_TURN, Math.max(-MOST_TURN, step)) : 0, c = Math.cos(angle), s = Math.sin(angle);
        columns[k] = a.map((v, i) => v * c + b[i]! * s);
        columns[l] = b.map((v, i) => v * c - a[i]! * s);
        largest = Math.max(largest, Math.abs(angle));
      }
    }
    if (largest < STILL) return;
  }
}

/** A test shape, NaN where not measured, empty without one, and the reciprocals of its standard deviations. */
export interface Measured { shape: Float64Array; weight: Float64Array }

/**
 * Turns the shapes of one cluster to those of the test: Q = U Vᵀ of the combinations B that explain the test shapes best, and on to where the
 * shapes fit best.
 *
 * * `at` - the shapes at the sensors, a row each; `shapes` - the same on coordinates; both are turned in place
 */
export function turn(cluster: number[], at: Float64Array[], shapes: Float64Array[], tests: Measured[]): void {
  const largest = Math.max(...cluster.map((k) => Math.sqrt(dot(at[k]!, at[k]!))));
  const own = cluster.filter((k) => Math.sqrt(dot(at[k]!, at[k]!)) > SEEN * largest);
  const n = own.length;
  if (n < 2) return;
  const found: { share: number; j: number; b: Float64Array }[] = [];
  tests.forEach(({ shape: test }, j) => {
    const measured = Array.from(test, (_, i) => i).filter((i) => !Number.isNaN(test[i]));
    if (!test.length || measured.length < n) return;
    const phi = own.map((k) => Float64Array.from(measured, (i) => at[k]![i]!));
    const t = Float64Array.from(measured, (i) => test[i]!);
    const { inverse, ratio } = roots(gramOf(phi), n);
    if (!(ratio >= SEEN)) return;
    const right = phi.map((p) => dot(p, t)), b = new Float64Array(n);
    for (let i = 0; i < n; i++) for (let k = 0; k < n; k++) b[i]! += inverse[i * n + k]! * right[k]!;
    const share = dot(b, right) / dot(t, t), length = Math.sqrt(dot(b, b));
    if (share > EXPLAINED && length > 0) found.push({ share, j, b: b.map((x) => x / length) });
  });
  found.sort((x, y) => y.share - x.share || x.j - y.j);
  found.length = Math.min(found.length, n);
  if (!found.length) return;
  found.sort((x, y) => x.j - y.j);
  // B (BᵀB)^(-1/2) is U Vᵀ.
  const t = found.length, b = found.map((f) => f.b);
  const { inverseRoot, least } = roots(gramOf(b), t);
  if (!(least >= 1e-3)) return;
  const columns: Float64Array[] = b.map((_, c) => {
    const q = new Float64Array(n);
    for (let k = 0; k < t; k++) for (let i = 0; i < n; i++) q[i]! += b[k]![i]! * inverseRoot[k * t + c]!;
    return q;
  });
  for (let k = 0; k < n && columns.length < n; k++) {
    const e = new Float64Array(n);
    e[k] = 1;
    for (let pass = 0; pass < 2; pass++) {
      for (const c of columns) {
        const f = dot(c, e);
        for (let i = 0; i < n; i++) e[i]! -= f * c[i]!;
      }
    }
    const length = Math.sqrt(dot(e, e));
    if (length > 0.5 / Math.sqrt(n)) columns.push(e.map((x) => x / length));
  }
  if (columns.length < n) return;
  settle(columns, found.map(({ j }) => {
    const { shape, weight } = tests[j]!, measured = Array.from(shape, (_, i) => i).filter((i) => !Number.isNaN(shape[i]));
    const w = (i: number): number => weight[i] ?? 1;
    const phi = own.map((k) => Float64Array.from(measured, (i) => at[k]![i]! * w(i))), t = Float64Array.from(measured, (i) => shape[i]! * w(i));
    return { cross: Float64Array.from(phi, (p) => dot(p, t)), gram: gramOf(phi) };
  }));
  for (const list of [at, shapes]) {
    const before = own.map((k) => list[k]!.slice());
    own.forEach((k, c) => {
      list[k]!.fill(0);
      before.forEach((row, i) => row.forEach((x, s) => { list[k]![s]! += x * columns[c]![i]!; }));
    });
  }
}
