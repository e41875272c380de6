"""What a model lacks: the results of ``diagnose`` and ``learn``."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import _core
from ._convert import Floats
from ._html import number, table
from ._model import Model
from ._results import Paged
from ._test import Test

@dataclass(frozen=True)
class Hypothesis:
    """An effect or a fault that may explain what the model misses."""

    id: str
    """Effect and place: ``point-mass@tip``."""
    name: str
    location: str
    probability: float
    estimate: float | None
    """Its size."""
    interval: tuple[float, float] | None
    """90 %."""
    unit: str | None
    tied_with: list[str]
    """Which others the data cannot tell it from."""


class Diagnosis(Paged):
    """What a model lacks to explain its tests."""

    def __init__(self, inner: _core.Diagnosed, notes: list[str]) -> None:
        super().__init__(inner.json(), notes)
        self._inner = inner

    def _page(self) -> str:
        return self._inner.page()

    @property
    def verdict(self) -> str:
        """In one word."""
        return str(self._dict["verdict"])

    @property
    def sentence(self) -> str:
        """In one sentence."""
        return str(self._dict["sentence"])

    @property
    def hypotheses(self) -> list[Hypothesis]:
        """The most probable first."""
        return [
            Hypothesis(
                h["id"],
                h["name"],
                h["location"],
                h["probability"],
                h["estimate"],
                None if h["interval"] is None else (h["interval"][0], h["interval"][1]),
                h["unit"],
                h["tied_with"],
            )
            for h in self._dict["hypotheses"]
        ]

    @property
    def is_partial(self) -> bool:
        """Whether the search was cut short."""
        return bool(self._dict.get("is_partial", False))

    def __repr__(self) -> str:
        return f"<Diagnosis: {self.sentence}>"

    def _repr_html_(self) -> str:
        rows = [
            [h.id, f"{h.probability:.3f}", number(h.estimate), h.unit or "", ", ".join(h.tied_with)]
            for h in self.hypotheses[:10]
        ]
        return table(self.sentence, ["hypothesis", "probability", "size", "unit", "tied with"], rows)


class Learning(Paged):
    """Effects added one after another until nothing more is justified."""

    def __init__(self, inner: _core.Learned, notes: list[str]) -> None:
        super().__init__(inner.json(), notes)
        self._inner = inner

    def _page(self) -> str:
        return self._inner.page()

    @property
    def effects(self) -> list[str]:
        """Effects in the last model: ``point-mass@tip``."""
        return list(self._dict["effects"])

    @property
    def models(self) -> list[Model]:
        """The model of every step, the first as it was, fitted."""
        return [Model._of(m) for m in self._inner.models()]

    @property
    def model(self) -> Model:
        """The last model."""
        return self.models[-1]

    @property
    def tests(self) -> list[Test]:
        """The tests, with every fault taken out that was found."""
        return [Test._of(t) for t in self._inner.tests()]

    @property
    def misfits(self) -> Floats:
        """Squared misfit at every step, (n_steps,)."""
        return np.array([step["misfit"] for step in self._dict["steps"]], dtype=np.float64)

    def __repr__(self) -> str:
        return f"<Learning: {', '.join(self.effects) or 'nothing'} found in {len(self._dict['steps'])} steps>"

    def _repr_html_(self) -> str:
        rows = [[k, step.get("added") or "", number(step["misfit"])] for k, step in enumerate(self._dict["steps"])]
        return table(repr(self)[1:-1], ["step", "then added", "misfit"], rows)
