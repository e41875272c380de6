"""A model whose matrices a Python class gives: the same answers as a model file, and errors that name the culprit."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import retune

Matrix = npt.NDArray[np.float64]


class Borrowed(retune.ParametricModel):
    """The cantilever, by its matrices: what another solver would give."""

    def __init__(self, model: retune.Model) -> None:
        self.model = model
        self.name = "borrowed"
        self.dofs = model.dofs
        known = model.nodes
        self.nodes = {d.rpartition(".")[0]: known[d.rpartition(".")[0]].tolist() for d in model.dofs}
        self.parameters = list(model.parameters.values())
        self.calls = 0

    def assemble(self, theta: Matrix) -> Any:
        self.calls += 1
        found = self.model.matrices(theta)
        return found.stiffness, found.mass


def test_a_borrowed_model_fits_as_its_own(cantilever: retune.Model, twin: retune.Test) -> None:
    tip = [s for s in twin.sensors if s.node not in (None, "root")]
    rows = [k for k, s in enumerate(twin.sensors) if s in tip]
    test = retune.Test.from_arrays(
        twin.frequencies, shapes=twin.shapes[rows], sensors=tip, frequency_sd=0.002 * twin.frequencies, shape_sd=0.01
    )
    own = retune.update(cantilever, test)
    borrowed = Borrowed(cantilever)
    other = retune.update(borrowed, test)
    assert borrowed.calls > 0
    # Derivatives are differences here, so the optimum is the same to what these can tell.
    assert other.cost == pytest.approx(own.cost, rel=1e-4)
    assert other["E"].after == pytest.approx(own["E"].after, rel=1e-4)
    assert other["E"].sd == pytest.approx(own["E"].sd, rel=1e-2)
    objective, its = retune.Objective(cantilever, test), retune.Objective(borrowed, test)
    assert its.residuals([0.3]) == pytest.approx(objective.residuals([0.3]), rel=1e-6, abs=1e-6)
    with pytest.raises(retune.RetuneError, match="model file"):
        other.to_html()


class Wrong(retune.ParametricModel):
    name = "wrong"
    parameters = [retune.ParametricModel.parameter("k", 1.0, bounds=(0.5, 2.0))]
    nodes = {"a": (0, 0, 0), "b": (1, 0, 0)}
    dofs = ["a.ux", "b.ux"]

    def __init__(self, what: str) -> None:
        self.what = what

    def assemble(self, theta: Matrix) -> Any:
        if self.what == "raises":
            raise ZeroDivisionError("the solver has failed")
        k = {"skew": [[1.0, 0.5], [0.0, 1.0]], "size": [[1.0]], "nan": [[np.nan, 0.0], [0.0, 1.0]]}[self.what]
        return np.array(k), np.eye(2)


@pytest.mark.parametrize(
    ("what", "message"),
    [
        ("raises", "wrong: ZeroDivisionError: the solver has failed"),
        ("skew", "K is not symmetric"),
        ("size", "K is 1 x 1, and there are 2 rows"),
        ("nan", "K has entries that are not finite"),
    ],
)
def test_what_is_wrong_is_named(what: str, message: str) -> None:
    test = retune.Test.from_arrays([0.2], frequency_sd=0.01)
    with pytest.raises(retune.RetuneError, match=message):
        retune.update(Wrong(what), test)


def test_calls_of_another_solver_never_overlap() -> None:
    """A program with one state, as OpenSees: K is what was set by this call, though the GIL changes hands in between."""
    state = {"k": 0.0}

    class Chain(retune.ParametricModel):
        name = "chain"
        parameters = [retune.ParametricModel.parameter("k", 900.0, bounds=(100.0, 2000.0), unit="N/m")]
        nodes = {"a": (0, 0, 0), "b": (1, 0, 0)}
        dofs = ["a.ux", "b.ux"]

        def assemble(self, theta: Any) -> Any:
            state["k"] = float(theta[0])
            time.sleep(1e-3)
            assert state["k"] == theta[0], "another call has come between"
            return state["k"] * np.array([[2.0, -1.0], [-1.0, 1.0]]), np.eye(2)

    test = retune.Test.from_arrays([3.0, 8.0], frequency_sd=0.01)
    objective = retune.Objective(Chain(), test)
    points = np.linspace(0.0, 1.0, 64)[:, None]
    # Two frequencies, both as √k; the cost of each point is its own.
    assert np.array_equal(objective.costs(points), [objective.cost(x) for x in points])
    assert np.isfinite(objective.costs(points)).all()


def test_rows_have_a_place() -> None:
    class Lost(Wrong):
        dofs = ["a.ux", "c.ux"]

    class Twice(Wrong):
        dofs = ["a.ux", "a.ux"]

    test = retune.Test.from_arrays([0.2], frequency_sd=0.01)
    with pytest.raises(retune.RetuneError, match="row `c.ux`: there is no such node"):
        retune.update(Lost("skew"), test)
    with pytest.raises(retune.RetuneError, match="row `a.ux` is given twice"):
        retune.update(Twice("skew"), test)
