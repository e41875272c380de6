/** Points, lines and faces of a structure, and how a shape of its nodes moves all of them. */

import { beamPoint, type Shape } from "../shape";
import type { Structure, Vec3 } from "../types";
import { edges } from "./edges";

/** Lines between two points each, and the element that each belongs to. */
export interface Segments { ends: Int32Array; element: Int32Array }
/** Corners of faces one after the other: node of each, the first corner of each face (and the end), the element of each face. */
export interface Faces { nodes: Int32Array; first: Int32Array; element: Int32Array }

export class Skeleton {
  /** Undeformed positions: every node, then the points along the beams. */
  readonly base: Float32Array;
  /** Lines that a beam is drawn with. */
  readonly pieces: number;
  readonly beams: { element: number; first: number; nodes: [number, number] }[] = [];
  readonly segments: Segments;
  readonly faces: Faces;
  /** Master, slave and the link. */
  readonly linkPairs: [number, number, number][] = [];
  private readonly beamOf = new Map<number, number>();

  constructor(private readonly data: Structure) {
    const { nodes, elements } = data;
    this.pieces = elements.length > 1200 ? 1 : 8;
    let count = nodes.length;
    const corners: number[] = [], first: number[] = [0], faceOf: number[] = [];
    elements.forEach((e, element) => {
      const valid = e.nodes.every((k) => k < nodes.length) ? e.nodes : e.nodes.filter((k) => k < nodes.length);
      if (valid.length === 2) {
        this.beamOf.set(element, this.beams.length);
        this.beams.push({ element, first: count, nodes: [valid[0]!, valid[1]!] });
        count += this.pieces - 1;
      } else if (valid.length > 2) {
        for (const k of valid) corners.push(k);
        first.push(corners.length);
        faceOf.push(element);
      }
    });
    data.rigid_links.forEach((link, index) => {
      for (const slave of link.slaves) {
        if (link.master < nodes.length && slave < nodes.length) this.linkPairs.push([link.master, slave, index]);
      }
    });

    this.base = new Float32Array(3 * count);
    nodes.forEach((n, i) => this.base.set(n.position, 3 * i));
    for (const { first: at, nodes: [a, b] } of this.beams) {
      for (let k = 1; k < this.pieces; k++) {
        for (let c = 0; c < 3; c++) {
          const p = this.base[3 * a + c]!, q = this.base[3 * b + c]!;
          this.base[3 * (at + k - 1) + c] = p + ((q - p) * k) / this.pieces;
        }
      }
    }
    this.faces = { nodes: Int32Array.from(corners), first: Int32Array.from(first), element: Int32Array.from(faceOf) };
    const between = edges(this.faces, this.base, nodes.length, (face) => elements[faceOf[face]!]!.group ?? "");
    const own = this.beams.length * this.pieces;
    this.segments = { ends: new Int32Array(2 * own + between.ends.length), element: new Int32Array(own + between.element.length) };
    let at = 0;
    for (const beam of this.beams) {
      for (const [a, b] of this.chain(beam)) {
        this.segments.ends.set([a, b], 2 * at);
        this.segments.element[at++] = beam.element;
      }
    }
    this.segments.ends.set(between.ends, 2 * own);
    this.segments.element.set(between.element, own);
  }

  private *chain({ first, nodes: [a, b] }: { first: number; nodes: [number, number] }): Generator<[number, number]> {
    for (let k = 0; k < this.pieces; k++) yield [k ? first + k - 1 : a, k < this.pieces - 1 ? first + k : b];
  }

  /** The lines around an element. */
  around(element: number): [number, number][] {
    const beam = this.beamOf.get(element);
    if (beam != null) return [...this.chain(this.beams[beam]!)];
    const own = (this.data.elements[element]?.nodes ?? []).filter((k) => k < this.data.nodes.length);
    return own.length > 2 ? own.map((a, k) => [a, own[(k + 1) % own.length]!]) : [];
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
