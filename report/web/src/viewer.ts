/** The structure in 3-D: what is drawn, how it moves, what is picked. Sections only say what to show. */

import {
  AmbientLight, BufferAttribute, BufferGeometry, Color, ColorManagement, ConeGeometry, DirectionalLight,
  InstancedMesh, LinearSRGBColorSpace, Matrix4, Mesh, MeshLambertMaterial,
  PerspectiveCamera, Quaternion, Scene, Vector3, WebGLRenderer,
} from "three";
import { parseHex, type Rgb } from "./color";
import { h } from "./dom";
import { Lines } from "./lines";
import { across, extent, extremes, eye, fit, HALF_VIEW, turn, VIEWS, zoom, type Orbit } from "./orbit";
import { pick, type Flat, type Hit } from "./pick";
import { atPhase, type Shape } from "./shape";
import type { Place, Structure, Vec3 } from "./types";
import { Dots } from "./viewer/dots";
import { listen } from "./viewer/gestures";
import { axes, clear, names, type Paper } from "./viewer/labels";
import { Sensed, type PointPainter } from "./viewer/sensed";
import { Skeleton } from "./viewer/skeleton";
import { faceMesh, masses, placeArrows, sectionAxes } from "./viewer/solids";
import { flat, targets, type Held, type Sight } from "./viewer/targets";

ColorManagement.enabled = false;

export type Layer = "axes" | "nodes" | "elements" | "links" | "masses" | "sensors" | "supports" | "ghost" | "test" | "names";
export type Painter = (index: number) => Rgb | null;

