import assert from "node:assert/strict";
import { test } from "node:test";
import { density, histogram } from "../src/bins";
import { categories, contrast, ink, onStage, parseHex, sample } from "../src/color";
import { floats, motion, polar } from "../src/decode";
import { csvCell } from "../src/dom";
import { fixed, folded, minuses, percent, plain, powers, probability, quoted, shorten, shortMode, significant, slug, unit } from "../src/format";
import { across, axes, extent, extremes, eye, fit, HALF_VIEW, turn, zoom, type Orbit } from "../src/orbit";
import { inside, pick, segmentDistance, type Target } from "../src/pick";
import { atPhase, beamPoint, difference, peak, peakOfNodes, scaleFactor, times } from "../src/shape";
import { unzipSync, strFromU8 } from "fflate";
import { columnName, workbook } from "../src/workbook";
import { edges } from "../src/viewer/edges";
import { neighbours, Wire } from "../src/viewer/wire";

const near = (a: number, b: number, by = 1e-6): void => assert.ok(Math.abs(a - b) <= by, `${a} is not ${b}`);

test("floats are read little-endian", () => {
  assert.deepEqual([...floats("AACAPwAAAMA=")], [1, -2]);
  assert.equal(floats(undefined).length, 0);
  assert.equal(floats("").length, 0);
});

test("levels are summed from node to node, axis by axis, and may be missing", () => {
  // Multiples 1, 2, -3 | 3, -32768, -2047 as differences of 16 bits.
  const words = Int16Array.from([1, 2, -3, 2, -32768 - 2, -2047 + 3]);
  const found = motion(undefined, { step: 0.5, data: Buffer.from(words.buffer).toString("base64") });
  assert.deepEqual([...found], [0.5, 1, -1.5, 1.5, NaN, -1023.5]);
  assert.deepEqual([...motion("AACAPwAAAMA=", undefined)], [1, -2]);
});

/** Corners and ends of squares of a grid of n by n. */
function grid(n: number, height: (x: number, y: number) => number): { faces: Parameters<typeof edges>[0]; at: Float32Array } {
  const nodes: number[] = [], first = [0], at: number[] = [];
  for (let y = 0; y <= n; y++) for (let x = 0; x <= n; x++) at.push(x, y, height(x, y));
  for (let y = 0; y < n; y++) {
    for (let x = 0; x < n; x++) {
      const a = y * (n + 1) + x;
      nodes.push(a, a + 1, a + n + 2, a + n + 1);
      first.push(nodes.length);
    }
  }
  return { faces: { nodes: Int32Array.from(nodes), first: Int32Array.from(first), element: Int32Array.from({ length: n * n }, (_, i) => i) }, at: Float32Array.from(at) };
}

test("few faces have all edges, each once; many have those at which they end, fold or change hands", () => {
  const few = grid(10, () => 0);
  assert.equal(edges(few.faces, few.at, 121, () => "").element.length, 2 * 10 * 11);
  const n = 70, nodes = (n + 1) ** 2, flat = grid(n, () => 0);
  assert.equal(edges(flat.faces, flat.at, nodes, () => "").element.length, 4 * n);
  // A roof of 45 degrees folds along its ridge, one of 10 degrees a side does not.
  const roof = (slope: number) => grid(n, (x) => -slope * Math.abs(x - n / 2));
  assert.equal(edges(roof(1).faces, roof(1).at, nodes, () => "").element.length, 5 * n);
  assert.equal(edges(roof(0.17).faces, roof(0.17).at, nodes, () => "").element.length, 4 * n);
  // Two groups meet along a line of n edges.
  const found = edges(flat.faces, flat.at, nodes, (face) => (face < (n / 2) * n ? "a" : "b"));
  assert.equal(found.element.length, 5 * n);
  assert.equal(new Set(Array.from({ length: found.element.length }, (_, i) => `${found.ends[2 * i]} ${found.ends[2 * i + 1]}`)).size, 5 * n);
});

