import assert from "node:assert/strict";
import { test } from "node:test";
import { clusters, turn } from "../src/live/close";
import { backward, cholesky, congruence, symmetricEigen } from "../src/live/eigen";
import { LiveModel, type Prediction } from "../src/live/model";
import { assign, pair } from "../src/live/pairing";
import { between, changes, commands, initial, read, theta, way, written, yaml } from "../src/live/state";
import { answer } from "../src/live/questions";
import { curve } from "../src/live/response";
import type { Live } from "../src/types";
import { reach } from "../src/live/whatif";

const near = (a: number, b: number, by: number): void => assert.ok(Math.abs(a - b) <= by, `${a} is not ${b}`);
/** The minimal standard generator of Park and Miller. */
function random(seed: number): () => number {
  let s = seed;
  return () => (s = (s * 16807) % 2147483647) / 2147483647 - 0.5;
}

test("eigenvalues of the second difference are 2 - 2 cos(kπ/(n + 1))", () => {
  for (const n of [1, 2, 3, 10, 61]) {
    const a = new Float64Array(n * n), d = new Float64Array(n), v = new Float64Array(n * n);
    for (let i = 0; i < n; i++) {
      a[i * n + i] = 2;
      if (i) a[i * n + i - 1] = a[(i - 1) * n + i] = -1;
    }
    assert.ok(symmetricEigen(a, n, d, v));
    // Backward stable: n ε times the norm of the matrix, which is 4.
    for (let k = 0; k < n; k++) near(d[k]!, 2 - 2 * Math.cos(((k + 1) * Math.PI) / (n + 1)), 4 * n * Number.EPSILON);
  }
});

test("eigenvectors are orthonormal and solve, of equal eigenvalues and zeros too", () => {
  const next = random(3);
  for (const [n, kind] of [[5, "full"], [40, "full"], [6, "diagonal"], [7, "zero"], [30, "low rank"]] as const) {
    const a = new Float64Array(n * n), u = Float64Array.from({ length: n }, next);
    for (let i = 0; i < n; i++) {
      for (let j = 0; j <= i; j++) {
        const x = kind === "full" ? next() : kind === "low rank" ? u[i]! * u[j]! : kind === "diagonal" && i === j ? 3 : 0;
        a[i * n + j] = a[j * n + i] = x;
      }
    }
    const d = new Float64Array(n), v = new Float64Array(n * n);
    assert.ok(symmetricEigen(a, n, d, v), kind);
    for (let r = 0; r < n; r++) {
      for (let i = 0; i < n; i++) {
        let s = -d[r]! * v[r * n + i]!;
        for (let j = 0; j < n; j++) s += a[i * n + j]! * v[r * n + j]!;
        near(s, 0, 1e-13 * n);
      }
      for (let q = 0; q <= r; q++) {
        let s = 0;
        for (let k = 0; k < n; k++) s += v[r * n + k]! * v[q * n + k]!;
        near(s, q === r ? 1 : 0, 1e-14 * n);
      }
    }
  }
});

test("a Cholesky factor multiplies back, transforms and solves; what is not positive is refused", () => {
  const n = 12, next = random(9), b = Float64Array.from({ length: n * n }, next), a = new Float64Array(n * n);
  for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) for (let k = 0; k < n; k++) a[i * n + j]! += b[i * n + k]! * b[j * n + k]! + (i === j ? 0.1 : 0);
  const l = a.slice();
  assert.ok(cholesky(l, n));
  const own = a.slice();
  congruence(own, l, n);
  for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) near(own[i * n + j]!, i === j ? 1 : 0, 1e-11);
  const x = Float64Array.from({ length: n }, next), y = x.slice();
  backward(l, n, y);
  for (let i = 0; i < n; i++) {
    let s = 0;
    for (let k = i; k < n; k++) s += l[k * n + i]! * y[k]!;
    near(s, x[i]!, 1e-12);
  }
  assert.equal(cholesky(Float64Array.of(1, 0, 2, 1), 2), false);
});

test("the assignment is the best of all", () => {
  const next = random(5);
  for (const [rows, columns] of [[3, 5], [5, 3], [4, 4]] as const) {
    for (let round = 0; round < 20; round++) {
      const cost = Array.from({ length: rows }, () => Array.from({ length: columns }, next));
      const found = assign(rows, columns, (i, j) => cost[i]![j]!);
      const sum = found.reduce((s, j, i) => (j < 0 ? s : s + cost[i]![j]!), 0);
      let best = Infinity;
      const tryAll = (i: number, used: number, total: number, pairs: number): void => {
        if (i === rows) { if (pairs === Math.min(rows, columns)) best = Math.min(best, total); return; }
        if (rows > columns) tryAll(i + 1, used, total, pairs);
        for (let j = 0; j < columns; j++) if (!(used & (1 << j))) tryAll(i + 1, used | (1 << j), total + cost[i]![j]!, pairs + 1);
      };
      tryAll(0, 0, 0, 0);
      near(sum, best, 1e-12);
      assert.equal(new Set(found.filter((j) => j >= 0)).size, Math.min(rows, columns));
    }
  }
});

