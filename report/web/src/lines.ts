/** Line segments of a constant width on the screen, cheap to move. */

import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import {
  BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments, type InstancedInterleavedBuffer, type InterleavedBufferAttribute,
} from "three";
import type { Rgb } from "./color";

/** More segments than these are one pixel wide: a ribbon costs four times the corners. */
const RIBBONS = 3000;

export class Lines {
  readonly object: LineSegments2 | LineSegments;
  /** Six numbers a segment; call [`moved`] after writing. */
  readonly positions: Float32Array;
  private readonly colors: Float32Array;
  private readonly changed: { position: { needsUpdate: boolean }; color: { needsUpdate: boolean } };

  constructor(readonly count: number, width: number, opacity = 1) {
    const transparent = opacity < 1;
    if (count > RIBBONS) {
      const geometry = new BufferGeometry();
      this.positions = new Float32Array(6 * count);
      this.colors = new Float32Array(6 * count).fill(0.5);
      const position = new BufferAttribute(this.positions, 3), color = new BufferAttribute(this.colors, 3);
      geometry.setAttribute("position", position);
      geometry.setAttribute("color", color);
      this.changed = { position, color };
      this.object = new LineSegments(geometry, new LineBasicMaterial({ vertexColors: true, transparent, opacity }));
    } else {
      const geometry = new LineSegmentsGeometry();
      geometry.setPositions(new Float32Array(6 * count));
      geometry.setColors(new Float32Array(6 * count).fill(0.5));
      const buffer = (name: string) => (geometry.attributes[name] as InterleavedBufferAttribute).data as InstancedInterleavedBuffer;
      this.changed = { position: buffer("instanceStart"), color: buffer("instanceColorStart") };
      this.positions = buffer("instanceStart").array as Float32Array;
      this.colors = buffer("instanceColorStart").array as Float32Array;
      this.object = new LineSegments2(geometry, new LineMaterial({ linewidth: width, vertexColors: true, transparent, opacity }));
    }
    this.object.frustumCulled = false;
    this.object.visible = count > 0;
  }

  moved(): void {
    this.changed.position.needsUpdate = true;
  }

  /** Moves all segments: two points of `from` each. */
  place(ends: ArrayLike<number>, from: Float32Array): void {
    const to = this.positions;
    for (let k = 0, at = 0; k < ends.length; k++) {
      const p = 3 * ends[k]!;
      to[at++] = from[p]!;
      to[at++] = from[p + 1]!;
      to[at++] = from[p + 2]!;
    }
    this.moved();
  }

  /** Colours both ends of every segment. */
  paint(color: (segment: number, end: 0 | 1) => Rgb): void {
    for (let i = 0; i < this.count; i++) {
      for (const end of [0, 1] as const) {
        const rgb = color(i, end);
        for (let k = 0; k < 3; k++) this.colors[6 * i + 3 * end + k] = rgb[k]! / 255;
      }
    }
    this.changed.color.needsUpdate = true;
  }

  dispose(): void {
    this.object.geometry.dispose();
    (this.object.material as LineMaterial | LineBasicMaterial).dispose();
  }
}