test("the outline of a large cloud is as large as the cloud from every side", () => {
  const cloud: number[][] = [];
  for (let i = 0; i < 30_000; i++) {
    const z = 1 - (2 * i + 1) / 30_000, r = Math.sqrt(1 - z * z);
    cloud.push([3 * r * Math.cos(i), 2 * r * Math.sin(i), z]);
  }
  const outline = extremes(cloud);
  assert.ok(outline.length < 1000, `${outline.length}`);
  for (let k = 0; k < 50; k++) {
    const d = [Math.cos(k), Math.sin(k) * Math.cos(3 * k), Math.sin(k) * Math.sin(3 * k)];
    const reach = (points: readonly (readonly number[])[]): number => points.reduce((m, p) => Math.max(m, p[0]! * d[0]! + p[1]! * d[1]! + p[2]! * d[2]!), 0);
    assert.ok(reach(outline) > 0.985 * reach(cloud), `${k}: ${reach(outline)} of ${reach(cloud)}`);
  }
  const few = cloud.slice(0, 500);
  assert.equal(extremes(few), few);
});

test("a spectrum is unfolded from its logarithm", () => {
  // a = 1, p = 0; a = 0 (missing); a = 3, p = 49152 (270 degrees)
  const bytes = Buffer.from([1, 0, 0, 0, 0, 0, 5, 0, 3, 0, 0, 192]);
  const h = polar({ log_low: Math.log(2), log_step: Math.log(3), data: bytes.toString("base64") });
  near(h.amplitude[0]!, 2);
  assert.ok(Number.isNaN(h.amplitude[1]) && Number.isNaN(h.phase[1]));
  near(h.amplitude[2]!, 18, 1e-9);
  near(h.phase[2]!, -90);
});

test("numbers are written as people read them", () => {
  assert.equal(significant(5.528508, 4), "5.529");
  assert.equal(quoted("with `1st Bending`; a ` alone"), "with “1st Bending”; a ` alone");
  assert.equal(powers("1 of 10^300, 10^-7 and 210^3"), "1 of 10³⁰⁰, 10⁻⁷ and 210^3");
  assert.equal(significant(19.884), "19.88");
  assert.equal(significant(-0.0421, 3), "−0.0421");
  assert.equal(significant(3e-9, 2), "3.0e−9");
  assert.equal(significant(0), "0");
  assert.equal(significant(20504), "20504");
  assert.equal(percent(0.0453), "+4.5 %");
  assert.equal(percent(-0.0001), "0.0 %");
  assert.equal(percent(-0.017), "−1.7 %");
  assert.equal(fixed(-0, 2), "0.00");
  assert.deepEqual([probability(0.9999), probability(1e-4), probability(0.93), probability(0), probability(1)], ["> 0.99", "< 0.01", "0.93", "< 0.01", "1.00"]);
  for (const f of [significant, percent, probability] as ((v: number | null) => string)[]) {
    assert.equal(f(null), "–");
    assert.equal(f(NaN), "–");
  }
});

test("modes have the short names of engineers, logarithmic axes plain numbers, and spreadsheets no formulas", () => {
  assert.deepEqual(["Sym 1st Bending", "Anti 2nd Vertical Bending", "antisymmetric 1st torsion", "1st Lateral Bending", "Anti 1st Fore-aft Bending", "mode 12", "M1", "<b>"].map(shortMode),
    ["S1B", "A2VB", "A1T", "1LB", "A1FB", "12", null, null]);
  assert.deepEqual(["=1+1", "@x", "+cmd", "-x", "−3.5 %", "+4.5 %", 'a "b", c', "–", "12"].map(csvCell), ["'=1+1", "'@x", "'+cmd", "'-x", "-3.5 %", "+4.5 %", '"a ""b"", c"', "", "12"]);
});

