"""Matrices and frequencies of other programs, and our files read by them.

    probe NAME          exit 0 if the peer is there
    make NAME FOLDER    matrices, a model file `model.yaml` that names them, and `frequencies.json`
    check FOLDER        reads what retune wrote into FOLDER by scipy, pyyeti and pyNastran, and compares with `expected.json`
"""

import json
import os
import shutil
import subprocess
import struct
import sys


def write(folder, name, text):
    with open(os.path.join(folder, name), "w") as f:
        f.write(text)


def lowest(k, m, n):
    """Frequencies in Hz of the n lowest modes."""
    import numpy as np
    import scipy.linalg

    k, m = [a.toarray() if hasattr(a, "toarray") else np.asarray(a) for a in (k, m)]
    values = scipy.linalg.eigh(k, m, eigvals_only=True)
    return (np.sqrt(np.abs(values[:n])) / (2 * np.pi)).tolist()


def result(folder, entry, frequencies, more=""):
    write(folder, "model.yaml", f"retune: 1\nname: peer\n{more}superelements:\n  s: {{{entry}}}\n")
    write(folder, "frequencies.json", json.dumps(frequencies))


def hexahedron(i, j, l):
    """The corners of a cell of a grid, the lower face first."""
    face = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
    return [(a, b, l) for a, b in face] + [(a, b, l + 1) for a, b in face]


def bar_input(free):
    """A bar of 10 x 2 x 1 linear hexahedra of aluminium."""
    nx, ny, nz = 10, 2, 1
    number = lambda i, j, l: 1 + l + (nz + 1) * (j + (ny + 1) * i)
    out = ["*NODE,NSET=NALL"]
    for i in range(nx + 1):
        for j in range(ny + 1):
            for l in range(nz + 1):
                out.append("%d,%.10g,%.10g,%.10g" % (number(i, j, l), 0.05 * i, 0.03 * j, 0.02 * l))
    out.append("*ELEMENT,TYPE=C3D8,ELSET=EALL")
    e = 0
    for i in range(nx):
        for j in range(ny):
            for l in range(nz):
                e += 1
                out.append(",".join(str(v) for v in [e] + [number(*p) for p in hexahedron(i, j, l)]))
    out.append("*MATERIAL,NAME=AL\n*ELASTIC\n70e9,0.33\n*DENSITY\n2700.\n*SOLID SECTION,ELSET=EALL,MATERIAL=AL")
    if not free:
        out.append("*BOUNDARY")
        out += ["%d,1,3" % number(0, j, l) for j in range(ny + 1) for l in range(nz + 1)]
    return "\n".join(out) + "\n"


def wing_input():
    """A tapered, swept box of S4 shells with ribs, clamped at its root: 19 623 rows."""
    numbers, nodes, elements = {}, [], {"SKIN": [], "WEB": []}
    nx, ny, nz = 8, 60, 2

    def node(i, j, l):
        y = 2.0 * j / ny
        chord, height = 0.5 - 0.1 * y, 0.06 - 0.01 * y
        at = (0.25 * y + i / nx * chord, y, (l / nz - 0.5) * height)
        key = tuple(round(c, 9) for c in at)
        if key not in numbers:
            numbers[key] = len(numbers) + 1
            nodes.append(at)
        return numbers[key]

    def add(name, *corners):
        elements[name].append([node(*c) for c in corners])

    for j in range(ny):
        for i in range(nx):
            for l in (0, nz):
                add("SKIN", (i, j, l), (i + 1, j, l), (i + 1, j + 1, l), (i, j + 1, l))
        for i in (0, nx):
            for l in range(nz):
                add("WEB", (i, j, l), (i, j + 1, l), (i, j + 1, l + 1), (i, j, l + 1))
    for j in range(0, ny + 1, 10):
        for i in range(nx):
            for l in range(nz):
                add("WEB", (i, j, l), (i + 1, j, l), (i + 1, j, l + 1), (i, j, l + 1))
    out = ["*NODE,NSET=NALL"] + ["%d,%.10g,%.10g,%.10g" % (n + 1, *at) for n, at in enumerate(nodes)]
    number = 0
    for name, members in elements.items():
        out.append("*ELEMENT,TYPE=S4,ELSET=" + name)
        for corners in members:
            number += 1
            out.append(",".join(str(v) for v in [number] + corners))
    out.append("*MATERIAL,NAME=AL\n*ELASTIC\n71e9,0.33\n*DENSITY\n2780.")
    out.append("*SHELL SECTION,ELSET=SKIN,MATERIAL=AL\n0.002\n*SHELL SECTION,ELSET=WEB,MATERIAL=AL\n0.003\n*BOUNDARY")
    out += ["%d,1,6" % (n + 1) for n, at in enumerate(nodes) if at[1] == 0.0]
    return "\n".join(out) + "\n"


