/** The structure in 3-D: what is drawn, how it moves, what is picked. Sections only say what to show. */

import {
  AmbientLight, BufferAttribute, BufferGeometry, CanvasTexture, Color, ColorManagement, ConeGeometry, DirectionalLight,
  DoubleSide, InstancedMesh, LinearSRGBColorSpace, Matrix4, Mesh, MeshLambertMaterial,
  PerspectiveCamera, Points, PointsMaterial, Quaternion, Scene, SphereGeometry, Vector3, WebGLRenderer,
} from "three";
import { parseHex, type Rgb } from "./color";
import { h } from "./dom";
import { Lines } from "./lines";
import { across, extent, eye, fit, HALF_VIEW, turn, VIEWS, zoom, type Orbit } from "./orbit";
import { pick, type Flat, type Hit, type Target } from "./pick";
import { atPhase, beamPoint, type Shape } from "./shape";
import type { Place, Structure, Vec3 } from "./types";

ColorManagement.enabled = false;

export type Layer = "nodes" | "elements" | "links" | "masses" | "sensors" | "supports" | "ghost" | "test" | "names";
export type Painter = (index: number) => Rgb | null;

interface Theme { line: Rgb; faint: Rgb; node: Rgb; sensor: Rgb; mass: Rgb; accent: Rgb; test: Rgb; model: Rgb; text: string; halo: string }

function dot(): CanvasTexture {
  const canvas = h("canvas", { width: 64, height: 64 });
  const context = canvas.getContext("2d")!;
  context.fillStyle = "#fff";
  context.arc(32, 32, 29, 0, 2 * Math.PI);
  context.fill();
  return new CanvasTexture(canvas);
}

class Dots {
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

  paint(color: (index: number) => Rgb): void {
    for (let i = 0; i < this.colors.length / 3; i++) this.colors.set(color(i).map((c) => c / 255), 3 * i);
    this.object.geometry.attributes["color"]!.needsUpdate = true;
  }
}

export class Viewer {
  readonly root: HTMLElement;
  private readonly canvas: HTMLCanvasElement;
  private readonly overlay: HTMLCanvasElement;
  private readonly tip: HTMLElement;
  private renderer: WebGLRenderer | null = null;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera((2 * HALF_VIEW * 180) / Math.PI, 1, 0.01, 1000);
  private orbit: Orbit;
  private readonly home: { centre: Vec3; radius: number };
  private readonly up: number;
  /** Azimuth of the oblique view. */
  private readonly oblique: number;
  private readonly fill: number;
  private theme!: Theme;
  private pending = false;
  /** Whether the view still is one of the named ones, which fit the structure into the picture. */
  private fitted = true;
  private readonly cloud: Vec3[];
  private layers: Record<Layer, boolean> = {
    nodes: true, elements: true, links: true, masses: true, sensors: true, supports: true, ghost: false, test: false, names: false,
  };

  /** Undeformed positions: every node, then the points along the beams. */
  private readonly base: Float32Array;
  private readonly now: Float32Array;
  private readonly shift: Float32Array;
  private shape: Shape | null = null;
  private readonly pieces: number;
  private readonly beams: { element: number; first: number; nodes: [number, number] }[] = [];
  private readonly segments: [number, number, number][] = [];
  private readonly faces: { element: number; nodes: number[] }[] = [];

  private readonly lines: Lines;
  private readonly ghost: Lines;
  private readonly links: Lines;
  private readonly linkPairs: [number, number, number][] = [];
  private readonly arrows: Lines;
  private readonly marks: Lines;
  private readonly traces: Lines;
  private readonly nodeDots: Dots;
  private readonly sensorDots: Dots;
  private readonly testDots: Dots;
  private readonly markDots: Dots;
  private readonly faceMesh: Mesh<BufferGeometry, MeshLambertMaterial>;
  private readonly masses: InstancedMesh;
  private readonly cones: InstancedMesh;
  /** Pyramids under what is held: supports, then elements to the ground. */
  private readonly feet: InstancedMesh;
  private readonly held: { kind: "support" | "element"; index: number; node: number }[] = [];
  private readonly sensorBase: Float32Array;
  private readonly sensorNow: Float32Array;
  private testShape: Shape | null = null;
  private readonly tracePairs: [number, number][] = [];
  private selected: Place | null = null;

  private elementPaint: Painter = () => null;
  private nodePaint: Painter = () => null;
  private sensorPaint: Painter = () => null;
  private testPaint: Painter = () => null;

