/** Frequency responses by the sum of modes (`base/src/modal/frf.rs`). */

/** Which response: sensors, the sign of their directions, (iω)^order, and the lines. */
export interface Line { response: number; reference: number; sign: number; order: number; hz: Float64Array }
/** Amplitude, and phase in degrees from -180 to 180. */
export interface Curve { amplitude: Float64Array; phase: Float64Array }
/** φ_response φ_reference of the rigid-body and the elastic modes of unit modal mass, and the frequencies of the latter, Hz. */
export interface Summands { rigid: number[]; elastic: number[]; hz: Float64Array }

/**
 * H(ω) = (iω)^p Σ_r φ_kr φ_sr / (ω_r² - ω² + 2 i ζ_r ω_r ω), time factor e^{+iωt}.
 *
 * * `damping` - ζ of the elastic modes
 */
export function curve({ rigid, elastic, hz }: Summands, damping: Float64Array, line: Line): Curve {
  const n = line.hz.length, amplitude = new Float64Array(n), phase = new Float64Array(n), free = rigid.reduce((a, b) => a + b, 0);
  for (let l = 0; l < n; l++) {
    const w = 2 * Math.PI * line.hz[l]!;
    let re = -free / (w * w), im = 0;
    for (let r = 0; r < elastic.length; r++) {
      const wr = 2 * Math.PI * hz[r]!, a = wr * wr - w * w, b = 2 * damping[r]! * wr * w, size = a * a + b * b;
      re += (elastic[r]! * a) / size;
      im -= (elastic[r]! * b) / size;
    }
    const power = line.sign * w ** line.order;
    // i^p turns by quarters.
    for (let p = 0; p < line.order; p++) [re, im] = [-im, re];
    amplitude[l] = Math.abs(power) * Math.hypot(re, im);
    phase[l] = (Math.atan2(power * im, power * re) * 180) / Math.PI;
  }
  return { amplitude, phase };
}
