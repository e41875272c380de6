"""A model around a solver of the user's own."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._convert import Floats
from ._model import Parameter


class _Sparse(Protocol):
    def toarray(self) -> npt.NDArray[Any]: ...


_ALONE = threading.RLock()
"""Held while another program computes: many have one state in a process, and the GIL changes hands between two of their calls."""

Matrix = Union[npt.ArrayLike, _Sparse]
"""A dense matrix, or one of ``scipy.sparse``."""


class ParametricModel:
    """A structure whose matrices another program computes: subclass it, and give it to ``update``, ``sample`` and ``Objective``.

    ``assemble`` gives K and M, or K, M and C, at θ in SI units: dense or sparse, symmetric, one row a dof. One call is made at a
    time, of all such models in the process, for many programs have one state. Fixed dofs have no rows. Sensors of a test stand on the nodes.

    >>> import numpy as np
    >>> import retune
    >>> class Chain(ParametricModel):
    ...     '''Two masses of 1 kg and two springs: ω² = k (3 ± √5)/2.'''
    ...     name = "chain"
    ...     parameters = [ParametricModel.parameter("k", 900.0, bounds=(100.0, 2000.0), unit="N/m")]
    ...     nodes = {"a": (0, 0, 0), "b": (1, 0, 0)}
    ...     dofs = ["a.ux", "b.ux"]
    ...     def assemble(self, theta):
    ...         return theta[0] * np.array([[2.0, -1.0], [-1.0, 1.0]]), np.eye(2)
    >>> f = np.sqrt(1000.0 * (3 + np.array([-1, 1]) * np.sqrt(5)) / 2) / (2 * np.pi)
    >>> found = retune.update(Chain(), retune.Test.from_arrays(f, frequency_sd=0.01))
    >>> round(found["k"].after, 2)
    1000.0
    """

    name: str = "a model of another solver"
    """Its name, for messages."""
    parameters: Sequence[Parameter] = ()
    """The parameters, in the order of θ."""
    nodes: Mapping[str, Sequence[float]] = {}
    """Positions of the nodes, m."""
    dofs: Sequence[str] = ()
    """The row of each dof: ``"tip.uz"``; ux, uy, uz, rx, ry, rz."""

    @staticmethod
    def parameter(
        name: str,
        value: float,
        *,
        bounds: tuple[float, float] | None = None,
        prior_sd: float | None = None,
        unit: str = "",
        unit_factor: float = 1.0,
        description: str = "",
    ) -> Parameter:
        """A parameter; values are SI, and one ``unit``, in which tables show it, is ``unit_factor`` in SI."""
        return Parameter(name, unit, unit_factor, value, bounds, prior_sd, description)

    def assemble(self, theta: Floats) -> tuple[Matrix, Matrix] | tuple[Matrix, Matrix, Matrix | None]:
        """K and M, or K, M and C, at θ, (n_parameters,)."""
        raise NotImplementedError

    def derivative(self, theta: Floats, j: int) -> tuple[Matrix, Matrix] | tuple[Matrix, Matrix, Matrix | None]:
        """∂K/∂θ_j and ∂M/∂θ_j, or with ∂C/∂θ_j. By central differences where a subclass has none."""
        raise NotImplementedError

    @property
    def _inner(self) -> _core.External:
        def rows() -> list[tuple[str, str]]:
            out = []
            for text in self.dofs:
                node, dot, dof = text.rpartition(".")
                if not dot:
                    raise ValueError(f"dof {text!r}: it is a node and a dof, such as tip.uz")
                out.append((node, dof))
            return out

        has_derivative = type(self).derivative is not ParametricModel.derivative
        return _core.External(
            self.name,
            [
                (p.name, float(p.value), None if p.bounds is None else list(p.bounds), p.prior_sd, p.unit, p.unit_factor)
                for p in self.parameters
            ],
            [(name, [float(v) for v in at]) for name, at in self.nodes.items()],
            rows(),
            lambda theta: _alone(lambda: self.assemble(theta)),
            (lambda theta, j: _alone(lambda: self.derivative(theta, j))) if has_derivative else None,
        )


_Found = Union[tuple[Matrix, Matrix], tuple[Matrix, Matrix, Union[Matrix, None]]]


def _alone(compute: Callable[[], _Found]) -> tuple[Floats, Floats, Floats | None]:
    with _ALONE:
        return _three(compute())


def _three(found: _Found) -> tuple[Floats, Floats, Floats | None]:
    k, m = found[0], found[1]
    c = found[2] if len(found) == 3 else None
    return _dense(k), _dense(m), None if c is None else _dense(c)


def _dense(a: Matrix) -> Floats:
    to_dense = getattr(a, "toarray", None)
    values: Any = a if to_dense is None else to_dense()
    return np.asarray(values, dtype=np.float64)
