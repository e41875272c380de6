/** What the page asks its model, and what it is answered. */

import { fitStep, type FitStep } from "./fit";
import type { LiveModel, Point, Prediction, Unstable } from "./model";

/** What a fit may move, and how carefully it steps. */
export interface FitQuestion { free: number[]; ranges: [number, number][]; damping: number }

/**
 * A point, and those on the way to it of which only χ² is wanted; or a step of a fit from there, of which the
 * prediction is told.
 */
export interface Question { id: number; at: Point; way: Point[]; fit?: FitQuestion | undefined }
export interface Answer { id: number; prediction: Prediction | Unstable; way: (number | null)[]; milliseconds: number; fit?: FitStep | undefined }

export function answer(model: LiveModel, { id, at, way, fit }: Question): Answer {
  const step = fit && fitStep(model, at, fit.free, fit.ranges, fit.damping);
  const start = performance.now();
  const prediction = model.predict(step ? { theta: step.theta, extras: at.extras } : at);
  const milliseconds = performance.now() - start;
  const chi = (point: Point): number | null => {
    const p = model.predict(point);
    return "unstable" in p ? null : p.chiSquared;
  };
  return { id, prediction, way: way.map(chi), milliseconds, fit: step };
}
