"""From frequency response functions in NumPy to a verdict and a page, on synthetic data: a cantilever with a mass that its model lacks."""
import numpy as np
import retune

model = retune.Model.from_text("""
retune: 1
name: cantilever
parameters: {E: {value: 70 GPa, bounds: [60 GPa, 80 GPa], prior_sd: 1 GPa}}
sections: {strip: {E: E, G: 26 GPa, density: 2700 kg/m3, shape: {rectangle: {width: 40 mm, height: 5 mm}}}}
nodes: {s0: [0, 0, 0], s1: [0.1, 0, 0], s2: [0.2, 0, 0], s3: [0.3, 0, 0], s4: [0.4, 0, 0], s5: [0.5, 0, 0], s6: [0.6, 0, 0]}
beams: {blade: {chain: [s0, s1, s2, s3, s4, s5, s6], section: strip, subdivide: 2}}
active_dofs: [uz, ry]
supports: {clamp: {node: s0}}
""")
frequencies = np.linspace(2.0, 500.0, 4000)  # what an analyser gives; here a heavier structure, 1 % damping, noise
measured = model.add("point-mass@s4").with_values({"point_mass.s4.mass": 0.1}).frf(frequencies, "s6", damping=0.01)
h = measured.h * (1 + 0.005 * np.random.default_rng(1).normal(size=measured.h.shape))
found = retune.identify(retune.Frfs(frequencies, h, measured.responses, measured.references, is_synthetic=True))
diagnosis = retune.diagnose(model, found.test)
print(diagnosis.sentence)
diagnosis.save_html("verdict.html", force=True)
