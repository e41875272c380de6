"""A fault of the measurement of the user's own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from . import _core
from ._convert import Complexes, Floats
from ._own import Own

Place = str | tuple[str, str] | int | tuple[int, int]
"""A sensor or two by name, a mode or two by number from 1."""


@dataclass(frozen=True)
class Bench:
    """The tests of a structure as a fault sees them: the sensors and modes of all of them."""

    sensors: Sequence[str]
    """Names of the sensors."""
    channels: Sequence[str]
    """Those of which one may be wrong: none where there are too few to tell, or no shapes."""
    directions: Mapping[str, tuple[float, float, float]]
    """Along what each reads, a unit vector in global axes."""
    positions: Mapping[str, tuple[float, float, float]]
    """Where each stands, m; empty where that is not known."""
    frequencies: Sequence[float]
    """Of the modes, Hz."""


@dataclass(frozen=True)
class At:
    """A place of a fault in the arrays of a test."""

    sensors: tuple[int, ...]
    """Rows of its sensors in shapes; empty where it is about modes."""
    modes: tuple[int, ...]
    """Numbers of its modes, from 0; empty where it is about sensors."""


class Fault(Own[_core.OwnFault]):
    """A fault of the measurement as a Python class: what may be wrong with a test while the model is right.

    ``places`` says where, ``shape`` takes it out of what the sensors read. Give it to ``diagnose(..., faults=[...])``.

    >>> class AmplifierStep(Fault):
    ...     '''An amplifier one step of 10 dB too low.'''
    ...     name = "amplifier-step"
    ...     summary = "The amplifier of a channel stood one step of 10 dB below what the test says."
    ...     signature = "Its reading is 3.16 times too small in every mode."
    ...     def remedy(self, place):
    ...         return f"multiply the readings of sensor {place} by 3.162"
    ...     def shape(self, at, number, shape, sd):
    ...         shape[at.sensors[0]] *= 10**0.5
    ...         if sd is not None:
    ...             sd[at.sensors[0]] *= 10**0.5
    ...     def put_into_shape(self, at, number, shape):
    ...         shape[at.sensors[0]] /= 10**0.5
    """

    name: str = ""
    """Its name, ``kebab-case``."""
    summary: str = ""
    """What is wrong."""
    signature: str = ""
    """How it shows."""
    number: tuple[Literal["factor", "angle", "frequency"], float] | None = None
    """The number that is estimated with it, and what is thought of it beforehand: ``("factor", sd of ln)``, ``("angle", sd in rad)``,
    ``("frequency", sd of ln)``; ``None`` where the fault is there, or it is not."""
    ln_odds: float = 0.0
    """ln of its odds against those of other kinds."""

    def places(self, bench: Bench) -> Sequence[Place]:
        """Where these tests could show it; every channel by default."""
        return list(bench.channels)

    def remedy(self, place: str) -> str:
        """What to do about it, as an order to the engineer.

        * ``place``: in words
        """
        raise NotImplementedError

    def shape(self, at: At, number: float, shape: Complexes, sd: Floats | None) -> None:
        """Takes it out of a shape, (n_sensors,), and out of its standard deviations, in place."""

    def put_into_shape(self, at: At, number: float, shape: Complexes) -> None:
        """Puts it into a shape, in place: by default ``shape`` with the inverse number, or again where it has none."""
        raise NotImplementedError

    def frequencies(self, at: At, number: float, frequencies: Floats) -> None:
        """Takes it out of the frequencies of the modes, Hz, (n_modes,), in place."""

    def functions(self, at: At, number: float) -> Mapping[int, float]:
        """By how much the functions of sensors, by their rows, are too large."""
        return {}

    def _counterpart(self) -> _core.OwnFault:
        def own(name: str) -> bool:
            return getattr(type(self), name) is not getattr(Fault, name)

        calls = (
            self._places,
            self.remedy,
            lambda s, m, number, shape, sd: self.shape(At(tuple(s), tuple(m)), number, shape, sd),
            (lambda s, m, number, shape, _: self.put_into_shape(At(tuple(s), tuple(m)), number, shape))
            if own("put_into_shape")
            else None,
            (lambda s, m, number, f: self.frequencies(At(tuple(s), tuple(m)), number, f)) if own("frequencies") else None,
            (lambda s, m, number: list(self.functions(At(tuple(s), tuple(m)), number).items())) if own("functions") else None,
        )
        return _core.OwnFault((self.name, self.summary, self.signature), self.number, self.ln_odds, calls)

    def _places(self, seen: dict[str, Any]) -> list[Any]:
        names = [name for name, _, _ in seen["sensors"]]
        bench = Bench(
            names,
            names[: seen["n_channels"]],
            {name: tuple(direction) for name, direction, _ in seen["sensors"]},
            {name: tuple(at) for name, at in zip(names, seen["positions"] or [])},
            [f for f, _ in seen["modes"]],
        )

        def sensor(name: str) -> int:
            if name not in names:
                raise ValueError(f"there is no sensor {name!r}; there are {', '.join(names)}")
            return names.index(name)

        out: list[Any] = []
        for place in self.places(bench):
            if isinstance(place, str):
                out.append(sensor(place))
            elif isinstance(place, int):
                out.append(("mode", place - 1, None))
            elif isinstance(place[0], str) and isinstance(place[1], str):
                out.append(("sensors", sensor(place[0]), sensor(place[1])))
            else:
                out.append(("modes", int(place[0]) - 1, int(place[1]) - 1))
        return out
