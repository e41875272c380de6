# %% [markdown]
# # The posterior of the parameters, and ArviZ
#
# A wing on springs, as in a wind tunnel, and four measured modes of it. `sample` draws from what these leave open of six parameters; runs with
# other seeds are the chains with which ArviZ computes R-hat and the effective sample size. The test is synthetic.

# %%
import importlib.util

import numpy as np

import retune

model = retune.Model.from_text("""
retune: 1
name: Wing on springs
active_dofs: [uz, rx, ry]
parameters:
  EI: {value: 60 N m2, bounds: [40 N m2, 90 N m2], description: bending stiffness of the spar}
  GJ: {value: 35 N m2, bounds: [20 N m2, 60 N m2], description: torsional stiffness of the spar}
  mu: {value: 0.9 kg/m, bounds: [0.6 kg/m, 1.3 kg/m], description: mass per length of the wing}
  k_plunge: {value: 2500 N/m, bounds: [1500 N/m, 4000 N/m], description: plunge stiffness of the mount}
  k_pitch: {value: 60 N m/rad, bounds: [30 N m/rad, 120 N m/rad], description: pitch stiffness of the mount}
  m_ballast: {value: 0.12 kg, bounds: [0.05 kg, 0.3 kg], description: each ballast mass}
nodes:
  root: [0, 0, 0]
  s1: [0, 0.3 m, 0]
  s2: [0, 0.6 m, 0]
  s3: [0, 0.9 m, 0]
  tip: [0, 1.2 m, 0]
sections:
  wing: {EIy: EI, GJ: GJ, mass_per_length: mu, polar_inertia_per_length: 2.2e-3 m2 * mu}
beams:
  wing: {chain: [root, s1, s2, s3, tip], section: wing, subdivide: 2}
springs:
  mount: {node: root, k: {uz: k_plunge, rx: 4000 N m/rad, ry: k_pitch}, c: {uz: 2 N s/m}}
masses:
  carriage: {node: root, mass: 1.5 kg, inertia: {xx: 0.01 kg m2, yy: 0.008 kg m2}}
  ballast: {nodes: [s1, s2, s3], mass: m_ballast, offset: [40 mm, 0, 0]}
""")
made = retune.twin(model, modes=4, noise_frequency="0.5 %", noise_shape="3 %", seed=7)
assert made.test is not None
made.test

# %% [markdown]
# ## Three runs

# %%
runs = [retune.sample(model, made.test, samples=120, seed=seed) for seed in range(3)]
for k, name in enumerate(runs[0].names):
    means = [run.samples[:, k].mean() for run in runs]
    print(f"{name}: {np.mean(means):.4g} +- {runs[0].sd[k]:.2g} {runs[0].units[k]}, between runs {np.std(means):.2g}")
print(runs[0])
runs[0]

# %% [markdown]
# ## As `InferenceData`, and as NetCDF
#
# Members of one run are weighed and moved together; only between runs does R-hat tell whether they have found the same posterior.

# %%
if importlib.util.find_spec("arviz") is None:
    print("skipped: arviz is not here")
else:
    import arviz

    data = runs[0].to_arviz(*runs[1:])
    if importlib.util.find_spec("netCDF4") is not None or importlib.util.find_spec("h5netcdf") is not None:
        data.to_netcdf("posterior.nc")
    summary = arviz.summary(data)
    print(summary)
