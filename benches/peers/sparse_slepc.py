"""SLEPc with CHOLMOD (or MUMPS) and scipy with SuperLU on the matrices of our sparse example, beside our solution.

    apt-get install python3-slepc4py python3-petsc4py python3-scipy
    /usr/bin/python3 benches/peers/sparse_slepc.py 58 183

The arguments are nodes a side: 58, 183, 578 give 10^4, 10^5, 10^6 dofs. `--scipy` adds scipy, `--mumps` SLEPc with MUMPS.
Every solver runs in a process of its own on one thread, with the same shift and tolerance, for the lowest 20 modes after
the three rigid-body modes. Prints CPU seconds without the time to read the matrices, peak memory, and the largest relative
difference of the frequencies to ours. SLEPc counts no modes; our line with the count is the one that users get.
"""
import os
import pathlib
import resource
import subprocess
import sys
import tempfile

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ[name] = "1"
ROOT = pathlib.Path(__file__).resolve().parents[2]
MODES, RIGID, TOLERANCE = 20, 3, 1e-10


def cpu():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def read(folder):
    import numpy as np
    import scipy.sparse as sp

    out = []
    for name in ("stiffness", "mass"):
        rows, columns = (np.fromfile(f"{folder}/{name}_{part}.i64", dtype=np.int64) for part in ("rows", "columns"))
        values = np.fromfile(f"{folder}/{name}_values.f64")
        lower = sp.coo_matrix((values, (rows, columns))).tocsr()
        full = (lower + sp.tril(lower, -1).T).tocsr()
        # Entries that are zero: a peer need not store them.
        full.eliminate_zeros()
        out.append(full)
    return out


def slepc(folder, solver):
    for path in ("/usr/lib/petscdir", "/usr/lib/slepcdir"):
        found = sorted(pathlib.Path(path).glob("*/*/lib/python3/dist-packages"))
        sys.path[:0] = [str(f) for f in found]
    import numpy as np
    import petsc4py

    petsc4py.init([])
    from petsc4py import PETSc
    import slepc4py

    slepc4py.init([])
    from slepc4py import SLEPc

    shift = float(open(f"{folder}/shift.txt").read())
    k, m = read(folder)
    n = k.shape[0]
    matrices = []
    for a in (k, m):
        p = PETSc.Mat().createAIJ(size=a.shape, csr=(a.indptr.astype("i4"), a.indices.astype("i4"), a.data))
        p.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        p.setOption(PETSc.Mat.Option.SPD, True)
        p.assemble()
        matrices.append(p)
    begin = cpu()
    eps = SLEPc.EPS().create()
    eps.setOperators(*matrices)
    eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    eps.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    eps.setTarget(-shift)
    eps.setDimensions(MODES + RIGID)
    eps.setTolerances(TOLERANCE)
    st = eps.getST()
    st.setType(SLEPc.ST.Type.SINVERT)
    st.setShift(-shift)
    # K + aM has the pattern of K: saves SLEPc a merge of patterns.
    st.setMatStructure(PETSc.Mat.Structure.SAME_NONZERO_PATTERN if k.nnz == m.nnz else PETSc.Mat.Structure.DIFFERENT)
    ksp = st.getKSP()
    ksp.setType("preonly")
    ksp.getPC().setType("cholesky")
    ksp.getPC().setFactorSolverType(solver)
    eps.setFromOptions()
    eps.solve()
    values = np.sort([eps.getEigenvalue(i).real for i in range(eps.getConverged())])
    return cpu() - begin, values


def scipy_eigsh(folder):
    import numpy as np
    from scipy.sparse.linalg import LinearOperator, eigsh, splu

    shift = float(open(f"{folder}/shift.txt").read())
    k, m = read(folder)
    begin = cpu()
    # The best of scipy's own: symmetric mode with minimum degree on A + A^T.
    lu = splu((k + shift * m).tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0.0)
    inverse = LinearOperator(k.shape, lu.solve, dtype=float)
    values = eigsh(k, k=MODES + RIGID, M=m, sigma=-shift, OPinv=inverse, tol=TOLERANCE)[0]
    return cpu() - begin, np.sort(values)


def peer(name, folder):
    seconds, values = scipy_eigsh(folder) if name == "scipy" else slepc(folder, name)
    ours = [float(line) for line in open(f"{folder}/values.txt")]
    elastic = [v for v in values if v > 1e-3 * ours[0]][: len(ours)]
    worst = max(abs((a / b) ** 0.5 - 1.0) for a, b in zip(elastic, ours)) if len(elastic) == len(ours) else float("nan")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{seconds:.3f} {peak:.0f} {worst:.1e}")


def main():
    if sys.argv[1] == "--peer":
        return peer(sys.argv[2], sys.argv[3])
    sides = [a for a in sys.argv[1:] if not a.startswith("--")] or ["58"]
    peers = ["cholmod"] + (["mumps"] if "--mumps" in sys.argv else []) + (["scipy"] if "--scipy" in sys.argv else [])
    print(f"{'solver':<22} {'nodes a side':>12} {'CPU s':>8} {'peak MiB':>9} {'difference':>11} {'ratio':>6}")
    for side in sides:
        with tempfile.TemporaryDirectory() as folder:
            seconds = {}
            for label, options in (("retune, no count", ["--no-count"]), ("retune", [])):
                subprocess.run(
                    ["cargo", "run", "-q", "--release", "-p", "retune-linalg", "--example", "sparse_grillage", "--", side, folder, *options],
                    cwd=ROOT, check=True, stdout=subprocess.DEVNULL,
                )
                cpu_s, peak = open(f"{folder}/cpu.txt").read().split()
                seconds[label] = float(cpu_s)
                print(f"{label:<22} {side:>12} {float(cpu_s):8.2f} {peak:>9}")
            for name in peers:
                answer = subprocess.run(
                    [sys.executable, __file__, "--peer", name, folder], capture_output=True, text=True, check=False
                )
                if answer.returncode != 0:
                    print(f"{name}: {answer.stderr.strip().splitlines()[-1]}")
                    continue
                cpu_s, peak, worst = answer.stdout.split()
                label = "scipy, SuperLU" if name == "scipy" else f"SLEPc, {name.upper()}"
                print(f"{label:<22} {side:>12} {float(cpu_s):8.2f} {peak:>9} {worst:>11} {float(cpu_s) / seconds['retune']:5.2f}x")


main()