test("chart labels cannot carry markup", () => {
  assert.equal(plain("<a href='javascript:x'>&</a>"), "&lt;a href='javascript:x'&gt;&amp;&lt;/a&gt;");
  assert.equal(slug("../Etc / päß <x>"), "etc-p-x");
  assert.equal(shorten("abcdefghij", 5), "ab…ij");
});

test("text on every map colour and every label colour reads well", () => {
  for (const map of ["cividis", "viridis", "diverging"] as const) {
    for (let i = 0; i <= 100; i++) {
      const rgb = sample(map, i / 100);
      assert.ok(contrast(rgb, parseHex(ink(rgb))) >= 4.2, `${map} ${i}`);
    }
  }
  assert.deepEqual(sample("viridis", NaN), [150, 150, 150]);
  assert.deepEqual(sample("viridis", 9), sample("viridis", 1));
});

test("what lies on the stage stands out from it in both themes", () => {
  for (const dark of [false, true]) {
    const stage = parseHex(dark ? "141b23" : "f7f9fb");
    for (const map of ["cividis", "viridis"] as const) {
      for (let i = 0; i <= 20; i++) assert.ok(contrast(onStage(map, i / 20, dark), stage) > 1.35, `${map} ${i} ${dark}`);
    }
    for (const color of categories(dark)) assert.ok(contrast(parseHex(color), stage) > 2.4, color);
  }
});

test("the scale factor brings the test onto the model", () => {
  const a = { re: Float32Array.of(1, 2, -3) };
  const x = times(a, [0, 2]);
  const [re, im] = scaleFactor(x, a);
  near(re, 0);
  near(im, -0.5);
  const back = times(x, [re, im]);
  near(Math.max(...difference(back, a)), 0);
  const gaps = { re: Float32Array.of(2, NaN, -6) };
  near(scaleFactor(gaps, a)[0], 0.5);
  assert.deepEqual(scaleFactor({ re: new Float32Array(3) }, a), [0, 0]);
});

test("peaks and phases", () => {
  near(peak({ re: Float32Array.of(3, NaN), im: Float32Array.of(4, 0) }), 5);
  near(peakOfNodes({ re: Float32Array.of(1, 2, 2, 0, 0, 1) }), 3);
  const out = new Float32Array(2);
  atPhase({ re: Float32Array.of(1, NaN), im: Float32Array.of(2, 0) }, Math.PI / 2, 3, out);
  near(out[0]!, -6, 1e-5);
  assert.equal(out[1], 0);
});

test("a beam bends by its cubic: a cantilever under an end load", () => {
  // w = P (3 L x² - x³)/(6 E I): with w(L) = 1, the slope is 1.5/L and w(L/2) = 5/16.
  const L = 2;
  const point = beamPoint([0, 0, 0], [L, 0, 0], [0, 0, 0], [0, 0, 1], [0, 0, 0], [0, -1.5 / L, 0], 0.5);
  near(point[2], 5 / 16);
  near(point[0], 0);
  assert.deepEqual(beamPoint([0, 0, 0], [L, 0, 0], [0, 0, 0], [1, 0, 1], null, null, 0.5), [0.5, 0, 0.5]);
});

test("a rigid rotation keeps a beam straight", () => {
  const angle = 0.01, L = 3;
  for (const t of [0.2, 0.5, 0.9]) {
    const point = beamPoint([0, 0, 0], [0, L, 0], [0, 0, 0], [0, 0, angle * L], [angle, 0, 0], [angle, 0, 0], t);
    near(point[2], angle * L * t, 1e-12);
  }
});

