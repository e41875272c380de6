"""From a universal file to a named effect: a portal frame carries a mass that its model lacks. The measurement is synthetic.

A file as an analyser writes it is read, its modes are identified and checked, and the diagnosis says what the model lacks, where and how
large. Then the effect is put into the model, and the misfit falls to what noise leaves.
"""

from pathlib import Path

import numpy as np

import retune

FOLDER = Path(__file__).resolve().parents[2] / "models"
model = retune.Model.from_file(FOLDER / "frame.yaml")
print(model)

# A hammer test, as the command `retune twin` writes it; in life this file comes from the laboratory.
if not Path("hammer.unv").exists():
    import subprocess
    import sys

    Path("forgotten.yaml").write_text("masses: {forgotten: {node: mid_left, mass: 1.5 kg}}\n", encoding="utf-8")
    places = {"p1": ("mid_left", "+x"), "p2": ("corner_left", "+x"), "p3": ("quarter_left", "+z"), "p4": ("centre", "+z")}
    places |= {"p5": ("quarter_right", "+z"), "p6": ("corner_right", "+x"), "p7": ("mid_right", "+x")}
    sensors = [retune.Sensor(name, node, axis, tuple(model.nodes[node])) for name, (node, axis) in places.items()]
    only_sensors = retune.Test.from_arrays(
        [1.0], shapes=np.ones((7, 1)), sensors=sensors, frequency_sd=0.1, shape_sd=0.1, is_synthetic=True
    )
    only_sensors.save("sensors.yaml", force=True)
    words = ["twin", str(FOLDER / "frame.yaml"), "--frf", "hammer.unv", "--patch", "forgotten.yaml", "--band", "5", "400"]
    words += ["--lines", "2000", "--noise-response", "0.5 %", "--seed", "2", "--exciter", "p2", "--sensors", "sensors.yaml"]
    subprocess.run([sys.executable, "-m", "retune", *words], check=True)

frfs = retune.read_frfs("hammer.unv")
print(frfs)
found = retune.identify("hammer.unv", model=model)
print(found)
print("frequencies, Hz:", np.round(found.frequencies, 3))

before = retune.compare(model, found.test)
learned = retune.learn(model, found.test, take_best=True, limit=1, effects=["point-mass", "mass-change", "stiffness-change"])
print(learned)
after = retune.compare(learned.model, learned.tests[0])
print(f"{', '.join(learned.effects)}: chi-squared {before.chi_squared:.0f} -> {after.chi_squared:.0f}")
learned.save_html("learned.html", force=True)
