/** A camera that turns about a point: pure arithmetic, no library. */

export type Point = [number, number, number];
export interface Orbit { azimuth: number; elevation: number; distance: number; target: Point }

export const VIEWS: Record<string, { azimuth: number; elevation: number; text: string }> = {
  iso: { azimuth: -0.9, elevation: 0.55, text: "Oblique" },
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
