"""An element of the user's own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from . import _core
from ._convert import Floats
from ._own import Own

Domain = Literal["positive", "non-negative", "fraction", "compliance", "any"]
"""The values that a property may take: above zero; zero or above; from zero to one; zero or above, infinity too; any finite number."""


@dataclass(frozen=True)
class Property:
    """A property of an element: a word of the model file."""

    name: str
    """The word. One that begins with ``end1_`` or ``end2_`` is of an end of a member."""
    unit: str
    """Its SI unit: ``"Pa"``, ``"kg m2"``, ``"rad/(N m)"``, ``"1"``."""
    domain: Domain = "any"
    """Admissible values."""
    description: str = ""
    """One line for people."""


@dataclass(frozen=True)
class Sample:
    """A typical input of an element, for ``Element.check``."""

    points: Sequence[tuple[float, float, float]]
    """Position of each node in element axes, from the first, m."""
    values: Mapping[str, float]
    """Properties by name, SI; the others are absent."""
    mass: float = 0.0
    """What the mass matrix must weigh, kg."""
    is_free: bool = True
    """Whether moving it as a rigid body costs no energy; not so where it is grounded or preloaded."""


class Element(Own[_core.OwnElement]):
    """A finite element as a Python class: subclass it, and give it to ``Model(..., elements=[MyElement()])``.

    Model files name it as ``type``. Matrices are (6 n_nodes, 6 n_nodes), the dofs of a node in the order ux, uy, uz, rx, ry, rz, in element
    axes; what an element does not touch is zero. They are called with the GIL taken, one call at a time; those that are polynomials of the
    parameters are found once, others at every θ.

    >>> import numpy as np
    >>> import retune
    >>> class TaperedBar(Element):
    ...     '''A bar whose section shrinks linearly: k = E (A1 - A2)/(L ln(A1/A2)).'''
    ...     name = "tapered_bar"
    ...     summary = "A bar whose cross-section changes linearly along its length."
    ...     nodes = (("ux", "uy", "uz"), ("ux", "uy", "uz"))
    ...     properties = (
    ...         Property("E", "Pa", "positive", "Young's modulus"),
    ...         Property("A1", "m2", "positive", "area at the first node"),
    ...         Property("A2", "m2", "positive", "area at the second node"),
    ...     )
    ...     samples = (Sample([(0, 0, 0), (0.5, 0, 0)], {"E": 70e9, "A1": 4e-4, "A2": 1e-4}),)
    ...     def stiffness(self, points, values):
    ...         a1, a2 = values["A1"], values["A2"]
    ...         mean = a1 if a1 == a2 else (a1 - a2) / np.log(a1 / a2)
    ...         stretch = np.zeros(12)
    ...         stretch[[0, 6]] = -1.0, 1.0
    ...         return values["E"] * mean / np.linalg.norm(points[1]) * np.outer(stretch, stretch)
    >>> TaperedBar().check()  # the contract of every element
    []
    >>> model = retune.Model({
    ...     "retune": 1, "name": "a lump on a tapered strut", "active_dofs": ["ux"],
    ...     "nodes": {"wall": [0, 0, 0], "end": [0.5, 0, 0]},
    ...     "elements": {"strut": {"type": "tapered_bar", "nodes": ["wall", "end"],
    ...                            "properties": {"E": "70 GPa", "A1": "4 cm2", "A2": "1 cm2"}}},
    ...     "masses": {"lump": {"node": "end", "mass": "2 kg"}}, "supports": {"clamp": {"node": "wall"}}},
    ...     elements=[TaperedBar()])
    >>> k = 140e9 * 3e-4 / np.log(4)
    >>> bool(np.isclose(model.modes(n=1).frequencies[0], np.sqrt(k / 2) / (2 * np.pi), rtol=1e-12))
    True
    """

    name: str = ""
    """The word in model files, ``snake_case``."""
    summary: str = ""
    """One sentence: what it is for."""
    theory: str = ""
    """Equations, axes, limits and sources; the docstring of the class where it is empty."""
    nodes: Sequence[Sequence[str]] = ()
    """The dofs that it touches at each of its nodes, in element axes."""
    properties: Sequence[Property] = ()
    """Its properties."""
    axes: Literal["along-nodes", "given"] = "along-nodes"
    """``along-nodes``: x from the first node to the second, z as near as possible to the orientation; ``given``: global axes, or those of the file."""
    is_scalar: bool = False
    """Whether its matrices act along motions that its properties name, and not on a body."""
    samples: Sequence[Sample] = ()
    """Typical inputs, which together give every property: for ``check``."""

    def stiffness(self, points: Floats, values: Mapping[str, float]) -> npt.ArrayLike:
        """K, N/m, N, N m.

        * ``points``: nodes in element axes, from the first, m, (n_nodes, 3)
        * ``values``: properties by name, SI; those that the file does not give are absent
        """
        raise NotImplementedError

    def mass(self, points: Floats, values: Mapping[str, float]) -> npt.ArrayLike | None:
        """M, kg, kg m, kg m²; none by default."""
        return None

    def damping(self, points: Floats, values: Mapping[str, float]) -> npt.ArrayLike | None:
        """C of dashpots, N s/m; none by default."""
        return None

    def check(self) -> list[str]:
        """What it breaks of the contract of every element, a sentence each.

        Definite matrices, no energy in a rigid motion and in nothing else, the mass of a sample, matrices that follow the units of the
        properties, properties that matter, refusals.
        """
        return self._core().check()

    def _counterpart(self) -> _core.OwnElement:
        return _core.OwnElement(
            self,
            (self.name, self.summary, self.theory or (type(self).__doc__ or self.summary)),
            [list(dofs) for dofs in self.nodes],
            [(p.name, p.unit, p.domain, p.description) for p in self.properties],
            self.axes,
            self.is_scalar,
            [
                ([(float(x), float(y), float(z)) for x, y, z in s.points], list(s.values.items()), s.mass, s.is_free)
                for s in self.samples
            ],
            self._matrix,
        )

    def _matrix(self, which: str, points: Floats, values: dict[str, float]) -> Floats | None:
        found = getattr(self, which)(points, values)
        return None if found is None else np.asarray(found, dtype=np.float64)