const rule = { by: "near-mac", min_mac: 0, frequency_window: null, same_family_only: true };

test("pairs go by likeness and nearness, plans come first, shapes that do not tell go by frequency", () => {
  const side = (frequencies: number[], families: (string | null)[] = frequencies.map(() => null)) => ({ frequencies, families });
  const free = ["free", "free"] as const;
  // By shape, although the frequencies are crosswise.
  assert.deepEqual([...pair(Float64Array.of(0.1, 0.9, 0.9, 0.1), side([5, 6]), side([5, 6]), rule, [...free])], [1, 0]);
  // Shapes within a hundredth: the order of the frequencies tells.
  assert.deepEqual([...pair(Float64Array.of(0.95, 0.951, 0.951, 0.95), side([5, 6]), side([5, 6]), rule, [...free])], [0, 1]);
  // Symmetric and antisymmetric modes are kept apart.
  assert.deepEqual([...pair(Float64Array.of(0.9, 0.2), side([5, 6], ["antisymmetric", "symmetric"]), side([5], ["symmetric"]), rule, ["free"])], [1]);
  assert.deepEqual([...pair(Float64Array.of(0.9, 0.2, 0.1, 0.9), side([5, 6]), side([5, 6]), rule, ["aside", { fixed: 0 }])], [-1, 0]);
  assert.deepEqual([...pair(Float64Array.of(0.9, 0, 0.1, 0, 0.2, 0), side([5, 6, 7]), side([5, 7]), rule, ["free", { ranked: 1 }])], [0, 2]);
  assert.deepEqual([...pair(new Float64Array(4), side([5, 6]), side([7, 5]), { ...rule, by: "order" }, [...free])], [1, 0]);
});

test("two modes at one frequency are turned to the plane of the test", () => {
  assert.deepEqual(clusters([1, 1.001, 2, 3, 3, 3], [1, 3], true, () => true), [[0, 1], [3, 4, 5]]);
  assert.deepEqual(clusters([1, 1.001, 2, 2], [1, 3], true, () => false), [[2, 3]]);
  const angle = 0.6, at = [Float64Array.of(1, 0, 1, 0), Float64Array.of(0, 1, 0, 1)], shapes = [Float64Array.of(1, 0), Float64Array.of(0, 1)];
  const c = Math.cos(angle), s = Math.sin(angle);
  const weight = Float64Array.of(50, 50, 50, 50);
  turn([0, 1], at, shapes, [{ shape: Float64Array.of(c, s, c, s), weight }, { shape: Float64Array.of(-s, c, -s, c), weight }]);
  [c, s].forEach((v, i) => near(Math.abs(shapes[0]![i]!), v, 1e-12));
  near(at[0]![0]! * at[1]![0]! + at[0]![1]! * at[1]![1]!, 0, 1e-12);
});

const text = (...values: number[]): string => Buffer.from(Float64Array.from(values).buffer).toString("base64");

/** Two masses between three springs, k, c k, k: λ = k/m and (1 + 2c) k/m; and a mass at the first that a hypothesis adds. */
function chain(): Live {
  const parameter = (name: string, value: number, range: [number, number]) => ({ name, unit: "N/m", unit_factor: 1, value, range, description: "" });
  return {
    n: 2, is_complete: true, n_rigid: 0, shift: 50, n_elastic: 4,
    parameters: [parameter("k", 100, [50, 200]), parameter("c k", 30, [10, 90]), { ...parameter("added", 0, [0, 2]), unit: "kg" }],
    hypotheses: [{ id: "point-mass@a", kind: "point-mass", sizes: [2], estimates: [1], probability: 0.5, alters: [], accuracy: { points: 0, frequency: [0, 0], mac: [0, 0] } }],
    terms: [
      { powers: [], mass: { lower: text(1, 0, 1) } },
      { powers: [[0, 1]], stiffness: { lower: text(1, 0, 1) } },
      { powers: [[1, 1]], stiffness: { sum: text(2, Math.SQRT1_2, -Math.SQRT1_2) } },
      { powers: [[2, 1]], mass: { sum: text(1, 1, 0) } },
    ],
    sensors: text(1, 0, 0, 1), displacement: Buffer.from(Float32Array.of(0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1).buffer).toString("base64"),
    test: [
      { label: "together", frequency_hz: 10 / (2 * Math.PI), frequency_sd: 0.01, shape: text(1, 1), shape_sd: text(0.1, 0.1), plan: "free", followed_alone: false },
      { label: "apart", frequency_hz: 2, frequency_sd: 0.02, shape: text(1, -1), shape_sd: text(0.1, 0.1), plan: "free", followed_alone: false },
    ],
    damping: 0.02, pairing: rule, n_data: 4, not_computed: 0, accuracy: { points: 0, frequency: [0, 0], mac: [0, 0] },
  };
}