def of_calculix(folder, text, more=""):
    write(folder, "part.inp", text)
    write(folder, "modes.inp", text + "*STEP\n*FREQUENCY,STORAGE=YES\n10\n*END STEP\n")
    write(folder, "job.inp", text + "*STEP\n*FREQUENCY,SOLVER=MATRIXSTORAGE\n*END STEP\n")
    program = os.environ.get("RETUNE_CCX", "ccx")
    for job in ["modes", "job"]:
        subprocess.run([program, job], cwd=folder, check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    # The eigenvalues stand in the file of modes as doubles, behind flags and their number.
    with open(os.path.join(folder, "modes.eig"), "rb") as f:
        data = f.read(400)
    with open(os.path.join(folder, "modes.dat")) as f:
        rows = [l.split() for l in f if len(l.split()) == 5 and l.split()[0].isdigit()]
    first = float(rows[0][1])
    at = next(i for i in range(0, 64, 4) if abs(struct.unpack_from("<d", data, i)[0] / first - 1) < 1e-6)
    values = struct.unpack_from("<10d", data, at)
    entry = "k: job.sti, m: job.mas, dofs: job.dof, nodes: part.inp" + more
    result(folder, entry, [v**0.5 / 6.283185307179586 for v in values])


def ccx(folder):
    of_calculix(folder, bar_input(free=False))


def ccx_shells(folder):
    of_calculix(folder, wing_input(), ", inner: true")


def kratos(folder):
    """A bar of hexahedra, free, from the matrices of its elements; clamped by supports of the model file."""
    import KratosMultiphysics as km
    import KratosMultiphysics.LinearSolversApplication as solvers
    import KratosMultiphysics.StructuralMechanicsApplication as structural

    model = km.Model()
    part = model.CreateModelPart("bar")
    for variable in [km.DISPLACEMENT, km.REACTION, km.VOLUME_ACCELERATION]:
        part.AddNodalSolutionStepVariable(variable)
    part.ProcessInfo[km.DOMAIN_SIZE] = 3
    nx, ny, nz = 8, 2, 2
    number = lambda i, j, l: 1 + l + (nz + 1) * (j + (ny + 1) * i)
    for i in range(nx + 1):
        for j in range(ny + 1):
            for l in range(nz + 1):
                part.CreateNewNode(number(i, j, l), 0.05 * i, 0.03 * j, 0.02 * l)
    alloy = part.CreateNewProperties(1)
    alloy[km.YOUNG_MODULUS], alloy[km.POISSON_RATIO], alloy[km.DENSITY] = 70e9, 0.33, 2700.0
    alloy[km.CONSTITUTIVE_LAW] = structural.LinearElastic3DLaw()
    count = 0
    for i in range(nx):
        for j in range(ny):
            for l in range(nz):
                count += 1
                nodes = [number(*corner) for corner in hexahedron(i, j, l)]
                part.CreateNewElement("SmallDisplacementElement3D8N", count, nodes, alloy)
    directions = [
        (km.DISPLACEMENT_X, km.REACTION_X, "ux"),
        (km.DISPLACEMENT_Y, km.REACTION_Y, "uy"),
        (km.DISPLACEMENT_Z, km.REACTION_Z, "uz"),
    ]
    for variable, reaction, _ in directions:
        km.VariableUtils().AddDof(variable, reaction, part)
    held = [node for node in part.Nodes if node.X0 == 0.0]
    for node in held:
        for variable, _, _ in directions:
            node.Fix(variable)
    settings = '{"solver_type": "eigen_eigensystem", "number_of_eigenvalues": 8, "max_iteration": 1000, "tolerance": 1e-12}'
    builder = km.ResidualBasedBlockBuilderAndSolver(solvers.EigensystemSolver(km.Parameters(settings)))
    scheme = structural.EigensolverDynamicScheme()
    structural.EigensolverStrategy(part, scheme, builder, 0.0, 1.0, False, False).Solve()
    found = part.ProcessInfo[structural.EIGENVALUE_VECTOR]
    sums = {"K": {}, "M": {}}
    own = {"K": km.Matrix(), "M": km.Matrix()}
    for element in part.Elements:
        element.CalculateLeftHandSide(own["K"], part.ProcessInfo)
        element.CalculateMassMatrix(own["M"], part.ProcessInfo)
        rows = element.EquationIdVector(part.ProcessInfo)
        for name, a in own.items():
            for i, row in enumerate(rows):
                for j, column in enumerate(rows):
                    place = (row, column)
                    sums[name][place] = sums[name].get(place, 0.0) + a[i, j]
    n = 3 * len(part.Nodes)
    for name, entries in sums.items():
        lines = ["%d %d %.17g" % (row + 1, column + 1, value) for (row, column), value in sorted(entries.items())]
        head = "%%%%MatrixMarket matrix coordinate real general\n%d %d %d\n" % (n, n, len(lines))
        write(folder, name + ".mtx", head + "\n".join(lines) + "\n")
    table = {}
    for node in part.Nodes:
        for variable, _, name in directions:
            table[node.GetDof(variable).EquationId] = "%d,%s,%.17g,%.17g,%.17g" % (node.Id, name, node.X0, node.Y0, node.Z0)
    write(folder, "dofs.csv", "node,dof,x,y,z\n" + "\n".join(table[i] for i in range(n)) + "\n")
    clamp = "supports: {clamp: {nodes: [%s]}}\n" % ", ".join("s.%d" % node.Id for node in held)
    frequencies = [found[i] ** 0.5 / 6.283185307179586 for i in range(len(found))]
    result(folder, "k: K.mtx, m: M.mtx, dofs: dofs.csv", frequencies, clamp)


def skfem(folder):
    import numpy as np
    import scipy.sparse
    from skfem import Basis, ElementTetP1, ElementVector, MeshTet, asm, condense
    from skfem.models.elasticity import lame_parameters, linear_elasticity
    from skfem.helpers import dot
    from skfem import BilinearForm

    mesh = MeshTet.init_tensor(np.linspace(0, 0.4, 7), np.linspace(0, 0.1, 3), np.linspace(0, 0.05, 3))
    basis = Basis(mesh, ElementVector(ElementTetP1()))
    k = asm(linear_elasticity(*lame_parameters(70e9, 0.3)), basis)
    m = 2700.0 * asm(BilinearForm(lambda u, v, w: dot(u, v)), basis)
    held = basis.get_dofs(lambda x: x[0] == 0.0).all()
    k, m, _, left = condense(k, m, D=held)
    node_of = {}
    for node in range(mesh.p.shape[1]):
        for d in range(3):
            node_of[basis.nodal_dofs[d, node]] = (node, d)
    rows = ["node,dof,x,y,z"]
    for dof in left:
        node, d = node_of[dof]
        rows.append("%d,%s,%r,%r,%r" % (node, "ux uy uz".split()[d], *map(float, mesh.p[:, node])))
    write(folder, "dofs.csv", "\n".join(rows) + "\n")
    for name, a in [("k", k), ("m", m)]:
        scipy.sparse.save_npz(os.path.join(folder, name + ".npz"), a.tocsr())
    result(folder, "k: k.npz, m: m.npz, dofs: dofs.csv", lowest(k, m, 10))


def opensees(folder):
    import numpy as np
    import openseespy.opensees as ops
    import scipy.io
    import scipy.sparse

    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    n = 6
    for i in range(n + 1):
        ops.node(i, 0.5 * i, 0.05 * i * i)
        ops.mass(i, 2.0, 2.0, 0.01)
    ops.fix(0, 1, 1, 1)
    ops.geomTransf("Linear", 1)
    for i in range(n):
        ops.element("elasticBeamColumn", i, i, i + 1, 1e-3, 70e9, 5e-7, 1)
    ops.system("FullGeneral")
    ops.numberer("Plain")
    ops.constraints("Plain")
    ops.algorithm("Linear")
    ops.analysis("Transient")

    def matrix(m, k):
        ops.integrator("GimmeMCK", m, 0.0, k)
        ops.analyze(1, 0.0)
        size = ops.systemSize()
        return np.array(ops.printA("-ret")).reshape(size, size)

    mass, stiffness = matrix(1.0, 0.0), matrix(0.0, 1.0)
    rows = ["node,dof,x,y,z"]
    for i in range(1, n + 1):
        for d, word in zip(ops.nodeDOFs(i), ["ux", "uy", "rz"]):
            rows.append((d, "%d,%s,%r,%r,0" % (i, word, 0.5 * i, 0.05 * i * i)))
    rows = rows[:1] + [r for _, r in sorted(rows[1:])]
    write(folder, "dofs.csv", "\n".join(rows) + "\n")
    for name, a in [("k", stiffness), ("m", mass)]:
        scipy.io.mmwrite(os.path.join(folder, name + ".mtx"), scipy.sparse.coo_matrix(0.5 * (a + a.T)), precision=17)
    values = ops.eigen("-fullGenLapack", 8)
    result(folder, "k: k.mtx, m: m.mtx, dofs: dofs.csv", [v**0.5 / (2 * np.pi) for v in values])


def pyyeti(folder):
    """A free chain in space reduced by Craig-Bampton here, written by pyyeti as OUTPUT4 in every layout and as DMIG."""
    import numpy as np
    import scipy.linalg
    from pyyeti.nastran import op4

    n = 8
    k, m = np.zeros((n, n)), np.diag(np.linspace(1.0, 2.0, n))
    for i in range(n - 1):
        k[i : i + 2, i : i + 2] += 1e5 * (1 + 0.1 * i) * np.array([[1.0, -1.0], [-1.0, 1.0]])
    b, inside = [0, n - 1], list(range(1, n - 1))
    ib, ii = np.ix_(inside, b), np.ix_(inside, inside)
    static = -np.linalg.solve(k[ii], k[ib])
    w, phi = scipy.linalg.eigh(k[ii], m[ii])
    t = np.zeros((n, 2 + len(inside)))
    t[b, [0, 1]] = 1.0
    t[np.ix_(inside, range(2))] = static
    t[np.ix_(inside, range(2, n))] = phi
    kr, mr = t.T @ k @ t, t.T @ m @ t
    for binary in [True, False]:
        for sparse in ["dense", "bigmat", "nonbigmat"]:
            name = "%s_%s.op4" % ("b" if binary else "t", sparse)
            op4.write(os.path.join(folder, name), {"KCB": kr, "MCB": mr, "R": t[2:3]}, binary=binary, sparse=sparse)
    rows = ["node,dof,x,y,z", "a,ux,0,0,0", "b,ux,7,0,0"] + ["q%d,modal,,," % (q + 1) for q in range(n - 2)]
    write(folder, "dofs.csv", "\n".join(rows) + "\n")
    write(folder, "inner.csv", "node,dof,x,y,z\nc,ux,2,0,0\n")
    entry = "k: {file: F, matrix: KCB}, m: {file: F, matrix: MCB}, dofs: dofs.csv, recovery: {matrix: {file: F, matrix: R}, dofs: inner.csv}"
    result(folder, entry, lowest(k, m, n)[1:])


def check(folder):
    import numpy as np
    import scipy.io
    import scipy.sparse
    from pyNastran.op4.op4 import OP4
    from pyyeti.nastran import op4

    with open(os.path.join(folder, "expected.json")) as f:
        expected = json.load(f)

    def same(name, found):
        found = found.toarray() if hasattr(found, "toarray") else np.asarray(found)
        wanted = np.zeros_like(found)
        for i, j, v in expected[name]:
            wanted[i, j] = wanted[j, i] = v
        assert np.array_equal(found, wanted), (name, abs(found - wanted).max())

    for name in ["K", "M"]:
        same(name, scipy.io.mmread(os.path.join(folder, "g_%s.mtx" % name)))
        same(name, scipy.sparse.load_npz(os.path.join(folder, "g_%s.npz" % name)))
    for file in ["t.op4", "b.op4"]:
        names, mats, _, _ = op4.load(os.path.join(folder, file), into="list")
        for name, a in zip(names, mats):
            same(name.upper(), a)
        for name, matrix in OP4().read_op4(os.path.join(folder, file)).items():
            same(name.upper(), matrix.data)
    print("read by scipy, pyyeti and pyNastran")


def probe(name):
    if name.startswith("ccx"):
        return shutil.which(os.environ.get("RETUNE_CCX", "ccx")) is not None
    if name == "kratos":
        __import__("KratosMultiphysics.StructuralMechanicsApplication")
        __import__("KratosMultiphysics.LinearSolversApplication")
        return True
    __import__({"skfem": "skfem", "opensees": "openseespy.opensees", "pyyeti": "pyyeti", "check": "pyNastran"}[name])
    if name == "check":
        __import__("pyyeti")
    __import__("scipy.sparse")
    return True


if __name__ == "__main__":
    what = sys.argv[1]
    if what == "probe":
        sys.exit(0 if probe(sys.argv[2]) else 1)
    elif what == "make":
        {"ccx": ccx, "ccx_shells": ccx_shells, "kratos": kratos, "skfem": skfem, "opensees": opensees, "pyyeti": pyyeti}[sys.argv[2]](sys.argv[3])
    else:
        check(sys.argv[2])
