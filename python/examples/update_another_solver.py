# %% [markdown]
# # Updating a model of another solver
#
# A portal frame of two columns and a beam; Young's modulus and the stiffness of the foundation are not known. OpenSeesPy gives K and M where it
# is installed, else thirty lines of NumPy; retune pairs modes, fits, and says how certain the parameters are. The test is synthetic.

# %%
from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import numpy.typing as npt

import retune

Matrix = npt.NDArray[np.float64]
NODES = {"left": (0.0, 0.0, 0.0), "eaves_left": (0.0, 0.0, 3.0), "eaves_right": (4.0, 0.0, 3.0), "right": (4.0, 0.0, 0.0)}
MEMBERS = [("left", "eaves_left"), ("eaves_left", "eaves_right"), ("eaves_right", "right")]
AREA, INERTIA, DENSITY = 4e-3, 8e-6, 7850.0
# ux, uz and ry of each node; the feet turn on springs and do not move.
DOFS = [f"{n}.{d}" for n in NODES for d in ("ux", "uz", "ry") if n.startswith("eaves") or d == "ry"]

# %% [markdown]
# ## Two solvers

# %%
def by_numpy(young: float, spring: float) -> tuple[Matrix, Matrix]:
    """K and M of plane beams of Euler and Bernoulli, with consistent masses."""
    all_dofs = [f"{n}.{d}" for n in NODES for d in ("ux", "uz", "ry")]
    k, m = np.zeros((12, 12)), np.zeros((12, 12))
    for a, b in MEMBERS:
        span = np.subtract(NODES[b], NODES[a])[[0, 2]]
        l = float(np.hypot(*span))
        c, s = span / l
        # In axes of the member: along, across, and the rotation from along to across, which is -ry.
        t = np.kron(np.eye(2), np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, -1.0]]))
        ea, ei, mass = young * AREA / l, young * INERTIA / l**3, DENSITY * AREA * l
        bending = ei * np.array([[12, 6 * l, -12, 6 * l], [6 * l, 4 * l * l, -6 * l, 2 * l * l], [-12, -6 * l, 12, -6 * l], [6 * l, 2 * l * l, -6 * l, 4 * l * l]])
        inertia = mass / 420 * np.array([[156, 22 * l, 54, -13 * l], [22 * l, 4 * l * l, 13 * l, -3 * l * l], [54, 13 * l, 156, -22 * l], [-13 * l, -3 * l * l, -22 * l, 4 * l * l]])
        across, along = [1, 2, 4, 5], [0, 3]
        ke, me = np.zeros((6, 6)), np.zeros((6, 6))
        ke[np.ix_(across, across)], me[np.ix_(across, across)] = bending, inertia
        ke[np.ix_(along, along)] = ea * np.array([[1, -1], [-1, 1]])
        me[np.ix_(along, along)] = mass / 6 * np.array([[2, 1], [1, 2]])
        rows = [all_dofs.index(f"{n}.{d}") for n in (a, b) for d in ("ux", "uz", "ry")]
        k[np.ix_(rows, rows)] += t.T @ ke @ t
        m[np.ix_(rows, rows)] += t.T @ me @ t
    for foot in ("left.ry", "right.ry"):
        k[all_dofs.index(foot), all_dofs.index(foot)] += spring
    kept = [all_dofs.index(d) for d in DOFS]
    return k[np.ix_(kept, kept)], m[np.ix_(kept, kept)]