  constructor(
    private readonly data: Structure,
    private readonly options: { label: string; pickable?: boolean; fill?: number; onPick?: (hit: Hit | null) => void; describe?: (hit: Hit) => string },
  ) {
    const { nodes, elements } = data;
    this.up = data.up ?? 2;
    this.fill = options.fill ?? 0.84;
    const points = [...nodes.map((n) => n.position), ...data.sensors.map((s) => s.position)];
    this.home = extent(points);
    this.cloud = points;
    this.oblique = across(nodes.length ? nodes.map((n) => n.position) : points, this.up);
    this.orbit = { ...this.named("iso"), distance: this.home.radius * 3.7, target: [...this.home.centre] };

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
    for (const line of data.trace_lines) {
      for (let k = 1; k < line.length; k++) this.tracePairs.push([line[k - 1]!, line[k]!]);
    }

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
    this.now = this.base.slice();
    this.shift = new Float32Array(this.base.length);
    this.sensorBase = new Float32Array(data.sensors.flatMap((s) => s.position));
    this.sensorNow = this.sensorBase.slice();

    this.ghost = new Lines(this.segments.length, 1.2, 0.55);
    this.links = new Lines(this.linkPairs.length, 1.6);
    this.lines = new Lines(this.segments.length, elements.length > 1200 ? 1.6 : 5);
    this.arrows = new Lines(data.sensors.length + data.exciters.length, 1.8);
    this.traces = new Lines(this.tracePairs.length || data.sensors.length, 3);
    this.marks = new Lines(Math.max(1, this.segments.length), 10, 0.55);
    this.nodeDots = new Dots(nodes.length, nodes.length > 800 ? 2.5 : 6);
    this.sensorDots = new Dots(data.sensors.length, 9);
    this.testDots = new Dots(data.sensors.length, 9);
    this.markDots = new Dots(nodes.length + data.sensors.length, 20);
    this.markDots.object.material.opacity = 0.6;
    this.faceMesh = this.makeFaces();
    this.masses = this.makeMasses();
    this.cones = new InstancedMesh(new ConeGeometry(1, 3.2, 14), new MeshLambertMaterial(), data.sensors.length + data.exciters.length);
    this.cones.frustumCulled = false;
    this.placeArrows();
    data.supports.forEach((b, index) => { if (b.node < nodes.length) this.held.push({ kind: "support", index, node: b.node }); });
    elements.forEach((e, index) => { if (e.nodes.length === 1 && e.nodes[0]! < nodes.length) this.held.push({ kind: "element", index, node: e.nodes[0]! }); });
    this.feet = new InstancedMesh(new ConeGeometry(1, 1.7, 4), new MeshLambertMaterial(), this.held.length);
    this.feet.frustumCulled = false;
    this.placeFeet();
    this.scene.add(this.feet, new AmbientLight(0xffffff, 1.6), this.cones, this.masses, this.faceMesh,
      this.marks.object, this.markDots.object, this.ghost.object, this.links.object, this.lines.object, this.arrows.object,
      this.traces.object, this.nodeDots.object, this.sensorDots.object, this.testDots.object);
    const sun = new DirectionalLight(0xffffff, 1.8);
    sun.position.set(0.4, 0.3, 1);
    this.camera.add(sun);
    this.scene.add(this.camera);

    this.canvas = h("canvas", { class: "gl", tabindex: 0, role: "img",
      "aria-label": `${options.label}. Arrow keys turn, plus and minus zoom, 0 resets the view.` });
    this.overlay = h("canvas", { class: "overlay", "aria-hidden": "true" });
    this.tip = h("div", { class: "tip", role: "status", hidden: true });
    this.root = h("div", { class: "viewer" }, this.canvas, this.overlay, this.tip, this.buttons());
    this.start();
  }

  // ---- what to show -------------------------------------------------------------------------------------------

  /** Colours by element, node and sensor; a painter that returns null leaves the plain colour. */
  paint(painters: { elements?: Painter; nodes?: Painter; sensors?: Painter; test?: Painter }): void {
    this.elementPaint = painters.elements ?? (() => null);
    this.nodePaint = painters.nodes ?? (() => null);
    this.sensorPaint = painters.sensors ?? (() => null);
    this.testPaint = painters.test ?? (() => null);
    this.colour();
  }

  /** Shows or hides a layer. */
  show(layer: Layer, on: boolean): void {
    this.layers[layer] = on;
    this.visible();
    this.request();
  }

