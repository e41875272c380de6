"""From frequency response functions in NumPy to a verdict and a page, on synthetic data: a cantilever with a mass that its model lacks."""

import numpy as np

import retune

model = retune.Model({
    "retune": 1, "name": "cantilever",
    "parameters": {"E": {"value": "70 GPa", "bounds": ["60 GPa", "80 GPa"], "prior_sd": "1 GPa"}},
    "sections": {"strip": {"E": "E", "G": "26 GPa", "density": "2700 kg/m3",
                           "shape": {"rectangle": {"width": "40 mm", "height": "5 mm"}}}},
    "nodes": {"root": [0, 0, 0], **{f"s{k}": [0.1 * k, 0, 0] for k in range(1, 7)}},
    "beams": {f"b{k}": {"nodes": [f"s{k - 1}" if k > 1 else "root", f"s{k}"], "section": "strip", "subdivide": 2}
                            for k in range(1, 7)},
    "active_dofs": ["uz", "ry"], "supports": {"clamp": {"node": "root"}},
})
frequencies = np.linspace(2.0, 500.0, 4000)  # what an analyser would give: here a heavier structure, 1 % damping, noise
truth = {"masses": {"forgotten": {"node": "s4", "mass": "0.1 kg"}}}
measured = retune.twin(model, modes=None, frequencies=frequencies, exciter="s6", patch=truth, noise_response="0.5 %", seed=1).frfs
assert measured is not None
found = retune.identify(retune.Frfs(measured.frequencies, measured.h, measured.responses, measured.references, is_synthetic=True))
diagnosis = retune.diagnose(model, found.test)
print(diagnosis.sentence)
diagnosis.save_html("verdict.html", force=True)
