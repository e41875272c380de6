/** The points where a test has sensors: what several channels of one point read together, and lines between the points. */

import type { Shape } from "../shape";
import type { Sensor } from "../types";

/** Up to as many points lines follow the relative neighbourhood; beyond, the shortest tree. */
const MOST = 300;
/** Channels of one point are as near as this part of the size of all. */
const SAME = 1e-6;
/** The part of a direction across those before it, below which a channel of the same point tells nothing new. */
const ACROSS = 0.1;

export class Wire {
  /** Point of every sensor. */
  readonly of: number[] = [];
  /** Sensors of every point. */
  readonly sensors: number[][] = [];
  /** Where the points are, three numbers each. */
  readonly base: Float32Array;
  /** Points that a line joins. */
  readonly pairs: [number, number][];

  /** * `lines` - sensors that the test itself joins; without them neighbours are joined */
  constructor(private readonly data: readonly Sensor[], lines: readonly number[][]) {
    const size = data.reduce((m, s) => Math.max(m, ...s.position.map(Math.abs)), 0) || 1, known = new Map<string, number>();
    const at: number[] = [];
    data.forEach((s, i) => {
      const key = s.position.map((v) => Math.round(v / (SAME * size))).join(" ");
      const point = known.get(key) ?? this.sensors.length;
      if (point === this.sensors.length) {
        known.set(key, point);
        this.sensors.push([]);
        at.push(...s.position);
      }
      this.sensors[point]!.push(i);
      this.of.push(point);
    });
    this.base = Float32Array.from(at);
    this.pairs = lines.length ? joined(lines, this.of) : neighbours(at);
  }

  get count(): number {
    return this.sensors.length;
  }

  /**
   * The motion of the points, three entries each, from what the sensors read: along the directions of their channels, zero across them. A
   * reading along d that stands on others counts with the part of d that is new.
   */
  motion(readings: Shape): Shape {
    const along = (values: Float32Array): Float32Array => {
      const out = new Float32Array(3 * this.count);
      this.sensors.forEach((all, point) => {
        const axes: { e: number[]; c: number }[] = [];
        for (const i of all) {
          const s = this.data[i]!, v = values[i] ?? NaN;
          if (s.is_rotation || !Number.isFinite(v)) continue;
          const e = [...s.direction];
          let rest = v;
          for (const known of axes) {
            const f = s.direction.reduce((sum, d, k) => sum + d * known.e[k]!, 0);
            rest -= f * known.c;
            for (let k = 0; k < 3; k++) e[k]! -= f * known.e[k]!;
          }
          const length = Math.hypot(...e);
          if (length < ACROSS) continue;
          axes.push({ e: e.map((x) => x / length), c: rest / length });
        }
        for (const { e, c } of axes) for (let k = 0; k < 3; k++) out[3 * point + k]! += c * e[k]!;
      });
      return out;
    };
    return { re: along(readings.re), im: readings.im ? along(readings.im) : undefined };
  }
}

function joined(lines: readonly number[][], of: number[]): [number, number][] {
  const pairs: [number, number][] = [];
  for (const line of lines) {
    for (let k = 1; k < line.length; k++) {
      const a = of[line[k - 1]!], b = of[line[k]!];
      if (a != null && b != null && a !== b) pairs.push([a, b]);
    }
  }
  return pairs;
}

/**
 * Points to join where the test says nothing: p and q where no third point is nearer to both than they are to each other. Such a graph
 * holds together, and of a grid it has the edges of the cells. (G. T. Toussaint, The relative neighbourhood graph of a finite planar
 * set, Pattern Recognition 12 (1980) 261-268.)
 */
export function neighbours(at: readonly number[]): [number, number][] {
  const n = at.length / 3, pairs: [number, number][] = [];
  const apart = (i: number, j: number): number => Math.hypot(at[3 * i]! - at[3 * j]!, at[3 * i + 1]! - at[3 * j + 1]!, at[3 * i + 2]! - at[3 * j + 2]!);
  if (n > MOST) return tree(n, apart);
  for (let i = 0; i < n; i++) {
    for (let j = 0; j < i; j++) {
      const d = apart(i, j) * (1 - 1e-6);
      let free = true;
      for (let k = 0; free && k < n; k++) free = k === i || k === j || Math.max(apart(i, k), apart(j, k)) >= d;
      if (free) pairs.push([j, i]);
    }
  }
  return pairs;
}

/** The shortest tree through all points (R. C. Prim, Bell System Technical Journal 36 (1957) 1389-1401). */
function tree(n: number, apart: (i: number, j: number) => number): [number, number][] {
  const from = new Int32Array(n), near = new Float64Array(n).fill(Infinity), inside = new Uint8Array(n), pairs: [number, number][] = [];
  let last = 0;
  inside[0] = 1;
  for (let step = 1; step < n; step++) {
    let next = -1;
    for (let k = 0; k < n; k++) {
      if (inside[k]) continue;
      const d = apart(last, k);
      if (d < near[k]!) { near[k] = d; from[k] = last; }
      if (next < 0 || near[k]! < near[next]!) next = k;
    }
    inside[next] = 1;
    pairs.push([from[next]!, next]);
    last = next;
  }
  return pairs;
}
