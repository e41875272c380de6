/** The test as it would be without faults of the measurement. */

import { doubles } from "../decode";
import type { LiveEntries, LiveTestEdit } from "../types";

/** What the page compares with. */
export interface Seen { test: SeenMode[]; sensors: Float64Array }
export interface SeenMode { hz: number; sd: number; space: string | null; shape: Float64Array; weight: Float64Array; followed: Float64Array; alone: boolean }

/** Calls `set` with each entry and its value at the number g. */
function each(entries: LiveEntries, isAngle: boolean, g: number, set: (k: number, value: number) => void): void {
  const v = doubles(entries.values), forms = isAngle ? [1, Math.cos(g), Math.sin(g)] : [1, g, 1 / g];
  entries.at.forEach((k, i) => set(k, v[3 * i]! + (v[3 * i + 1]! ? v[3 * i + 1]! * forms[1]! : 0) + (v[3 * i + 2]! ? v[3 * i + 2]! * forms[2]! : 0)));
}

/** The test without one more fault of number g. Entries that two faults change are those of the last. */
export function edited({ test, sensors }: Seen, edit: LiveTestEdit, g: number): Seen {
  const out = test.map((t) => ({ ...t, shape: t.shape.slice(), weight: t.weight.slice() })), rows = sensors.slice(), m = out.length;
  const n = out.reduce((most, t) => Math.max(most, t.shape.length), 0);
  const at = (k: number): [SeenMode | undefined, number] => [n > 0 ? out[Math.floor(k / n)] : undefined, n > 0 ? k % n : 0];
  each(edit.frequency, edit.is_angle, g, (k, v) => { if (k < m) out[k]!.hz = v; });
  each(edit.frequency_sd, edit.is_angle, g, (k, v) => { if (k < m) out[k]!.sd = v; });
  each(edit.shape, edit.is_angle, g, (k, v) => { const [t, i] = at(k); if (t && i < t.shape.length) t.shape[i] = v; });
  each(edit.shape_sd, edit.is_angle, g, (k, v) => { const [t, i] = at(k); if (t && i < t.weight.length) t.weight[i] = 1 / v; });
  each(edit.sensors, edit.is_angle, g, (k, v) => { rows[k] = v; });
  (edit.spaces ?? []).forEach((space, k) => { if (space != null && k < m) out[k]!.space = space; });
  return { test: out, sensors: rows };
}
