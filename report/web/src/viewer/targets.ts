/** Everything of a picture that a pointer can hit, where it is on the screen now. */

import type { Flat, Target } from "../pick";
import type { Structure, Vec3 } from "../types";
import type { Layer } from "../viewer";
import type { Sensed } from "./sensed";
import type { Skeleton } from "./skeleton";

export interface Held { kind: "support" | "element"; index: number; node: number }
export interface Sight {
  data: Structure; skeleton: Skeleton; sensed: Sensed; layers: Record<Layer, boolean>; held: readonly Held[];
  /** Where points and sensors are, three numbers each. */
  now: Float32Array; sensorBase: Float32Array;
  /** Half-diagonal, the axis that points up, and how far the middle of a foot is below its node. */
  radius: number; up: number; footSize: number;
  /** From the structure to -1 ... 1 on the screen, by columns, and the size of the screen. */
  matrix: ArrayLike<number>; width: number; height: number;
}
/** Where to look: what is farther away is passed over. */
export interface Near { x: number; y: number; reach: number }

/** x, y and depth on the screen of points, three numbers each. */
function projected({ matrix: m, width, height }: Sight, points: Float32Array): Float32Array {
  const out = new Float32Array(points.length);
  for (let i = 0; i < points.length; i += 3) {
    const x = points[i]!, y = points[i + 1]!, z = points[i + 2]!;
    const w = 1 / (m[3]! * x + m[7]! * y + m[11]! * z + m[15]!);
    out[i] = (((m[0]! * x + m[4]! * y + m[8]! * z + m[12]!) * w + 1) / 2) * width;
    out[i + 1] = ((1 - (m[1]! * x + m[5]! * y + m[9]! * z + m[13]!) * w) / 2) * height;
    out[i + 2] = (m[2]! * x + m[6]! * y + m[10]! * z + m[14]!) * w;
  }
  return out;
}

/** Where one point is on the screen. */
export function flat(s: Sight, point: readonly number[]): Flat {
  const [x, y, depth] = projected(s, Float32Array.from(point)) as unknown as [number, number, number];
  return { x, y, depth };
}

export function* targets(s: Sight, near?: Near): Generator<Target> {
  const { data, skeleton, layers: l, radius } = s;
  const points = projected(s, s.now);
  const at = (a: Float32Array, i: number): Flat => ({ x: a[3 * i]!, y: a[3 * i + 1]!, depth: a[3 * i + 2]! });
  const far = (i: number): boolean => near != null && (Math.abs(points[3 * i]! - near.x) > near.reach || Math.abs(points[3 * i + 1]! - near.y) > near.reach);
  /** Whether all points of a list are on one side of where the pointer is. */
  const beside = (nodes: Int32Array | readonly number[], from: number, to: number): boolean => {
    if (!near) return false;
    let left = true, right = true, above = true, below = true;
    for (let k = from; k < to; k++) {
      const x = points[3 * nodes[k]!]! - near.x, y = points[3 * nodes[k]! + 1]! - near.y;
      left &&= x < -near.reach;
      right &&= x > near.reach;
      above &&= y < -near.reach;
      below &&= y > near.reach;
    }
    return left || right || above || below;
  };
  if (l.sensors || l.test) {
    const { now, wire } = s.sensed, seen = projected(s, l.test ? now : s.sensorBase);
    for (let i = 0; i < data.sensors.length; i++) yield { kind: "sensor", index: i, points: [at(seen, l.test ? wire.of[i]! : i)] };
  }
  if (l.sensors) for (const [i, e] of data.exciters.entries()) {
    const tip = e.position.map((p, k) => p + (e.direction[k]! * radius * 0.14) / (Math.hypot(...e.direction) || 1)) as Vec3;
    yield { kind: "exciter", index: i, points: [flat(s, tip)] };
  }
  if (l.masses) for (const [i, m] of data.masses.entries()) {
    if (m.node >= data.nodes.length) continue;
    const p = 3 * m.node, o = m.offset ?? [0, 0, 0];
    if (Math.hypot(...o) > 0) yield { kind: "mass", index: i, points: [flat(s, [s.now[p]! + o[0], s.now[p + 1]! + o[1], s.now[p + 2]! + o[2]])] };
  }
  if (l.supports) for (const { kind, index, node } of s.held) {
    const p = skeleton.node(node);
    p[s.up]! -= 1.7 * s.footSize;
    yield { kind, index, points: [flat(s, p)] };
  }
  if (l.nodes) for (let i = 0; i < data.nodes.length; i++) if (!far(i)) yield { kind: "node", index: i, points: [at(points, i)] };
  if (l.elements) {
    for (const { element, first, nodes: [a, b] } of skeleton.beams) {
      const chain = [a, ...Array.from({ length: skeleton.pieces - 1 }, (_, k) => first + k), b];
      if (!beside(chain, 0, chain.length)) yield { kind: "element", index: element, points: chain.map((i) => at(points, i)) };
    }
    const { nodes, first, element } = skeleton.faces;
    for (let f = 0; f < element.length; f++) {
      if (beside(nodes, first[f]!, first[f + 1]!)) continue;
      yield { kind: "element", index: element[f]!, points: Array.from(nodes.subarray(first[f]!, first[f + 1]!), (i) => at(points, i)), closed: true };
    }
  }
  if (l.links) for (const [a, b, link] of skeleton.linkPairs) yield { kind: "link", index: link, points: [at(points, a), at(points, b)] };
}
