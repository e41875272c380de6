/** Arithmetic of mode shapes: scaling, phase, beam curves, differences. Pure functions on typed arrays. */

/** A real or complex vector; `im` is missing for a real one. */
export interface Shape { re: Float32Array; im?: Float32Array | undefined }

/** Largest modulus over the entries; NaN entries are skipped. */
export function peak(shape: Shape): number {
  let best = 0;
  for (let i = 0; i < shape.re.length; i++) {
    const size = Math.hypot(shape.re[i]!, shape.im?.[i] ?? 0);
    if (size > best) best = size;
  }
  return best;
}

/** Largest length of a node's displacement, of a shape with three entries a node. */
export function peakOfNodes(shape: Shape): number {
  let best = 0;
  for (let i = 0; i + 2 < shape.re.length; i += 3) {
    let sum = 0;
    for (let k = 0; k < 3; k++) sum += shape.re[i + k]! ** 2 + (shape.im?.[i + k] ?? 0) ** 2;
    if (sum > best) best = sum;
  }
  return Math.sqrt(best);
}

/**
 * The complex factor s that brings `x` closest to `a`: s = xᴴa / xᴴx (the modal scale factor; R. J. Allemang,
 * Investigation of some multiple input/output frequency response function experimental modal analysis techniques,
 * 1980). Entries missing on either side are skipped; [0, 0] when nothing is left.
 */
export function scaleFactor(x: Shape, a: Shape): [number, number] {
  let re = 0, im = 0, norm = 0;
  for (let i = 0; i < x.re.length; i++) {
    const xr = x.re[i]!, xi = x.im?.[i] ?? 0, ar = a.re[i] ?? NaN, ai = a.im?.[i] ?? 0;
    if (!Number.isFinite(xr + xi + ar + ai)) continue;
    re += xr * ar + xi * ai;
    im += xr * ai - xi * ar;
    norm += xr * xr + xi * xi;
  }
  return norm > 0 ? [re / norm, im / norm] : [0, 0];
}

/** `shape` times a complex factor; stays real when both are. */
export function times(shape: Shape, [fr, fi]: [number, number]): Shape {
  const n = shape.re.length;
  const re = new Float32Array(n);
  if (!shape.im && fi === 0) {
    for (let i = 0; i < n; i++) re[i] = shape.re[i]! * fr;
    return { re };
  }
  const im = new Float32Array(n);
  for (let i = 0; i < n; i++) {
    const r = shape.re[i]!, m = shape.im?.[i] ?? 0;
    re[i] = r * fr - m * fi;
    im[i] = r * fi + m * fr;
  }
  return { re, im };
}

/** |x - a| at every entry, relative to the largest entry of `a`; NaN where one is missing. */
export function difference(x: Shape, a: Shape): Float32Array {
  const unit = peak(a) || 1;
  return Float32Array.from(x.re, (xr, i) =>
    Math.hypot(xr - (a.re[i] ?? NaN), (x.im?.[i] ?? 0) - (a.im?.[i] ?? 0)) / unit);
}

/** Re(value · e^{iφ}) = re cos φ - im sin φ, into `out`; missing entries become 0. */
export function atPhase(shape: Shape, phase: number, amplitude: number, out: Float32Array): void {
  const c = amplitude * Math.cos(phase), d = amplitude * Math.sin(phase);
  const { re, im } = shape;
  for (let i = 0; i < out.length; i++) {
    const value = c * re[i]! - (im ? d * im[i]! : 0);
    out[i] = Number.isFinite(value) ? value : 0;
  }
}

type Point = readonly [number, number, number];

function cross(a: Point, b: Point): [number, number, number] {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/**
 * Displacement at fraction `t` of a beam from p to q whose ends move by u, v and turn by r, s: linear along the axis,
 * cubic across it (Hermite polynomials with the end slopes θ × e; J. S. Przemieniecki, Theory of matrix structural
 * analysis, 1968, section 5.6).
 */
export function beamPoint(
  p: Point, q: Point, u: Point, v: Point, r: Point | null, s: Point | null, t: number,
): [number, number, number] {
  const linear = [0, 1, 2].map((k) => u[k]! + (v[k]! - u[k]!) * t) as [number, number, number];
  const axis = [q[0] - p[0], q[1] - p[1], q[2] - p[2]] as const;
  const length = Math.hypot(...axis);
  if (!r || !s || length === 0) return linear;
  const e = axis.map((a) => a / length) as [number, number, number];
  const across = (w: Point): [number, number, number] => {
    const along = w[0] * e[0] + w[1] * e[1] + w[2] * e[2];
    return [w[0] - along * e[0], w[1] - along * e[1], w[2] - along * e[2]];
  };
  const along = linear[0] * e[0] + linear[1] * e[1] + linear[2] * e[2];
  const n1 = 1 - 3 * t * t + 2 * t ** 3, n2 = length * t * (1 - t) ** 2;
  const n3 = 3 * t * t - 2 * t ** 3, n4 = length * t * t * (t - 1);
  const ut = across(u), vt = across(v), a = cross(r, e), b = cross(s, e);
  return [0, 1, 2].map((k) =>
    along * e[k]! + n1 * ut[k]! + n2 * a[k]! + n3 * vt[k]! + n4 * b[k]!) as [number, number, number];
}
