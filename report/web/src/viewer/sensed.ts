/** The shape of the test as a wireframe of its sensors, in motion. */

import type { Object3D } from "three";
import type { Rgb } from "../color";
import { Lines } from "../lines";
import { atPhase, type Shape } from "../shape";
import type { Structure } from "../types";
import { Dots } from "./dots";
import { Wire } from "./wire";

/** The colour of a point by the sensors that it has. */
export type PointPainter = (sensors: readonly number[]) => Rgb | null;

export class Sensed {
  readonly wire: Wire;
  /** Where the points are now. */
  readonly now: Float32Array;
  private readonly dots: Dots;
  private readonly lines: Lines;
  private readonly shift: Float32Array;
  private shape: Shape | null = null;

  constructor(data: Structure) {
    this.wire = new Wire(data.sensors, data.trace_lines);
    this.now = this.wire.base.slice();
    this.shift = new Float32Array(this.now.length);
    this.dots = new Dots(this.wire.count, 9);
    this.lines = new Lines(this.wire.pairs.length, 3);
  }

  get objects(): Object3D[] {
    return [this.lines.object, this.dots.object];
  }

  /** What the sensors read, or nothing. */
  set(readings: Shape | null): void {
    this.shape = readings && this.wire.motion(readings);
  }

  show(on: boolean): void {
    this.dots.object.visible = on;
    this.lines.object.visible = on && this.lines.count > 0;
  }

  /** Moves the points to a phase, rad; the largest reading moves by `world` metres where the shape has largest 1. */
  place(phase: number, world: number): void {
    if (this.shape) atPhase(this.shape, phase, world, this.shift);
    else this.shift.fill(0);
    for (let i = 0; i < this.now.length; i++) this.now[i] = this.wire.base[i]! + this.shift[i]!;
    this.dots.positions.set(this.now);
    this.dots.moved();
    this.wire.pairs.forEach(([a, b], i) => {
      this.lines.positions.set(this.now.subarray(3 * a, 3 * a + 3), 6 * i);
      this.lines.positions.set(this.now.subarray(3 * b, 3 * b + 3), 6 * i + 3);
    });
    this.lines.moved();
  }

  paint(painter: PointPainter, plain: Rgb): void {
    const of = (point: number): Rgb => painter(this.wire.sensors[point]!) ?? plain;
    this.dots.paint(of);
    this.lines.paint((i, end) => of(this.wire.pairs[i]![end]));
  }
}
