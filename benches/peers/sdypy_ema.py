"""Identify the functions written by `tools/src/bin/identify_accuracy.rs` with sdypy-EMA: errors and time.

Usage: python sdypy_ema.py FOLDER     (needs: pip install sdypy-EMA)
The true frequencies are given to it as starting values (select_closest_poles): it has no automatic choice of poles.
"""

import glob
import os
import sys
import time

import numpy as np
from sdypy import EMA

F = np.array([5.67, 8.37, 18.34, 19.82, 23.17, 28.6])
Z = np.array([0.0155, 0.0106, 0.0206, 0.0233, 0.0285, 0.0255])
N = 34
o = np.arange(N)
PHI = np.array([np.cos((k + 1) * 0.7 * (o + 1.3) / 5.0 + k) for k in range(6)]).T

# Its tolerances of a stable pole: the defaults, which lost the fewest modes of the settings tried (0.001/0.05, 0.01/0.2, 0.02/0.5).
FN, XI = (float(x) for x in (sys.argv[2:4] or ("0.001", "0.05")))

for eps in ("0.01", "0.05", "0.1"):
    f2, z2, worst, lost, elapsed, files = [], [], 0.0, 0, 0.0, sorted(glob.glob(f"{sys.argv[1]}/frf_{eps}_*.bin"))
    for path in files:
        h = np.fromfile(path, dtype="<c16").reshape(-1, N).T.copy()
        freq = np.linspace(0.0, 35.0, h.shape[1])
        start = time.perf_counter()
        model = EMA.Model(h, freq, lower=3, upper=34.9, pol_order_high=40, frf_form="accelerance")
        model.get_poles(method="lscf", show_progress=False)
        try:
            model.select_closest_poles(list(F), f_window=2, fn_temp=FN, xi_temp=XI)
            h_rec, shapes = model.get_constants(method="lsfd")
        except Exception as error:  # a pole that is not stable is an error there
            print(os.path.basename(path), "failed:", error)
            lost += 6
            continue
        finally:
            elapsed += time.perf_counter() - start
        f, z = np.array(model.nat_freq), np.array(model.nat_xi)
        for k in range(6):
            at = np.argmin(abs(f - F[k]))
            if abs(f[at] / F[k] - 1) > 0.01:
                lost += 1
                continue
            f2.append(f[at] / F[k] - 1)
            z2.append(z[at] / Z[k] - 1)
            a, b = shapes[:, at], PHI[:, k]
            worst = max(worst, 1 - abs(np.vdot(a, b)) ** 2 / (np.vdot(a, a).real * np.vdot(b, b)))
    rms = lambda x: np.sqrt(np.mean(np.square(x)))
    print(f"sdypy-EMA noise {eps:>5}: rms error f {rms(f2):.1e}, damping {rms(z2):.1e}; "
          f"worst 1-MAC {worst:.1e}; lost {lost}; {1e3 * elapsed / len(files):.0f} ms")
