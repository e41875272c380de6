/** A camera that turns about a point: pure arithmetic, no library. */

export type Point = [number, number, number];
export interface Orbit { azimuth: number; elevation: number; distance: number; target: Point }

export const VIEWS: Record<string, { azimuth: number; elevation: number; text: string }> = {
  iso: { azimuth: -1.2, elevation: 0.62, text: "Oblique" },
  top: { azimuth: -Math.PI / 2, elevation: Math.PI / 2 - 1e-4, text: "Top" },
  front: { azimuth: -Math.PI / 2, elevation: 0, text: "Front" },
  side: { azimuth: 0, elevation: 0, text: "Side" },
};

/** Turns by pixels of a drag. */
export function turn(orbit: Orbit, dx: number, dy: number): Orbit {
  const limit = Math.PI / 2 - 1e-4;
  return {
    ...orbit,
    azimuth: orbit.azimuth - dx * 0.008,
    elevation: Math.min(limit, Math.max(-limit, orbit.elevation + dy * 0.008)),
  };
}

/** Moves closer (factor below 1) or away, within limits of the model's size. */
export function zoom(orbit: Orbit, factor: number, size: number): Orbit {
  return { ...orbit, distance: Math.min(size * 20, Math.max(size * 0.02, orbit.distance * factor)) };
}

/** The axes in the order (right-handed) that puts `up` last. */
export function axes(up: number): [number, number, number] {
  return up === 0 ? [1, 2, 0] : up === 1 ? [2, 0, 1] : [0, 1, 2];
}

/** Azimuth of the oblique view: the longer horizontal extent runs across the picture. */
export function across(points: readonly (readonly number[])[], up: number): number {
  const [a, b] = axes(up).map((k) => {
    const on = points.map((p) => p[k]!).filter(Number.isFinite);
    return on.reduce((x, y) => Math.max(x, y), -Infinity) - on.reduce((x, y) => Math.min(x, y), Infinity);
  });
  return VIEWS["iso"]!.azimuth + (b! > a! ? Math.PI / 2 : 0);
}

/** Where the camera stands. */
export function eye(orbit: Orbit, up: number): Point {
  const [a, b, c] = axes(up);
  const flat = Math.cos(orbit.elevation) * orbit.distance;
  const point: Point = [...orbit.target];
  point[a]! += flat * Math.cos(orbit.azimuth);
  point[b]! += flat * Math.sin(orbit.azimuth);
  point[c]! += Math.sin(orbit.elevation) * orbit.distance;
  return point;
}

/** Half of the vertical field of view of the camera, rad. */
export const HALF_VIEW = Math.PI / 12;

/**
 * The orbit that shows all points from the direction of `orbit`, centred, in `fill` of a picture of this aspect ratio
 * (width over height): two rounds of centring, because perspective moves the centre with the distance.
 */
export function fit(orbit: Orbit, points: readonly (readonly number[])[], up: number, aspect: number, fill = 0.84): Orbit {
  if (points.length === 0) return orbit;
  const [i, j, k] = axes(up);
  const [ca, sa, ce, se] = [Math.cos(orbit.azimuth), Math.sin(orbit.azimuth), Math.cos(orbit.elevation), Math.sin(orbit.elevation)];
  const basis = (a: number, b: number, c: number): Point => {
    const v: Point = [0, 0, 0];
    v[i] = a; v[j] = b; v[k] = c;
    return v;
  };
  const right = basis(-sa, ca, 0), upward = basis(-se * ca, -se * sa, ce), toward = basis(ce * ca, ce * sa, se);
  const dot = (p: readonly number[], v: Point): number => p[0]! * v[0] + p[1]! * v[1] + p[2]! * v[2];
  const tall = Math.tan(HALF_VIEW) * fill, wide = tall * aspect;
  let { target, distance } = orbit;
  for (let round = 0; round < 3; round++) {
    const seen = points.map((p) => {
      const q = p.map((v, n) => v - target[n]!);
      return [dot(q, right), dot(q, upward), dot(q, toward)] as const;
    });
    distance = seen.reduce((d, [x, y, z]) => Math.max(d, Math.abs(x) / wide + z, Math.abs(y) / tall + z), 1e-9);
    if (round === 2) break;
    const middle = (n: 0 | 1): number => {
      const on = seen.map((q) => q[n] / Math.max(distance - q[2], 1e-9));
      return ((on.reduce((a, b) => Math.min(a, b)) + on.reduce((a, b) => Math.max(a, b))) / 2) * distance;
    };
    const [x, y] = [middle(0), middle(1)];
    target = target.map((v, n) => v + x * right[n]! + y * upward[n]!) as Point;
  }
  return { ...orbit, target, distance: distance * 1.0001 };
}

/** Up to as many points a cloud is its own outline. */
const FEW = 1000;
/** Directions in which the outermost points of a cloud are looked for, 7 degrees apart. */
const DIRECTIONS = 800;

/** The outermost points of a cloud in directions all around (a spiral of equal areas): what a picture of it must show. */
export function extremes(points: readonly (readonly number[])[]): readonly (readonly number[])[] {
  if (points.length <= FEW) return points;
  const sampled = points.length > 20 * FEW ? points.filter((_, i) => i % 8 === 0) : points, found = new Set<readonly number[]>();
  // The coordinate axes see every point: along them the outermost must not be missed.
  for (const k of [0, 1, 2]) for (const sign of [1, -1]) found.add(points.reduce((a, b) => (sign * b[k]! > sign * a[k]! ? b : a)));
  for (let d = 0; d < DIRECTIONS; d++) {
    const z = 1 - (2 * d + 1) / DIRECTIONS, r = Math.sqrt(1 - z * z), turned = d * Math.PI * (3 - Math.sqrt(5));
    const x = r * Math.cos(turned), y = r * Math.sin(turned);
    let best = sampled[0]!, most = -Infinity;
    for (const p of sampled) {
      const far = x * p[0]! + y * p[1]! + z * p[2]!;
      if (far > most) { most = far; best = p; }
    }
    found.add(best);
  }
  return [...found];
}

/** Centre and half-diagonal of a cloud of points. */
export function extent(points: Iterable<readonly number[]>): { centre: Point; radius: number } {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  let any = false;
  for (const p of points) {
    any = true;
    for (let k = 0; k < 3; k++) {
      low[k] = Math.min(low[k]!, p[k]!);
      high[k] = Math.max(high[k]!, p[k]!);
    }
  }
  if (!any) return { centre: [0, 0, 0], radius: 1 };
  const centre = low.map((l, k) => (l + high[k]!) / 2) as Point;
  return { centre, radius: Math.hypot(...low.map((l, k) => high[k]! - l)) / 2 || 1 };
}