test("points win over the lines that they sit on", () => {
  const at = (x: number, y: number) => ({ x, y, depth: 0 });
  const targets: Target[] = [
    { kind: "element", index: 0, points: [at(0, 0), at(100, 0)] },
    { kind: "node", index: 4, points: [at(0, 0)] },
    { kind: "sensor", index: 7, points: [at(50, 3)] },
  ];
  assert.equal(pick(1, 1, targets)?.kind, "node");
  assert.equal(pick(51, 1, targets)?.kind, "sensor");
  assert.deepEqual([pick(25, 2, targets)?.kind, pick(25, 2, targets)?.index], ["element", 0]);
  assert.equal(pick(25, 40, targets), null);
  assert.equal(pick(0, 0, [{ kind: "node", index: 0, points: [{ x: 0, y: 0, depth: 3 }] }]), null);
  near(segmentDistance(5, 4, at(0, 0), at(3, 0)), Math.hypot(2, 4));
  assert.ok(inside(1, 1, [at(0, 0), at(4, 0), at(0, 4)]) && !inside(3, 3, [at(0, 0), at(4, 0), at(0, 4)]));
});

test("the camera fits a structure from every side", () => {
  const points = [[-2, 0, 0], [2, 0.4, 0], [0, -0.3, 0.2], [1, 1, 1]];
  for (const up of [0, 1, 2]) {
    for (const [azimuth, elevation] of [[-1.2, 0.62], [0, 0], [-Math.PI / 2, 1.57]] as const) {
      for (const aspect of [0.5, 1.8]) {
        const start: Orbit = { azimuth, elevation, distance: 9, target: extent(points).centre };
        const orbit = fit(start, points, up, aspect, 0.8);
        const camera = eye(orbit, up);
        const toward = camera.map((c, k) => (c - orbit.target[k]!) / orbit.distance);
        let widest = 0;
        for (const p of points) {
          const q = p.map((v, k) => v - orbit.target[k]!);
          const depth = orbit.distance - q.reduce((s, v, k) => s + v * toward[k]!, 0);
          const [i, j, k] = axes(up);
          const right = -Math.sin(azimuth) * q[i]! + Math.cos(azimuth) * q[j]!;
          const above = Math.cos(elevation) * q[k]! - Math.sin(elevation) * (Math.cos(azimuth) * q[i]! + Math.sin(azimuth) * q[j]!);
          const size = Math.max(Math.abs(right) / (depth * Math.tan(HALF_VIEW) * aspect), Math.abs(above) / (depth * Math.tan(HALF_VIEW)));
          assert.ok(size < 0.81, `${size}`);
          widest = Math.max(widest, size);
        }
        near(widest, 0.8, 0.002);
      }
    }
  }
  assert.equal(extent([]).radius, 1);
});

test("turning stops at the poles and zooming stays in reach", () => {
  const orbit: Orbit = { azimuth: 0, elevation: 0, distance: 5, target: [0, 0, 0] };
  assert.ok(turn(orbit, 0, 1e6).elevation < Math.PI / 2);
  assert.equal(zoom(orbit, 1e9, 1).distance, 20);
  assert.equal(zoom(orbit, 1e-9, 1).distance, 0.02);
});

test("the longer horizontal extent runs across the oblique view", () => {
  const flat = (x: number, y: number): number[][] => [[0, 0, 0], [x, y, 0]];
  assert.equal(across(flat(3, 1), 2), -1.2);
  near(across(flat(1, 3), 2), -1.2 + Math.PI / 2);
  assert.ok(Number.isFinite(across([], 2)));
});

test("units, minus signs and long names are set as people read them", () => {
  assert.deepEqual(["kg m2", "N/m", "kg/m3", "1.25e-07 m4", "p12"].map(unit), ["kg m²", "N/m", "kg/m³", "1.25e-07 m⁴", "p12"]);
  assert.equal(minuses("-0.18 m1 - 0.925 m2 + m4_9; a-b"), "−0.18 m1 − 0.925 m2 + m4_9; a-b");
  assert.deepEqual(folded("4. + stiffness-change@right_wing.3", 18), ["4. + stiffness-", "change@right_", "wing.3"]);
});

test("samples are counted in equal bins, the ends in the last ones", () => {
  assert.deepEqual(histogram([0, 0.2, 0.6, 1], 0, 1, 2), [0.5, 0.5]);
  assert.deepEqual([...density([0, 1, 1], [0, 0, 1], [0, 1, 0, 1], 2)], [1, 1, 0, 1]);
  assert.deepEqual(histogram([], 0, 1, 2), [0, 0]);
});

