/** The lines that are drawn on a surface: all edges of few faces; of many those at which it ends, folds or changes hands. */

import type { Faces, Segments } from "./skeleton";

/** Up to as many faces every edge is drawn. */
const FEW = 4000;
/** Faces whose normals are farther apart than this meet in a fold: cos 30 degrees. */
const FOLD = Math.cos(Math.PI / 6);

/**
 * Edges of faces, each once.
 *
 * * `at` - positions of the nodes, three numbers each
 * * `group` - of a face
 */
export function edges({ nodes, first, element }: Faces, at: Float32Array, nNodes: number, group: (face: number) => string): Segments {
  const n = element.length, most = nodes.length;
  // Edges from their lower node, in lists: `head` of a node, then `next`.
  const head = new Int32Array(nNodes).fill(-1), next = new Int32Array(most), upper = new Int32Array(most), lower = new Int32Array(most);
  const face = new Int32Array(most), other = new Int32Array(most).fill(-1), uses = new Uint8Array(most);
  let count = 0;
  for (let f = 0; f < n; f++) {
    const from = first[f]!, to = first[f + 1]!;
    for (let k = from; k < to; k++) {
      const a = nodes[k]!, b = nodes[k + 1 < to ? k + 1 : from]!, low = Math.min(a, b), high = Math.max(a, b);
      let e = head[low]!;
      while (e >= 0 && upper[e] !== high) e = next[e]!;
      if (e < 0) {
        e = count++;
        [lower[e], upper[e], face[e], next[e]] = [low, high, f, head[low]!];
        head[low] = e;
      } else if (other[e]! < 0) other[e] = f;
      uses[e] = Math.min(3, uses[e]! + 1);
    }
  }
  const isFew = n <= FEW, normals = isFew ? null : normalsOf({ nodes, first, element }, at);
  const apart = (f: number, g: number): boolean => {
    const dot = normals![3 * f]! * normals![3 * g]! + normals![3 * f + 1]! * normals![3 * g + 1]! + normals![3 * f + 2]! * normals![3 * g + 2]!;
    // Neighbours may be turned over.
    return Math.abs(dot) < FOLD;
  };
  const ends: number[] = [], of: number[] = [];
  for (let e = 0; e < count; e++) {
    const f = face[e]!, g = other[e]!;
    if (!isFew && uses[e] === 2 && !apart(f, g) && group(f) === group(g)) continue;
    ends.push(lower[e]!, upper[e]!);
    of.push(element[f]!);
  }
  return { ends: Int32Array.from(ends), element: Int32Array.from(of) };
}

/** Unit normals of faces (M. E. Newell: of a polygon that need not be plane). */
function normalsOf({ nodes, first, element }: Faces, at: Float32Array): Float32Array {
  const out = new Float32Array(3 * element.length);
  for (let f = 0; f < element.length; f++) {
    let x = 0, y = 0, z = 0;
    for (let k = first[f]!, to = first[f + 1]!; k < to; k++) {
      const a = 3 * nodes[k]!, b = 3 * nodes[k + 1 < to ? k + 1 : first[f]!]!;
      x += (at[a + 1]! - at[b + 1]!) * (at[a + 2]! + at[b + 2]!);
      y += (at[a + 2]! - at[b + 2]!) * (at[a]! + at[b]!);
      z += (at[a]! - at[b]!) * (at[a + 1]! + at[b + 1]!);
    }
    const length = Math.hypot(x, y, z) || 1;
    out.set([x / length, y / length, z / length], 3 * f);
  }
  return out;
}
