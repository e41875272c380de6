"""The posterior of the parameters, and ArviZ: chains, R-hat, effective sample size, NetCDF. The test is synthetic."""

from pathlib import Path

import numpy as np

import retune

model = retune.Model.from_file(Path(__file__).resolve().parents[2] / "models" / "wing_on_spring.yaml")
print(model)
made = retune.twin(model, modes=4, noise_frequency="0.5 %", noise_shape="3 %", seed=7)
assert made.test is not None
runs = [retune.sample(model, made.test, samples=120, seed=seed) for seed in range(3)]
print(runs[0])
for k, name in enumerate(runs[0].names):
    means = [run.samples[:, k].mean() for run in runs]
    print(f"{name}: {np.mean(means):.4g} +- {runs[0].sd[k]:.2g} {runs[0].units[k]}, between runs {np.std(means):.2g}")
try:
    import arviz
except ImportError:
    print("skipped: arviz is not here")
else:
    data = runs[0].to_arviz(*runs[1:])
    print(arviz.summary(data))
    try:
        data.to_netcdf("posterior.nc")
    except (ImportError, ValueError) as e:
        print(f"skipped: NetCDF cannot be written here: {e}")