  /** The shape of the model, three entries a node with largest length 1, with rotations on the same scale; and of the test at the sensors. */
  setShapes(model: { displacement: Shape; rotation: Shape | null } | null, test: Shape | null): void {
    this.testShape = test;
    this.shape = model ? this.spread(model.displacement, model.rotation) : null;
    this.frame(0, 0);
  }

  /** Moves everything to a phase (rad); amplitude is a part of the structure's half-diagonal. */
  frame(phase: number, amplitude: number): void {
    const world = amplitude * this.home.radius;
    if (this.shape) atPhase(this.shape, phase, world, this.shift);
    else this.shift.fill(0);
    for (let i = 0; i < this.now.length; i++) this.now[i] = this.base[i]! + this.shift[i]!;
    const values = new Float32Array(this.data.sensors.length);
    if (this.testShape) atPhase(this.testShape, phase, world, values);
    this.data.sensors.forEach((s, i) => {
      const value = s.is_rotation ? 0 : values[i]!;
      for (let c = 0; c < 3; c++) this.sensorNow[3 * i + c] = this.sensorBase[3 * i + c]! + value * s.direction[c]!;
    });
    this.place();
    this.request();
  }

  /** Marks a place, or nothing. */
  highlight(place: Place | null): void {
    this.selected = place;
    this.mark();
    this.request();
  }

  /** A named view of this structure. */
  private named(name: string): { azimuth: number; elevation: number } {
    const { azimuth, elevation } = VIEWS[name]!;
    return { azimuth: name === "iso" ? this.oblique : azimuth, elevation };
  }

  view(name: string): void {
    if (!VIEWS[name]) return;
    const v = this.named(name);
    this.orbit = { ...v, distance: this.home.radius * 3.7, target: [...this.home.centre] };
    this.fitted = true;
    this.request();
  }

  /** Reads the colours of the page again. */
  retheme(): void {
    const style = getComputedStyle(document.documentElement);
    const of = (name: string): Rgb => parseHex(style.getPropertyValue(name).trim());
    this.theme = {
      line: of("--element"), faint: of("--ghost"), node: of("--node"), sensor: of("--sensor"), mass: of("--mass"),
      accent: of("--mark"), test: of("--test"), model: of("--model"),
      text: style.getPropertyValue("--ink").trim(), halo: style.getPropertyValue("--stage").trim(),
    };
    this.colour();
  }

  /** Centre of what is picked on the screen, for tests and for the pointer-free way of choosing. */
  screenOf(kind: Hit["kind"], index: number): { x: number; y: number } | null {
    for (const target of this.targets()) {
      if (target.kind === kind && target.index === index) {
        const n = target.points.length;
        const a = target.points[Math.floor((n - 1) / 2)]!, b = target.points[Math.ceil((n - 1) / 2)]!;
        const box = this.canvas.getBoundingClientRect();
        return { x: box.left + (a.x + b.x) / 2, y: box.top + (a.y + b.y) / 2 };
      }
    }
    return null;
  }

  /** Where node `index` is now, m. */
  nodeNow(index: number): Vec3 {
    return [this.now[3 * index]!, this.now[3 * index + 1]!, this.now[3 * index + 2]!];
  }

  /** Draws now, and onto the canvas that prints: paper gets neither frames nor what the graphics card drew. */
  drawForPaper(): void {
    this.draw();
    const context = this.overlay.getContext("2d");
    if (!this.renderer || !context || this.overlay.width === 0) return;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.globalCompositeOperation = "destination-over";
    context.drawImage(this.canvas, 0, 0, this.overlay.width, this.overlay.height);
    context.globalCompositeOperation = "source-over";
  }

  // ---- geometry -----------------------------------------------------------------------------------------------

