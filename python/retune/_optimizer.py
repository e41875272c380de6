"""An optimiser of the user's own."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from . import _core
from ._convert import Floats, vector
from ._own import Own


class SearchEnded(Exception):
    """The budget is spent, or Ctrl-C was pressed: raised by a ``Run`` in ``minimize``. Let it pass: the best point is kept."""


class Run:
    """What an optimiser asks for costs. It counts, keeps the best point, and evaluates a batch on all cores."""

    def __init__(self, inner: _core.Run) -> None:
        self._inner = inner

    @property
    def n_parameters(self) -> int:
        """Length of x."""
        return self._inner.n_parameters

    @property
    def n_residuals(self) -> int:
        """Length of the residuals."""
        return self._inner.n_residuals

    @property
    def remaining(self) -> int | None:
        """Evaluations that are left; ``None`` where they are not limited."""
        return self._inner.remaining()

    def costs(self, points: npt.ArrayLike) -> Floats:
        """Costs of points of the unit box, (n_points, n_parameters); infinite where the model has none."""
        return self._inner.costs(np.asarray(points, dtype=np.float64))

    def cost(self, x: npt.ArrayLike) -> float:
        """The cost of one point."""
        return float(self.costs(vector(x, "x")[None, :])[0])

    def linearize(self, x: npt.ArrayLike) -> tuple[Floats, Floats] | None:
        """Residuals, (n_residuals,), and Jacobian, (n_residuals, n_parameters); ``None`` where the model has none."""
        return self._inner.linearize(vector(x, "x"))

    def rng(self, stream: int = 0) -> np.random.Generator:
        """Random numbers that follow from the seed of the update."""
        return np.random.default_rng(self._inner.seed(stream))


class Optimizer(Own[_core.OwnOptimizer]):
    """A search as a Python class: subclass it, and give it to ``update(..., optimizer=MySearch())``.

    >>> import numpy as np
    >>> import retune
    >>> class Compass(Optimizer):
    ...     '''Asks for the neighbours of the best point, goes to the best of them, halves its step when none is better.'''
    ...     name = "compass"
    ...     def minimize(self, start, run):
    ...         x, cost, step = start, run.cost(start), 0.25
    ...         while step > 1e-7:
    ...             around = np.clip(x + step * np.vstack([np.eye(len(x)), -np.eye(len(x))]), 0, 1)
    ...             costs = run.costs(around)
    ...             if costs.min() < cost:
    ...                 x, cost = around[costs.argmin()], costs.min()
    ...             else:
    ...                 step /= 2
    ...         return True
    >>> model = retune.Model({"retune": 1, "name": "mass on a spring", "nodes": {"a": [0, 0, 0]}, "active_dofs": ["uz"],
    ...     "parameters": {"k": {"value": "100 N/m", "bounds": ["10 N/m", "1000 N/m"]}},
    ...     "springs": {"s": {"node": "a", "k": {"uz": "k"}}}, "masses": {"b": {"node": "a", "mass": "1 kg"}}})
    >>> found = retune.update(model, retune.Test.from_arrays([2.0], frequency_sd=0.01), optimizer=Compass())
    >>> round(found["k"].after, 2)  # k = m (2 pi f)^2
    157.91
    """

    name: str = ""
    """Its name, ``kebab-case``."""

    def minimize(self, start: Floats, run: Run) -> bool | None:
        """Searches from ``start`` in the unit box; the run keeps the best point that it was asked for.

        Returns whether it has ended at an optimum; ``None`` where it does not know. The same answers must lead to the same questions: all
        randomness from ``run.rng``, no clock.
        """
        raise NotImplementedError

    def _counterpart(self) -> _core.OwnOptimizer:
        return _core.OwnOptimizer(self.name, lambda start, run: self.minimize(start, Run(run)))
