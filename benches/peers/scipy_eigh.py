"""scipy's eigh on the matrices of benches/kernel.rs, beside our kernel, in one go.

    python -m venv venv && venv/bin/pip install numpy==2.4.6 scipy==1.17.1
    OPENBLAS_NUM_THREADS=1 venv/bin/python benches/peers/scipy_eigh.py

Prints microseconds per candidate (best of several rounds on both sides), the ratio, and the largest relative
difference of the frequencies.
"""
import os
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import pathlib
import subprocess
import tempfile
import time

import numpy as np
from scipy.linalg import eigh

CANDIDATES, MODES, RIGID = 64, 9, 3
root = pathlib.Path(__file__).resolve().parents[2]

with tempfile.TemporaryDirectory() as folder:
    ours = subprocess.run(
        ["cargo", "bench", "--bench", "kernel"],
        cwd=root, env={**os.environ, "RETUNE_DUMP": folder}, capture_output=True, text=True, check=True,
    ).stdout
    print(f"{'n':>4} {'retune':>9} {'subset':>9} {'gvd':>9} {'ratio':>7} {'ratio':>7} {'difference':>11}")
    for line in ours.splitlines():
        parts = line.split()
        if len(parts) != 2 or not parts[0].isdigit():
            continue
        n, microseconds = int(parts[0]), float(parts[1])
        data = np.fromfile(pathlib.Path(folder) / f"grillage_{n}.f64").reshape(CANDIDATES, -1)
        k = data[:, : n * n].reshape(-1, n, n)
        m = data[:, n * n : 2 * n * n].reshape(-1, n, n)
        best = [np.inf, np.inf]
        worst = 0.0
        count = CANDIDATES if n <= 60 else 8
        for _ in range(5 if n <= 60 else 2):
            begin = time.perf_counter()
            for c in range(count):
                values, _ = eigh(k[c], m[c], subset_by_index=[0, RIGID + MODES - 1])
                worst = max(worst, np.abs(np.sqrt(values[RIGID:] / data[c, 2 * n * n :]) - 1.0).max())
            best[0] = min(best[0], (time.perf_counter() - begin) / count * 1e6)
            begin = time.perf_counter()
            for c in range(count):
                eigh(k[c], m[c], driver="gvd", check_finite=False)
            best[1] = min(best[1], (time.perf_counter() - begin) / count * 1e6)
        ratios = [b / microseconds for b in best]
        print(f"{n:4d} {microseconds:9.2f} {best[0]:9.1f} {best[1]:9.1f} {ratios[0]:6.1f}x {ratios[1]:6.1f}x {worst:11.1e}")