  private spread(displacement: Shape, rotation: Shape | null): Shape {
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

  private place(): void {
    const copy = (out: Float32Array, at: number, from: Float32Array, i: number): void => {
      out[at] = from[3 * i]!;
      out[at + 1] = from[3 * i + 1]!;
      out[at + 2] = from[3 * i + 2]!;
    };
    const fill = (lines: Lines, pairs: readonly (readonly number[])[], from: Float32Array, to = from): void => {
      pairs.forEach((pair, i) => {
        copy(lines.positions, 6 * i, from, pair[0]!);
        copy(lines.positions, 6 * i + 3, to, pair[1]!);
      });
      lines.moved();
    };
    fill(this.lines, this.segments, this.now);
    fill(this.ghost, this.segments, this.base);
    fill(this.links, this.linkPairs, this.now);
    if (this.tracePairs.length) fill(this.traces, this.tracePairs, this.sensorNow);
    else fill(this.traces, this.data.sensors.map((_, i) => [i, i]), this.sensorBase, this.sensorNow);
    this.nodeDots.positions.set(this.now.subarray(0, this.nodeDots.positions.length));
    this.sensorDots.positions.set(this.sensorBase);
    this.testDots.positions.set(this.sensorNow);
    for (const dots of [this.nodeDots, this.sensorDots, this.testDots]) dots.moved();
    const face = this.faceMesh.geometry.attributes["position"] as BufferAttribute | undefined;
    if (face) {
      let at = 0;
      for (const { nodes } of this.faces) {
        for (let k = 2; k < nodes.length; k++) {
          for (const n of [nodes[0]!, nodes[k - 1]!, nodes[k]!]) copy(face.array as Float32Array, 3 * at++, this.now, n);
        }
      }
      face.needsUpdate = true;
      this.faceMesh.geometry.computeVertexNormals();
    }
    const matrix = new Matrix4();
    this.data.masses.forEach((m, i) => {
      const size = this.massSize(m.mass);
      const o = m.offset ?? [0, 0, 0];
      const p = 3 * Math.min(m.node, Math.max(0, this.data.nodes.length - 1));
      matrix.makeScale(size, size, size).setPosition((this.now[p] ?? 0) + o[0], (this.now[p + 1] ?? 0) + o[1], (this.now[p + 2] ?? 0) + o[2]);
      this.masses.setMatrixAt(i, matrix);
    });
    this.masses.instanceMatrix.needsUpdate = true;
    this.mark();
  }

  private massSize(mass: number | null): number {
    const all = this.data.masses.map((m) => m.mass ?? 0);
    const largest = Math.max(...all, 1e-300);
    return this.home.radius * (0.012 + 0.024 * Math.cbrt(Math.max(mass ?? 0, 0) / largest));
  }

  private makeMasses(): InstancedMesh {
    const mesh = new InstancedMesh(new SphereGeometry(1, 20, 14), new MeshLambertMaterial(), this.data.masses.length);
    mesh.frustumCulled = false;
    return mesh;
  }

  private makeFaces(): Mesh<BufferGeometry, MeshLambertMaterial> {
    const geometry = new BufferGeometry();
    const triangles = this.faces.reduce((n, f) => n + f.nodes.length - 2, 0);
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(9 * triangles), 3));
    geometry.setAttribute("color", new BufferAttribute(new Float32Array(9 * triangles), 3));
    const material = new MeshLambertMaterial({ vertexColors: true, side: DoubleSide, transparent: true, opacity: 0.85,
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    const mesh = new Mesh(geometry, material);
    mesh.frustumCulled = false;
    mesh.visible = triangles > 0;
    return mesh;
  }

  private placeArrows(): void {
    const matrix = new Matrix4(), turnTo = new Quaternion(), from = new Vector3(0, 1, 0);
    const all = [...this.data.sensors.map((s) => ({ ...s, scale: 1 })), ...this.data.exciters.map((e) => ({ ...e, scale: 1.9 }))];
    all.forEach(({ position, direction, scale }, i) => {
      const norm = Math.hypot(...direction) || 1;
      const d = new Vector3(...direction).divideScalar(norm);
      const length = this.home.radius * 0.075 * scale;
      const head = this.home.radius * 0.0085 * scale;
      const p = new Vector3(...position);
      const tip = p.clone().addScaledVector(d, length);
      this.arrows.positions.set([...p.toArray(), ...tip.toArray()], 6 * i);
      turnTo.setFromUnitVectors(from, d);
      matrix.compose(tip, turnTo, new Vector3(head, head, head));
      this.cones.setMatrixAt(i, matrix);
    });
    this.arrows.moved();
  }

  /** How far the middle of a foot is below its node. */
  private get footSize(): number {
    return this.home.radius * 0.022;
  }

  private placeFeet(): void {
    const matrix = new Matrix4(), turnTo = new Quaternion();
    const down = new Vector3().setComponent(this.up, 1);
    turnTo.setFromUnitVectors(new Vector3(0, 1, 0), down);
    this.held.forEach(({ kind, node }, i) => {
      const size = this.footSize * (kind === "support" ? 1 : 0.7);
      const p = new Vector3(...this.nodeBase(node)).addScaledVector(down, -0.85 * size);
      matrix.compose(p, turnTo, new Vector3(size, size, size));
      this.feet.setMatrixAt(i, matrix);
    });
  }

  private nodeBase(i: number): Vec3 {
    return [this.base[3 * i]!, this.base[3 * i + 1]!, this.base[3 * i + 2]!];
  }

  private mark(): void {
    const place = this.selected;
    const elements = new Set(place?.elements ?? []);
    const { positions } = this.marks;
    positions.fill(0);
    this.segments.forEach(([a, b, element], i) => {
      if (!elements.has(element)) return;
      for (let c = 0; c < 3; c++) {
        positions[6 * i + c] = this.now[3 * a + c]!;
        positions[6 * i + 3 + c] = this.now[3 * b + c]!;
      }
    });
    this.marks.moved();
    this.marks.object.visible = elements.size > 0;
    const dots = this.markDots.positions;
    // Dots without a place of their own hide behind one that has one.
    const node = place?.nodes.find((i) => i < this.data.nodes.length), sensor = place?.sensors.find((i) => i < this.data.sensors.length);
    const anchor = node != null ? this.now.slice(3 * node, 3 * node + 3) : sensor != null ? this.sensorBase.slice(3 * sensor, 3 * sensor + 3) : new Float32Array(3);
    for (let i = 0; i < dots.length; i += 3) dots.set(anchor, i);
    for (const i of place?.nodes ?? []) if (i < this.data.nodes.length) dots.set(this.now.subarray(3 * i, 3 * i + 3), 3 * i);
    const n = this.data.nodes.length;
    for (const i of place?.sensors ?? []) if (i < this.data.sensors.length) dots.set(this.sensorBase.subarray(3 * i, 3 * i + 3), 3 * (n + i));
    this.markDots.moved();
    this.markDots.object.visible = (place?.nodes.length ?? 0) + (place?.sensors.length ?? 0) > 0;
  }

  // ---- colours ------------------------------------------------------------------------------------------------

  private colour(): void {
    if (!this.theme) return;
    const t = this.theme;
    this.lines.paint((i, end) => {
      const segment = this.segments[i]!;
      return this.elementPaint(segment[2]) ?? this.pointColor(segment[end]!) ?? t.line;
    });
    this.ghost.paint(() => t.faint);
    this.links.paint(() => t.faint);
    this.marks.paint(() => t.accent);
    this.markDots.paint(() => t.accent);
    this.nodeDots.paint((i) => this.nodePaint(i) ?? t.node);
    const n = this.data.sensors.length;
    this.sensorDots.paint((i) => this.sensorPaint(i) ?? t.sensor);
    this.arrows.paint((i) => (i < n ? this.sensorPaint(i) ?? t.sensor : t.accent));
    const color = new Color();
    for (let i = 0; i < n + this.data.exciters.length; i++) {
      const rgb = i < n ? this.sensorPaint(i) ?? t.sensor : t.accent;
      this.cones.setColorAt(i, color.setRGB(rgb[0] / 255, rgb[1] / 255, rgb[2] / 255));
    }
    if (this.cones.instanceColor) this.cones.instanceColor.needsUpdate = true;
    this.held.forEach(({ kind, index }, i) => {
      const rgb = kind === "element" ? this.elementPaint(index) ?? t.line : t.node;
      this.feet.setColorAt(i, color.setRGB(rgb[0] / 255, rgb[1] / 255, rgb[2] / 255));
    });
    if (this.feet.instanceColor) this.feet.instanceColor.needsUpdate = true;
    (this.masses.material as MeshLambertMaterial).color.setRGB(t.mass[0] / 255, t.mass[1] / 255, t.mass[2] / 255);
    this.testDots.paint((i) => this.testPaint(i) ?? t.test);
    this.traces.paint((i, end) => {
      const sensor = this.tracePairs.length ? this.tracePairs[i]![end] : i;
      return this.testPaint(sensor) ?? t.test;
    });
    const face = this.faceMesh.geometry.attributes["color"] as BufferAttribute;
    let at = 0;
    for (const { element, nodes } of this.faces) {
      for (let k = 2; k < nodes.length; k++) {
        for (const node of [nodes[0]!, nodes[k - 1]!, nodes[k]!]) {
          const rgb = this.elementPaint(element) ?? this.nodePaint(node) ?? t.line;
          face.setXYZ(at++, rgb[0] / 255, rgb[1] / 255, rgb[2] / 255);
        }
      }
    }
    face.needsUpdate = true;
    this.request();
  }

  /** Colour of a node, or between two nodes along a beam. */
  private pointColor(point: number): Rgb | null {
    const n = this.data.nodes.length;
    if (point < n) return this.nodePaint(point);
    const at = (point - n) / (this.pieces - 1);
    const { nodes: [i, j], first } = this.beams[Math.floor(at)]!;
    const a = this.nodePaint(i), b = this.nodePaint(j), f = (point - first + 1) / this.pieces;
    return a && b ? (a.map((c, k) => Math.round(c + (b[k]! - c) * f)) as Rgb) : null;
  }

  private visible(): void {
    const l = this.layers;
    this.lines.object.visible = l.elements && this.segments.length > 0;
    this.faceMesh.visible = l.elements && this.faces.length > 0;
    this.ghost.object.visible = l.ghost && this.segments.length > 0;
    this.links.object.visible = l.links && this.linkPairs.length > 0;
    this.nodeDots.object.visible = l.nodes;
    this.masses.visible = l.masses;
    this.feet.visible = l.supports && this.held.length > 0;
    this.sensorDots.object.visible = this.arrows.object.visible = this.cones.visible = l.sensors;
    this.testDots.object.visible = l.test;
    this.traces.object.visible = l.test && this.traces.count > 0;
  }

  // ---- drawing ------------------------------------------------------------------------------------------------

  private start(): void {
    try {
      this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    } catch {
      this.root.replaceChildren(h("p", { class: "empty" },
        "This browser cannot draw in 3-D (WebGL is switched off). Every number is in the other sections."));
      return;
    }
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.visible();
    this.place();
    this.retheme();
    new ResizeObserver(() => this.request()).observe(this.root);
    this.listen();
  }

  private request(): void {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.draw();
    });
  }

  private draw(): void {
    const { clientWidth: width, clientHeight: height } = this.root;
    if (!this.renderer || width === 0 || height === 0) return;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    if (this.overlay.width !== Math.round(width * ratio) || this.overlay.height !== Math.round(height * ratio)) {
      this.renderer.setPixelRatio(ratio);
      this.renderer.setSize(width, height, false);
      this.overlay.width = Math.round(width * ratio);
      this.overlay.height = Math.round(height * ratio);
    }
    // Never under the buttons along the upper edge, which take 46 pixels.
    const fill = Math.max(0.5, Math.min(this.fill, 1 - 92 / height));
    if (this.fitted) this.orbit = fit(this.orbit, this.cloud, this.up, width / height, fill);
    this.look(width, height);
    this.renderer.render(this.scene, this.camera);
    this.annotate(width, height, ratio);
    this.root.dataset["drawn"] = String(Number(this.root.dataset["drawn"] ?? 0) + 1);
  }

  private look(width: number, height: number): void {
    const { camera, orbit, up } = this;
    camera.aspect = width / height;
    const at = eye(orbit, up);
    camera.up.set(up === 0 ? 1 : 0, up === 1 ? 1 : 0, up === 2 ? 1 : 0);
    camera.position.set(...at);
    camera.near = orbit.distance * 0.01;
    camera.far = orbit.distance + this.home.radius * 8;
    camera.lookAt(...orbit.target);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
  }

  private flat(x: number, y: number, z: number, out = new Vector3()): Flat {
    out.set(x, y, z).project(this.camera);
    return { x: ((out.x + 1) / 2) * this.root.clientWidth, y: ((1 - out.y) / 2) * this.root.clientHeight, depth: out.z };
  }

  private annotate(width: number, height: number, ratio: number): void {
    const context = this.overlay.getContext("2d");
    if (!context) return;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    context.font = "12px system-ui, sans-serif";
    context.lineJoin = "round";
    const write = (text: string, x: number, y: number): void => {
      context.lineWidth = 3;
      context.strokeStyle = this.theme.halo;
      context.strokeText(text, x, y);
      context.fillStyle = this.theme.text;
      context.fillText(text, x, y);
    };
    const taken: [number, number, number, number][] = [];
    const label = (text: string, p: Flat): void => {
      const w = context.measureText(text).width;
      const box: [number, number, number, number] = [p.x + 7, p.y - 14, p.x + 9 + w, p.y + 1];
      if (Math.abs(p.depth) > 1 || taken.some((t) => t[0] < box[2] && box[0] < t[2] && t[1] < box[3] && box[1] < t[3])) return;
      taken.push(box);
      write(text, p.x + 8, p.y - 4);
    };
    if (this.layers.names) {
      if (this.layers.nodes) this.data.nodes.forEach((n, i) => label(n.name, this.flat(...this.nodeNow(i))));
      if (this.layers.sensors) this.data.sensors.forEach((s) => label(s.name, this.flat(...s.position)));
    }
    // The axes, bottom left.
    const origin = this.flat(...this.orbit.target);
    for (const [k, name] of ["x", "y", "z"].entries()) {
      const end: Vec3 = [...this.orbit.target];
      end[k]! += this.orbit.distance * 0.05;
      const p = this.flat(...end);
      const size = height * 0.085, scale = 30 / size;
      const x = 44 + (p.x - origin.x) * scale * 0.9, y = height - 44 + (p.y - origin.y) * scale * 0.9;
      context.strokeStyle = this.theme.text;
      context.globalAlpha = 0.65;
      context.lineWidth = 1.5;
      context.beginPath();
      context.moveTo(44, height - 44);
      context.lineTo(x, y);
      context.stroke();
      if (Math.hypot(x - 44, y - height + 44) > 8) write(name, x + (x - 44) * 0.22 - 3, y + (y - height + 44) * 0.22 + 4);
      context.globalAlpha = 1;
    }
  }

  // ---- pointer and keys ---------------------------------------------------------------------------------------

  private *targets(): Generator<Target> {
    const l = this.layers;
    const at = (a: Float32Array, i: number): Flat => this.flat(a[3 * i]!, a[3 * i + 1]!, a[3 * i + 2]!);
    if (l.sensors || l.test) {
      const from = l.test ? this.sensorNow : this.sensorBase;
      for (let i = 0; i < this.data.sensors.length; i++) yield { kind: "sensor", index: i, points: [at(from, i)] };
    }
    if (l.sensors) for (const [i, e] of this.data.exciters.entries()) {
      const tip = e.position.map((p, k) => p + (e.direction[k]! * this.home.radius * 0.14) / (Math.hypot(...e.direction) || 1)) as Vec3;
      yield { kind: "exciter", index: i, points: [this.flat(...tip)] };
    }
    if (l.masses) for (const [i, m] of this.data.masses.entries()) {
      if (m.node >= this.data.nodes.length) continue;
      const p = this.nodeNow(m.node), o = m.offset ?? [0, 0, 0];
      if (Math.hypot(...o) > 0) yield { kind: "mass", index: i, points: [this.flat(p[0] + o[0], p[1] + o[1], p[2] + o[2])] };
    }
    if (l.supports) for (const { kind, index, node } of this.held) {
      const p = this.nodeBase(node);
      p[this.up]! -= 1.7 * this.footSize;
      yield { kind, index, points: [this.flat(...p)] };
    }
    if (l.nodes) for (let i = 0; i < this.data.nodes.length; i++) yield { kind: "node", index: i, points: [at(this.now, i)] };
    if (l.elements) {
      for (const { element, first, nodes: [a, b] } of this.beams) {
        const points = [at(this.now, a)];
        for (let k = 1; k < this.pieces; k++) points.push(at(this.now, first + k - 1));
        points.push(at(this.now, b));
        yield { kind: "element", index: element, points };
      }
      for (const { element, nodes } of this.faces) yield { kind: "element", index: element, points: nodes.map((n) => at(this.now, n)), closed: true };
    }
    if (l.links) for (const [a, b, link] of this.linkPairs) yield { kind: "link", index: link, points: [at(this.now, a), at(this.now, b)] };
  }

  private hitAt(event: PointerEvent): Hit | null {
    const box = this.canvas.getBoundingClientRect();
    return pick(event.clientX - box.left, event.clientY - box.top, this.targets(), event.pointerType === "touch" ? 20 : 11);
  }

  private listen(): void {
    const down = new Map<number, { x: number; y: number }>();
    let moved = 0;
    const { canvas } = this;
    canvas.addEventListener("pointerdown", (e) => {
      if (down.size === 0) moved = 0;
      down.set(e.pointerId, { x: e.clientX, y: e.clientY });
      canvas.setPointerCapture(e.pointerId);
      this.tip.hidden = true;
    });
    canvas.addEventListener("pointermove", (e) => {
      const last = down.get(e.pointerId);
      if (!last) {
        if (this.options.pickable) this.hover(e);
        return;
      }
      const dx = e.clientX - last.x, dy = e.clientY - last.y;
      moved += Math.abs(dx) + Math.abs(dy);
      if (down.size === 2) {
        const other = [...down].find(([id]) => id !== e.pointerId)![1];
        const before = Math.hypot(last.x - other.x, last.y - other.y), after = Math.hypot(e.clientX - other.x, e.clientY - other.y);
        if (after > 0) this.orbit = zoom(this.orbit, before / after, this.home.radius);
      } else if (e.shiftKey || e.buttons === 2 || e.buttons === 4) this.pan(dx, dy);
      else this.orbit = turn(this.orbit, dx, dy);
      this.fitted = false;
      down.set(e.pointerId, { x: e.clientX, y: e.clientY });
      this.request();
    });
    const release = (e: PointerEvent): void => {
      down.delete(e.pointerId);
    };
    canvas.addEventListener("pointerup", (e) => {
      release(e);
      if (moved < 6 && this.options.pickable) this.options.onPick?.(this.hitAt(e));
    });
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("pointerleave", () => (this.tip.hidden = true));
    canvas.addEventListener("contextmenu", (e) => e.preventDefault());
    canvas.addEventListener("wheel", (e) => {
      // The page scrolls over a picture that was not chosen; a chosen one zooms.
      if (document.activeElement !== canvas && !e.ctrlKey) return;
      e.preventDefault();
      this.fitted = false;
      this.orbit = zoom(this.orbit, Math.exp(e.deltaY * 0.0012), this.home.radius);
      this.request();
    }, { passive: false });
    canvas.addEventListener("keydown", (e) => {
      const step = 24;
      const turns: Record<string, [number, number]> = {
        ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step],
      };
      const by = turns[e.key];
      if (by || ["+", "=", "-"].includes(e.key)) this.fitted = false;
      if (by && e.shiftKey) this.pan(...by);
      else if (by) this.orbit = turn(this.orbit, ...by);
      else if (e.key === "+" || e.key === "=") this.orbit = zoom(this.orbit, 0.85, this.home.radius);
      else if (e.key === "-") this.orbit = zoom(this.orbit, 1 / 0.85, this.home.radius);
      else if (e.key === "0") this.view("iso");
      else return;
      e.preventDefault();
      this.request();
    });
  }

  private hover(event: PointerEvent): void {
    const hit = this.hitAt(event);
    this.canvas.style.cursor = hit ? "pointer" : "grab";
    if (!hit || !this.options.describe) {
      this.tip.hidden = true;
      return;
    }
    const box = this.canvas.getBoundingClientRect();
    this.tip.textContent = this.options.describe(hit);
    this.tip.hidden = false;
    const x = event.clientX - box.left, right = x > box.width / 2;
    this.tip.style.left = right ? "auto" : `${x + 14}px`;
    this.tip.style.right = right ? `${box.width - x + 14}px` : "auto";
    this.tip.style.top = `${Math.max(4, event.clientY - box.top - 10)}px`;
  }

  private pan(dx: number, dy: number): void {
    const scale = (2 * this.orbit.distance * Math.tan(HALF_VIEW)) / this.root.clientHeight;
    const right = new Vector3().setFromMatrixColumn(this.camera.matrixWorld, 0);
    const upward = new Vector3().setFromMatrixColumn(this.camera.matrixWorld, 1);
    const target = new Vector3(...this.orbit.target).addScaledVector(right, -dx * scale).addScaledVector(upward, dy * scale);
    this.orbit = { ...this.orbit, target: [target.x, target.y, target.z] };
    this.request();
  }

  private buttons(): HTMLElement {
    const near = (factor: number) => () => {
      this.fitted = false;
      this.orbit = zoom(this.orbit, factor, this.home.radius);
      this.request();
    };
    return h("div", { class: "viewer-buttons", role: "group", "aria-label": "View" },
      Object.entries(VIEWS).map(([name, v]) =>
        h("button", { type: "button", "data-view": name, onclick: () => this.view(name) }, v.text)),
      h("button", { type: "button", "aria-label": "Zoom in", onclick: near(0.8) }, "+"),
      h("button", { type: "button", "aria-label": "Zoom out", onclick: near(1.25) }, "−"));
  }
}

/** Every viewer of the page, so that a change of theme reaches all. */
export const viewers: Viewer[] = [];

export function makeViewer(...parameters: ConstructorParameters<typeof Viewer>): Viewer {
  const viewer = new Viewer(...parameters);
  viewers.push(viewer);
  return viewer;
}