def by_opensees(young: float, spring: float) -> tuple[Matrix, Matrix]:
    """The same by OpenSeesPy: K from `printA`, M the same way from an integrator that asks for it alone."""
    # Its functions are made by the library as it is loaded, so that no checker of types can know them.
    ops: Any = importlib.import_module("openseespy.opensees")

    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    tags = {name: j + 1 for j, name in enumerate(NODES)}
    for name, (x, _, z) in NODES.items():
        ops.node(tags[name], x, z)
    for j, foot in enumerate(("left", "right")):
        ops.node(10 + j, *(NODES[foot][i] for i in (0, 2)))
        ops.fix(10 + j, 1, 1, 1)
        ops.fix(tags[foot], 1, 1, 0)
        ops.uniaxialMaterial("Elastic", j + 1, spring)
        ops.element("zeroLength", 10 + j, 10 + j, tags[foot], "-mat", j + 1, "-dir", 6)
    ops.geomTransf("Linear", 1)
    for j, (a, b) in enumerate(MEMBERS):
        ops.element("elasticBeamColumn", j + 1, tags[a], tags[b], AREA, young, INERTIA, 1, "-mass", DENSITY * AREA, "-cMass")
    ops.system("FullGeneral")
    ops.numberer("Plain")
    ops.constraints("Plain")
    ops.algorithm("Linear")
    ops.integrator("GimmeMCK", 1.0, 0.0, 0.0)
    ops.analysis("Transient")

    def asked(*of: float) -> Matrix:
        ops.integrator("GimmeMCK", *of)
        ops.analyze(1, 0.0)
        n = ops.systemSize()
        return np.array(ops.printA("-ret")).reshape(n, n)

    m, k = asked(1.0, 0.0, 0.0), asked(0.0, 0.0, 1.0)
    # Its rotation turns x to y, which is -ry here; its equations number the dofs of each node in turn.
    number = {f"{n}.{d}": ops.nodeDOFs(tags[n])[j] for n in NODES for j, d in enumerate(("ux", "uz", "ry"))}
    order = [number[d] for d in DOFS]
    sign = np.diag([-1.0 if d.endswith("ry") else 1.0 for d in DOFS])
    return sign @ k[np.ix_(order, order)] @ sign, sign @ m[np.ix_(order, order)] @ sign

# %% [markdown]
# ## The model: parameters, nodes, the row of each dof, and K and M at θ

# %%
class Portal(retune.ParametricModel):
    """The frame, by whichever solver is here."""

    name = "portal frame"
    nodes = NODES
    dofs = DOFS
    parameters = [
        retune.ParametricModel.parameter("E", 200e9, bounds=(150e9, 250e9), unit="GPa", unit_factor=1e9),
        retune.ParametricModel.parameter("foot", 2e6, bounds=(1e5, 1e7), unit="MN m", unit_factor=1e6),
    ]

    def __init__(self) -> None:
        try:
            import openseespy.opensees  # noqa: F401
        except (ImportError, RuntimeError) as e:  # the second where a library of the system is missing
            print(f"skipped OpenSeesPy: {e}")
            self.solver = by_numpy
        else:
            self.solver = by_opensees

    def assemble(self, theta: Matrix) -> tuple[Matrix, Matrix]:
        return self.solver(theta[0], theta[1])


portal = Portal()
print("solver:", portal.solver.__name__)

# %% [markdown]
# ## The test

# %%
# What a laboratory would give: the first four modes of another frame, with noise.
stiffness, mass = by_numpy(212e9, 3.1e6)
inverse = np.linalg.inv(np.linalg.cholesky(mass))
values, vectors = np.linalg.eigh(inverse @ stiffness @ inverse.T)
shapes = inverse.T @ vectors[:, :4]
noise = np.random.default_rng(0)
measured = np.sqrt(values[:4]) / (2 * np.pi) * (1 + 0.002 * noise.normal(size=4))
sensors = [d for d in DOFS if not d.endswith("ry")]
at_sensors = shapes[[DOFS.index(d) for d in sensors]]
test = retune.Test.from_arrays(
    measured,
    shapes=at_sensors / np.abs(at_sensors).max(axis=0),
    sensors=[retune.Sensor(d, d.split(".")[0], "+" + d[-1]) for d in sensors],
    frequency_sd=0.002 * measured,
    shape_sd=0.02,
    is_synthetic=True,
    source="the same frame with E = 212 GPa and feet of 3.1 MN m, 0.2 % noise",
)
test

# %% [markdown]
# ## The fit

# %%
result = retune.update(portal, test)
for p in result.parameters.values():
    print(f"{p.name}: {p.before:.4g} -> {p.after:.4g} +- {p.sd:.2g} {p.unit}")
assert abs(result["E"].after - 212.0) < 4 * (result["E"].sd or 0.0)
print(result)
result
