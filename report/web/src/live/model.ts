/** The model that the page computes with: matrices at θ, modes, pairs and misfit. Pure arithmetic, the same as the library's. */

import { doubles, floats } from "../decode";
import type { Live, LiveMatrix } from "../types";
import { clusters, turn } from "./close";
import { edited, type Seen } from "./edits";
import { backward, cholesky, congruence, symmetricEigen } from "./eigen";
import { pair } from "./pairing";
import { curve, type Curve, type Line } from "./response";

/** Residual of a frequency without a partner, in standard deviations: `NO_PARTNER` of the library. */
const NO_PARTNER = 2.648;
/** A mode whose shape at the sensors is smaller than this share of the largest is not seen. */
const UNSEEN = 1e-6;
const SYMMETRIC = 0.5;
/** λ below this part of the shift, which is near the first elastic λ, is that of a rigid-body motion. */
const RIGID = 1e-9;

/** What the model predicts at one θ. */
export interface Prediction {
  /** Frequencies of the elastic modes, Hz. */
  hz: Float64Array;
  /** Their shapes on the coordinates and at the sensors, of unit modal mass. */
  shapes: Float64Array[];
  atSensors: Float64Array[];
  families: (string | null)[];
  /** By rows, (n_elastic x n_test); zero where there is no shape. */
  mac: Float64Array;
  /** The elastic mode of every test mode, or -1. */
  partner: Int32Array;
  /** Its frequency residual squared, and that of its shape. */
  ofFrequency: Float64Array;
  ofShape: Float64Array;
  /** The sum of both over the test modes. */
  chiSquared: number;
  /** The frequency response that was asked for. */
  curve?: Curve;
}

/** Why there are no modes. */
export interface Unstable { unstable: true }

/** A mass, and a spring to the ground along each axis, that a reader puts at a node. */
export interface Extra { node: number; mass: number; stiffness: number }
/** Where the model is asked: all parameters, what has been put at nodes, and the hypotheses that are faults taken out of the test. */
export interface Point { theta: Float64Array; extras: Extra[]; faults?: number[] }

interface Term { powers: [number, number][]; stiffness: Float64Array | null; mass: Float64Array | null }

function triangle(m: LiveMatrix | undefined, n: number): Float64Array | null {
  if (!m) return null;
  if ("lower" in m) return doubles(m.lower);
  const sum = doubles(m.sum), out = new Float64Array((n * (n + 1)) / 2);
  for (let at = 0; at < sum.length; at += n + 1) {
    const d = sum[at]!;
    for (let i = 0, k = 0; i < n; i++) {
      const f = d * sum[at + 1 + i]!;
      if (f === 0) { k += i + 1; continue; }
      for (let j = 0; j <= i; j++) out[k++]! += f * sum[at + 1 + j]!;
    }
  }
  return out;
}

/** xᵀ A x of a lower triangle by rows. */
function quadratic(a: Float64Array, x: Float64Array): number {
  let s = 0;
  for (let i = 0, k = 0; i < x.length; i++) {
    let row = 0;
    for (let j = 0; j < i; j++) row += a[k++]! * x[j]!;
    s += x[i]! * (2 * row + a[k++]! * x[i]!);
  }
  return s;
}

export class LiveModel {
  private readonly terms: Term[];
  /** The test and the sensors as given, and as they are at the point that is asked for. */
  private readonly given: Seen;
  private seen: Seen;
  private readonly symmetry: { mirror: Float64Array; gram: Float64Array } | null;
  private readonly stiffness: Float64Array;
  private readonly mass: Float64Array;
  private readonly n: number;
  /** Motions of the nodes, a row of three a node for each coordinate. */
  private readonly nodes: Float32Array;

  constructor(private readonly live: Live) {
    const n = (this.n = live.n);
    this.terms = live.terms.map((t) => ({ powers: t.powers, stiffness: triangle(t.stiffness, n), mass: triangle(t.mass, n) }));
    this.nodes = floats(live.displacement);
    this.symmetry = live.symmetry ? { mirror: doubles(live.symmetry.mirror), gram: doubles(live.symmetry.gram) } : null;
    const test = live.test.map((m) => ({
      hz: m.frequency_hz, sd: m.frequency_sd, space: m.space ?? null, shape: doubles(m.shape), weight: doubles(m.shape_sd).map((s) => 1 / s),
      followed: doubles(m.followed), alone: m.followed_alone ?? false,
    }));
    this.given = this.seen = { test, sensors: doubles(live.sensors) };
    this.stiffness = new Float64Array((n * (n + 1)) / 2);
    this.mass = new Float64Array((n * (n + 1)) / 2);
  }