interface Theme { line: Rgb; faint: Rgb; node: Rgb; sensor: Rgb; mass: Rgb; accent: Rgb; test: Rgb; model: Rgb; text: string; halo: string }

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
  private readonly cloud: readonly (readonly number[])[];
  /** What the picture was fitted to last. */
  private fittedTo = "";
  private layers: Record<Layer, boolean> = {
    axes: false, nodes: true, elements: true, links: true, masses: true, sensors: true, supports: true, ghost: false, test: false, names: false,
  };

  private readonly skeleton: Skeleton;
  private readonly now: Float32Array;
  private readonly shift: Float32Array;
  private shape: Shape | null = null;
  private readonly lines: Lines;
  private readonly ghost: Lines;
  private readonly links: Lines;
  private readonly arrows: Lines;
  /** The lines around what is marked, and the points that they join. */
  private marks = new Lines(0, 10, 0.55);
  private markEnds: number[] = [];
  private readonly sectionAxes: Lines;
  private readonly nodeDots: Dots;
  private readonly sensorDots: Dots;
  private readonly sensed: Sensed;
  private markDots = new Dots(0, 20);
  private readonly faceMesh: Mesh<BufferGeometry, MeshLambertMaterial>;
  private readonly masses: InstancedMesh;
  private readonly cones: InstancedMesh;
  /** Pyramids under what is held: supports, then elements to the ground. */
  private readonly feet: InstancedMesh;
  private readonly held: Held[] = [];
  private readonly sensorBase: Float32Array;
  /** The picture that looks from the same side. */
  private twin: Viewer | null = null;
  private selected: Place | null = null;

  private elementPaint: Painter = () => null;
  private nodePaint: Painter = () => null;
  private sensorPaint: Painter = () => null;
  private testPaint: PointPainter = () => null;

  constructor(
    private readonly data: Structure,
    private readonly options: { label: string; pickable?: boolean; fill?: number; onPick?: (hit: Hit | null) => void; describe?: (hit: Hit) => string },
  ) {
    const { nodes, elements } = data;
    this.up = data.up ?? 2;
    this.fill = options.fill ?? 0.84;
    const points = [...nodes.map((n) => n.position), ...data.sensors.map((s) => s.position)];
    this.home = extent(points);
    this.cloud = extremes(points);
    this.oblique = across(nodes.length ? nodes.map((n) => n.position) : points, this.up);
    this.orbit = { ...this.named("iso"), distance: this.home.radius * 3.7, target: [...this.home.centre] };

    this.skeleton = new Skeleton(data);
    const { base, linkPairs, segments } = this.skeleton;
    this.now = base.slice();
    this.shift = new Float32Array(base.length);
    this.sensorBase = new Float32Array(data.sensors.flatMap((s) => s.position));
    this.sensed = new Sensed(data);

    this.ghost = new Lines(segments.element.length, 1.2, 0.55);
    this.ghost.place(segments.ends, base);
    this.links = new Lines(linkPairs.length, 1.6);
    this.lines = new Lines(segments.element.length, elements.length > 1200 || this.skeleton.faces.element.length ? 1.6 : 5);
    this.arrows = new Lines(data.sensors.length + data.exciters.length, 1.8);
    this.sectionAxes = sectionAxes(data, this.home.radius);
    this.nodeDots = new Dots(nodes.length, nodes.length > 800 ? 2.5 : 6);
    this.sensorDots = new Dots(data.sensors.length, 9);
    this.faceMesh = faceMesh(this.skeleton.faces);
    this.masses = masses(data.masses.length);
    this.cones = new InstancedMesh(new ConeGeometry(1, 3.2, 14), new MeshLambertMaterial(), data.sensors.length + data.exciters.length);
    this.cones.frustumCulled = false;
    placeArrows(data, this.home.radius, this.arrows, this.cones);
    data.supports.forEach((b, index) => { if (b.node < nodes.length) this.held.push({ kind: "support", index, node: b.node }); });
    elements.forEach((e, index) => { if (e.nodes.length === 1 && e.nodes[0]! < nodes.length) this.held.push({ kind: "element", index, node: e.nodes[0]! }); });
    this.feet = new InstancedMesh(new ConeGeometry(1, 1.7, 4), new MeshLambertMaterial(), this.held.length);
    this.feet.frustumCulled = false;
    this.placeFeet();
    this.scene.add(this.feet, new AmbientLight(0xffffff, 1.6), this.cones, this.masses, this.faceMesh,
      this.ghost.object, this.links.object, this.lines.object, this.arrows.object, this.sectionAxes.object,
      this.nodeDots.object, this.sensorDots.object, ...this.sensed.objects);
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
  paint(painters: { elements?: Painter; nodes?: Painter; sensors?: Painter; test?: PointPainter }): void {
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
    this.sensed.set(test);
    this.shape = model ? this.skeleton.spread(model.displacement, model.rotation) : null;
    this.frame(0, 0);
  }

  /** Moves everything to a phase (rad); amplitude is a part of the structure's half-diagonal. */
  frame(phase: number, amplitude: number): void {
    const world = amplitude * this.home.radius;
    if (this.shape) atPhase(this.shape, phase, world, this.shift);
    else this.shift.fill(0);
    for (let i = 0; i < this.now.length; i++) this.now[i] = this.skeleton.base[i]! + this.shift[i]!;
    this.sensed.place(phase, world);
    this.place();
    this.request();
  }

  /** Marks a place, or nothing. */
  highlight(place: Place | null): void {
    for (const old of [this.marks, this.markDots]) {
      this.scene.remove(old.object);
      old.dispose();
    }
    const nodes = (place?.nodes ?? []).filter((i) => i < this.data.nodes.length), sensors = (place?.sensors ?? []).filter((i) => i < this.data.sensors.length);
    this.selected = place && { ...place, nodes, sensors };
    this.markEnds = (place?.elements ?? []).flatMap((e) => this.skeleton.around(e)).flat();
    this.marks = new Lines(this.markEnds.length / 2, 10, 0.55);
    this.markDots = new Dots(nodes.length + sensors.length, 20);
    this.markDots.object.material.opacity = 0.6;
    this.scene.add(this.marks.object, this.markDots.object);
    this.marks.paint(() => this.theme.accent);
    this.markDots.paint(() => this.theme.accent);
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
    this.look({ ...this.named(name), distance: this.home.radius * 3.7, target: [...this.home.centre] }, true);
  }

  /** Two pictures of one structure look from the same side from now on. */
  join(other: Viewer): void {
    [this.twin, other.twin] = [other, this];
    this.look(this.orbit, this.fitted);
  }

  private look(orbit: Orbit, fitted = false): void {
    for (const v of this.twin ? [this, this.twin] : [this]) {
      v.orbit = { ...orbit };
      v.fitted = fitted;
      v.request();
    }
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
    for (const target of targets(this.sight())) {
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

  private place(): void {
    this.lines.place(this.skeleton.segments.ends, this.now);
    this.links.place(this.skeleton.linkPairs.flatMap(([a, b]) => [a, b]), this.now);
    this.nodeDots.positions.set(this.now.subarray(0, this.nodeDots.positions.length));
    this.sensorDots.positions.set(this.sensorBase);
    for (const dots of [this.nodeDots, this.sensorDots]) dots.moved();
    const corners = this.skeleton.faces.nodes, face = this.faceMesh.geometry.attributes["position"] as BufferAttribute, to = face.array as Float32Array;
    for (let k = 0, at = 0; k < corners.length; k++) {
      const p = 3 * corners[k]!;
      to[at++] = this.now[p]!;
      to[at++] = this.now[p + 1]!;
      to[at++] = this.now[p + 2]!;
    }
    face.needsUpdate = true;
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
      const p = new Vector3(...this.skeleton.node(node)).addScaledVector(down, -0.85 * size);
      matrix.compose(p, turnTo, new Vector3(size, size, size));
      this.feet.setMatrixAt(i, matrix);
    });
  }

  private mark(): void {
    this.marks.place(this.markEnds, this.now);
    const dots = this.markDots.positions, place = this.selected;
    const copy = (to: number, from: Float32Array, i: number): void => dots.set(from.subarray(3 * i, 3 * i + 3), 3 * to);
    place?.nodes.forEach((i, k) => copy(k, this.now, i));
    place?.sensors.forEach((i, k) => copy(place.nodes.length + k, this.sensorBase, i));
    this.markDots.moved();
    this.markDots.object.visible = dots.length > 0;
  }

  // ---- colours ------------------------------------------------------------------------------------------------

  private colour(): void {
    if (!this.theme) return;
    const t = this.theme;
    const { segments } = this.skeleton;
    this.lines.paint((i, end) => this.elementPaint(segments.element[i]!) ?? this.pointColor(segments.ends[2 * i + end]!) ?? t.line);
    this.ghost.paint(() => t.faint);
    this.links.paint(() => t.faint);
    this.marks.paint(() => t.accent);
    this.sectionAxes.paint(() => t.sensor);
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
    this.sensed.paint(this.testPaint, t.test);
    const face = this.faceMesh.geometry.attributes["color"] as BufferAttribute, { nodes, first, element } = this.skeleton.faces;
    for (let f = 0; f < element.length; f++) {
      const own = this.elementPaint(element[f]!);
      for (let k = first[f]!; k < first[f + 1]!; k++) {
        const rgb = own ?? this.nodePaint(nodes[k]!) ?? t.line;
        face.setXYZ(k, rgb[0] / 255, rgb[1] / 255, rgb[2] / 255);
      }
    }
    face.needsUpdate = true;
    this.request();
  }

  /** Colour of a node, or between two nodes along a beam. */
  private pointColor(point: number): Rgb | null {
    const n = this.data.nodes.length;
    if (point < n) return this.nodePaint(point);
    const at = (point - n) / (this.skeleton.pieces - 1);
    const { nodes: [i, j], first } = this.skeleton.beams[Math.floor(at)]!;
    const a = this.nodePaint(i), b = this.nodePaint(j), f = (point - first + 1) / this.skeleton.pieces;
    return a && b ? (a.map((c, k) => Math.round(c + (b[k]! - c) * f)) as Rgb) : null;
  }

  private visible(): void {
    const l = this.layers;
    this.lines.object.visible = l.elements && this.skeleton.segments.element.length > 0;
    this.faceMesh.visible = l.elements && this.skeleton.faces.element.length > 0;
    this.ghost.object.visible = l.ghost && this.skeleton.segments.element.length > 0;
    this.links.object.visible = l.links && this.skeleton.linkPairs.length > 0;
    this.nodeDots.object.visible = l.nodes;
    this.sectionAxes.object.visible = l.axes && this.sectionAxes.count > 0;
    this.masses.visible = l.masses;
    this.feet.visible = l.supports && this.held.length > 0;
    this.sensorDots.object.visible = this.arrows.object.visible = this.cones.visible = l.sensors;
    this.sensed.show(l.test);
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
    // Asking how its programs were compiled waits for them; they are the same on every page.
    this.renderer.debug.checkShaderErrors = false;
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
    const wanted = `${width} ${height} ${this.orbit.azimuth} ${this.orbit.elevation}`;
    if (this.fitted && wanted !== this.fittedTo) this.orbit = fit(this.orbit, this.cloud, this.up, width / height, fill);
    this.fittedTo = this.fitted ? wanted : "";
    this.aim(width, height);
    this.renderer.render(this.scene, this.camera);
    this.annotate(width, height, ratio);
    this.root.dataset["drawn"] = String(Number(this.root.dataset["drawn"] ?? 0) + 1);
  }

  private aim(width: number, height: number): void {
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

  /** What is to be seen, and how it comes to the screen. */
  private sight(): Sight {
    const matrix = new Matrix4().multiplyMatrices(this.camera.projectionMatrix, this.camera.matrixWorldInverse).elements;
    const { data, skeleton, sensed, layers, held, now, sensorBase, up, footSize } = this;
    return { data, skeleton, sensed, layers, held, now, sensorBase, radius: this.home.radius, up, footSize, matrix, width: this.root.clientWidth, height: this.root.clientHeight };
  }

  private annotate(width: number, height: number, ratio: number): void {
    const context = this.overlay.getContext("2d");
    if (!context) return;
    const paper: Paper = { context, width, height, ink: this.theme.text, halo: this.theme.halo };
    clear(paper, ratio);
    const sight = this.sight();
    if (this.layers.names) {
      const nodes = this.layers.nodes ? this.data.nodes.map((n, i) => ({ text: n.name, at: flat(sight, this.nodeNow(i)) })) : [];
      const sensors = this.layers.sensors ? this.data.sensors.map((s) => ({ text: s.name, at: flat(sight, s.position) })) : [];
      names(paper, [...nodes, ...sensors]);
    }
    const end = (k: number): Flat => {
      const at: Vec3 = [...this.orbit.target];
      at[k]! += this.orbit.distance * 0.05;
      return flat(sight, at);
    };
    axes(paper, flat(sight, this.orbit.target), [end(0), end(1), end(2)]);
  }

  // ---- pointer and keys ---------------------------------------------------------------------------------------

  private hitAt(event: PointerEvent): Hit | null {
    const box = this.canvas.getBoundingClientRect();
    const reach = event.pointerType === "touch" ? 20 : 11, x = event.clientX - box.left, y = event.clientY - box.top;
    return pick(x, y, targets(this.sight(), { x, y, reach }), reach);
  }

  private listen(): void {
    listen(this.canvas, {
      turn: (dx, dy) => this.look(turn(this.orbit, dx, dy)),
      pan: (dx, dy) => this.pan(dx, dy),
      zoom: (factor) => this.look(zoom(this.orbit, factor, this.home.radius)),
      reset: () => this.view("iso"),
      pick: (e) => { if (this.options.pickable) this.options.onPick?.(this.hitAt(e)); },
      hover: (e) => { if (this.options.pickable) this.hover(e); },
      leave: () => { this.tip.hidden = true; },
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
    this.look({ ...this.orbit, target: [target.x, target.y, target.z] });
  }

  private buttons(): HTMLElement {
    const near = (factor: number) => () => this.look(zoom(this.orbit, factor, this.home.radius));
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
