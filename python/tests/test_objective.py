"""The objective for searches of the user's own, and the searches of retune for objectives of the user's own."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import differential_evolution, least_squares

import retune


@pytest.mark.filterwarnings("ignore::retune.RetuneWarning")
def test_residuals_have_the_cost_of_an_update(models: Path) -> None:
    model, test = retune.Model(models / "bff.yaml"), retune.Test(models / "bff_gvt.yaml")
    objective = retune.Objective(model, test)
    x = np.full(len(objective.names), 0.4)
    r = objective.residuals(x)
    assert r.shape == (objective.n_residuals,)
    assert objective.cost(x) == pytest.approx(0.5 * r @ r, rel=1e-8)
    found = retune.update(model, test, budget=300)
    assert objective.cost(objective.x(found.theta)) == pytest.approx(found.cost, rel=1e-6)


def test_the_jacobian_is_the_slope(cantilever: retune.Model, twin: retune.Test) -> None:
    objective = retune.Objective(cantilever, twin)
    x = np.array([0.37])
    r, jacobian = objective.linearize(x)
    step = 1e-6
    slope = (objective.residuals(x + step) - objective.residuals(x - step)) / (2 * step)
    # Central differences: h² r'''/6 and ε r/h, both below 1e-5 of the largest slope here.
    assert np.abs(jacobian[:, 0] - slope).max() < 1e-5 * np.abs(slope).max()
    assert objective.gradient(x) == pytest.approx(jacobian.T @ r)
    jacobian[:] = 0.0
    assert np.any(objective.jacobian(x) != 0.0)


def test_scipy_finds_what_an_update_finds(cantilever: retune.Model, twin: retune.Test) -> None:
    objective = retune.Objective(cantilever, twin)
    ours = retune.update(cantilever, twin)
    theirs = least_squares(objective.residuals, objective.start, objective.jacobian, bounds=(0, 1), xtol=1e-12)
    assert theirs.cost == pytest.approx(ours.cost, rel=1e-6)
    assert objective.theta(theirs.x) == pytest.approx(ours.theta, rel=1e-5)
    evolved = differential_evolution(
        objective.vectorized, objective.bounds, vectorized=True, updating="deferred", seed=1, maxiter=30, polish=False
    )
    assert evolved.fun == pytest.approx(ours.cost, rel=1e-4)


def test_a_generation_at_once_is_the_strategy_of_its_name() -> None:
    """Every trial is its member, or the best plus F times the difference of two others; every other member takes part."""
    size, n = 7, 3
    # Powers of three: from a difference of two entries both can be read.
    population = 3.0 ** np.arange(size)[:, None] * np.ones(n) * (1.0 + np.arange(n))
    strategy = retune.Best1Bin(mutation=0.5, recombination=0.6)
    rng, seen, mixed = np.random.default_rng(4), [set() for _ in range(size)], 0
    for _ in range(200):
        trials = strategy.trials(population, rng)
        for i, (trial, own) in enumerate(zip(trials, population)):
            of_mutant = trial != own
            assert of_mutant.any()
            mixed += int((~of_mutant).sum())
            k = int(np.flatnonzero(of_mutant)[0])
            difference = 2.0 * (trial[k] / population[0, k] - 1.0)
            [(a, b)] = [(a, b) for a in range(size) for b in range(size) if a != b and abs(3.0**a - 3.0**b - difference) < 1e-9]
            assert i not in (a, b)
            assert np.allclose(trial[of_mutant], (population[0] + 0.5 * (population[a] - population[b]))[of_mutant])
            seen[i].add((a, b))
    assert all(len(pairs) == (size - 1) * (size - 2) for pairs in seen)
    # Two of three entries can be the member's, each with probability 0.4.
    expected = 0.4 * 2 / 3 * 200 * size * n
    assert abs(mixed - expected) < 5 * np.sqrt(expected)
    with pytest.raises(ValueError, match="recombination is 70"):
        retune.Best1Bin(recombination=70)
    with pytest.raises(ValueError, match="needs three"):
        strategy.trials(population[:2], rng)


@pytest.mark.filterwarnings("ignore::retune.RetuneWarning")
def test_scipy_costs_little_beyond_an_update(models: Path) -> None:
    """20 000 costs of the flying wing: SciPy's differential evolution, and the command's own. Processor time, for the machine may be busy."""
    pytest.importorskip("scipy", minversion="1.12", reason="skipped: SciPy takes strategies from 1.12 on")
    model, test = retune.Model(models / "bff.yaml"), retune.Test(models / "bff_gvt.yaml")
    objective = retune.Objective(model, test, cost="paper")

    def theirs() -> None:
        found = differential_evolution(
            objective.vectorized, objective.bounds, strategy=retune.Best1Bin(), vectorized=True, updating="deferred", seed=1,
            popsize=10, maxiter=105, tol=0, polish=False,
        )  # fmt: skip
        assert found.nit == 105

    def ours() -> None:
        found = retune.update(model, test, cost="paper", optimizer={"differential-evolution": {}}, budget=106 * 190)
        assert found.to_dict()["evaluations"] > 19_000

    def seconds(work: Callable[[], None]) -> float:
        took = []
        for _ in range(5):
            begun = time.process_time()
            work()
            took.append(time.process_time() - begun)
        return min(took)

    assert seconds(theirs) < 1.3 * seconds(ours)


def test_costs_of_many_are_those_of_each(cantilever: retune.Model, twin: retune.Test) -> None:
    objective = retune.Objective(cantilever, twin)
    points = np.linspace(0.0, 1.0, 40)[:, None]
    assert objective.costs(points) == pytest.approx([objective.cost(x) for x in points], rel=1e-12)
    assert np.array_equal(objective.vectorized(points.T), objective.costs(points))
    with pytest.raises(retune.RetuneError, match="1 free parameters"):
        objective.costs(np.zeros((3, 2)))


def test_a_search_asks_and_is_told() -> None:
    """Rosenbrock's valley, scaled into the unit box: its minimum is at (1, 1) of [-2, 2]²."""

    def cost(x: np.ndarray) -> float:
        a, b = 4 * x - 2
        return float((1 - a) ** 2 + 100 * (b - a * a) ** 2)

    for optimizer in ("nelder-mead", "cma-es", {"differential-evolution": {}}):
        found = retune.Search([0.2, 0.8], optimizer=optimizer, seed=3, budget=30_000).run(cost)
        assert found.x == pytest.approx([0.75, 0.75], abs=1e-3), optimizer


def test_a_search_takes_derivatives() -> None:
    """The same as residuals r = (1 - a, 10 (b - a²))."""

    def residuals(x: np.ndarray) -> np.ndarray:
        a, b = 4 * x - 2
        return np.array([1 - a, 10 * (b - a * a)])

    def linearize(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        a = 4 * x[0] - 2
        return residuals(x), 4 * np.array([[-1.0, 0.0], [-20 * a, 10.0]])

    search = retune.Search([0.2, 0.8], optimizer="levenberg-marquardt", n_residuals=2)
    found = search.run(lambda x: float(0.5 * np.sum(residuals(x) ** 2)), linearize)
    assert found.x == pytest.approx([0.75, 0.75], abs=1e-6) and found.cost < 1e-12


def test_a_search_that_is_left_alone_ends() -> None:
    search = retune.Search([0.5, 0.5], optimizer="cma-es")
    assert search.ask() is not None
    with pytest.raises(retune.RetuneError, match="has not ended"):
        _ = search.optimum
    with pytest.raises(retune.RetuneError):
        search.tell(np.ones(1000))
    del search