  /** How a node moves along an axis with each coordinate; its motion in a mode is the product with the shape. */
  motion(node: number, axis: number): Float64Array {
    const width = this.nodes.length / this.n;
    return Float64Array.from({ length: this.n }, (_, c) => this.nodes[c * width + 3 * node + axis] ?? 0);
  }

  /** K and M at a point, lower triangles by rows. */
  assemble({ theta, extras }: Point): { stiffness: Float64Array; mass: Float64Array } {
    this.stiffness.fill(0);
    this.mass.fill(0);
    for (const t of this.terms) {
      let c = 1;
      for (const [j, p] of t.powers) c *= theta[j]! ** p;
      if (c === 0) continue;
      for (const [from, into] of [[t.stiffness, this.stiffness], [t.mass, this.mass]] as const) {
        if (from) for (let k = 0; k < into.length; k++) into[k]! += c * from[k]!;
      }
    }
    for (const { node, mass, stiffness } of extras) {
      for (let axis = 0; axis < 3; axis++) {
        const d = this.motion(node, axis);
        for (let i = 0, k = 0; i < this.n; i++) {
          for (let j = 0; j <= i; j++, k++) {
            const f = d[i]! * d[j]!;
            this.mass[k]! += mass * f;
            this.stiffness[k]! += stiffness * f;
          }
        }
      }
    }
    return { stiffness: this.stiffness, mass: this.mass };
  }

  /**
   * The lowest elastic modes, and the rigid-body modes: M φ = ϑ (K + aM) φ with λ = 1/ϑ - a, so that massless coordinates and rigid-body motions need no case of
   * their own.
   */
  modes(at: Point, most = this.live.n_elastic): { hz: Float64Array; shapes: Float64Array[]; rigid: Float64Array[] } | Unstable {
    const { n, live } = this, a = live.shift;
    const { stiffness, mass } = this.assemble(at);
    const x = new Float64Array(n * n), m = new Float64Array(n * n);
    for (let i = 0, k = 0; i < n; i++) {
      for (let j = 0; j <= i; j++, k++) {
        x[i * n + j] = stiffness[k]! + a * mass[k]!;
        m[i * n + j] = m[j * n + i] = mass[k]!;
      }
    }
    if (!cholesky(x, n)) return { unstable: true };
    congruence(m, x, n);
    const values = new Float64Array(n), vectors = new Float64Array(n * n);
    if (!symmetricEigen(m, n, values, vectors)) return { unstable: true };
    // Motions that nothing strains come first, with a λ that is rounding.
    let rigid = 0;
    while (rigid < live.n_rigid && 1 / values[n - 1 - rigid]! - a < RIGID * a) rigid++;
    const shapeOf = (k: number): Float64Array => {
      const shape = vectors.slice(k * n, (k + 1) * n), scale = 1 / Math.sqrt(values[k]!);
      backward(x, n, shape);
      for (let i = 0; i < n; i++) shape[i]! *= scale;
      return shape;
    };
    const hz: number[] = [], shapes: Float64Array[] = [];
    for (let k = n - 1 - rigid; k >= 0 && hz.length < most; k--) {
      const inverse = values[k]!;
      if (inverse <= 1e-14 * values[n - 1]!) break;
      const lambda = 1 / inverse - a;
      // Below zero by more than rounding: the structure buckles or a size is out of reach.
      if (lambda < -1e-6 * a) return { unstable: true };
      shapes.push(shapeOf(k));
      hz.push(Math.sqrt(Math.max(lambda, 0)) / (2 * Math.PI));
    }
    return { hz: Float64Array.from(hz), shapes, rigid: Array.from({ length: rigid }, (_, k) => shapeOf(n - 1 - k)) };
  }

  private atSensors(shape: Float64Array): Float64Array {
    return Float64Array.from({ length: this.seen.sensors.length / this.n }, (_, s) => this.reads(s, shape));
  }

