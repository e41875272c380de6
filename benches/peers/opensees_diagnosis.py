"""Diagnoses of a shaft whose tests come from another finite-element code: what is hidden is made by OpenSees, not by our effects.

    python3 -m venv target/peers && target/peers/bin/pip install numpy==2.4.6 openseespy==3.7.1.2
    cargo build --release
    target/peers/bin/python benches/peers/opensees_diagnosis.py

A stepped steel shaft of 2 m with four discs on two bearings, softer across than upright: Timoshenko beams, five to a section of
the model file, consistent masses. Eighteen sensors, seven modes, 0.3 % noise of frequencies and 2 % of shapes. Every test is synthetic.
First the frequencies of both codes are compared with nothing hidden; then each case is diagnosed.
"""

import json
import pathlib
import re
import subprocess
import tempfile
import time

import numpy as np
import openseespy.opensees as ops

ROOT = pathlib.Path(__file__).resolve().parents[2]
RETUNE = ROOT / "target" / "release" / "retune"

POSITIONS = [0, 0.15, 0.35, 0.6, 0.8, 1.0, 1.25, 1.45, 1.65, 1.85, 2.0]
MEMBERS = {  # first node, last node, diameter
    "stub_left": (0, 2, 0.04),
    "body_left": (2, 4, 0.05),
    "body": (4, 6, 0.06),
    "body_right": (6, 8, 0.05),
    "stub_right": (8, 10, 0.04),
}
DISCS = {3: ("disc", 0.06), 5: (15.0, 0.1), 7: ("disc", 0.06), 10: (4.0, 0.01)}  # mass, inertia across
TRUTH = {"E": 201e9, "rho": 7700.0, "disc": 11.2, "k_y": 8.5e6, "k_z": 1.9e7}
ESTIMATES = {"E": 208e9, "rho": 7850.0, "disc": 10.5, "k_y": 1e7, "k_z": 1.6e7}
BOUNDS = {"E": (180e9, 230e9), "rho": (7000, 8500), "disc": (8, 14), "k_y": (4e6, 2e7), "k_z": (8e6, 4e7)}
SENSED = [0, 2, 3, 4, 5, 6, 7, 8, 10]
SENSORS = [(node, axis) for node in SENSED for axis in ("y", "z")]
MODES = 7
FINE = 5
G, KAPPA = 80e9, 0.9


class Opensees:
    """The truth, with what is hidden as keyword arguments."""

    def __init__(self, stiffness=None, mass=None, hinge=None, point=None, spring=None, sprung=None, brace=None, tension=0.0):
        """stiffness: (member, element) -> factor; mass: member -> kg/m; hinge: (node, N m/rad about y); point: (node, kg);
        spring: (node, N/m along z); sprung: (node, kg, Hz along z); brace: (node, node, N/m along z); tension: N, by a
        string without stiffness of its own beside every beam"""
        ops.wipe()
        ops.model("basic", "-ndm", 3, "-ndf", 6)
        self.tags = 0
        self.nodes = [self.node(x) for x in POSITIONS]
        fixed = list(self.nodes)
        for member, (first, last, diameter) in MEMBERS.items():
            for element in range(first, last):
                here = self.nodes[element]
                if hinge and hinge[0] == element:
                    here = self.node(POSITIONS[element])
                    ops.equalDOF(self.nodes[element], here, 1, 2, 3, 4, 6)
                    self.link(self.nodes[element], here, hinge[1], 5)
                factor = (stiffness or {}).get((member, element - first + 1), 1.0)
                added = (mass or {}).get(member, 0.0)
                for k in range(FINE):
                    share = (k + 1) / FINE
                    x = POSITIONS[element] + share * (POSITIONS[element + 1] - POSITIONS[element])
                    there = self.nodes[element + 1] if k + 1 == FINE else self.node(x)
                    fixed += [] if k + 1 == FINE else [there]
                    self.beam(here, there, diameter, factor, added)
                    if tension:
                        self.string(here, there, tension)
                    here = there
        for node, (value, inertia) in DISCS.items():
            kg = TRUTH["disc"] if value == "disc" else value
            ops.mass(self.nodes[node], kg, kg, kg, 2 * inertia, inertia, inertia)
        if point:
            kg, inertia = DISCS.get(point[0], (0.0, 0.0))
            kg = (TRUTH["disc"] if kg == "disc" else kg) + point[1]
            ops.mass(self.nodes[point[0]], kg, kg, kg, 2 * inertia, inertia, inertia)
        for node in (1, 9):
            self.link(self.ground(node), self.nodes[node], TRUTH["k_y"], 2)
            self.link(self.ground(node), self.nodes[node], TRUTH["k_z"], 3)
        if spring:
            self.link(self.ground(spring[0]), self.nodes[spring[0]], spring[1], 3)
        if brace:
            self.link(self.nodes[brace[0]], self.nodes[brace[1]], brace[2], 3)
        if sprung:
            node, kg, hertz = sprung
            body = self.node(POSITIONS[node])
            ops.equalDOF(self.nodes[node], body, 1, 2, 4, 5, 6)
            ops.mass(body, kg, kg, kg, 1e-9, 1e-9, 1e-9)
            self.link(self.nodes[node], body, kg * (2 * np.pi * hertz) ** 2, 3)
        for node in fixed:
            ops.fix(node, 1, 0, 0, 1, 0, 0)
        if tension:
            ops.constraints("Transformation")
            ops.numberer("RCM")
            ops.system("UmfPack")
            ops.test("NormDispIncr", 1e-10, 50)
            ops.algorithm("Newton")
            ops.integrator("LoadControl", 0.1)
            ops.analysis("Static")
            if ops.analyze(10) != 0:
                raise SystemExit("the tension finds no equilibrium")

    def tag(self):
        self.tags += 1
        return self.tags

    def node(self, x):
        tag = self.tag()
        ops.node(tag, float(x), 0.0, 0.0)
        return tag

    def ground(self, node):
        tag = self.node(POSITIONS[node])
        ops.fix(tag, 1, 1, 1, 1, 1, 1)
        return tag

    def link(self, a, b, stiffness, dof):
        material = self.tag()
        ops.uniaxialMaterial("Elastic", material, stiffness)
        ops.element("zeroLength", self.tag(), a, b, "-mat", material, "-dir", dof)

    def string(self, a, b, tension):
        soft, tensed = self.tag(), self.tag()
        ops.uniaxialMaterial("Elastic", soft, 1e3)
        ops.uniaxialMaterial("InitStressMaterial", tensed, soft, tension)
        ops.element("corotTruss", self.tag(), a, b, 1.0, tensed)

    def beam(self, a, b, diameter, factor, added):
        area, inertia = np.pi * diameter**2 / 4, np.pi * diameter**4 / 64
        tag = self.tag()
        ops.geomTransf("Linear", tag, 0, 0, 1)
        shear = KAPPA * area * factor
        section = [TRUTH["E"] * factor, G, area, 2 * inertia, inertia, inertia, shear, shear]
        mass = TRUTH["rho"] * area + added
        ops.element("ElasticTimoshenkoBeam", tag, a, b, *section, tag, "-mass", mass, "-cMass")

    def modes(self):
        """Frequencies, Hz, and shapes at the sensors, one row a mode."""
        values = np.array(ops.eigen("-genBandArpack", MODES))
        shapes = [
            [ops.nodeEigenvector(self.nodes[node], k + 1)["xyz".index(axis)] for node, axis in SENSORS]
            for k in range(MODES)
        ]
        return np.sqrt(values) / (2 * np.pi), np.array(shapes)


