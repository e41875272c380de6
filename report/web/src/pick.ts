/** What lies under the pointer, decided on the screen: forgiving for thin lines and small dots, exact to test. */

export interface Flat { x: number; y: number; depth: number }
export type Kind = "node" | "element" | "sensor" | "mass" | "exciter" | "support" | "link";
export interface Target { kind: Kind; index: number; points: Flat[]; closed?: boolean }
export interface Hit { kind: Kind; index: number; distance: number }

/** Distance from a point to a segment on the screen. */
export function segmentDistance(x: number, y: number, a: Flat, b: Flat): number {
  const dx = b.x - a.x, dy = b.y - a.y;
  const square = dx * dx + dy * dy;
  const t = square > 0 ? Math.min(1, Math.max(0, ((x - a.x) * dx + (y - a.y) * dy) / square)) : 0;
  return Math.hypot(x - a.x - t * dx, y - a.y - t * dy);
}

/** Whether a point is inside a polygon on the screen (even-odd rule). */
export function inside(x: number, y: number, polygon: Flat[]): boolean {
  let odd = false;
  for (let i = 0, j = polygon.length - 1; i < polygon.length; j = i++) {
    const a = polygon[i]!, b = polygon[j]!;
    if (a.y > y !== b.y > y && x < ((b.x - a.x) * (y - a.y)) / (b.y - a.y) + a.x) odd = !odd;
  }
  return odd;
}

/** Points first, then lines, then faces: what is smaller is harder to hit. */
const EASE: Record<Kind, number> = { sensor: 0, exciter: 0, mass: 1, support: 1, node: 2, element: 5, link: 6 };

/** The nearest target within `reach` pixels. */
export function pick(x: number, y: number, targets: Iterable<Target>, reach = 11): Hit | null {
  let best: Hit | null = null;
  let bestRank = Infinity;
  for (const { kind, index, points, closed } of targets) {
    if (points.some((p) => !(Math.abs(p.depth) <= 1))) continue;
    let distance = Infinity;
    if (points.length === 1) distance = Math.hypot(x - points[0]!.x, y - points[0]!.y);
    else if (closed && inside(x, y, points)) distance = reach * 0.5;
    else for (let i = 1; i < points.length; i++) distance = Math.min(distance, segmentDistance(x, y, points[i - 1]!, points[i]!));
    const rank = distance + EASE[kind];
    if (distance <= reach && rank < bestRank) {
      best = { kind, index, distance };
      bestRank = rank;
    }
  }
  return best;
}