  private family(shape: Float64Array): string | null {
    if (!this.symmetry) return null;
    const index = quadratic(this.symmetry.mirror, shape) / quadratic(this.symmetry.gram, shape);
    return index > SYMMETRIC ? "symmetric" : index < -SYMMETRIC ? "antisymmetric" : null;
  }

  /** Residuals of frequencies, then of shapes mode by mode, each over its standard deviation; null where there are no modes. */
  residuals(at: Point): Float64Array | null {
    const p = this.predict(at);
    if ("unstable" in p) return null;
    const m = this.seen.test.length, n = this.seen.sensors.length / this.n, out = new Float64Array(m * (n + 1));
    this.seen.test.forEach((t, j) => {
      const i = p.partner[j]!, isAside = this.live.test[j]!.plan === "aside";
      if (isAside) return;
      out[j] = i < 0 ? NO_PARTNER : (p.hz[i]! - t.hz) / t.sd;
      if (i < 0 || !t.shape.length) return;
      const phi = p.atSensors[i]!, c = shapeScale(phi, t.shape, t.weight);
      for (let k = 0; k < n; k++) if (!Number.isNaN(t.shape[k])) out[m + j * n + k] = (c * phi[k]! - t.shape[k]!) * t.weight[k]!;
    });
    return out;
  }

  /** What a sensor reads of a shape. */
  private reads(sensor: number, shape: Float64Array): number {
    let sum = 0;
    for (let i = 0; i < this.n; i++) sum += this.seen.sensors[sensor * this.n + i]! * shape[i]!;
    return sum;
  }

  /** Takes the faults of a point out of the test. */
  private look({ theta, faults }: Point): void {
    this.seen = (faults ?? []).reduce((seen, i) => {
      const h = this.live.hypotheses[i], g = h?.sizes[0];
      return h?.test ? edited(seen, h.test, g == null ? 1 : theta[g]!) : seen;
    }, this.given);
  }

  /** MAC of the modes with the test modes, a row for each mode, and the partner of each test mode. */
  private pairs(hz: Float64Array, all: Float64Array[], shapes: Float64Array[], families: (string | null)[]): { mac: Float64Array; partner: Int32Array } {
    const atSensors = seen(all), m = this.seen.test.length, mac = new Float64Array(hz.length * m), likeness = new Float64Array(hz.length * m);
    for (let i = 0; i < hz.length; i++) {
      this.seen.test.forEach((t, j) => {
        const own = assurance(atSensors[i]!, t.shape);
        mac[i * m + j] = own;
        likeness[i * m + j] = own;
        if (!t.followed.length) return;
        let product = 0;
        for (let k = 0; k < this.n; k++) product += t.followed[k]! * shapes[i]![k]!;
        const same = Math.min(product * product, 1);
        likeness[i * m + j] = t.alone ? same : 0.5 * (own + same);
      });
    }
    const partner = pair(likeness, { frequencies: hz, families }, { frequencies: this.seen.test.map((t) => t.hz), families: this.live.test.map((t) => t.family ?? null) },
      this.live.pairing, this.live.test.map((t) => t.plan));
    return { mac, partner };
  }

