/** Dots of a constant size on the screen. */

import { BufferAttribute, BufferGeometry, CanvasTexture, Points, PointsMaterial } from "three";
import type { Rgb } from "../color";
import { h } from "../dom";

function dot(): CanvasTexture {
  const canvas = h("canvas", { width: 64, height: 64 });
  const context = canvas.getContext("2d")!;
  context.fillStyle = "#fff";
  context.arc(32, 32, 29, 0, 2 * Math.PI);
  context.fill();
  return new CanvasTexture(canvas);
}

export class Dots {
  readonly object: Points<BufferGeometry, PointsMaterial>;
  readonly positions: Float32Array;
  private readonly colors: Float32Array;

  constructor(count: number, size: number) {
    this.positions = new Float32Array(3 * count);
    this.colors = new Float32Array(3 * count);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(this.positions, 3));
    geometry.setAttribute("color", new BufferAttribute(this.colors, 3));
    const material = new PointsMaterial({ size, sizeAttenuation: false, vertexColors: true, map: dot(), alphaTest: 0.5, transparent: true });
    this.object = new Points(geometry, material);
    this.object.frustumCulled = false;
  }

  moved(): void {
    this.object.geometry.attributes["position"]!.needsUpdate = true;
  }

  dispose(): void {
    this.object.geometry.dispose();
    this.object.material.map?.dispose();
    this.object.material.dispose();
  }

  paint(color: (index: number) => Rgb): void {
    for (let i = 0; i < this.colors.length / 3; i++) this.colors.set(color(i).map((c) => c / 255), 3 * i);
    this.object.geometry.attributes["color"]!.needsUpdate = true;
  }
}
