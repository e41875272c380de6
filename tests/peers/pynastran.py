"""What pyNastran (BSD) reads of a deck, as JSON: nodes, elements, mass, and the rigidities of its laminates.

    python3 pynastran.py probe
    python3 pynastran.py read DECK
    python3 pynastran.py masses DECK...
"""

import contextlib
import json
import math
import sys

from pyNastran.bdf.bdf import BDF
from pyNastran.bdf.mesh_utils.mass_properties import mass_properties


def read(path: str) -> dict:
    model = BDF(debug=None)
    model.read_bdf(path, punch=False)
    mass, centre, inertia = mass_properties(model)
    laminates = {}
    for pid, card in model.properties.items():
        if card.type in ("PCOMP", "PCOMPG"):
            laminates[pid] = card.get_ABD_matrices().tolist()
    return {
        "nodes": {nid: node.get_position().tolist() for nid, node in model.nodes.items()},
        "elements": sorted([*model.elements, *model.masses]),
        "mass": mass,
        "centre": list(centre),
        # xx, yy, zz, xy, xz, yz about the centre of mass
        "inertia": list(inertia),
        "laminates": laminates,
    }


def mass_of(path: str) -> "float | None":
    """The mass of a deck; none of one that pyNastran does not read."""
    try:
        model = BDF(debug=None)
        model.read_bdf(path, punch=False)
        mass = float(mass_properties(model)[0])
    except BaseException:  # it ends the process at some mistakes of a deck
        return None
    return mass if math.isfinite(mass) else None


if __name__ == "__main__":
    if sys.argv[1] == "read":
        print(json.dumps(read(sys.argv[2])))
    if sys.argv[1] == "masses":
        masses = {}
        with contextlib.redirect_stdout(sys.stderr):
            for path in sys.argv[2:]:
                masses[path] = mass_of(path)
        print(json.dumps(masses))
