"""A residual term of the user's own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _core
from ._convert import Floats
from ._own import Own


@dataclass(frozen=True)
class Measured:
    """What a residual sees of a test."""

    sensors: Sequence[str]
    """Names of the sensors."""
    frequencies: Floats
    """Hz, (n_modes,)."""
    frequency_sd: Floats
    """Their standard deviations, Hz, (n_modes,)."""
    shapes: Floats
    """Real shapes, (n_sensors, n_modes); NaN where an entry was not measured, and for modes that take part in nothing."""
    shape_sd: Floats
    """Standard deviations of their entries, (n_sensors, n_modes); NaN where there is no shape."""
    is_aside: npt.NDArray[np.bool_]
    """Whether a mode takes part in nothing, (n_modes,)."""
    parameters: Sequence[str]
    """Names of the parameters, in the order of ``Predicted.theta``."""


@dataclass(frozen=True)
class Predicted:
    """What the model says of the same modes, each paired with its partner."""

    theta: Floats
    """All parameters, SI, (n_parameters,)."""
    frequencies: Floats
    """Hz, (n_modes,); NaN where the model has no partner."""
    shapes: Floats
    """Mass-normalised, at the sensors, (n_sensors, n_modes); NaN where the model has no partner. Their signs are free."""


class Residual(Own[_core.OwnResidual]):
    """A term of a least-squares objective as a Python class: rows r = (model - test)/σ. Give it to ``update(..., residuals=[MyTerm()])``.

    It stands beside the usual terms; where ``objective`` states ``terms`` it takes part if they name it, with the factor that they give.
    Derivatives of frequencies and shapes are the model's own; how the rows follow from these is taken by central differences.

    >>> import numpy as np
    >>> import retune
    >>> class Spacing(Residual):
    ...     '''Ratio of neighbouring frequencies: blind to a scale of all of them.'''
    ...     name = "spacing"
    ...     summary = "ratios of neighbouring frequencies, over one per mille"
    ...     def rows(self, test):
    ...         return [f"ratio {k + 2} to {k + 1}" for k in range(len(test.frequencies) - 1)]
    ...     def evaluate(self, test, model):
    ...         ratio = model.frequencies[1:] / model.frequencies[:-1]
    ...         return np.nan_to_num((ratio - test.frequencies[1:] / test.frequencies[:-1]) / 1e-3)
    >>> chain = {"retune": 1, "name": "chain", "nodes": {"a": [0, 0, 0], "b": [1, 0, 0]}, "active_dofs": ["ux"],
    ...     "parameters": {"k": {"value": "900 N/m", "bounds": ["100 N/m", "2000 N/m"]}},
    ...     "springs": {"s": {"node": "a", "k": {"ux": "1000 N/m"}}, "t": {"nodes": ["a", "b"], "k": {"ux": "k"}}},
    ...     "masses": {"m": {"node": "a", "mass": "1 kg"}, "n": {"node": "b", "mass": "1 kg"}}}
    >>> f = np.sqrt(1000.0 * (3 + np.array([-1, 1]) * np.sqrt(5)) / 2) / (2 * np.pi)
    >>> found = retune.update(retune.Model(chain), retune.Test.from_arrays(3 * f, frequency_sd=0.01),
    ...                       objective={"terms": {"spacing": 1}}, residuals=[Spacing()], pairing="order")
    >>> round(found["k"].after, 1)  # only the ratio counts
    1000.0
    """

    name: str = ""
    """The word in ``terms``, ``kebab-case``."""
    summary: str = ""
    """One sentence: what it compares."""

    def rows(self, test: Measured) -> Sequence[str]:
        """What each row compares, for reports. Their number may depend on the test, and never on θ."""
        raise NotImplementedError

    def evaluate(self, test: Measured, model: Predicted) -> npt.ArrayLike:
        """The rows, finite, (n_rows,); a row without a partner in the model has a constant."""
        raise NotImplementedError

    def _counterpart(self) -> _core.OwnResidual:
        return _core.OwnResidual(
            self.name,
            self.summary,
            lambda test: [str(row) for row in self.rows(Measured(**test))],
            self._evaluate,
        )

    def _evaluate(self, test: dict[str, Any], model: tuple[Floats, Floats, Floats]) -> Floats:
        return np.asarray(self.evaluate(Measured(**test), Predicted(*model)), dtype=np.float64)
