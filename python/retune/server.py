"""A server of UM-Bridge, so that tools of uncertainty quantification drive a model. Needs ``umbridge``.

Models of the server, each with one input, the free parameters in the unit box, and one output:

* ``posterior``: the logarithm of the posterior up to a constant, minus the cost of the fit, with gradient and Jacobian action
* ``residuals``: r = (model - test)/σ, with gradient and Jacobian action
* ``frequencies``: the elastic frequencies of the model, Hz, without derivatives

>>> import retune
>>> model = retune.Model({"retune": 1, "name": "mass on a spring", "nodes": {"a": [0, 0, 0]}, "active_dofs": ["uz"],
...     "parameters": {"k": {"value": "100 N/m", "bounds": ["10 N/m", "1000 N/m"]}},
...     "springs": {"s": {"node": "a", "k": {"uz": "k"}}}, "masses": {"b": {"node": "a", "mass": "1 kg"}}})
>>> server = Served(model, retune.Test.from_arrays([2.0], frequency_sd=0.01))
>>> x = server.objective.x([16.0 * 3.14159265**2])  # k = m (2 pi f)^2
>>> [[hz]] = server.evaluate("frequencies", [x.tolist()])
>>> round(hz, 6)
2.0
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from ._convert import PathLike, Tests
from ._model import Model
from ._objective import Objective

Name = Literal["posterior", "residuals", "frequencies"]
NAMES: tuple[Name, ...] = ("posterior", "residuals", "frequencies")


class Served:
    """What the server answers, without the server."""

    def __init__(self, model: Model | PathLike, tests: Tests, *, modes: int = 10, **options: Any) -> None:
        self.model = model if isinstance(model, Model) else Model.from_file(model)
        self.objective = Objective(self.model, tests, **options)
        found = self.model.modes(n=modes)
        self.modes = len(found) - found.n_rigid

    def _x(self, parameters: list[list[float]]) -> np.ndarray[Any, np.dtype[np.float64]]:
        return np.asarray(parameters[0], dtype=np.float64)

    def output_size(self, name: Name) -> int:
        """Length of the output."""
        return {"posterior": 1, "residuals": self.objective.n_residuals, "frequencies": self.modes}[name]

    def evaluate(self, name: Name, parameters: list[list[float]]) -> list[list[float]]:
        """The output at a point."""
        x = self._x(parameters)
        if name == "posterior":
            return [[-self.objective.cost(x)]]
        if name == "residuals":
            return [self.objective.residuals(x).tolist()]
        found = self.model.modes(self.objective.theta(x), n=self.modes)
        return [found.frequencies[found.n_rigid :].tolist()]

    def jacobian(self, name: Name, parameters: list[list[float]]) -> np.ndarray[Any, np.dtype[np.float64]]:
        """∂output/∂x, (n_output, n_free)."""
        x = self._x(parameters)
        if name == "posterior":
            return -self.objective.gradient(x)[None, :]
        if name == "residuals":
            return self.objective.jacobian(x)
        raise ValueError("`frequencies` has no derivatives here; `residuals` has")


def serve(model: Model | PathLike, tests: Tests, port: int = 4242, *, modes: int = 10, **options: Any) -> None:
    """Serves until the process ends. Options are those of ``Objective``."""
    import umbridge

    served = Served(model, tests, modes=modes, **options)

    # Its methods are typed by what the base class answers.
    base: Any = umbridge.Model

    class Bridge(base):  # type: ignore[misc]
        def __init__(self, name: Name) -> None:
            super().__init__(name)
            self._name: Name = name

        def get_input_sizes(self, config: dict[str, Any]) -> list[int]:
            return [len(served.objective.names)]

        def get_output_sizes(self, config: dict[str, Any]) -> list[int]:
            return [served.output_size(self._name)]

        def __call__(self, parameters: list[list[float]], config: dict[str, Any]) -> list[list[float]]:
            return served.evaluate(self._name, parameters)

        def gradient(
            self, out_wrt: int, in_wrt: int, parameters: list[list[float]], sens: list[float], config: dict[str, Any]
        ) -> list[float]:
            return [float(v) for v in served.jacobian(self._name, parameters).T @ np.asarray(sens)]

        def apply_jacobian(
            self, out_wrt: int, in_wrt: int, parameters: list[list[float]], vec: list[float], config: dict[str, Any]
        ) -> list[float]:
            return [float(v) for v in served.jacobian(self._name, parameters) @ np.asarray(vec)]

        def supports_evaluate(self) -> bool:
            return True

        def supports_gradient(self) -> bool:
            return self._name != "frequencies"

        def supports_apply_jacobian(self) -> bool:
            return self._name != "frequencies"

    umbridge.serve_models([Bridge(name) for name in NAMES], port)