  /** Everything that the page shows at a point; with a line, the frequency response along it by the sum of all modes. */
  predict(at: Point, line?: Line): Prediction | Unstable {
    const found = this.modes(at, line ? this.n : this.live.n_elastic);
    if ("unstable" in found) return found;
    this.look(at);
    const m = this.seen.test.length, few = this.live.n_elastic;
    // Before close modes are turned: a sum over modes wants them as they are.
    const residue = (shape: Float64Array): number => this.reads(line!.response, shape) * this.reads(line!.reference, shape);
    const summands = line && { rigid: found.rigid.map(residue), elastic: found.shapes.map(residue), hz: found.hz };
    const hz = found.hz.subarray(0, few), shapes = found.shapes.slice(0, few);
    let atSensors = shapes.map((s) => this.atSensors(s));
    let families = shapes.map((s) => this.family(s));
    const tests = this.seen.test, hasShapes = tests.some((t) => t.shape.length > 0);
    const close = clusters(hz, tests.map((t) => t.hz), hasShapes, (i, j) => families[i] === families[j]);
    if (hasShapes && close.length) {
      for (const cluster of close) turn(cluster, atSensors, shapes, tests);
      families = shapes.map((s) => this.family(s));
    }
    let { mac, partner } = this.pairs(hz, atSensors, shapes, families);
    // Modes of one space have their partners by the shapes as they are, and are turned then.
    const spaces = [...new Set(tests.flatMap((t) => (t.space != null && t.shape.length ? [t.space] : [])))];
    for (const space of spaces) {
      const own = tests.flatMap((t, j) => (t.space === space && t.shape.length ? [j] : []));
      if (own.length < 2) continue;
      const partners = own.flatMap((j) => (partner[j]! < 0 ? [] : [partner[j]!])), shared = close.filter((c) => c.some((k) => partners.includes(k)));
      const cluster = [...new Set([...partners, ...shared.flat()])].sort((a, b) => a - b);
      turn(cluster, atSensors, shapes, tests.map((t, j) => (own.includes(j) ? t : { shape: new Float64Array(), weight: t.weight })));
    }
    if (spaces.length) {
      families = shapes.map((s) => this.family(s));
      ({ mac, partner } = this.pairs(hz, atSensors, shapes, families));
    }
    atSensors = seen(atSensors);
    const ofFrequency = new Float64Array(m), ofShape = new Float64Array(m);
    this.seen.test.forEach((t, j) => {
      const i = partner[j]!;
      if (i < 0) {
        ofFrequency[j] = this.live.test[j]!.plan === "aside" ? 0 : NO_PARTNER ** 2;
        return;
      }
      ofFrequency[j] = ((hz[i]! - t.hz) / t.sd) ** 2;
      ofShape[j] = this.live.test[j]!.plan === "aside" ? 0 : shapeMisfit(atSensors[i]!, t.shape, t.weight);
    });
    const chiSquared = ofFrequency.reduce((s, v, j) => s + v + ofShape[j]!, 0);
    const out: Prediction = { hz: hz.slice(), shapes, atSensors, families, mac, partner, ofFrequency, ofShape, chiSquared };
    if (line && summands) {
      const damping = Float64Array.from(summands.hz, () => this.live.damping);
      this.live.test.forEach((t, j) => { if (t.damping != null && partner[j]! >= 0) damping[partner[j]!] = t.damping; });
      out.curve = curve(summands, damping, line);
    }
    return out;
  }
}

/** MAC of two shapes at the sensors that measured both; 0 without a shape. */
export function assurance(a: Float64Array, x: Float64Array): number {
  let cross = 0, na = 0, nx = 0;
  for (let k = 0; k < x.length; k++) {
    const p = a[k]!, q = x[k]!;
    if (Number.isNaN(p) || Number.isNaN(q)) continue;
    cross += p * q;
    na += p * p;
    nx += q * q;
  }
  return na > 0 && nx > 0 ? Math.min((cross * cross) / na / nx, 1) : 0;
}

/** Shapes at the sensors, zero where no sensor sees a mode. */
function seen(atSensors: Float64Array[]): Float64Array[] {
  const norms = atSensors.map((s) => s.reduce((sum, v) => sum + v * v, 0)), least = UNSEEN ** 2 * Math.max(0, ...norms);
  return atSensors.map((s, i) => (norms[i]! < least ? new Float64Array(s.length) : s));
}

/** The scale c of a shape with the least Σ ((c φ - t)/σ)². */
function shapeScale(phi: Float64Array, test: Float64Array, weight: Float64Array): number {
  let cross = 0, own = 0;
  for (let k = 0; k < test.length; k++) {
    if (Number.isNaN(test[k])) continue;
    const w = weight[k]! ** 2;
    cross += w * phi[k]! * test[k]!;
    own += w * phi[k]! * phi[k]!;
  }
  return own > 0 ? cross / own : 0;
}

/** Σ ((c φ - t)/σ)² with that scale. */
function shapeMisfit(phi: Float64Array, test: Float64Array, weight: Float64Array): number {
  const c = shapeScale(phi, test, weight);
  let sum = 0;
  for (let k = 0; k < test.length; k++) if (!Number.isNaN(test[k])) sum += ((c * phi[k]! - test[k]!) * weight[k]!) ** 2;
  return sum;
}