const at = (...values: number[]) => ({ theta: Float64Array.from(values), extras: [] });

test("a chain of two masses has its closed-form modes, pairs and misfit", () => {
  const live = chain(), model = new LiveModel(live);
  for (const [k, ck] of [[100, 30], [57, 80], [200, 20]] as const) {
    const p = model.predict(at(k, ck, 0)) as Prediction;
    near(p.hz[0]!, Math.sqrt(k) / (2 * Math.PI), 1e-13);
    near(p.hz[1]!, Math.sqrt(k + 2 * ck) / (2 * Math.PI), 1e-13);
    assert.deepEqual([...p.partner], [0, 1]);
    near(p.mac[0]!, 1, 1e-14);
    near(p.ofFrequency[0]!, ((p.hz[0]! - 10 / (2 * Math.PI)) / 0.01) ** 2, 1e-9);
    near(p.ofShape[0]!, 0, 1e-20);
    // Unit modal mass.
    near(p.shapes[0]![0]! ** 2 + p.shapes[0]![1]! ** 2, 1, 1e-13);
  }
  // With a mass at the first: λ² (1 + s) - λ (K11 + (1 + s) K22) + det K = 0.
  const s = 0.7, [a, b] = [130, -30], det = a * a - b * b, q = model.predict(at(100, 30, s)) as Prediction;
  const root = Math.sqrt((a * (2 + s)) ** 2 - 4 * (1 + s) * det);
  near((2 * Math.PI * q.hz[0]!) ** 2, (a * (2 + s) - root) / (2 * (1 + s)), 1e-10);
  assert.ok("unstable" in model.predict(at(-30, 30, 0)));
  // The same mass put at the first node by hand, and springs to the ground at the second.
  const extra = model.predict({ theta: Float64Array.of(100, 30, 0), extras: [{ node: 0, mass: s, stiffness: 0 }] }) as Prediction;
  near(extra.hz[0]!, q.hz[0]!, 1e-12);
  const held = model.predict({ theta: Float64Array.of(100, 30, 0), extras: [{ node: 1, mass: 0, stiffness: 1e9 }] }) as Prediction;
  near(held.hz[0]!, Math.sqrt(130 - 900 / 1e9) / (2 * Math.PI), 1e-6);
  assert.deepEqual(reach(model, extra, 9, 2), null);
});

test("modes of one space agree with a test that mixes them, as a fault does when it is taken out", () => {
  const live = chain(), c = Math.cos(0.3), s = Math.sin(0.3), r = Math.SQRT1_2;
  const mixed = (a: number, b: number) => [r * (a + b), r * (a - b)] as const;
  live.test.forEach((t, j) => { t.shape = text(...(j ? mixed(-s, c) : mixed(c, s))); t.shape_sd = text(0.01, 0.01); });
  const apart = new LiveModel(live).predict(at(100, 30, 0)) as Prediction;
  assert.ok(apart.mac[0]! < 0.95 && apart.ofShape[0]! > 50);
  const none = () => ({ at: [], values: text() });
  live.hypotheses.push({
    ...live.hypotheses[0]!, id: "modes-mixed", sizes: [], estimates: [],
    test: { is_angle: false, frequency: none(), frequency_sd: none(), shape: none(), shape_sd: none(), sensors: none(), spaces: ["both", "both"], remedy: "" },
  });
  const corrected = new LiveModel(live).predict({ ...at(100, 30, 0), faults: [1] }) as Prediction;
  live.test.forEach((t) => { t.space = "both"; });
  for (const p of [corrected, new LiveModel(live).predict(at(100, 30, 0)) as Prediction]) {
    assert.deepEqual([...p.partner], [0, 1]);
    near(p.mac[0]!, 1, 1e-12);
    near(p.ofShape[0]! + p.ofShape[1]!, 0, 1e-12);
    near(p.hz[0]!, apart.hz[0]!, 1e-13);
  }
});

