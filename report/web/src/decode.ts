/** From the compact text of the data to typed arrays. */

import { inflateSync } from "fflate";
import type { Doubles, Floats, Levels, Spectrum } from "./types";

function bytes(text: string): Uint8Array<ArrayBuffer> {
  const raw = atob(text);
  const out = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
  return out;
}

/** The numbers behind a `Floats` text; an empty array when there is none. */
export function floats(text: Floats | null | undefined): Float32Array {
  if (!text) return new Float32Array(0);
  const view = new DataView(bytes(text).buffer);
  const out = new Float32Array(view.byteLength >> 2);
  for (let i = 0; i < out.length; i++) out[i] = view.getFloat32(4 * i, true);
  return out;
}

/** The numbers behind a `Doubles` text; an empty array when there is none. */
export function doubles(text: Doubles | null | undefined): Float64Array {
  if (!text) return new Float64Array(0);
  const view = new DataView(bytes(text).buffer);
  const out = new Float64Array(view.byteLength >> 3);
  for (let i = 0; i < out.length; i++) out[i] = view.getFloat64(8 * i, true);
  return out;
}

/** The numbers of a shape at nodes, exact or rounded; an empty array when there is none. */
export function motion(exact: Floats | undefined, rounded: Levels | undefined): Float32Array {
  if (!rounded) return floats(exact);
  const view = new DataView(bytes(rounded.data).buffer), out = new Float32Array(view.byteLength >> 1), last = new Int16Array(3);
  for (let i = 0; i < out.length; i++) {
    const level = (last[i % 3]! += view.getInt16(2 * i, true));
    // Sums go round at 16 bits, as they were taken.
    const k = (level << 16) >> 16;
    out[i] = k === -32768 ? NaN : rounded.step * k;
  }
  return out;
}

/** The JSON text of the data of a page, packed or not. */
export function textOfPage(element: HTMLElement | null): string {
  const text = element?.textContent ?? "{}";
  return element?.dataset["packed"] === "deflate" ? new TextDecoder().decode(inflateSync(bytes(text))) : text;
}

/** Amplitude and phase (degrees, -180 to 180) of a frequency response; NaN where it is missing. */
export interface Polar { amplitude: Float64Array; phase: Float64Array }

/** The curve behind a `Spectrum`: |h| = exp(log_low + (a - 1) log_step), arg h = p 2π/65536, a = 0 for missing. */
export function polar(spectrum: Spectrum): Polar {
  const view = new DataView(bytes(spectrum.data).buffer);
  const n = view.byteLength >> 2;
  const amplitude = new Float64Array(n);
  const phase = new Float64Array(n);
  for (let i = 0; i < n; i++) {
    const a = view.getUint16(4 * i, true);
    const degrees = (view.getUint16(4 * i + 2, true) * 360) / 65536;
    amplitude[i] = a === 0 ? NaN : Math.exp(spectrum.log_low + (a - 1) * spectrum.log_step);
    phase[i] = a === 0 ? NaN : degrees > 180 ? degrees - 360 : degrees;
  }
  return { amplitude, phase };
}
