"""Objects of other libraries, by what they have: nothing of them is imported."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np

from ._convert import Complexes, Floats

# Numbers of directions as universal files and SDynPy have them: 1 is +x, -3 is -z, 4 is about +x.
_AXES = ("x", "y", "z")


def axis_of(direction: int) -> tuple[str, bool] | None:
    """Signed axis, and whether it is a rotation about it; ``None`` for a scalar."""
    k = abs(direction)
    if not 1 <= k <= 6:
        return None
    return ("-" if direction < 0 else "+") + _AXES[(k - 1) % 3], k > 3


def channel_name(node: int, direction: int) -> str:
    """Point and axis of a function: ``"12.+z"``; the point alone where the direction is a scalar.

    >>> channel_name(12, -3), channel_name(4, 0)
    ('12.-z', '4')
    """
    axis = axis_of(direction)
    if axis is None:
        return str(node)
    if axis[1]:
        raise ValueError(f"point {node}: direction {direction} is a rotation, and functions are of translations")
    return f"{node}.{axis[0]}"


def listed(datasets: object) -> list[dict[str, Any]]:
    """One dataset or several."""
    return [datasets] if isinstance(datasets, dict) else list(cast("Sequence[dict[str, Any]]", datasets))


class Shapes:
    """Modes of another library: what ``Test.from_arrays`` takes, with one column a mode."""

    def __init__(self) -> None:
        self.frequencies: list[float] = []
        self.damping: list[float] = []
        self.rows: dict[tuple[int, int], dict[int, complex]] = {}

    def add(self, frequency: float, damping: float, entries: Mapping[tuple[int, int], complex]) -> None:
        """One mode more, by node and direction."""
        k = len(self.frequencies)
        self.frequencies.append(float(frequency))
        self.damping.append(float(damping))
        for key, value in entries.items():
            self.rows.setdefault(key, {})[k] = complex(value)

    def arrays(self) -> tuple[Floats, Floats | None, Complexes, list[tuple[int, int]]]:
        """Frequencies, damping where all modes have it, shapes with NaN where nothing was measured, and node and direction of each row."""
        n = len(self.frequencies)
        # A universal file has three or six values a node, and zero in those directions in which nothing was measured.
        keys = [key for key, row in self.rows.items() if any(v != 0 for v in row.values())]
        shapes = np.full((len(keys), n), np.nan, dtype=np.complex128)
        for i, key in enumerate(keys):
            for k, value in self.rows[key].items():
                shapes[i, k] = value
        zeta = np.array(self.damping)
        order = np.argsort(self.frequencies, kind="stable")
        has_damping = bool(np.all(np.isfinite(zeta)) and np.any(zeta > 0))
        return np.array(self.frequencies)[order], zeta[order] if has_damping else None, shapes[:, order], keys


def modes_of_uff(datasets: object) -> tuple[Shapes, dict[int, tuple[float, float, float]]]:
    """Datasets 55 and 2414 of normal and complex modes, and the positions of datasets 15 and 2411."""
    found = Shapes()
    places: dict[int, tuple[float, float, float]] = {}
    for d in listed(datasets):
        kind = d.get("type")
        if kind in (15, 2411):
            for node, x, y, z in zip(d["node_nums"], d["x"], d["y"], d["z"]):
                places[int(node)] = (float(x), float(y), float(z))
        if kind not in (55, 2414) or int(d.get("analysis_type", 0)) not in (2, 3, 7):
            continue
        if int(d["analysis_type"]) == 2:
            frequency, damping = d["freq"], d.get("modal_damp_vis", np.nan)
        else:
            pole = complex(d["eig"])
            frequency, damping = abs(pole) / (2 * np.pi), -pole.real / abs(pole)
        entries: dict[tuple[int, int], complex] = {}
        for k in range(1, 7):
            values = d.get(f"r{k}")
            if values is not None:
                entries.update({(int(node), k): complex(v) for node, v in zip(d["node_nums"], np.ravel(values))})
        found.add(frequency, damping, entries)
    if not found.frequencies:
        raise ValueError("there are no modes among these: datasets 55 or 2414 of normal or complex modes")
    return found, places


def modes_of_sdynpy(shapes: Any) -> Shapes:
    """A ``ShapeArray``: frequency, Hz, damping ratio, coordinate and shape matrix of each."""
    found = Shapes()
    for shape in np.ravel(shapes):
        node, direction = np.ravel(shape["coordinate"]["node"]), np.ravel(shape["coordinate"]["direction"])
        keys = [(int(n), int(d)) for n, d in zip(node, direction)]
        found.add(shape["frequency"], shape["damping"], dict(zip(keys, np.ravel(shape["shape_matrix"]))))
    if not found.frequencies:
        raise ValueError("there are no shapes in this array")
    return found


def form_of_sdypy(model: Any) -> str:
    """What the functions of a ``Model`` of sdypy-EMA are: older versions call it ``frf_type``."""
    form = getattr(model, "frf_form", None)
    return str(getattr(model, "frf_type", "accelerance") if form is None else form)


__all__ = ["Shapes", "axis_of", "channel_name", "form_of_sdypy", "listed", "modes_of_sdynpy", "modes_of_uff"]
