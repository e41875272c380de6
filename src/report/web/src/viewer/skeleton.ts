/** Points, lines and faces of a structure, and how a shape of its nodes moves all of them. */

import { beamPoint, type Shape } from "../shape";
import type { Structure, Vec3 } from "../types";

export class Skeleton {
  /** Undeformed positions: every node, then the points along the beams. */
  readonly base: Float32Array;
  /** Lines that a beam is drawn with. */
  readonly pieces: number;
  readonly beams: { element: number; first: number; nodes: [number, number] }[] = [];
  /** Two points and the element that their line belongs to. */
  readonly segments: [number, number, number][] = [];
  readonly faces: { element: number; nodes: number[] }[] = [];
  /** Master, slave and the link. */
  readonly linkPairs: [number, number, number][] = [];

  constructor(private readonly data: Structure) {
    const { nodes, elements } = data;
    this.pieces = elements.length > 1200 ? 1 : 8;
    let count = nodes.length;
    elements.forEach((e, element) => {
      const valid = e.nodes.filter((k) => k < nodes.length);
      if (valid.length === 2) {
        this.beams.push({ element, first: count, nodes: [valid[0]!, valid[1]!] });
        const chain = [valid[0]!, ...Array.from({ length: this.pieces - 1 }, (_, k) => count + k), valid[1]!];
        for (let k = 0; k < this.pieces; k++) this.segments.push([chain[k]!, chain[k + 1]!, element]);
        count += this.pieces - 1;
      } else if (valid.length > 2) {
        this.faces.push({ element, nodes: valid });
        valid.forEach((a, k) => this.segments.push([a, valid[(k + 1) % valid.length]!, element]));
      }
    });
    data.rigid_links.forEach((link, index) => {
      for (const slave of link.slaves) {
        if (link.master < nodes.length && slave < nodes.length) this.linkPairs.push([link.master, slave, index]);
      }
    });

    this.base = new Float32Array(3 * count);
    nodes.forEach((n, i) => this.base.set(n.position, 3 * i));
    for (const { first, nodes: [a, b] } of this.beams) {
      for (let k = 1; k < this.pieces; k++) {
        for (let c = 0; c < 3; c++) {
          const p = this.base[3 * a + c]!, q = this.base[3 * b + c]!;
          this.base[3 * (first + k - 1) + c] = p + ((q - p) * k) / this.pieces;
        }
      }
    }
  }

  /** Node `i` at rest, m. */
  node(i: number): Vec3 {
    return [this.base[3 * i]!, this.base[3 * i + 1]!, this.base[3 * i + 2]!];
  }

  /** The motion of every point from that of the nodes. */
  spread(displacement: Shape, rotation: Shape | null): Shape {
    const along = (u: Float32Array, r: Float32Array | undefined): Float32Array => {
      const out = new Float32Array(this.base.length);
      out.set(u.subarray(0, 3 * this.data.nodes.length));
      const at = (a: Float32Array, i: number): Vec3 => [a[3 * i]!, a[3 * i + 1]!, a[3 * i + 2]!];
      for (const { first, nodes: [a, b] } of this.beams) {
        for (let k = 1; k < this.pieces; k++) {
          const point = beamPoint(at(this.base, a), at(this.base, b), at(u, a), at(u, b),
            r ? at(r, a) : null, r ? at(r, b) : null, k / this.pieces);
          out.set(point, 3 * (first + k - 1));
        }
      }
      return out;
    };
    return { re: along(displacement.re, rotation?.re), im: displacement.im ? along(displacement.im, rotation?.im) : undefined };
  }
}
