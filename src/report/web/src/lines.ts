/** Line segments of a constant width on the screen, cheap to move. */

import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import type { InstancedInterleavedBuffer, InterleavedBufferAttribute } from "three";
import type { Rgb } from "./color";

export class Lines {
  readonly object: LineSegments2;
  readonly material: LineMaterial;
  /** Six numbers a segment; call [`moved`] after writing. */
  positions: Float32Array;
  private readonly colors: Float32Array;

  constructor(readonly count: number, width: number, opacity = 1) {
    const geometry = new LineSegmentsGeometry();
    geometry.setPositions(new Float32Array(6 * count));
    geometry.setColors(new Float32Array(6 * count).fill(0.5));
    this.positions = this.buffer(geometry, "instanceStart").array as Float32Array;
    this.colors = this.buffer(geometry, "instanceColorStart").array as Float32Array;
    this.material = new LineMaterial({ linewidth: width, vertexColors: true, transparent: opacity < 1, opacity });
    this.object = new LineSegments2(geometry, this.material);
    this.object.frustumCulled = false;
    this.object.visible = count > 0;
  }

  private buffer(geometry: LineSegmentsGeometry, name: string): InstancedInterleavedBuffer {
    return (geometry.attributes[name] as InterleavedBufferAttribute).data as InstancedInterleavedBuffer;
  }

  moved(): void {
    this.buffer(this.object.geometry, "instanceStart").needsUpdate = true;
  }

  /** Colours both ends of every segment. */
  paint(color: (segment: number, end: 0 | 1) => Rgb): void {
    for (let i = 0; i < this.count; i++) {
      for (const end of [0, 1] as const) {
        const rgb = color(i, end);
        for (let k = 0; k < 3; k++) this.colors[6 * i + 3 * end + k] = rgb[k]! / 255;
      }
    }
    this.buffer(this.object.geometry, "instanceColorStart").needsUpdate = true;
  }

  dispose(): void {
    this.object.geometry.dispose();
    this.material.dispose();
  }
}
