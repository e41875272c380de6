"""The cost of a fit, for searches of the user's own; and the searches of retune for costs of the user's own."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from . import _core
from ._convert import Floats, PathLike, Tests, parametric_of, tests_of, text_of, vector
from ._errors import RetuneError, tell
from ._external import ParametricModel
from ._model import Model
from ._residual import Residual

CostName = Literal["least-squares", "paper", "frequencies"]
PairingName = Literal["probable", "mac", "near-mac", "order", "label"]


class Objective:
    """The cost that ``retune.update`` minimises, as a function of x in the unit box of the free parameters.

    Pairs, terms, loss, pull towards the estimates and limits are those of an update with the same arguments, so that what another search finds
    has the cost that an update would give it. Residuals are (model - test)/σ and the cost is ½ rᵀr; the costs ``paper`` and ``frequencies``
    are costs of their own. x = 0 and x = 1 are the bounds of a parameter; ``theta`` gives its value.

    For ``scipy.optimize.least_squares``:

    >>> import retune
    >>> from scipy.optimize import least_squares
    >>> model = retune.Model({"retune": 1, "name": "mass on a spring", "nodes": {"a": [0, 0, 0]}, "active_dofs": ["uz"],
    ...     "parameters": {"k": {"value": "100 N/m", "bounds": ["10 N/m", "1000 N/m"]}},
    ...     "springs": {"s": {"node": "a", "k": {"uz": "k"}}}, "masses": {"b": {"node": "a", "mass": "1 kg"}}})
    >>> objective = retune.Objective(model, retune.Test.from_arrays([2.0], frequency_sd=0.01))
    >>> found = least_squares(objective.residuals, objective.start, objective.jacobian, bounds=(0, 1))
    >>> round(float(objective.theta(found.x)[0]), 1)
    157.9

    For ``scipy.optimize.differential_evolution`` with ``vectorized=True``, ``objective.vectorized`` evaluates a population at once, on all
    cores.
    """

    def __init__(
        self,
        model: Model | ParametricModel | PathLike,
        tests: Tests,
        *,
        cost: CostName = "least-squares",
        objective: str | Mapping[str, Any] | None = None,
        pairing: PairingName = "probable",
        min_mac: float | None = None,
        frequency_window: float | None = None,
        configuration: str | None = None,
        sensor_masses: bool = False,
        residuals: Sequence[Residual] = (),
    ) -> None:
        how = (pairing, min_mac, frequency_window)
        arguments = (cost, text_of(objective), how, configuration, sensor_masses, [r._core() for r in residuals])
        self._inner = _core.Objective(parametric_of(model), tests_of(tests), *arguments)
        self.notes: list[str] = tell(self._inner.remarks())
        self._last: tuple[bytes, tuple[Floats, Floats]] | None = None

    @property
    def names(self) -> list[str]:
        """The free parameters, in the order of x."""
        return self._inner.names()

    @property
    def start(self) -> Floats:
        """Where an update begins, (n_free,)."""
        return self._inner.start()

    @property
    def n_residuals(self) -> int:
        """Number of residuals."""
        return self._inner.n_residuals

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """The unit box, as SciPy wants it."""
        return [(0.0, 1.0)] * len(self.names)

    def residuals(self, x: npt.ArrayLike) -> Floats:
        """r(x), (n_residuals,)."""
        return self._inner.residuals(vector(x, "x"))

    def jacobian(self, x: npt.ArrayLike) -> Floats:
        """∂r/∂x, exact, (n_residuals, n_free)."""
        return self.linearize(x)[1]

    def linearize(self, x: npt.ArrayLike) -> tuple[Floats, Floats]:
        """Residuals and Jacobian together; the last point is remembered."""
        at = vector(x, "x")
        key = at.tobytes()
        if self._last is None or self._last[0] != key:
            self._last = (key, self._inner.linearize(at))
        residuals, jacobian = self._last[1]
        return residuals.copy(), jacobian.copy()

    def gradient(self, x: npt.ArrayLike) -> Floats:
        """Gradient of ½ rᵀr, (n_free,)."""
        residuals, jacobian = self.linearize(x)
        return jacobian.T @ residuals

    def cost(self, x: npt.ArrayLike) -> float:
        """The cost at x; infinite where the model has none."""
        return float(self.costs(vector(x, "x")[None, :])[0])

    __call__ = cost

    def costs(self, points: npt.ArrayLike) -> Floats:
        """Costs of points, (n_points, n_free), on all cores by the batched kernel; infinite where the model has none."""
        return self._inner.costs(np.asarray(points, dtype=np.float64))

    def vectorized(self, points: npt.ArrayLike) -> Floats:
        """``costs`` of points as columns, (n_free, n_points), as ``differential_evolution(..., vectorized=True)`` hands them over."""
        return self._inner.costs(np.asarray(points, dtype=np.float64).T)

    def theta(self, x: npt.ArrayLike) -> Floats:
        """All parameters of the model at x, SI, in the order of ``Model.parameters``."""
        return self._inner.theta(vector(x, "x"))

    def x(self, theta: npt.ArrayLike) -> Floats:
        """x of parameters, SI, in the order of ``Model.parameters``."""
        return self._inner.x_of(vector(theta, "theta"))

    def __repr__(self) -> str:
        return f"<Objective: {len(self.names)} parameters, {self.n_residuals} residuals>"


@dataclass(frozen=True)
class Optimum:
    """Where a search ended."""

    x: Floats
    """The best point, (n,)."""
    cost: float
    """Its cost."""
    evaluations: int
    """Costs and linearizations that were asked for."""
    termination: str
    """Why it ended."""


class Search:
    """A search of retune that asks for costs and is told them: for costs of the user's own, wherever they are computed.

    It visits the same points as the command with the same seed. x is in the unit box.

    >>> import numpy as np
    >>> search = Search([0.9, 0.9], optimizer="nelder-mead", seed=1, budget=2000)
    >>> while (points := search.ask()) is not None:
    ...     search.tell([(x[0] - 0.3) ** 2 + (x[1] - x[0]) ** 2 for x in points])
    >>> search.optimum.x.round(3)
    array([0.3, 0.3])

    With ``n_residuals`` methods that need derivatives ask for linearizations; ``wants`` says what is asked for.
    """

    def __init__(
        self,
        start: npt.ArrayLike,
        *,
        optimizer: str | Mapping[str, Any] | Sequence[Any] = "auto",
        n_residuals: int = 0,
        seed: int = 0,
        budget: int | None = None,
    ) -> None:
        text = optimizer if isinstance(optimizer, str) else _yaml(optimizer)
        self._inner = _core.Search(text, vector(start, "start"), n_residuals, seed, budget)
        self._optimum: Optimum | None = None
        self.wants: Literal["costs", "linearizations", "done"] = "costs"
        """What the open question asks for."""

    def ask(self) -> Floats | None:
        """Points, (n_points, n), whose costs or linearizations are wanted; ``None`` when the search has ended."""
        question, points, found = self._inner.ask()
        if found is not None:
            self.wants = "done"
            self._optimum = Optimum(*found)
            return None
        self.wants = "linearizations" if question == "linearizations" else "costs"
        return points

    def tell(self, costs: npt.ArrayLike) -> None:
        """The costs of the points, (n_points,); one that is not finite says that the point cannot be evaluated."""
        self._inner.tell_costs(vector(costs, "costs"))

    def tell_linearizations(self, told: Sequence[tuple[npt.ArrayLike, npt.ArrayLike] | None]) -> None:
        """Residuals, (n_residuals,), and Jacobian, (n_residuals, n), of each point; ``None`` for one that cannot be evaluated."""
        self._inner.tell_linearizations(
            [None if one is None else (vector(one[0], "residuals"), np.asarray(one[1], dtype=np.float64)) for one in told]
        )

    def run(
        self,
        cost: Callable[[Floats], float],
        linearize: Callable[[Floats], tuple[npt.ArrayLike, npt.ArrayLike]] | None = None,
    ) -> Optimum:
        """Answers every question by a function until the search ends."""
        while (points := self.ask()) is not None:
            if self.wants == "costs":
                self.tell([cost(x) for x in points])
            elif linearize is None:
                raise RetuneError("the search asks for linearizations: give a function for them, or no `n_residuals`")
            else:
                self.tell_linearizations([linearize(x) for x in points])
        return self.optimum

    @property
    def optimum(self) -> Optimum:
        """Where it ended."""
        if self._optimum is None:
            raise RetuneError("the search has not ended: ask and tell until `ask` gives None")
        return self._optimum


def _yaml(optimizer: Mapping[str, Any] | Sequence[Any]) -> str:
    from ._convert import dumps

    return _core.yaml_of_json(dumps(optimizer))
