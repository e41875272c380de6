"""Solvers that are run for their matrices at values of parameters.

    probe NAME          exit 0 if the solver is there
    make NAME FOLDER    a template, a model file `model.yaml` that names it, and `expected.json`: parameters between the values of the runs and
                        the frequencies that the solver itself has there
"""

import json
import os
import shutil
import struct
import subprocess
import sys

import matrices


def eigenvalues(folder, job, n):
    """Of a run of CalculiX with STORAGE=YES: doubles in the file of modes, behind flags and their number."""
    with open(os.path.join(folder, job + ".eig"), "rb") as f:
        data = f.read(400)
    with open(os.path.join(folder, job + ".dat")) as f:
        rows = [l.split() for l in f if len(l.split()) == 5 and l.split()[0].isdigit()]
    first = float(rows[0][1])
    at = next(i for i in range(0, 64, 4) if abs(struct.unpack_from("<d", data, i)[0] / first - 1) < 1e-6)
    return struct.unpack_from("<%dd" % n, data, at)


def ccx(folder):
    """The bar of hexahedra: stiffness in proportion to E, mass to the density."""
    program = os.environ.get("RETUNE_CCX", "ccx")
    text = matrices.bar_input(free=False)
    assert "70e9,0.33" in text and "2700." in text
    template = text.replace("70e9,", "{{E:Pa}},").replace("2700.", "{{rho:kg/m3}}")
    matrices.write(folder, "bar.inp.tpl", template + "*STEP\n*FREQUENCY,SOLVER=MATRIXSTORAGE\n*END STEP\n")
    theta = [71.3e9, 2755.0]
    filled = template.replace("{{E:Pa}}", repr(theta[0])).replace("{{rho:kg/m3}}", repr(theta[1]))
    own = os.path.join(folder, "own")
    os.mkdir(own)
    matrices.write(own, "own.inp", filled + "*STEP\n*FREQUENCY,STORAGE=YES\n10\n*END STEP\n")
    subprocess.run([program, "-i", "own"], cwd=own, check=True, stdout=subprocess.DEVNULL)
    frequencies = [v**0.5 / 6.283185307179586 for v in eigenvalues(own, "own", 10)]
    parameters = "{E: {value: 70 GPa, bounds: [60 GPa, 80 GPa]}, rho: {value: 2700 kg/m3, bounds: [2600 kg/m3, 2800 kg/m3]}}"
    solver = "{run: %s -i {job}, template: bar.inp.tpl, writes: calculix, time_limit: 1 min}" % program
    return parameters, solver.replace("run: %s -i {job}" % program, 'run: "%s -i {job}"' % program), theta, frequencies


FRAME = """import sys
import numpy as np
import openseespy.opensees as ops

def build(E, A, I):
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    at = [(0.0, 0.0), (0.0, 1.5), (0.0, 3.0), (2.0, 3.0), (4.0, 3.0), (4.0, 1.5), (4.0, 0.0)]
    for i, (x, y) in enumerate(at):
        ops.node(i + 1, x, y)
    ops.fix(1, 1, 1, 1)
    ops.fix(7, 1, 1, 1)
    for i in range(2, 7):
        ops.mass(i, 12.0, 12.0, 0.4)
    ops.geomTransf("Linear", 1)
    for i in range(6):
        ops.element("elasticBeamColumn", i + 1, i + 1, i + 2, A, E, I, 1)
    return at

"""

MATRICES = """at = build({{E:Pa}}, 2e-3, {{I:m4}})
ops.numberer("Plain"); ops.system("FullGeneral"); ops.constraints("Plain")
ops.algorithm("Linear"); ops.analysis("Transient")
found = []
for factors in [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0)]:
    ops.integrator("GimmeMCK", *factors)
    ops.analyze(1, 0.0)
    n = ops.systemSize()
    found.append(np.array(ops.printA("-ret")).reshape(n, n))
for name, a in zip("km", found):
    np.save(name + ".npy", 0.5 * (a + a.T))
rows = ["node,dof,x,y,z"] + [""] * n
for i, (x, y) in enumerate(at):
    for d, equation in enumerate(ops.nodeDOFs(i + 1)):
        if equation >= 0:
            rows[equation + 1] = "%d,%s,%r,%r,0" % (i + 1, ["ux", "uy", "rz"][d], x, y)
open("dofs.csv", "w").write("\\n".join(rows) + "\\n")
"""


def opensees(folder):
    """A plane frame: axial stiffness E A with a fixed A, bending E I; so I alone and E alone are linear, and E is held."""
    matrices.write(folder, "frame.py.tpl", FRAME + MATRICES.replace("{{E:Pa}}", "210e9"))
    theta = [1.37e-6]
    own = FRAME + "build(210e9, 2e-3, %r)\nprint([v**0.5 / 6.283185307179586 for v in ops.eigen('-fullGenLapack', 8)])\n" % theta[0]
    said = subprocess.run([sys.executable, "-c", own], check=True, capture_output=True, text=True)
    frequencies = json.loads(said.stdout.strip().splitlines()[-1])
    parameters = "{I: {value: 1.2e-6 m4, bounds: [0.8e-6 m4, 2e-6 m4]}}"
    solver = '{run: ["%s", "{file}"], template: frame.py.tpl, writes: {k: k.npy, m: m.npy, dofs: dofs.csv}}' % sys.executable
    return parameters, solver, theta, frequencies


if __name__ == "__main__":
    if sys.argv[1] == "probe":
        sys.exit(0 if matrices.probe(sys.argv[2]) else 1)
    folder = sys.argv[3]
    parameters, solver, theta, frequencies = {"ccx": ccx, "opensees": opensees}[sys.argv[2]](folder)
    matrices.write(
        folder,
        "model.yaml",
        f"retune: 1\nname: peer\nparameters: {parameters}\nsuperelements:\n  s: {{solver: {solver}}}\n",
    )
    matrices.write(folder, "expected.json", json.dumps({"theta": theta, "frequencies": frequencies}))