const sensor = (name: string, position: [number, number, number], direction: [number, number, number]) => ({ name, position, direction, is_rotation: false, attached_to: "" });

test("the channels of a point give its motion together, also where they are not square to each other", () => {
  const s = Math.SQRT1_2;
  const wire = new Wire([sensor("a", [0, 0, 0], [1, 0, 0]), sensor("b", [0, 0, 0], [s, s, 0]), sensor("c", [0, 0, 0], [0, -1, 0]), sensor("d", [1, 0, 0], [0, 0, 1])], []);
  assert.equal(wire.count, 2);
  assert.deepEqual(wire.sensors, [[0, 1, 2], [3]]);
  // u = (2, 3, 0): the channels read 2, 5/√2 and -3; the third tells nothing that the two before it do not.
  const at = wire.motion({ re: Float32Array.of(2, 5 * s, 99, -4) });
  [2, 3, 0, 0, 0, -4].forEach((v, k) => near(at.re[k]!, v, 1e-5));
  // Without the first channel the others take its place; a point without readings stands.
  const rest = wire.motion({ re: Float32Array.of(NaN, 5 * s, -3, NaN) });
  [2, 3, 0, 0, 0, 0].forEach((v, k) => near(rest.re[k]!, v, 1e-5));
  assert.deepEqual(wire.pairs, [[0, 1]]);
});

test("neighbours of a grid are the edges of its cells, and everything hangs together", () => {
  const grid = Array.from({ length: 12 }, (_, i) => [i % 4, Math.floor(i / 4), 0]).flat();
  const pairs = neighbours(grid);
  assert.equal(pairs.length, 3 * 3 + 4 * 2);
  for (const [a, b] of pairs) assert.ok([1, 4].includes(b - a));
  // Beyond a number of points the shortest tree: one line fewer than points.
  const line = Array.from({ length: 400 }, (_, i) => [i, 0, 0]).flat(), tree = neighbours(line);
  assert.equal(tree.length, 399);
  assert.ok(tree.every(([a, b]) => Math.abs(a - b) === 1));
  assert.deepEqual(new Wire([sensor("a", [0, 0, 0], [1, 0, 0]), sensor("b", [9, 0, 0], [1, 0, 0]), sensor("c", [3, 0, 0], [1, 0, 0])], [[0, 1, 7]]).pairs, [[0, 1]]);
});

test("a workbook holds every table under a name of its own, numbers as numbers, and text as text", () => {
  assert.deepEqual([0, 25, 26, 701, 702].map(columnName), ["A", "Z", "AA", "ZZ", "AAA"]);
  const bytes = workbook([{ name: "Pairs: all/of [them], and more than a sheet may have", rows: [["Mode", "Error"], ["=1+1 <b>&\u0000", { value: 0.0125, percent: true }]] }, { name: "pairs  all of  them , and more t", rows: [[{ value: 1e-300, percent: false }]] }]);
  const files = unzipSync(bytes), text = (name: string): string => strFromU8(files[name]!);
  const names = [...text("xl/workbook.xml").matchAll(/<sheet name="([^"]*)"/g)].map((m) => m[1]!);
  assert.equal(names.length, 2);
  assert.ok(names.every((n) => n.length <= 31 && !/[[\]:*?/\\]/.test(n)) && names[0]!.toLowerCase() !== names[1]!.toLowerCase(), `${names}`);
  const first = text("xl/worksheets/sheet1.xml");
  // What a spreadsheet would take for a formula stays text, and markup stays text.
  assert.ok(first.includes("=1+1 &lt;b&gt;&amp;\ufffd</t>") && first.includes('<c r="B2" s="1"><v>0.0125</v></c>') && !first.includes("<f>"));
  assert.ok(text("xl/worksheets/sheet2.xml").includes("<v>1e-300</v>"));
  assert.deepEqual(workbook([]), workbook([]));
});
