"""Frequency response functions as NumPy arrays."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, cast

import numpy as np
import numpy.typing as npt

from . import _core
from ._convert import AXES, Complexes, Floats, PathLike, direction_of, vector
from ._errors import tell
from ._foreign import channel_name, form_of_sdypy, listed

Quantity = Literal["receptance", "mobility", "accelerance"]
"""What functions are: displacement, velocity or acceleration over force."""


@dataclass(frozen=True)
class Channel:
    """One end of a function: a named point and a signed direction."""

    name: str
    """Name of the point."""
    direction: tuple[float, float, float] | None = None
    """Unit vector in global axes; ``None`` where it is not known."""

    @classmethod
    def parse(cls, text: str | Channel) -> Channel:
        """From ``"p12.+z"``; without an axis at its end the whole text is the name.

        >>> Channel.parse("p12.-z")
        Channel(name='p12', direction=(-0.0, -0.0, -1.0))
        >>> Channel.parse("p12").direction is None
        True
        """
        if isinstance(text, Channel):
            return text
        name, dot, axis = text.rpartition(".")
        if dot and axis in AXES:
            x, y, z = AXES[axis]
            return cls(name, (x, y, z))
        return cls(text)


class Frfs:
    """Frequency response functions of one structure on common lines.

    * ``frequencies``: lines, Hz, ascending, (n_lines,)
    * ``h``: values, SI, (n_lines, n_responses, n_references) or (n_lines, n_responses) with one reference; NaN where a function was not
      measured
    * ``responses``, ``references``: channels, or their names with an axis: ``"p12.+z"``. Functions of points alone have the ``direction``
    * ``quantity``: ``"accelerance"``, ``"mobility"`` or ``"receptance"``
    * ``coherence``: as ``h``; with ``averages`` it gives the variance of every value
    * ``positions``: where points are, m, by name: sensors get their places in a model from it

    >>> import numpy as np
    >>> f = np.linspace(1.0, 10.0, 50)
    >>> s = 2j * np.pi * f
    >>> h = s**2 / (s**2 + 0.5 * s + (2 * np.pi * 5.0) ** 2)
    >>> frfs = Frfs(f, h[:, None], responses=["a.+z"], references=["a.+z"])
    >>> frfs.h.shape
    (50, 1, 1)
    """

    def __init__(
        self,
        frequencies: npt.ArrayLike,
        h: npt.ArrayLike,
        responses: Sequence[str | Channel],
        references: Sequence[str | Channel],
        *,
        quantity: Quantity = "accelerance",
        coherence: npt.ArrayLike | None = None,
        averages: int | None = None,
        positions: Mapping[str, Sequence[float]] | None = None,
        direction: str | npt.ArrayLike | None = None,
        is_synthetic: bool = False,
    ) -> None:
        usual = None if direction is None else direction_of(direction)

        def ends(channels: Sequence[str | Channel]) -> list[tuple[str, list[float] | None]]:
            parsed = [Channel.parse(c) for c in channels]
            return [(c.name, usual if c.direction is None else list(c.direction)) for c in parsed]

        self._inner = _core.Frfs(
            vector(frequencies, "frequencies"),
            _cube(h, np.complex128),
            ends(responses),
            ends(references),
            quantity,
            None if coherence is None else _cube(coherence, np.float64),
            averages,
            [(name, [float(v) for v in at]) for name, at in (positions or {}).items()],
            is_synthetic,
        )

    @classmethod
    def _of(cls, inner: _core.Frfs) -> Frfs:
        out = cls.__new__(cls)
        out._inner = inner
        return out

    @classmethod
    def from_uff(cls, datasets: object, **options: Any) -> Frfs:
        """From the dictionaries of pyuff (dataset 58), as ``pyuff.UFF(file).read_sets()`` gives them.

        Nodes are points, directions 1, 2, 3 are x, y, z. All functions must have the same lines. Their unit is that of the file: give SI.
        Options are those of ``Frfs``.
        """
        sets = [d for d in listed(datasets) if d.get("type") == 58]
        if not sets:
            raise ValueError("there is no dataset 58 among these")

        def channel(d: dict[str, Any], end: str) -> str:
            return channel_name(int(d[f"{end}_node"]), int(d[f"{end}_direct"]))

        first = np.asarray(sets[0]["x"], dtype=np.float64)
        cells: dict[tuple[str, str], Complexes] = {}
        for d in sets:
            x = np.asarray(d["x"], dtype=np.float64)
            if x.shape != first.shape or not np.allclose(x, first, rtol=1e-6, atol=0.0):
                raise ValueError("the functions have different lines")
            cells[channel(d, "rsp"), channel(d, "ref")] = np.asarray(d["data"], dtype=np.complex128)
        return cls._of_cells(first, cells, options)

    @classmethod
    def from_sdynpy(cls, data: Any, **options: Any) -> Frfs:
        """From a ``TransferFunctionArray`` of SDynPy, by what it has: ``abscissa``, ``ordinate``, ``coordinate`` with ``node`` and ``direction``.

        Its functions are (..., n_lines); coordinates are (..., 2), response first. Options are those of ``Frfs``.
        """
        ordinate = np.asarray(data.ordinate)
        n_lines = ordinate.shape[-1]
        values = ordinate.reshape(-1, n_lines)
        lines = np.asarray(data.abscissa, dtype=np.float64).reshape(-1, n_lines)
        if not np.allclose(lines, lines[0]):
            raise ValueError("the functions have different lines")
        nodes = np.asarray(data.coordinate.node).reshape(-1, 2)
        directions = np.asarray(data.coordinate.direction).reshape(-1, 2)

        def channel(k: int, end: int) -> str:
            return channel_name(int(nodes[k, end]), int(directions[k, end]))

        cells = {(channel(k, 0), channel(k, 1)): values[k] for k in range(len(values))}
        return cls._of_cells(lines[0], cells, options)

    @classmethod
    def from_sdypy(cls, model: Any, responses: Sequence[str | Channel], reference: str | Channel, **options: Any) -> Frfs:
        """From a ``Model`` of sdypy-EMA, by what it has: ``freq``, (n_lines,), and ``frf``, (n_responses, n_lines).

        Options are those of ``Frfs``; what sdypy calls ``frf_form``, in older versions ``frf_type``, is the ``quantity``.
        """
        options.setdefault("quantity", form_of_sdypy(model))
        h = np.asarray(model.frf, dtype=np.complex128).T
        return cls(np.asarray(model.freq, dtype=np.float64), h, responses, [reference], **options)

    @classmethod
    def _of_cells(cls, lines: Floats, cells: Mapping[tuple[str, str], npt.NDArray[Any]], options: dict[str, Any]) -> Frfs:
        responses = list(dict.fromkeys(r for r, _ in cells))
        references = list(dict.fromkeys(r for _, r in cells))
        h = np.full((len(lines), len(responses), len(references)), np.nan, dtype=np.complex128)
        for (response, reference), values in cells.items():
            h[:, responses.index(response), references.index(reference)] = values
        return cls(lines, h, responses, references, **options)

    @property
    def frequencies(self) -> Floats:
        """Lines, Hz, (n_lines,)."""
        return self._inner.frequencies()

    @property
    def h(self) -> Complexes:
        """Values, SI, (n_lines, n_responses, n_references)."""
        return self._inner.h()

    @property
    def coherence(self) -> Floats | None:
        """Coherence, as ``h``."""
        return self._inner.coherence()

    @property
    def quantity(self) -> Quantity:
        """What the functions are."""
        return cast(Quantity, self._inner.quantity)

    @property
    def responses(self) -> list[Channel]:
        """Points of response."""
        return [Channel(name, None if d is None else (d[0], d[1], d[2])) for name, d in self._inner.responses()]

    @property
    def references(self) -> list[Channel]:
        """Points of excitation."""
        return [Channel(name, None if d is None else (d[0], d[1], d[2])) for name, d in self._inner.references()]

    @property
    def is_synthetic(self) -> bool:
        """Whether they were computed."""
        return self._inner.is_synthetic

    def __repr__(self) -> str:
        lines, responses, references = self._inner.h().shape
        counted = [f"{n} {what}{'' if n == 1 else 's'}" for n, what in ((responses, "response"), (references, "reference"), (lines, "line"))]
        return f"<Frfs: {self.quantity}, {counted[0]} x {counted[1]}, {counted[2]}>"

    def _repr_html_(self) -> str:
        from ._html import curves

        f, h = self.frequencies, np.abs(self.h)
        names = [f"{r.name} / {q.name}" for q in self.references for r in self.responses]
        columns = [h[:, i, j] for j in range(h.shape[2]) for i in range(h.shape[1])]
        return curves(f, columns, names, repr(self)[1:-1])


def _cube(values: npt.ArrayLike, dtype: Any) -> Any:
    out = np.asarray(values, dtype=dtype)
    return out[:, :, None] if out.ndim == 2 else out


def read_options(**options: Any) -> dict[str, Any]:
    """Answers to what measurement files leave open, with every name."""
    names = (
        "units",
        "quantity",
        "unit",
        "duplicates",
        "frequency_unit",
        "direction",
        "geometry",
        "geometry_units",
        "variables",
        "frame",
    )
    unknown = set(options) - set(names)
    if unknown:
        raise TypeError(f"{', '.join(sorted(unknown))}: no such answer; there are {', '.join(names)}")
    return {name: options.get(name) for name in names}


def read_frfs(
    files: PathLike | Sequence[PathLike],
    *,
    units: str | None = None,
    quantity: Quantity | None = None,
    unit: str | None = None,
    duplicates: Literal["first", "last"] | None = None,
    frequency_unit: str | None = None,
    direction: str | None = None,
    geometry: PathLike | None = None,
    geometry_units: str | None = None,
    variables: str | None = None,
    frame: str | None = None,
) -> Frfs:
    """The functions of measurement files: universal files, tables, OpenModal folders, NumPy, MATLAB.

    Options are those of ``retune identify``: nothing that the files leave open is guessed.
    """
    paths = [files] if isinstance(files, (str, os.PathLike)) else list(files)
    options = read_options(
        units=units,
        quantity=quantity,
        unit=unit,
        duplicates=duplicates,
        frequency_unit=frequency_unit,
        direction=direction,
        geometry=geometry,
        geometry_units=geometry_units,
        variables=variables,
        frame=frame,
    )
    inner, remarks = _core.read_frfs([os.fspath(p) for p in paths], options)
    tell(remarks)
    return Frfs._of(inner)