def model_file(values):
    parameters = "".join(
        f"  {name}: {{value: {value:.9g}, bounds: [{BOUNDS[name][0]:.9g}, {BOUNDS[name][1]:.9g}]}}\n" for name, value in values.items()
    )
    nodes = "".join(f"  s{i}: [{x}, 0, 0]\n" for i, x in enumerate(POSITIONS))
    sections, beams = "", ""
    for member, (first, last, d) in MEMBERS.items():
        area, inertia = np.pi * d**2 / 4, np.pi * d**4 / 64
        sections += f"  {member}: {{E: E, G: {G}, A: {area:.9g}, Iy: {inertia:.9g}, Iz: {inertia:.9g}, J: {2 * inertia:.9g}, "
        sections += f"density: rho, kappa_y: {KAPPA}, kappa_z: {KAPPA}}}\n"
        chain = ", ".join(f"s{i}" for i in range(first, last + 1))
        beams += f"  {member}: {{chain: [{chain}], section: {member}, orientation: [0, 0, 1], subdivide: 2}}\n"
    masses = "".join(
        f"  disc_{node}: {{node: s{node}, mass: {kg}, inertia: {{xx: {2 * i:.9g}, yy: {i:.9g}, zz: {i:.9g}}}}}\n"
        for node, (kg, i) in DISCS.items()
    )
    springs = "".join(f"  bearing_{node}: {{node: s{node}, k: {{uy: k_y, uz: k_z}}}}\n" for node in (1, 9))
    return (
        f"retune: 1\nname: stepped shaft\nactive_dofs: [uy, uz, ry, rz]\nparameters:\n{parameters}nodes:\n{nodes}"
        f"sections:\n{sections}beams:\n{beams}masses:\n{masses}springs:\n{springs}"
    )


def test_file(frequencies, shapes):
    sensors = "".join(f"  s{node}{axis}: {{node: s{node}, direction: +{axis}}}\n" for node, axis in SENSORS)
    modes = "".join(
        f"  - {{frequency: {f:.8g} Hz, source: opensees, shape: {{real: [{', '.join(f'{v:.6g}' for v in shape)}]}}}}\n"
        for f, shape in zip(frequencies, shapes)
    )
    return (
        "retune_test: 1\nname: shaft by OpenSees\nsources:\n  opensees: {kind: synthetic, text: OpenSees with stated noise}\n"
        f"defaults: {{frequency_sd: 0.3 %, shape_sd: 2 %}}\nsensors:\n{sensors}modes:\n{modes}"
    )


