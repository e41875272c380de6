"""Criteria of published packages on the numbers of tests/correlation/peers.rs.

    correlation.py probe        says whether the packages are there
    correlation.py DIR          reads DIR/cases.json, writes DIR/answers.json

MAC and MSF: sdypy-EMA (ladisk/sdypy-EMA, MIT). Cross-signature (there: response vector) and frequency domain assurance
criterion: pymodal. SEREP and Guyan: vibrationtesting (J. C. Slater). The modules of the latter two are loaded from their
files, since the packages around them want much more than numpy and scipy.
"""

import importlib.util
import json
import sys
from pathlib import Path

import numpy as np
import scipy.linalg
from sdypy import EMA


def module(package, name):
    """One module of an installed package, without the package."""
    root = Path(importlib.util.find_spec(package).origin).parent
    spec = importlib.util.spec_from_file_location(f"{package}_{name}", root / f"{name}.py")
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


pymodal = module("pymodal", "utils")
testing = module("vibrationtesting", "system")


def array(value):
    """{"re": [[...]], "im": [[...]]} or rows as an array."""
    if isinstance(value, dict):
        return np.array(value["re"]) + 1j * np.array(value["im"])
    return np.array(value)


def answers(cases):
    a, x = array(cases["phi_a"]), array(cases["phi_x"])
    h_a, h_x = array(cases["h_a"]), array(cases["h_x"])
    k, m = array(cases["stiffness"]), array(cases["mass"])
    master = np.array(cases["masters"])
    serep_mass, serep_stiffness, _, _ = testing.serep(m, k, master + 1)
    guyan_mass, guyan_stiffness = testing.guyan(m, k, master=master)[:2]
    return {
        "mac": EMA.MAC(a, x).tolist(),
        "msf": [float(np.ravel(EMA.MSF(a.real[:, [j]], x.real[:, [j]]))[0]) for j in range(x.shape[1])],
        "csac": pymodal.value_RVAC(h_x, h_a).real.tolist(),
        "fdac": pymodal.value_FDAC(h_x, h_a).real.tolist(),
        "serep_lambda": scipy.linalg.eigh(serep_stiffness, serep_mass)[0].tolist(),
        "guyan_mass": guyan_mass.tolist(),
        "guyan_stiffness": guyan_stiffness.tolist(),
    }


if sys.argv[1] != "probe":
    folder = Path(sys.argv[1])
    cases = json.loads((folder / "cases.json").read_text())
    (folder / "answers.json").write_text(json.dumps(answers(cases)))
