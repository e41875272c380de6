"""A strategy for SciPy's differential evolution that makes a whole generation at once."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._convert import Floats


class Best1Bin:
    """The strategy ``best1bin`` of ``scipy.optimize.differential_evolution``, one generation at a time instead of one member.

    v = x_best + F (x_a - x_b), mixed with the member parameter by parameter with probability CR, at least one from v (Storn and Price, Journal of
    Global Optimization 11 (1997) 341-359). SciPy's own shuffles the population once for each member, in Python, which takes longer than
    the model does; this one takes a third of that. It is for ``updating="deferred"``; its random numbers, and so its points, are others than those
    of the built-in one. SciPy 1.12 or later.

    * ``mutation``: F, or the interval in which it is drawn for every generation; ``recombination``: CR. Those of the call count for built-in
      strategies alone.

    >>> from scipy.optimize import differential_evolution
    >>> found = differential_evolution(
    ...     lambda x: ((x - [[0.3], [0.7]]) ** 2).sum(axis=0), [(0, 1)] * 2, strategy=Best1Bin(), vectorized=True, updating="deferred", polish=False
    ... )
    >>> found.x.round(3)
    array([0.3, 0.7])
    """

    def __init__(self, mutation: float | tuple[float, float] = (0.5, 1.0), recombination: float = 0.7) -> None:
        low, high = mutation if isinstance(mutation, tuple) else (mutation, mutation)
        if not 0.0 <= low <= high < 2.0 or (low == high == 0.0):
            raise ValueError(f"mutation is {mutation}; it is a factor above 0 and below 2, or an ascending pair of such")
        if not 0.0 <= recombination <= 1.0:
            raise ValueError(f"recombination is {recombination}; it is a probability")
        self.mutation = (low, high)
        self.recombination = recombination
        self._trials: Floats = np.zeros((0, 0))
        self._last = 0

    def __call__(self, candidate: int, population: Floats, rng: Any = None) -> Floats:
        """The trial of one member, as SciPy asks for them: in ascending order, (n,)."""
        if candidate <= self._last or self._trials.shape != population.shape:
            self._trials = self.trials(population, np.random.default_rng() if rng is None else rng)
        self._last = candidate
        trial: Floats = self._trials[candidate]
        return trial

    def trials(self, population: Floats, rng: Any) -> Floats:
        """The trials of all members, (n_members, n); the best member comes first.

        * ``rng``: a ``Generator`` or ``RandomState``
        """
        size, n = population.shape
        if size < 3:
            raise ValueError(f"the population has {size} members; a difference of two others needs three")
        own = np.arange(size)
        # Two others, different from each other: numbers among those that are left, moved past those that are taken.
        a = np.minimum((rng.uniform(size=size) * (size - 1)).astype(np.int64), size - 2)
        a += a >= own
        b = np.minimum((rng.uniform(size=size) * (size - 2)).astype(np.int64), size - 3)
        b += b >= np.minimum(a, own)
        b += b >= np.maximum(a, own)
        factor = rng.uniform(*self.mutation)
        mutants = population[0] + factor * (population[a] - population[b])
        is_taken = rng.uniform(size=(size, n)) < self.recombination
        is_taken[own, np.minimum((rng.uniform(size=size) * n).astype(np.int64), n - 1)] = True
        return np.where(is_taken, mutants, population)