def scattered(seed):
    rng = np.random.default_rng(seed)
    elements = [(m, k + 1) for m, (first, last, _) in MEMBERS.items() for k in range(last - first)]
    return {e: 1 + rng.uniform(-0.3, 0.3) for e in elements}


def both(member, factor):
    return {(member, 1): factor, (member, 2): factor}


# Name, what is hidden, what is done to the readings, the ids that are right.
CASES = [
    *((f"nothing, noise {seed}", {}, None, "adequate") for seed in range(5)),
    ("2 kg at s6", {"point": (6, 2.0)}, None, r"point-mass@s6"),
    ("one element 30 % softer", {"stiffness": {("body", 1): 0.7}}, None, r"(bending-)?stiffness-change@body\.1"),
    ("a member 25 % softer", {"stiffness": both("body_right", 0.75)}, None, r"(bending-)?stiffness-change@body_right(\.r.)?$"),
    ("a joint that gives at s6", {"hinge": (6, 4e5)}, None, r"joint-flexibility@.*s6\.ry"),
    ("a spring to ground at s5", {"spring": (5, 2e5)}, None, r"ground-spring@s5\.uz"),
    ("8 kg/m along a member", {"mass": {"body_left": 8.0}}, None, r"distributed-mass@body_left$"),
    ("0.8 kg on a spring at s6", {"sprung": (6, 0.8, 105.0)}, None, r"sprung-mass@s6\.uz"),
    ("sensor upside down", {}, ("sign", "s6z"), r"sensor-sign@s6z"),
    ("sensors exchanged", {}, ("swap", "s3y", "s4z"), r"sensor-swap@(s3y\+s4z|s4z\+s3y)"),
    ("sensor with gain 0.6", {}, ("gain", "s7z"), r"sensor-gain@s7z"),
    ("sensor dead", {}, ("dead", "s2y"), r"sensor-dead@s2y"),
    ("stiffness scattered by 30 %", {"stiffness": scattered(5)}, None, "unexplained"),
    ("a spring between s2 and s8", {"brace": (2, 8, 1e6)}, None, "unexplained"),
    ("60 kN of tension in the whole shaft", {"tension": 6e4}, None, r"axial-preload@stub_left\.\.stub_right$"),
]


def spoil(shapes, fault, rng):
    names = [f"s{node}{axis}" for node, axis in SENSORS]
    kind, at = fault[0], [names.index(name) for name in fault[1:]]
    if kind == "sign":
        shapes[:, at[0]] *= -1
    elif kind == "gain":
        shapes[:, at[0]] *= 0.6
    elif kind == "dead":
        shapes[:, at[0]] = 0.02 * rng.standard_normal(len(shapes))
    else:
        shapes[:, at] = shapes[:, at[::-1]]


def run(*arguments):
    found = subprocess.run([RETUNE, *arguments], capture_output=True, text=True)
    if not found.stdout:
        raise SystemExit(found.stderr)
    return json.loads(found.stdout)


def main():
    with tempfile.TemporaryDirectory() as folder:
        model, test = pathlib.Path(folder) / "model.yaml", pathlib.Path(folder) / "test.yaml"
        model.write_text(model_file(TRUTH))
        theirs, _ = Opensees().modes()
        ours = [m["frequency_hz"] for m in run("modes", model, "--json")["modes"]][:MODES]
        print(f"largest difference of frequencies, nothing hidden: {100 * np.max(np.abs(theirs / ours - 1)):.3f} %")
        model.write_text(model_file(ESTIMATES))
        print("| hidden | verdict | first hypothesis | P | misfit | right | s |\n|" + " --- |" * 7)
        for seed, (name, hidden, fault, right) in enumerate(CASES):
            rng = np.random.default_rng(seed)
            frequencies, shapes = Opensees(**hidden).modes()
            shapes /= np.abs(shapes).max(axis=1, keepdims=True)
            frequencies = frequencies * (1 + 0.003 * rng.standard_normal(MODES))
            shapes = shapes + 0.02 * rng.standard_normal(shapes.shape)
            if fault:
                spoil(shapes, fault, rng)
            test.write_text(test_file(frequencies, shapes))
            begin = time.perf_counter()
            d = run("diagnose", model, test, "--json")
            seconds = time.perf_counter() - begin
            first = d["hypotheses"][0]
            if right in ("adequate", "unexplained"):
                answer = "yes" if d["verdict"] == right else "no"
            else:
                is_right = lambda i: re.match(right, i) is not None
                answer = "first" if is_right(first["id"]) else "tied" if any(map(is_right, first["tied_with"])) else "no"
            named = first["id"] if d["verdict"] not in ("adequate", "unexplained") else "–"
            p = {"adequate": d["probability_none"], "unexplained": d["probability_other"]}.get(d["verdict"], first["probability"])
            after = d["misfit"] if d["verdict"] == "adequate" else d.get("spread", first).get("misfit", first["misfit_after"])
            print(
                f"| {name} | {d['verdict']} | {named} | {p:.2f} | {d['misfit']:.0f} -> {after:.0f}"
                f" for {d['degrees_of_freedom']:.0f} | {answer} | {seconds:.0f} |",
                flush=True,
            )


main()
