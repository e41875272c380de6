/** The shape of one mode as the model has it now, with the measured one over it. */

import { doubles, floats } from "../decode";
import { peak, peakOfNodes, scaleFactor, times, type Shape } from "../shape";
import type { Live, Structure } from "../types";
import { makeViewer, type Viewer } from "../viewer";
import { parseHex } from "../color";
import type { Prediction } from "./model";

export class Picture {
  readonly viewer: Viewer;
  private readonly displacement: Float32Array;
  private readonly rotation: Float32Array | null;
  private phase = 0;
  private last = 0;
  private playing = false;
  /** The shape at the sensors that was shown last, so that a solver's sign does not turn the picture over. */
  private before: { key: string; at: Float64Array } | null = null;

  constructor(private readonly live: Live, structure: Structure, picked: (node: number) => void) {
    this.displacement = floats(live.displacement);
    this.rotation = live.rotation ? floats(live.rotation) : null;
    this.viewer = makeViewer(structure, { label: "The mode shape of the model as it is set now, over the measured one; a node can be chosen", fill: 0.74,
      pickable: true, onPick: (hit) => { if (hit?.kind === "node") picked(hit.index); }, describe: (hit) => (hit.kind === "node" ? `${structure.nodes[hit.index]!.name}: what if a mass or a spring stood here` : "") });
    this.viewer.root.id = "live-viewer";
    for (const layer of ["sensors", "masses"] as const) this.viewer.show(layer, false);
    this.viewer.show("ghost", true);
    this.viewer.show("test", true);
    this.paint();
    document.addEventListener("retheme", () => this.paint());
  }

  private paint(): void {
    const style = getComputedStyle(document.documentElement);
    const [model, test] = ["--model", "--test"].map((n) => parseHex(style.getPropertyValue(n).trim()));
    this.viewer.paint({ elements: () => model!, nodes: () => model!, test: () => test! });
  }

  /** Shows elastic mode `i`; `test` is its test mode, or -1. */
  show(p: Prediction, i: number, test: number): void {
    const y = p.shapes[i];
    if (!y) return this.viewer.setShapes(null, null);
    const key = test >= 0 ? `t${test}` : `m${i}`, at = p.atSensors[i]!;
    const same = this.before?.key === key ? at.reduce((s, v, k) => s + v * this.before!.at[k]!, 0) : 1;
    const sign = same < 0 ? -1 : 1;
    this.before = { key, at: at.map((v) => sign * v) };
    const combined = (basis: Float32Array): Shape => {
      const length = basis.length / this.live.n, out = new Float32Array(length);
      for (let c = 0; c < this.live.n; c++) {
        const f = sign * y[c]!;
        for (let k = 0; k < length; k++) out[k]! += f * basis[c * length + k]!;
      }
      return { re: out };
    };
    const displacement = combined(this.displacement), atSensors: Shape = { re: Float32Array.from(this.before.at) };
    const unit = 1 / (Math.max(peakOfNodes(displacement), peak(atSensors)) || 1);
    const scaled = times(atSensors, [unit, 0]);
    const own = doubles(this.live.test[test]?.shape), measured: Shape | null = own.length ? { re: Float32Array.from(own) } : null;
    this.viewer.setShapes({ displacement: times(displacement, [unit, 0]), rotation: this.rotation ? times(combined(this.rotation), [unit, 0]) : null },
      measured && times(measured, scaleFactor(measured, scaled)));
    this.viewer.frame(this.phase, 0.18);
  }

  play(on: boolean): void {
    if (on === this.playing) return;
    this.playing = on;
    this.last = 0;
    if (on) requestAnimationFrame(this.tick);
    else {
      this.phase = 0;
      this.viewer.frame(0, 0.18);
    }
  }

  private readonly tick = (now: number): void => {
    if (!this.playing) return;
    if (this.viewer.root.clientWidth > 0) {
      if (this.last) this.phase = (this.phase + (Math.min(now - this.last, 100) / 1000) * 2 * Math.PI * 0.7) % (2 * Math.PI);
      this.viewer.frame(this.phase, 0.18);
      this.last = now;
      requestAnimationFrame(this.tick);
    } else {
      this.last = 0;
      setTimeout(() => requestAnimationFrame(this.tick), 250);
    }
  };
}
