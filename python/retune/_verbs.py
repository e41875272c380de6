"""The verbs of the command, as functions."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, Union

import numpy.typing as npt

from . import _core
from ._convert import PathLike, Tests, dumps, model_of, parametric_of, part_of, percent_of, tests_of, text_of, vector
from ._effect import Effect
from ._errors import tell
from ._external import ParametricModel
from ._fault import Fault
from ._found import Diagnosis, Learning
from ._frfs import Frfs, Quantity, read_frfs, read_options
from ._model import Model
from ._objective import CostName, PairingName
from ._optimizer import Optimizer
from ._residual import Residual
from ._results import (
    Comparison,
    Identification,
    Plan,
    Posterior,
    Report,
    TwinResult,
    UpdateResult,
)
from ._test import Test

Progress = Union[bool, Callable[[str, "int | None", "float | None"], object]]
"""``True`` for a line on standard error, or a function that is told what is being done, evaluations, and the best cost."""

Reduction = Literal["auto", "full", "guyan", "irs", "dynamic", "serep"]
Placement = Literal["effective-independence", "auto-mac", "kinetic-energy"]
Method = Literal["plscf", "quadrature", "circle"]


class _Line:
    """A line that follows a search, in a terminal or under a cell."""

    def __init__(self) -> None:
        self._width = 0

    def __call__(self, text: str, evaluations: int | None, cost: float | None) -> None:
        if evaluations is not None:
            text += f": {evaluations} evaluations"
        if cost is not None:
            text += f", cost {cost:.6g}"
        text = text[:100]
        print("\r" + text.ljust(self._width), end="", file=sys.stderr, flush=True)
        self._width = len(text)

    def end(self) -> None:
        if self._width:
            print("\r" + " " * self._width + "\r", end="", file=sys.stderr, flush=True)


class _Telling:
    """Progress as it was asked for, and gone afterwards."""

    def __init__(self, progress: Progress) -> None:
        self._line = _Line() if progress is True else None
        self.function: Callable[[str, int | None, float | None], object] | None = (
            self._line if self._line is not None else (progress if callable(progress) else None)
        )

    def __enter__(self) -> Callable[[str, int | None, float | None], object] | None:
        return self.function

    def __exit__(self, *_: object) -> None:
        if self._line is not None:
            self._line.end()


def _frfs_of(frfs: Frfs | PathLike | Sequence[PathLike] | None) -> _core.Frfs | None:
    if frfs is None or isinstance(frfs, Frfs):
        return None if frfs is None else frfs._inner
    return read_frfs(frfs)._inner


def compare(
    model: Model | PathLike,
    tests: Tests,
    *,
    pairing: PairingName = "probable",
    min_mac: float | None = None,
    frequency_window: float | None = None,
    reduction: Reduction = "auto",
    everything: bool = False,
    frf: Frfs | PathLike | Sequence[PathLike] | None = None,
    bands: Sequence[float] = (),
    profile: PathLike | None = None,
    configuration: str | None = None,
    sensor_masses: bool = False,
) -> Comparison:
    """Compares a model with a test, or with several: pairs, errors, MAC, what noise alone would give, and where it fails.

    * ``pairing``: how modes are paired; ``min_mac`` and ``frequency_window`` are the limits of a pair
    * ``reduction``: how the mass is reduced to the sensors
    * ``everything``: places, parameters and suspect sensors also of a model with more than 600 dofs
    * ``frf``: measured functions, beside those of the model; ``bands`` are the edges of their bands, Hz
    * ``profile``: criteria to judge by: a name of ``retune list profiles``, or a file with profiles, ``file.yaml:NAME``
    """
    judged: tuple[str | None, str | None] | None = None
    if profile is not None:
        word = os.fspath(profile)
        file, colon, name = word.rpartition(":")
        if not colon or not file.endswith((".yaml", ".yml")):
            file, name = (word, "") if word.endswith((".yaml", ".yml")) or os.sep in word else ("", word)
        text = None
        if file:
            with open(file, encoding="utf-8") as stream:
                text = stream.read()
        judged = (text, name or None)
    inner = _core.compare(
        model_of(model),
        tests_of(tests),
        (pairing, min_mac, frequency_window),
        reduction,
        everything,
        _frfs_of(frf),
        [float(b) for b in bands],
        judged,
        configuration,
        sensor_masses,
    )
    return Comparison(inner, tell(inner.remarks()))


def update(
    model: Model | ParametricModel | PathLike,
    tests: Tests,
    *,
    cost: CostName = "least-squares",
    objective: str | Mapping[str, Any] | None = None,
    pairing: PairingName = "probable",
    min_mac: float | None = None,
    frequency_window: float | None = None,
    residuals: Sequence[Residual] = (),
    optimizer: str | Mapping[str, Any] | Sequence[Any] | Optimizer | None = None,
    seed: int = 0,
    budget: int | None = None,
    reduced: float | None = None,
    checkpoint: PathLike | None = None,
    resume: bool = False,
    configuration: str | None = None,
    sensor_masses: bool = False,
    progress: Progress = False,
) -> UpdateResult:
    """Changes the bounded parameters of a model until it fits a test, or several at once, and says how certain they are.

    Ctrl-C stops the search and keeps the best point so far; ``is_converged`` then is false.

    * ``objective``: terms and weights, loss, regularisation and limits, as YAML text or a dict
    * ``residuals``: terms of the user's own, beside the usual ones
    * ``optimizer``: a method of ``retune list optimizers``, or YAML or a dict with settings, or a search of the user's own
    * ``budget``: largest number of evaluations
    * ``reduced``: search on a reduced model whose frequencies are right to this part; for large models
    * ``checkpoint``: keep the state of the search in this file; ``resume`` continues from it
    """
    method: str | _core.OwnOptimizer | None
    if isinstance(optimizer, Optimizer):
        method = optimizer._core()
    else:
        method = optimizer if optimizer is None or isinstance(optimizer, str) else _core.yaml_of_json(dumps(optimizer))
    with _Telling(progress) as function:
        inner = _core.update(
            parametric_of(model),
            tests_of(tests),
            cost,
            text_of(objective),
            (pairing, min_mac, frequency_window),
            method,
            seed,
            budget,
            reduced,
            None if checkpoint is None else os.fspath(checkpoint),
            resume,
            configuration,
            sensor_masses,
            [r._core() for r in residuals],
            function,
        )
    return UpdateResult(inner, tell(inner.remarks()))


def sample(
    model: Model | ParametricModel | PathLike,
    tests: Tests,
    *,
    samples: int = 1000,
    objective: str | Mapping[str, Any] | None = None,
    residuals: Sequence[Residual] = (),
    pairing: PairingName = "probable",
    min_mac: float | None = None,
    frequency_window: float | None = None,
    seed: int = 0,
    reduced: float | None = None,
    configuration: str | None = None,
    shard: str | None = None,
    folder: PathLike | None = None,
) -> Posterior:
    """Samples the posterior of the parameters, by transitional Markov chain Monte Carlo; the prior is uniform between the bounds.

    * ``residuals``: terms of the user's own, beside the usual ones
    * ``shard``, ``folder``: evaluate only this part of every generation, ``"3/8"``, and take the rest from a folder into which processes with
      the other parts write it; each has the samples that one run has
    """
    part: tuple[int, int, str] | None = None
    if (shard is None) != (folder is None):
        raise ValueError("shard and folder belong together")
    if shard is not None and folder is not None:
        index, of = part_of(shard)
        part = (index, of, os.fspath(folder))
    inner = _core.sample(
        parametric_of(model),
        tests_of(tests),
        samples,
        text_of(objective),
        (pairing, min_mac, frequency_window),
        seed,
        reduced,
        configuration,
        [r._core() for r in residuals],
        part,
    )
    return Posterior(inner, tell(inner.remarks()))


def _search(
    effects: Sequence[str | Effect],
    places: Sequence[str],
    budget: float | None,
    effort: float,
    seed: int,
    faults: bool | Sequence[str | Fault],
    pairing: tuple[str, float | None, float | None],
) -> dict[str, Any]:
    return {
        "effects": [e if isinstance(e, str) else e._core() for e in effects],
        "places": list(places),
        "budget": budget,
        "effort": effort,
        "seed": seed,
        "faults": (None if faults else []) if isinstance(faults, bool) else [f if isinstance(f, str) else f._core() for f in faults],
        "pairing": pairing,
    }


def diagnose(
    model: Model | PathLike,
    tests: Tests,
    *,
    effects: Sequence[str | Effect] = (),
    places: Sequence[str] = (),
    faults: bool | Sequence[str | Fault] = True,
    budget: float | None = None,
    effort: float = 1.0,
    pairing: PairingName = "probable",
    min_mac: float | None = None,
    frequency_window: float | None = None,
    seed: int = 0,
    progress: Progress = False,
) -> Diagnosis:
    """Which physical effect or measurement fault explains what a model misses, where, how large, how sure.

    Ctrl-C ends the search with the best answer so far; ``is_partial`` then is true.

    * ``effects``: only these, by name or of the user's own; all built-in ones when empty: ``[*catalogue("effects"), MyEffect()]``
    * ``places``: only where they have a node or an element of these
    * ``faults``: whether the measurement may be wrong, or in which ways, by name or of the user's own
    * ``budget``: answer after so many seconds
    * ``effort``: how much is tried, as a factor: 0.5 fits half as many hypotheses from half as many starts
    """
    options = _search(effects, places, budget, effort, seed, faults, (pairing, min_mac, frequency_window))
    with _Telling(progress) as function:
        inner = _core.diagnose(model_of(model), tests_of(tests), options, function)
    return Diagnosis(inner, tell(inner.remarks()))


def learn(
    model: Model | PathLike,
    tests: Tests,
    *,
    take_best: bool = False,
    limit: int = 5,
    effects: Sequence[str | Effect] = (),
    places: Sequence[str] = (),
    budget: float | None = None,
    effort: float = 1.0,
    pairing: PairingName = "probable",
    min_mac: float | None = None,
    frequency_window: float | None = None,
    seed: int = 0,
    progress: Progress = False,
) -> Learning:
    """Diagnoses, adds, refits, until nothing more is justified.

    * ``take_best``: take the most probable of tied effects instead of stopping
    * ``limit``: largest number of effects
    """
    options = _search(effects, places, budget, effort, seed, True, (pairing, min_mac, frequency_window))
    with _Telling(progress) as function:
        inner = _core.learn(model_of(model), tests_of(tests), options, take_best, limit, function)
    return Learning(inner, tell(inner.remarks()))


def pretest(
    model: Model | PathLike,
    *,
    modes: int | None = None,
    sensors: int | None = None,
    by: Placement | None = None,
    test: Test | PathLike | None = None,
    noise_shape: float | str = "2 %",
    noise_frequency: float | str = "0.5 %",
) -> Plan:
    """Plans a test: which modes, where to measure, where to excite, what one more sensor would tell.

    * ``modes``: number of target modes; ``sensors``: number of sensors to choose
    * ``by``: how they are chosen; all ways side by side when absent
    * ``test``: whose sensors are judged and added to
    * ``noise_shape``: standard deviation of a shape entry, of the largest entry; ``noise_frequency``: that of a frequency, of the frequency
    """
    given = None if test is None else tests_of(test)[0]
    text = _core.pretest(
        model_of(model), modes, sensors, by, given, percent_of(noise_shape), percent_of(noise_frequency)
    )
    return Plan(text, [])


def twin(
    model: Model | PathLike,
    *,
    modes: int | None = 10,
    frequencies: npt.ArrayLike | None = None,
    sensors: Test | PathLike | None = None,
    exciter: str | Sequence[str] = (),
    quantity: Quantity = "accelerance",
    band: tuple[float, float] | None = None,
    noise_frequency: float | str = "0 %",
    noise_damping: float | str = "0 %",
    noise_shape: float | str = "0 %",
    noise_force: float | str = "0 %",
    noise_response: float | str = "0 %",
    averages: int = 16,
    damping: float | str | None = None,
    set: Mapping[str, str] | None = None,
    patch: PathLike | Mapping[str, Any] | None = None,
    fault: str | Sequence[str] = (),
    seed: int = 0,
) -> TwinResult:
    """Makes synthetic test data from a model: modes and functions at sensors, with noise, faults of the measurement and hidden changes.

    * ``modes``: most modes; no test with modes when ``None``
    * ``frequencies``: lines of functions, Hz; no functions when absent
    * ``sensors``: test whose sensors they are; a sensor on every node when absent
    * ``exciter``: sensors at which the force acts, one after the other; the first when absent
    * ``damping``: ratio of every mode; the model's own damping when absent, 1 % where it has none
    * ``set``: parameters with their units: ``{"m_tip": "70 g"}``
    * ``patch``: a partial model file laid over the model, or what it says: what the test has and the model lacks
    * ``fault``: ``"sensor-sign@p11"``, ``"sensor-gain@p5=1.5"``
    """
    laid: tuple[str, str] | None = None
    if isinstance(patch, Mapping):
        laid = ("a dict", _core.yaml_of_json(dumps(patch)))
    elif patch is not None:
        with open(patch, encoding="utf-8") as stream:
            laid = (os.path.basename(os.fspath(patch)), stream.read())
    arguments: dict[str, Any] = {
        "modes": modes,
        "band": band,
        "lines": None if frequencies is None else vector(frequencies, "frequencies").tolist(),
        "exciters": [exciter] if isinstance(exciter, str) else list(exciter),
        "quantity": quantity,
        "noise_frequency": percent_of(noise_frequency),
        "noise_damping": percent_of(noise_damping),
        "noise_shape": percent_of(noise_shape),
        "noise_force": percent_of(noise_force),
        "noise_response": percent_of(noise_response),
        "averages": averages,
        "damping": None if damping is None else percent_of(damping),
        "set": list((set or {}).items()),
        "patch": laid,
        "faults": [fault] if isinstance(fault, str) else list(fault),
        "seed": seed,
    }
    given = None if sensors is None else tests_of(sensors)[0]
    return TwinResult(_core.twin(model_of(model), given, arguments))


def identify(
    source: Frfs | PathLike | Sequence[PathLike],
    *,
    band: tuple[float, float] | None = None,
    method: Method = "plscf",
    peak_height: float = 10.0,
    order: int = 40,
    suspension: int = 0,
    exponential_window: float | None = None,
    repeatability: float = 0.001,
    health: bool = True,
    model: Model | PathLike | None = None,
    name: str | None = None,
    configuration: str | None = None,
    **answers: Any,
) -> Identification:
    """Identifies modes from frequency response functions, each number with its standard deviation, and checks the test.

    * ``source``: functions as arrays, or measurement files
    * ``band``: limits, Hz; ``order``: poles of the highest model order of each octave
    * ``suspension``: how many of the lowest modes are rigid-body modes on the suspension: checked as such, not part of the test
    * ``exponential_window``: rate, 1/s, of a window whose damping is taken out; 0 leaves in what a file states
    * ``repeatability``: what a repeated test would change, as a share of a frequency, and ten times as much of a shape
    * ``model``: in which the sensors get their places, by the positions of the points
    * ``answers``: to what files leave open: those of ``read_frfs``

    >>> import numpy as np
    >>> s = 2j * np.pi * np.linspace(1.0, 20.0, 400)
    >>> h = s**2 / (s**2 + 2 * 0.01 * 50.0 * s + 50.0**2)
    >>> found = identify(Frfs(np.linspace(1.0, 20.0, 400), h[:, None], ["a.+z"], ["a.+z"]), health=False)
    >>> found.frequencies.round(3), found.damping.round(4)
    (array([7.958]), array([0.01]))
    """
    frfs = source._inner if isinstance(source, Frfs) else None
    files: list[str] = []
    if not isinstance(source, Frfs):
        files = [os.fspath(f) for f in ([source] if isinstance(source, (str, os.PathLike)) else source)]
    elif answers:
        raise TypeError(f"{', '.join(answers)}: answers are for files; arrays say these themselves")
    arguments: dict[str, Any] = {
        "band": band,
        "method": method,
        "peak_height": peak_height,
        "order": order,
        "suspension": suspension,
        "exponential_window": exponential_window,
        "repeatability": repeatability,
        "health": health,
        "name": name,
        "configuration": configuration,
    }
    placed = None if model is None else model_of(model)
    inner = _core.identify(files, frfs, read_options(**answers), arguments, placed)
    return Identification(inner, tell(inner.remarks()))


def report(
    model: Model | PathLike,
    test: Test | PathLike,
    *,
    before: Model | PathLike | None = None,
    diagnose: bool = False,
    frf: Frfs | PathLike | Sequence[PathLike] | None = None,
    pairing: PairingName = "probable",
    min_mac: float | None = None,
    frequency_window: float | None = None,
    seed: int = 0,
    configuration: str | None = None,
    progress: Progress = False,
) -> Report:
    """A page with pictures: pairs, MAC, the structure in its modes, where model and test disagree.

    ``to_dict()`` is the file of the command's ``--json``.

    * ``before``: an earlier version of the model, beside which this one stands
    * ``diagnose``: what is missing, too
    * ``frf``: measured functions, beside those of the model
    """
    with _Telling(progress) as function:
        page, data, remarks = _core.report(
            model_of(model),
            tests_of(test)[0],
            None if before is None else model_of(before),
            diagnose,
            _frfs_of(frf),
            (pairing, min_mac, frequency_window),
            seed,
            configuration,
            function,
        )
    return Report(page, data, tell(remarks))


__all__ = ["compare", "diagnose", "identify", "learn", "pretest", "report", "sample", "twin", "update"]
