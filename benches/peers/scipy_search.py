"""The paper's search (differential evolution, 200 members, 100 generations) by scipy beside retune, in one go.

    python3 -m venv target/peers && target/peers/bin/pip install numpy==2.4.6 scipy==1.17.1
    cargo build --release -p retune-tools --bin paper_search
    target/peers/bin/python benches/peers/scipy_search.py

Both minimise the paper's cost of the Body Freedom Flutter aircraft (27 dofs, 19 parameters, modes paired by MAC within
symmetry families, mass-property targets as a penalty) with DE/rand/1/bin, F = 0.8, CR = 0.9, 20 000 evaluations. CPU
seconds of whole processes are compared, because a machine may be shared; the cost function is first checked to be the
same one on 500 random points.
"""
import json
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import pathlib
import resource
import subprocess
import tempfile
import time

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import differential_evolution, linear_sum_assignment

REPEATS = 20
root = pathlib.Path(__file__).resolve().parents[2]
program = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", root / "target")) / "release/paper_search"


def children():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


with tempfile.TemporaryDirectory() as folder:
    file = pathlib.Path(folder) / "problem.json"
    subprocess.run([program, "dump", file], check=True)
    problem = json.loads(file.read_text())

stiffness, mass = np.array(problem["stiffness"]), np.array(problem["mass"])
n = stiffness.shape[1]
k_basis, m_basis = stiffness.reshape(-1, n * n), mass.reshape(-1, n * n)
rigid_basis = np.array(problem["rigid_mass"]).reshape(-1, 36)
bounds = np.array(problem["bounds"])
lower, width = bounds[:, 0], bounds[:, 1] - bounds[:, 0]
sensors, shapes = np.array(problem["sensors"]), np.array(problem["shapes"])
frequencies = np.array(problem["frequencies"])
unit_shapes = shapes / np.linalg.norm(shapes, axis=0)
partner, sign = np.array([p[0] for p in problem["mirror"]]), np.array([p[1] for p in problem["mirror"]])
test_family = np.array([1.0 if label.lower().startswith("s") else -1.0 for label in problem["labels"]])
N_RIGID, N_ELASTIC = 3, 2 * len(frequencies) + 4
driver = {"subset": {"subset_by_index": [0, N_RIGID + N_ELASTIC - 1]}, "gvd": {"driver": "gvd"}}


def make(options):
    def cost(x):
        theta = np.empty(len(x) + 1)
        theta[0] = 1.0
        theta[1:] = lower + x * width
        k, m = (theta @ k_basis).reshape(n, n), (theta @ m_basis).reshape(n, n)
        values, vectors = eigh(k, m, check_finite=False, overwrite_a=True, overwrite_b=True, **options)
        values, vectors = values[N_RIGID : N_RIGID + N_ELASTIC], vectors[:, N_RIGID : N_RIGID + N_ELASTIC]
        f = np.sqrt(np.maximum(values, 0.0)) / (2.0 * np.pi)
        seen = sensors @ vectors
        mac = (seen.T @ unit_shapes) ** 2 / np.einsum("ij,ij->j", seen, seen)[:, None]
        family = np.sign(np.einsum("ij,ij->j", vectors, sign[:, None] * vectors[partner]))
        mac[family[:, None] != test_family[None, :]] = 0.0
        rows, columns = linear_sum_assignment(mac, maximize=True)
        error = f[rows] / frequencies[columns] - 1.0
        value = (len(frequencies) - mac[rows, columns].sum() + np.sqrt(error @ error)) / (2.0 * len(frequencies))
        r = (theta @ rigid_basis).reshape(6, 6)
        total = (r[0, 0] + r[1, 1] + r[2, 2]) / 3.0
        cg = 0.5 * np.array([r[5, 1] - r[4, 2], r[3, 2] - r[5, 0], r[4, 0] - r[3, 1]]) / total
        pitch = r[4, 4] - total * (cg[0] ** 2 + cg[2] ** 2)
        for name, v in (("mass", total), ("cg_x", cg[0]), ("inertia_yy", pitch)):
            target, tolerance = problem["targets"][name]
            value += max(0.0, abs(v - target) / tolerance - 1.0)
        return value

    return cost


points, costs = np.array(problem["points"]), np.array(problem["costs"])
worst = max(abs(make(driver["subset"])(x) / c - 1.0) for x, c in zip(points, costs))
print(f"largest relative difference of the costs of {len(points)} points: {worst:.1e}")

ours = {}
for threads in (1, 2):
    before = children()
    lines = subprocess.run(
        [program, "run", str(threads), str(REPEATS)], capture_output=True, text=True, check=True
    ).stdout.splitlines()
    ours[threads] = (children() - before) / REPEATS
    walls = sorted(float(line.split()[0]) for line in lines)
    print(
        f"retune, {threads} thread(s): {ours[threads]:.3f} CPU s, {walls[len(walls) // 2]:.3f} s wall (median of"
        f" {REPEATS}), {walls[0]:.3f} s best; {lines[0].split(', ', 1)[1]}"
    )

rng = np.random.default_rng(1)
for name, options in driver.items():
    begin, wall = time.process_time(), time.perf_counter()
    result = differential_evolution(
        make(options),
        [(0.0, 1.0)] * len(lower),
        strategy="rand1bin",
        mutation=0.8,
        recombination=0.9,
        init=rng.random((200, len(lower))),
        maxiter=99,
        tol=0.0,
        atol=0.0,
        polish=False,
        updating="deferred",
        rng=1,
    )
    seconds = (time.process_time() - begin) * 20_000 / result.nfev
    print(
        f"scipy, eigh {name}: {seconds:.2f} CPU s, {time.perf_counter() - wall:.2f} s wall, cost {result.fun:.9f},"
        f" {result.nfev} evaluations; ratio per core {seconds / ours[1]:.1f}"
    )
print(f"load of the machine: {os.getloadavg()[0]:.1f} (two cores)")
