/** Bodies of the picture: balls for masses, arrows for sensors and exciters, faces of shells. */

import {
  BufferAttribute, BufferGeometry, DoubleSide, InstancedMesh, Matrix4, Mesh, MeshLambertMaterial, Quaternion,
  SphereGeometry, Vector3,
} from "three";
import { Lines } from "../lines";
import type { Structure } from "../types";
import type { Faces } from "./skeleton";

export function masses(count: number): InstancedMesh {
  const mesh = new InstancedMesh(new SphereGeometry(1, 20, 14), new MeshLambertMaterial(), count);
  mesh.frustumCulled = false;
  return mesh;
}

/** All faces as one body: corners of their own, so that each may have its colour, joined to triangles around the first. */
export function faceMesh({ nodes, first, element }: Faces): Mesh<BufferGeometry, MeshLambertMaterial> {
  const geometry = new BufferGeometry(), n = element.length, triangles = new Uint32Array(3 * (nodes.length - 2 * n));
  let at = 0;
  for (let f = 0; f < n; f++) {
    for (let k = first[f]! + 2; k < first[f + 1]!; k++) {
      triangles[at++] = first[f]!;
      triangles[at++] = k - 1;
      triangles[at++] = k;
    }
  }
  geometry.setIndex(new BufferAttribute(triangles, 1));
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(3 * nodes.length), 3));
  geometry.setAttribute("color", new BufferAttribute(new Float32Array(3 * nodes.length), 3));
  // Flat shading needs no normals, which would have to follow every frame.
  const material = new MeshLambertMaterial({ vertexColors: true, side: DoubleSide, transparent: true, opacity: 0.85, flatShading: true,
    polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
  const mesh = new Mesh(geometry, material);
  mesh.frustumCulled = false;
  mesh.visible = n > 0;
  return mesh;
}

/** Shafts and heads of the arrows at sensors, then at exciters, of a structure of this half-diagonal. */
export function placeArrows(data: Structure, radius: number, shafts: Lines, heads: InstancedMesh): void {
  const matrix = new Matrix4(), turnTo = new Quaternion(), from = new Vector3(0, 1, 0);
  const all = [...data.sensors.map((s) => ({ ...s, scale: 1 })), ...data.exciters.map((e) => ({ ...e, scale: 1.9 }))];
  all.forEach(({ position, direction, scale }, i) => {
    const norm = Math.hypot(...direction) || 1;
    const d = new Vector3(...direction).divideScalar(norm);
    const length = radius * 0.075 * scale;
    const head = radius * 0.0085 * scale;
    const p = new Vector3(...position);
    const tip = p.clone().addScaledVector(d, length);
    shafts.positions.set([...p.toArray(), ...tip.toArray()], 6 * i);
    turnTo.setFromUnitVectors(from, d);
    matrix.compose(tip, turnTo, new Vector3(head, head, head));
    heads.setMatrixAt(i, matrix);
  });
  shafts.moved();
}

/** The z axes of sections, from the middle of each beam. */
export function sectionAxes(data: Structure, size: number): Lines {
  const own = data.elements.flatMap((e) => (e.z_axis && e.nodes.length === 2 && e.nodes.every((k) => k < data.nodes.length) ? [e] : []));
  const lines = new Lines(own.length, 1.8);
  own.forEach((e, i) => {
    const [p, q] = [data.nodes[e.nodes[0]!]!.position, data.nodes[e.nodes[1]!]!.position];
    for (let c = 0; c < 3; c++) {
      const middle = (p[c]! + q[c]!) / 2;
      lines.positions[6 * i + c] = middle;
      lines.positions[6 * i + 3 + c] = middle + 0.06 * size * e.z_axis![c]!;
    }
  });
  lines.moved();
  return lines;
}
