/** What the page asks its model, and what it is answered. */

import { fitStep, type FitStep } from "./fit";
import type { LiveModel, Point, Prediction, Unstable } from "./model";
import type { Curve, Line } from "./response";

/** What a fit may move, and how carefully it steps. */
export interface FitQuestion { free: number[]; ranges: [number, number][]; damping: number }

/**
 * A point, and those on the way to it of which only χ² is wanted; or a step of a fit from there, of which the
 * prediction is told. `track` are points at which the partners of the test modes are wanted; `line` is a frequency response that is wanted at the point
 * and at `base`.
 */
export interface Question { id: number; at: Point; way: Point[]; fit?: FitQuestion | undefined; track?: Point[] | undefined; line?: Line | undefined; base?: Point | undefined }
/** The partner of each test mode at one point: its number, frequency and MAC; a number below 0 where there is none. */
export interface Partners { partner: Int32Array; hz: Float64Array; mac: Float64Array }
export interface Answer {
  id: number; prediction: Prediction | Unstable; way: (number | null)[]; milliseconds: number; fit?: FitStep | undefined;
  track?: (Partners | null)[] | undefined; base?: Curve | undefined;
}

export function answer(model: LiveModel, { id, at, way, fit, track, line, base }: Question): Answer {
  const step = fit && fitStep(model, at, fit.free, fit.ranges, fit.damping);
  const start = performance.now();
  const prediction = model.predict(step ? { ...at, theta: step.theta } : at, line);
  const milliseconds = performance.now() - start;
  const chi = (point: Point): number | null => {
    const p = model.predict(point);
    return "unstable" in p ? null : p.chiSquared;
  };
  const partners = (point: Point): Partners | null => {
    const p = model.predict(point);
    if ("unstable" in p) return null;
    const m = p.partner.length, of = (f: (i: number, j: number) => number): Float64Array => Float64Array.from(p.partner, (i, j) => (i < 0 ? NaN : f(i, j)));
    return { partner: p.partner, hz: of((i) => p.hz[i]!), mac: of((i, j) => p.mac[i * m + j]!) };
  };
  const reported = base && line ? model.predict(base, line) : null;
  return { id, prediction, way: way.map(chi), milliseconds, fit: step, track: track?.map(partners), base: reported && !("unstable" in reported) ? reported.curve : undefined };
}
