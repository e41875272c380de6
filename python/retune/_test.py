"""A test: sensors, modes with standard deviations, functions."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._convert import Complexes, Floats, PathLike, direction_of, dumps, vector
from ._errors import Problem, problems_of, tell
from ._foreign import Shapes, axis_of, modes_of_sdynpy, modes_of_uff
from ._frfs import Frfs


@dataclass(frozen=True)
class Sensor:
    """Where a sensor sits, and which way it looks."""

    name: str
    """Its name."""
    node: str | None = None
    """The node that it sits on, or is rigidly connected to; its own name when neither node nor element is given."""
    direction: tuple[float, float, float] | str = "+z"
    """A signed axis, ``"+z"``, or a unit vector in global axes."""
    position: tuple[float, float, float] | None = None
    """Position in global axes, m, when it is not that of the node."""
    element: str | None = None
    """The element that it sits on, in place of a node."""
    fraction: float | None = None
    """Where on the element: 0 at its first node, 1 at its second."""
    is_rotation: bool = False
    """Whether it measures a rotation, rad."""

    def _entry(self) -> dict[str, Any]:
        if self.element is not None:
            entry: dict[str, Any] = {"element": self.element, "fraction": 0.5 if self.fraction is None else self.fraction}
        else:
            entry = {"node": self.name if self.node is None else self.node}
        if self.position is not None:
            entry["position"] = [f"{float(v)!r} m" for v in self.position]
        entry["direction"] = self.direction if isinstance(self.direction, str) else direction_of(self.direction)
        if self.is_rotation:
            entry["rotation"] = True
        return entry


@dataclass(frozen=True)
class TestMode:
    """A measured mode."""

    __test__ = False  # not for pytest

    frequency: float
    """Hz."""
    frequency_sd: float
    """Its standard deviation, Hz."""
    damping: float | None
    """Damping ratio."""
    damping_sd: float | None
    """Its standard deviation."""
    label: str | None
    """Its name."""
    is_synthetic: bool
    """Whether it was computed."""
    source: str
    """Where it comes from."""


class Test:
    """Test data.

    >>> test = Test.from_arrays([10.2, 31.0], shapes=[[1.0, 1.0], [0.4, -0.9]], sensors=["tip", "middle"],
    ...                         frequency_sd=0.05, shape_sd=0.02, name="bench")
    >>> test.frequencies
    array([10.2, 31. ])
    >>> test.shapes.shape
    (2, 2)
    >>> print(test.to_yaml().splitlines()[0])
    retune_test: 1
    """

    __test__ = False  # not for pytest
    __slots__ = ("_inner",)

    def __init__(self, source: PathLike | Mapping[str, Any]) -> None:
        """From a file, or from what a test file says as a dict."""
        if isinstance(source, Mapping):
            self._inner = _core.Test.from_text(_core.yaml_of_json(dumps(source)))
        else:
            self._inner = _core.Test.from_file(os.fspath(source))
        self._warn()

    def _warn(self) -> None:
        name = self.path or self.name
        tell((("warning", f"{name}: {p.key}: {p.message}") for p in self.warnings), stacklevel=4)

    @classmethod
    def _of(cls, inner: _core.Test) -> Test:
        out = cls.__new__(cls)
        out._inner = inner
        return out

    @classmethod
    def from_file(cls, path: PathLike) -> Test:
        """From a test file."""
        out = cls._of(_core.Test.from_file(os.fspath(path)))
        out._warn()
        return out

    @classmethod
    def from_text(cls, text: str, *, folder: PathLike | None = None) -> Test:
        """From the text of a test file; files that it names are in the folder."""
        out = cls._of(_core.Test.from_text(text, None if folder is None else os.fspath(folder)))
        out._warn()
        return out

    @classmethod
    def from_arrays(
        cls,
        frequencies: npt.ArrayLike,
        *,
        shapes: npt.ArrayLike | None = None,
        sensors: Sequence[Sensor | str] = (),
        damping: npt.ArrayLike | None = None,
        frequency_sd: npt.ArrayLike | None = None,
        damping_sd: npt.ArrayLike | None = None,
        shape_sd: npt.ArrayLike | None = None,
        labels: Sequence[str | None] | None = None,
        name: str = "test",
        source: str = "arrays",
        is_synthetic: bool = False,
        configuration: str | None = None,
        date: str | None = None,
    ) -> Test:
        """From modes as arrays.

        * ``frequencies``: Hz, (n_modes,)
        * ``shapes``: real or complex, any scale, (n_sensors, n_modes); NaN where an entry was not measured
        * ``sensors``: one a row of ``shapes``; a name stands for a sensor on the node of that name that looks along +z
        * ``damping``: damping ratios, (n_modes,)
        * ``frequency_sd``: standard deviations, Hz, one for all or one a mode; likewise ``damping_sd`` of the ratios. ``shape_sd`` is
          one share of the largest entry of each shape, or a standard deviation of every entry, (n_sensors, n_modes). The documented
          defaults of the test file when absent.
        * ``source``: where the numbers come from; the file says so
        * ``date``: the day of the test, ``2014-05-22``

        >>> Test.from_arrays([5.0], frequency_sd=0.02, source="hammer test of 3 May").modes[0].source
        'hammer test of 3 May'
        """
        f = vector(frequencies, "frequencies")
        n = len(f)
        placed = [s if isinstance(s, Sensor) else Sensor(s) for s in sensors]
        columns: Complexes | None = None
        if shapes is not None:
            columns = np.asarray(shapes, dtype=np.complex128)
            if columns.shape != (len(placed), n):
                raise ValueError(f"shapes are {columns.shape}; {len(placed)} sensors and {n} modes make {(len(placed), n)}")
        elif placed:
            raise ValueError("there are sensors and no shapes")

        def each(values: npt.ArrayLike | None, what: str) -> Floats | None:
            return None if values is None else np.broadcast_to(vector(np.atleast_1d(values), what), (n,))

        zeta, f_sd, zeta_sd = each(damping, "damping"), each(frequency_sd, "frequency_sd"), each(damping_sd, "damping_sd")
        entries: list[dict[str, Any]] = []
        for k in range(n):
            entry: dict[str, Any] = {"frequency": f"{float(f[k])!r} Hz", "source": "origin"}
            if labels is not None and labels[k] is not None:
                entry["label"] = labels[k]
            if f_sd is not None:
                entry["frequency_sd"] = f"{float(f_sd[k])!r} Hz"
            if zeta is not None:
                entry["damping"] = float(zeta[k])
                if zeta_sd is not None:
                    entry["damping_sd"] = float(zeta_sd[k])
            if columns is not None:
                entry["shape"] = _shape(columns[:, k], shape_sd, k)
            entries.append(entry)
        content: dict[str, Any] = {
            "retune_test": 1,
            "name": name,
            "sources": {"origin": {"kind": "synthetic" if is_synthetic else "measured", "text": source}},
            "modes": entries,
        }
        if configuration is not None:
            content["configuration"] = configuration
        if date is not None:
            content["date"] = date
        if placed:
            content["sensors"] = {s.name: s._entry() for s in placed}
            if len(content["sensors"]) != len(placed):
                raise ValueError("two sensors have one name")
        return cls(content)

    @classmethod
    def from_frfs(cls, frfs: Frfs, **options: Any) -> Test:
        """From frequency response functions: the modes that ``retune.identify`` finds in them. Options are those of ``identify``."""
        from ._verbs import identify

        return identify(frfs, **options).test

    @classmethod
    def from_uff(cls, datasets: object, *, nodes: Mapping[int, str] | None = None, **options: Any) -> Test:
        """From the dictionaries of pyuff: modes of datasets 55 and 2414, with positions of datasets 15 and 2411, where they are there.

        What is zero at a node in a direction in all modes was not measured.

        * ``nodes``: names of the nodes of the model, by the numbers of the points; the numbers themselves when absent
        * ``options``: those of ``from_arrays``: ``frequency_sd``, ``shape_sd``, ``name``, ...
        """
        found, places = modes_of_uff(datasets)
        return cls._of_shapes(found, nodes, places, options)

    @classmethod
    def from_sdynpy(cls, shapes: Any, *, nodes: Mapping[int, str] | None = None, **options: Any) -> Test:
        """From a ``ShapeArray`` of SDynPy, by what it has: ``frequency``, Hz, ``damping``, ``coordinate`` and ``shape_matrix``.

        * ``nodes``, ``options``: those of ``from_uff``
        """
        return cls._of_shapes(modes_of_sdynpy(shapes), nodes, {}, options)

    @classmethod
    def from_sdypy(cls, model: Any, sensors: Sequence[Sensor | str], **options: Any) -> Test:
        """From a ``Model`` of sdypy-EMA whose poles have been selected: ``nat_freq``, Hz, ``nat_xi``, and ``A``, (n_sensors, n_modes), where
        ``get_constants`` has found it.

        * ``sensors``: one a row of its functions
        * ``options``: those of ``from_arrays``
        """
        shapes = getattr(model, "A", None)
        options.setdefault("damping", np.asarray(model.nat_xi, dtype=np.float64))
        options.setdefault("shapes", None if shapes is None else np.asarray(shapes, dtype=np.complex128))
        return cls.from_arrays(model.nat_freq, sensors=[] if shapes is None else sensors, **options)

    @classmethod
    def _of_shapes(
        cls,
        found: Shapes,
        nodes: Mapping[int, str] | None,
        places: Mapping[int, tuple[float, float, float]],
        options: dict[str, Any],
    ) -> Test:
        frequencies, damping, shapes, keys = found.arrays()
        sensors = []
        for node, direction in keys:
            axis = axis_of(direction)
            if axis is None:
                raise ValueError(f"point {node} has a scalar, and a shape has directions")
            if nodes is not None and node not in nodes:
                raise ValueError(f"`nodes` has no name for point {node}")
            turn = "about " if axis[1] else ""
            at = str(node) if nodes is None else nodes[node]
            sensors.append(Sensor(f"{node}.{turn}{axis[0]}", at, axis[0], places.get(node), is_rotation=axis[1]))
        options.setdefault("damping", damping)
        return cls.from_arrays(frequencies, shapes=shapes, sensors=sensors, **options)

    @property
    def name(self) -> str:
        """Its name."""
        return self._inner.name

    @property
    def path(self) -> str | None:
        """The file that it came from."""
        return self._inner.path

    @property
    def date(self) -> str | None:
        """The day on which it was measured, ``2014-05-22``."""
        return self._inner.date

    @property
    def configuration(self) -> str | None:
        """The configuration of the model that was tested."""
        return self._inner.configuration

    @property
    def warnings(self) -> list[Problem]:
        """What is doubtful in its file."""
        return problems_of(self._inner.warnings())

    @property
    def sensors(self) -> list[Sensor]:
        """The sensors, in the order of the rows of ``shapes``."""
        out = []
        for name, at, fraction, position, direction, is_rotation in self._inner.sensors():
            x, y, z = direction
            where = None if position is None else (position[0], position[1], position[2])
            node, element = (at, None) if fraction is None else (None, at)
            out.append(Sensor(name, node, (x, y, z), where, element, fraction, is_rotation))
        return out

    @property
    def modes(self) -> list[TestMode]:
        """The modes."""
        return [TestMode(*row) for row in self._inner.modes()]

    @property
    def frequencies(self) -> Floats:
        """Hz, (n_modes,)."""
        return np.array([m.frequency for m in self.modes])

    @property
    def damping(self) -> Floats:
        """Damping ratios, (n_modes,); NaN where there is none."""
        return np.array([np.nan if m.damping is None else m.damping for m in self.modes])

    @property
    def shapes(self) -> Complexes:
        """Shapes, (n_sensors, n_modes); NaN where an entry was not measured."""
        return self._inner.shapes()

    @property
    def shape_sd(self) -> Floats:
        """Standard deviations of their entries, (n_sensors, n_modes); NaN where there is no shape."""
        return self._inner.shape_sd()

    @property
    def frfs(self) -> Frfs | None:
        """The functions that its file names."""
        found = self._inner.frfs()
        return None if found is None else Frfs._of(found)

    def to_yaml(self) -> str:
        """The text of its file."""
        return self._inner.text

    def save(self, path: PathLike, *, force: bool = False) -> None:
        """Writes its file; one that exists only with ``force``."""
        with open(path, "w" if force else "x", encoding="utf-8") as file:
            file.write(self.to_yaml())

    def __repr__(self) -> str:
        return f"<Test {self.name!r}: {len(self.modes)} modes at {len(self._inner.sensors())} sensors>"

    def _repr_html_(self) -> str:
        from ._html import number, table

        rows = [[k + 1, m.label or "", number(m.frequency), number(m.frequency_sd), number(m.damping)] for k, m in enumerate(self.modes)]
        return table(repr(self)[1:-1], ["#", "mode", "Hz", "± sd", "damping ratio"], rows)

    def __reduce__(self) -> tuple[object, ...]:
        folder = None if self.path is None else os.path.dirname(os.path.abspath(self.path))
        return (_again, (self.to_yaml(), folder))


def _again(text: str, folder: str | None) -> Test:
    return Test._of(_core.Test.from_text(text, folder))


def _shape(column: Complexes, sd: npt.ArrayLike | None, k: int) -> dict[str, Any]:
    """The entry of a shape in a test file; what was not measured is null."""

    def numbers(values: Floats) -> list[float | None]:
        return [float(v) if known else None for v, known in zip(values, measured)]

    measured = np.isfinite(column)
    entry: dict[str, Any] = {"real": numbers(column.real)}
    if np.any(column.imag[measured] != 0.0):
        entry["imaginary"] = numbers(column.imag)
    if sd is not None:
        values = np.asarray(sd, dtype=np.float64)
        if values.ndim == 0:
            entry["sd"] = f"{100.0 * float(values)!r} %"
        else:
            entry["sds"] = [float(v) for v in values[:, k]]
    return entry
