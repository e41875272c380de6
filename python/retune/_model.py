"""A model: what its file says, and what becomes of it."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._convert import Floats, PathLike, Theta, dumps, vector
from ._effect import Effect
from ._element import Element
from ._errors import Problem, RetuneError, problems_of, tell
from ._frfs import Frfs, Quantity
from ._html import number, table
from ._test import Test

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix


@dataclass(frozen=True)
class Parameter:
    """A parameter of a model, SI."""

    name: str
    """Its name."""
    unit: str
    """The unit of its tables."""
    unit_factor: float
    """One such unit in SI."""
    value: float
    """Its value in the file."""
    bounds: tuple[float, float] | None
    """Between which it may change; ``None`` for a constant."""
    prior_sd: float | None
    """Standard deviation of a prior about its value."""
    description: str
    """What it is."""


@dataclass(frozen=True)
class MassProperties:
    """Mass, centre of gravity and inertia."""

    mass: float
    """kg."""
    cg: Floats
    """m, (3,)."""
    inertia: Floats
    """About the centre of gravity, kg m², (3, 3)."""


@dataclass(frozen=True)
class Matrices:
    """K, M and C on the independent dofs, symmetric, ``scipy.sparse`` in columns."""

    stiffness: csc_matrix
    """K, N/m, N, N m, (n_dof, n_dof)."""
    mass: csc_matrix
    """M, kg, kg m, kg m², (n_dof, n_dof)."""
    damping: csc_matrix | None
    """C of dashpots, where there are any."""
    dofs: list[str]
    """Names of the rows: ``tip.uz``."""


class Modes:
    """Modes of a model at one θ, by ascending frequency."""

    __slots__ = ("_model", "_names", "_theta", "frequencies", "n_mechanisms", "n_rigid", "shapes")

    frequencies: Floats
    """Hz, (n_modes,); rigid-body modes have zero."""
    shapes: Floats
    """Mass-normalised, on the independent dofs, (n_dof, n_modes)."""
    n_rigid: int
    """How many of the first are rigid-body modes."""
    n_mechanisms: int
    """How many after them are mechanisms."""

    def __init__(self, model: _core.Model, theta: Floats | None, n: int) -> None:
        self.frequencies, self.shapes, self.n_rigid, self.n_mechanisms = model.modes(theta, n)
        self._model = model
        self._theta = theta
        self._names: list[dict[str, Any]] | None = None

    def __len__(self) -> int:
        return len(self.frequencies)

    def to_dict(self) -> dict[str, Any]:
        """What ``retune modes --json`` prints."""
        import json

        if self._names is None:
            n_elastic = len(self.frequencies) - self.n_rigid
            self._names = json.loads(self._model.mode_names(self._theta, max(n_elastic, 1)))["modes"]
        return {"modes": self._names}

    @property
    def labels(self) -> list[str]:
        """Names: ``Sym 1st Bending``."""
        return [m["label"] for m in self.to_dict()["modes"]]

    def at_nodes(self, mode: int) -> Floats:
        """Displacements and rotations of the nodes in a mode, m and rad, (n_nodes, 6), in the order of ``Model.dof_nodes``."""
        return self._model.expand(np.ascontiguousarray(self.shapes[:, mode]))

    def __repr__(self) -> str:
        return f"<Modes: {', '.join(number(f) for f in self.frequencies)} Hz>"

    def _repr_html_(self) -> str:
        rows = [[k + 1, number(m["frequency_hz"]), m["label"]] for k, m in enumerate(self.to_dict()["modes"])]
        return table("", ["mode", "Hz", "name"], rows)


class Model:
    """A model. It does not change: what changes it gives another one.

    * ``source``: the path of a model file, or what such a file says as a dict
    * ``elements``: of the user's own, which the file names by their ``type``

    >>> model = Model({
    ...     "retune": 1,
    ...     "name": "cantilever",
    ...     "parameters": {"E": {"value": "70 GPa", "bounds": ["60 GPa", "80 GPa"]}},
    ...     "sections": {"strip": {"E": "E", "G": "26 GPa", "density": "2700 kg/m3",
    ...                            "shape": {"rectangle": {"width": "40 mm", "height": "5 mm"}}}},
    ...     "nodes": {"root": [0, 0, 0], "tip": [0.6, 0, 0]},
    ...     "beams": {"blade": {"nodes": ["root", "tip"], "section": "strip", "subdivide": 8}},
    ...     "supports": {"clamp": {"node": "root"}},
    ... })
    >>> model.modes(n=2).frequencies.round(2)
    array([11.42, 71.6 ])
    >>> model.modes({"E": 77e9}, n=1).frequencies.round(2)
    array([11.98])
    """

    __slots__ = ("_inner",)

    def __init__(
        self, source: PathLike | Mapping[str, Any], *, configuration: str | None = None, elements: Sequence[Element] = ()
    ) -> None:
        own = [e._core() for e in elements]
        if isinstance(source, Mapping):
            self._inner = _core.Model.from_text(_core.yaml_of_json(dumps(source)), None, configuration, own)
        else:
            self._inner = _core.Model.from_file(os.fspath(source), configuration, own)
        self._warn()

    def _warn(self) -> None:
        name = self.path or self.name
        tell((("warning", f"{name}: {p.key}: {p.message}") for p in self.warnings), stacklevel=4)

    @classmethod
    def _of(cls, inner: _core.Model) -> Model:
        out = cls.__new__(cls)
        out._inner = inner
        return out

    @classmethod
    def from_file(
        cls, path: PathLike, *, configuration: str | None = None, elements: Sequence[Element] = ()
    ) -> Model:
        """From a model file, in one of its configurations."""
        out = cls._of(_core.Model.from_file(os.fspath(path), configuration, [e._core() for e in elements]))
        out._warn()
        return out

    @classmethod
    def from_text(
        cls,
        text: str,
        *,
        folder: PathLike | None = None,
        configuration: str | None = None,
        elements: Sequence[Element] = (),
    ) -> Model:
        """From the text of a model file; files that it names are in the folder."""
        own = [e._core() for e in elements]
        out = cls._of(_core.Model.from_text(text, None if folder is None else os.fspath(folder), configuration, own))
        out._warn()
        return out

    @property
    def name(self) -> str:
        """Its name."""
        return self._inner.name

    @property
    def path(self) -> str | None:
        """The file that it came from."""
        return self._inner.path

    @property
    def configuration(self) -> str | None:
        """The configuration that it is in."""
        return self._inner.configuration

    @property
    def configurations(self) -> list[str]:
        """The configurations of its file."""
        return self._inner.configurations

    @property
    def elements(self) -> list[Element]:
        """The elements of the user's own that its file may name."""
        return self._inner.elements()

    def configured(self, name: str) -> Model:
        """The same file in another configuration."""
        return Model._of(self._inner.configured(name))

    @property
    def warnings(self) -> list[Problem]:
        """What is doubtful in its file."""
        return problems_of(self._inner.warnings())

    @property
    def parameters(self) -> dict[str, Parameter]:
        """Its parameters by name, in the order of θ."""
        out = {}
        for name, unit, factor, value, bounds, sd, description in self._inner.parameters():
            ends = None if bounds is None else (bounds[0], bounds[1])
            out[name] = Parameter(name, unit, factor, value, ends, sd, description)
        return out

    def theta(self, values: Theta = None) -> Floats:
        """θ, SI, (n_parameters,): the values of the file, with those that are given by name."""
        out = self._inner.nominal()
        if values is None:
            return out
        if not isinstance(values, Mapping):
            return vector(values, "theta")
        index = {name: k for k, name in enumerate(self.parameters)}
        for name, value in values.items():
            if name not in index:
                raise RetuneError(f"there is no parameter `{name}`; there are {', '.join(index)}")
            out[index[name]] = value
        return out

    def _theta(self, values: Theta) -> Floats | None:
        return None if values is None else self.theta(values)

    def with_values(self, theta: Theta) -> Model:
        """The model with other values of its parameters: the same file, numbers replaced, everything else kept."""
        return Model._of(self._inner.with_values(self.theta(theta)))

    @property
    def n_dof(self) -> int:
        """Number of independent dofs."""
        return self._inner.n_dof

    @property
    def dofs(self) -> list[str]:
        """Names of the independent dofs: ``tip.uz``, (n_dof,)."""
        return self._inner.dof_names()

    @property
    def dof_nodes(self) -> list[str]:
        """Nodes in the order of ``Modes.at_nodes``."""
        return self._inner.dof_nodes()

    @property
    def nodes(self) -> dict[str, Floats]:
        """Positions of the nodes, m, (3,) each, those inside subdivided members among them."""
        names, positions = self._inner.nodes()
        return dict(zip(names, positions))

    def modes(self, theta: Theta = None, n: int = 10) -> Modes:
        """The rigid-body modes and ``n`` elastic modes.

        * ``theta``: values by name, or all of them, SI; those of the file when absent
        """
        return Modes(self._inner, None if theta is None else self.theta(theta), n)

    def matrices(self, theta: Theta = None) -> Matrices:
        """K, M and C. Needs SciPy.

        >>> m = Model({"retune": 1, "name": "mass on a spring", "nodes": {"a": [0, 0, 0]}, "active_dofs": ["uz"],
        ...            "springs": {"s": {"node": "a", "k": {"uz": "4 N/m"}}},
        ...            "masses": {"b": {"node": "a", "mass": "1 kg"}}}).matrices()
        >>> float(m.stiffness[0, 0]), float(m.mass[0, 0]), m.dofs
        (4.0, 1.0, ['a.uz'])
        """
        from scipy.sparse import coo_matrix

        n = self.n_dof
        k, m, c = self._inner.matrices(self._theta(theta))

        def built(triplets: tuple[Floats, npt.NDArray[np.int64], npt.NDArray[np.int64]]) -> csc_matrix:
            values, rows, columns = triplets
            return coo_matrix((values, (rows, columns)), shape=(n, n)).tocsc()

        return Matrices(built(k), built(m), None if c is None else built(c), self.dofs)

    def mass_properties(self, theta: Theta = None) -> MassProperties | None:
        """Mass, centre of gravity and inertia."""
        found = self._inner.mass_properties(self._theta(theta))
        return None if found is None else MassProperties(found[0], np.array(found[1]), np.array(found[2]))

    @property
    def node_sensors(self) -> list[str]:
        """Names of a sensor on every node for each translation that exists there: ``n4``, or ``n4.ux`` where there are several."""
        return self._inner.node_sensors()

    def frf(
        self,
        frequencies: npt.ArrayLike,
        references: Sequence[str] | str,
        responses: Sequence[str] | str | None = None,
        *,
        theta: Theta = None,
        damping: float = 0.01,
        quantity: Quantity = "accelerance",
        sensors: Test | None = None,
    ) -> Frfs:
        """Frequency response functions, by superposition of the rigid-body modes and at most 400 elastic ones.

        * ``frequencies``: lines, Hz, ascending, above zero
        * ``references``, ``responses``: names of ``node_sensors``, or of the sensors of a test; all when no response is named
        * ``damping``: damping ratio of every elastic mode
        """

        def names(given: Sequence[str] | str) -> list[str]:
            return [given] if isinstance(given, str) else list(given)

        found = self._inner.frf(
            self._theta(theta),
            vector(frequencies, "frequencies"),
            None if responses is None else names(responses),
            names(references),
            damping,
            quantity,
            None if sensors is None else sensors._inner,
        )
        return Frfs._of(found)

    def add(
        self, effect: str | Effect, *, at: str | None = None, because: str = "", test: Test | None = None
    ) -> Model:
        """The model with an effect at its neutral value, recorded in its history: ``model.add("point-mass@tip")``.

        * ``effect``: effect and place, or an effect of the user's own with its place in ``at``
        * ``test``: whose sensors the effect needs: ``sensor-mass``
        """
        own = None if isinstance(effect, str) else effect._core()
        name = effect if isinstance(effect, str) else effect.name
        id = name if at is None else f"{name}@{at}"
        return Model._of(self._inner.add(id, because, None if test is None else test._inner, own))

    def undo(self) -> Model:
        """The model without what was added last."""
        return Model._of(self._inner.undo())

    def to_yaml(self) -> str:
        """The text of its file."""
        return self._inner.text

    def save(self, path: PathLike, *, force: bool = False) -> None:
        """Writes its file; one that exists only with ``force``."""
        with open(path, "w" if force else "x", encoding="utf-8") as file:
            file.write(self.to_yaml())

    def __repr__(self) -> str:
        configuration = "" if self.configuration is None else f", configuration {self.configuration}"
        return f"<Model {self.name!r}: {self.n_dof} dofs, {len(self._inner.parameters())} parameters{configuration}>"

    def _repr_html_(self) -> str:
        def bound(p: Parameter, k: int) -> str:
            return "" if p.bounds is None else number(p.bounds[k] / p.unit_factor)

        rows = [
            [p.name, number(p.value / p.unit_factor), bound(p, 0), bound(p, 1), p.unit, p.description]
            for p in self.parameters.values()
        ]
        return table(repr(self)[1:-1], ["parameter", "value", "lower", "upper", "unit", ""], rows)

    def __reduce__(self) -> tuple[object, ...]:
        folder = None if self.path is None else os.path.dirname(os.path.abspath(self.path))
        return (_again, (self.to_yaml(), folder, self.configuration, self.elements))


def _again(text: str, folder: str | None, configuration: str | None, elements: Sequence[Element]) -> Model:
    return Model._of(_core.Model.from_text(text, folder, configuration, [e._core() for e in elements]))
