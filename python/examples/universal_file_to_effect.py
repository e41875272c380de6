# %% [markdown]
# # From a universal file to a named effect
#
# A portal frame carries a mass that its model lacks. A file as an analyser writes it is read, its modes are identified and checked, and the
# diagnosis says what the model lacks, where, and how large. Then the effect is put into the model, and the misfit falls to what noise leaves.
#
# The measurement is synthetic: the command `retune twin` writes it, with noise, from a model that has the mass.

# %%
import subprocess
import sys
from pathlib import Path

import numpy as np

import retune

model = retune.Model.from_text("""
retune: 1
name: Portal frame
active_dofs: [ux, uz, ry]
symmetry: {normal: x}
parameters:
  E_columns: {value: 205 GPa, bounds: [180 GPa, 230 GPa], description: Young's modulus of the columns}
  E_girder: {value: 205 GPa, bounds: [180 GPa, 230 GPa], description: Young's modulus of the girder}
  m_machine: {value: 12 kg, bounds: [5 kg, 30 kg], description: machine in the middle of the girder}
nodes:
  foot_left: [-1 m, 0, 0]
  mid_left: [-1 m, 0, 0.75 m]
  corner_left: [-1 m, 0, 1.5 m]
  quarter_left: [-0.5 m, 0, 1.5 m]
  centre: [0, 0, 1.5 m]
  quarter_right: {mirror: quarter_left}
  corner_right: {mirror: corner_left}
  mid_right: {mirror: mid_left}
  foot_right: {mirror: foot_left}
sections:
  column: {E: E_columns, G: 79 GPa, density: 7850 kg/m3, shape: {box: {width: 60 mm, height: 60 mm, wall: 4 mm}}}
  girder: {E: E_girder, G: 79 GPa, density: 7850 kg/m3, shape: {box: {width: 60 mm, height: 60 mm, wall: 4 mm}}}
beams:
  left_column: {chain: [foot_left, mid_left, corner_left], section: column, subdivide: 2}
  right_column: {chain: [foot_right, mid_right, corner_right], section: column, subdivide: 2}
  girder: {chain: [corner_left, quarter_left, centre, quarter_right, corner_right], section: girder, subdivide: 2}
masses:
  machine: {node: centre, mass: m_machine}
supports:
  feet: {nodes: [foot_left, foot_right]}
""")
model

# %% [markdown]
# ## The measurement
#
# In life this file comes from the laboratory. Here a hammer hits point `p2`, and seven accelerometers answer.

# %%
places = {"p1": ("mid_left", "+x"), "p2": ("corner_left", "+x"), "p3": ("quarter_left", "+z"), "p4": ("centre", "+z")}
places |= {"p5": ("quarter_right", "+z"), "p6": ("corner_right", "+x"), "p7": ("mid_right", "+x")}
positions = {node: (float(at[0]), float(at[1]), float(at[2])) for node, at in model.nodes.items()}
sensors = [retune.Sensor(name, node, axis, positions[node]) for name, (node, axis) in places.items()]
if not Path("hammer.unv").exists():
    model.save("frame.yaml", force=True)
    Path("forgotten.yaml").write_text("masses: {forgotten: {node: mid_left, mass: 1.5 kg}}\n", encoding="utf-8")
    only_sensors = retune.Test.from_arrays(
        [1.0], shapes=np.ones((7, 1)), sensors=sensors, frequency_sd=0.1, shape_sd=0.1, is_synthetic=True
    )
    only_sensors.save("sensors.yaml", force=True)
    words = ["twin", "frame.yaml", "--frf", "hammer.unv", "--patch", "forgotten.yaml", "--band", "5", "400", "--lines", "2000"]
    words += ["--noise-response", "0.5 %", "--seed", "2", "--exciter", "p2", "--sensors", "sensors.yaml"]
    subprocess.run([sys.executable, "-m", "retune", *words], check=True)
frfs = retune.read_frfs("hammer.unv")
frfs

# %% [markdown]
# ## Modes, with standard deviations and the health of the test

# %%
found = retune.identify("hammer.unv", model=model)
print("frequencies, Hz:", np.round(found.frequencies, 3))
found

# %% [markdown]
# ## Model and test, before

# %%
before = retune.compare(model, found.test)
before

# %% [markdown]
# ## What is missing?
#
# Three kinds of effects are tried at every place; without `effects` all of them are.

# %%
learned = retune.learn(model, found.test, take_best=True, limit=1, effects=["point-mass", "mass-change", "stiffness-change"])
learned

# %%
after = retune.compare(learned.model, learned.tests[0])
after

# %% [markdown]
# ## The page: the structure in its modes, and everything above

# %%
learned.save_html("learned.html", force=True)
print(f"{', '.join(learned.effects)}: chi-squared {before.chi_squared:.0f} -> {after.chi_squared:.0f}")
learned.show()