test("a state goes into an address and comes back, and hostile addresses do no harm", () => {
  const live = chain(), s = initial(live), nodes = ["a", "b 2"];
  assert.deepEqual(changes(live, s), []);
  assert.equal(written(live, s, nodes), "");
  s.values[1] = 42;
  s.on[0] = true;
  s.order = [-1, 1];
  const address = written(live, s, nodes);
  assert.equal(address, "point-mass%40a=1;c%20k=42");
  const back = read(live, address, nodes);
  assert.deepEqual(back.values, s.values);
  assert.deepEqual(back.on, s.on);
  assert.deepEqual([...theta(live, back)], [100, 42, 1]);
  assert.deepEqual(way(live, back).map((p) => [...p.theta]), [[100, 30, 1]]);
  assert.deepEqual(read(live, "k=1e9;%E0%A4%A=3;__proto__=1;k=x;=;c%20k=-5;at:zz=1,2;at:a=-1,0", nodes).values, [200, 10, 1]);
  s.extras = [{ node: 1, mass: 0.25, stiffness: 10 }];
  assert.equal(written(live, s, nodes), "point-mass%40a=1;c%20k=42;at:b%202=0.25,10");
  assert.deepEqual(read(live, written(live, s, nodes), nodes).extras, s.extras);
  assert.deepEqual(way(live, s).map((p) => [p.theta[1], p.theta[2], p.extras.length]), [[30, 1, 0], [42, 1, 0]]);
  assert.ok(yaml(live, s, nodes).includes('masses:\n  what_if_mass_at_b_2: {node: "b 2", mass: 0.25 kg}'));
  s.extras = [];
  assert.ok(yaml(live, s, nodes).includes('  "c k": {value: 42 N/m, bounds: [10 N/m, 90 N/m]}'));
  const lines = commands(live, s, nodes, "my model.yaml", "test.yaml");
  assert.ok(lines.startsWith("retune add 'my model.yaml' point-mass@a -o changed.yaml\n") && lines.endsWith("retune compare changed.yaml test.yaml\n"));
});

test("a frequency response is that of the closed form, with rigid-body modes and of every order", () => {
  // Two masses of 1 kg on springs to the ground and between them, as the chain; 1 % of damping.
  const live = chain(), hz = Float64Array.of(0.3, 1.1, 1.7, 4);
  const [k, ck, z] = [100, 30, 0.02];
  for (const order of [0, 1, 2]) {
    const p = new LiveModel(live).predict(at(k, ck, 0), { response: 1, reference: 0, sign: -1, order, hz }) as Prediction;
    hz.forEach((f, l) => {
      const w = 2 * Math.PI * f;
      // (1, 1)/√2 and (1, -1)/√2: ± 1/2 over each denominator.
      const [re, im] = [k, k + 2 * ck].map((lambda, r) => {
        const a = lambda - w * w, b = 2 * z * Math.sqrt(lambda) * w;
        return [(r ? -0.5 : 0.5) * a / (a * a + b * b), -(r ? -0.5 : 0.5) * b / (a * a + b * b)];
      }).reduce(([s, t], [u, v]) => [s! + u!, t! + v!], [0, 0]) as [number, number];
      near(p.curve!.amplitude[l]!, w ** order * Math.hypot(re, im), 1e-12);
      // The phase turns by a quarter an order, and by a half for the sign.
      const turned = (Math.atan2(im, re) * 180) / Math.PI + 90 * order + 180, off = (p.curve!.phase[l]! - turned + 1080) % 360;
      assert.ok(Math.min(off, 360 - off) < 1e-9, `${off}`);
    });
  }
  // A free mass of 2 kg: H = -1/(m ω²).
  const free = curve({ rigid: [0.5], elastic: [], hz: new Float64Array(0) }, new Float64Array(0), { response: 0, reference: 0, sign: 1, order: 0, hz });
  hz.forEach((f, l) => near(free.amplitude[l]!, 0.5 / (2 * Math.PI * f) ** 2, 1e-15));
});

test("the line between two states has both ends, and partners are followed along it", () => {
  const live = chain(), from = at(100, 10, 0), to = at(150, 80, 0);
  const line = between(from, to);
  assert.deepEqual([...line[0]!.theta], [...from.theta]);
  assert.deepEqual([...line.at(-1)!.theta], [...to.theta]);
  assert.deepEqual(between(from, from), []);
  const { track } = answer(new LiveModel(live), { id: 1, at: to, way: [], track: line });
  track!.forEach((q, i) => {
    const t = i / (line.length - 1), k = 100 + 50 * t, ck = 10 + 70 * t;
    near(q!.hz[0]!, Math.sqrt(k) / (2 * Math.PI), 1e-12);
    near(q!.hz[1]!, Math.sqrt(k + 2 * ck) / (2 * Math.PI), 1e-12);
    near(q!.mac[0]!, 1, 1e-12);
  });
});
