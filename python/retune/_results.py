"""Results of the verbs: objects with arrays; ``to_dict()`` is what the command prints with ``--json``."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from . import _core
from ._convert import Floats, PathLike
from ._frfs import Frfs
from ._html import framed, heat, number, table
from ._model import Model
from ._test import Test
from ._widget import page_widget


class Result:
    """The answer of a verb."""

    def __init__(self, text: str, notes: list[str]) -> None:
        self._dict: dict[str, Any] = json.loads(text)
        self.notes = notes
        """What was done that nobody asked for."""

    def to_dict(self) -> dict[str, Any]:
        """The answer as the command prints it with ``--json``."""
        return cast("dict[str, Any]", json.loads(json.dumps(self._dict)))

    def to_json(self) -> str:
        """The text that the command prints with ``--json``."""
        return json.dumps(self._dict, indent=2, ensure_ascii=False) + "\n"


class Paged(Result):
    """A result that has a page."""

    def _page(self) -> str:
        raise NotImplementedError

    def to_html(self) -> str:
        """The page of the command's ``--report``: one file, with pictures and the structure in three dimensions."""
        return self._page()

    def save_html(self, path: PathLike, *, force: bool = False) -> None:
        """Writes the page; over a file that exists only with ``force``."""
        page = self.to_html()
        with open(path, "w" if force else "x", encoding="utf-8") as file:
            file.write(page)

    def show(self, height: int = 700) -> Report:
        """The page in a cell of a notebook, the structure moving in its modes. It stays in the file of the notebook."""
        return Report(self.to_html(), None, [], height)

    def widget(self, height: int = 700) -> Any:
        """The page as a widget, whose ``page`` may be set to that of another result: every view of it follows. Needs anywidget."""
        return page_widget(self.to_html(), height)


@dataclass(frozen=True)
class Pair:
    """A measured mode and its partner in the model."""

    test_mode: int
    """From 1."""
    model_mode: int
    """From 1, rigid-body modes counted."""
    test_hz: float
    model_hz: float
    error_percent: float
    """(model - test)/test."""
    mac: float | None
    test_label: str | None
    model_label: str
    probability: float | None
    """That they are the same mode, where pairs are inferred."""


def _pairs(rows: list[dict[str, Any]]) -> list[Pair]:
    names = Pair.__dataclass_fields__
    return [Pair(**{name: row[name] for name in names}) for row in rows]


def _pair_table(pairs: list[Pair], caption: str) -> str:
    rows = [
        [
            p.test_mode,
            p.test_label or "",
            number(p.test_hz),
            number(p.model_hz),
            f"{p.error_percent:+.2f} %",
            "–" if p.mac is None else f"{p.mac:.3f}",
            p.model_label,
        ]
        for p in pairs
    ]
    return table(caption, ["#", "test mode", "test Hz", "model Hz", "error", "MAC", "model mode"], rows)


class _Mac:
    """The MAC of a comparison, with what its rows and columns are."""

    def __init__(self, content: Mapping[str, Any]) -> None:
        self.values: Floats = _array(content["values"])
        self.model_hz: Floats = _array(content["model_hz"])
        self.test_hz: Floats = _array(content["test_hz"])

    def picture(self, last: int) -> str:
        if self.values.size == 0 or not np.any(np.isfinite(self.values)):
            return ""
        rows = min(max(last, int(np.sum(self.model_hz <= 1.2 * self.test_hz.max())), 1), len(self.model_hz))
        names = [number(float(f)) for f in self.model_hz[:rows]]
        return heat(self.values[:rows], names, [str(k + 1) for k in range(len(self.test_hz))], "MAC: model Hz by test mode")


def _array(values: Any) -> Floats:
    """Numbers with null for what there is not."""
    return np.array(values, dtype=np.float64)


class Comparison(Paged):
    """A model beside a test, or several; pairs and arrays are those of the first."""

    def __init__(self, inner: _core.Compared, notes: list[str]) -> None:
        super().__init__(inner.json(), notes)
        self._inner = inner
        self._first: dict[str, Any] = self._dict["tests"][0] if "tests" in self._dict else self._dict
        self._mac = _Mac(self._first["mac"])

    def _page(self) -> str:
        return self._inner.page()

    @property
    def pairs(self) -> list[Pair]:
        """Paired modes."""
        return _pairs(self._first["pairs"])

    @property
    def mac(self) -> Floats:
        """MAC, (n_model_modes, n_test_modes); NaN where a test mode has no shape."""
        return self._mac.values

    @property
    def model_frequencies(self) -> Floats:
        """Hz, of the rows of ``mac``."""
        return self._mac.model_hz

    @property
    def chi_squared(self) -> float:
        """Σ ((model - test)/σ)²."""
        return float(self._first["chi_squared"])

    @property
    def p_value(self) -> float:
        """Probability that noise alone gives as much."""
        return float(self._first["p_value"])

    @property
    def passed(self) -> bool:
        """Whether the criteria of the profile are met; true without a profile."""
        return self._inner.passed()

    def __repr__(self) -> str:
        return f"<Comparison: {len(self.pairs)} pairs, chi² {number(self.chi_squared)} for {self._first['n_data']} data>"

    def _repr_html_(self) -> str:
        last = max((p.model_mode for p in self.pairs), default=1)
        return _pair_table(self.pairs, str(self._first["misfit"])) + self._mac.picture(last)


@dataclass(frozen=True)
class ParameterEstimate:
    """A parameter before and after, in its unit."""

    name: str
    unit: str
    before: float
    after: float
    lower: float | None
    """Bounds; ``None`` for a constant."""
    upper: float | None
    at_bound: bool
    sd: float | None
    """Standard deviation, where the data give one."""
    interval: tuple[float, float] | None
    """90 %."""
    determined: bool
    """Whether the data set it a limit inside its bounds."""


class UpdateResult(Paged):
    """A fit."""

    def __init__(self, inner: _core.Updated, notes: list[str]) -> None:
        super().__init__(inner.json(), notes)
        self._inner = inner
        self._mac = _Mac(self._dict["mac"])
        self.theta: Floats = inner.theta()
        """All parameters at the optimum, SI, in the order of ``Model.parameters``."""
        self.history_evaluations, self.history_cost = inner.history()

    def _page(self) -> str:
        return self._inner.page()

    history_evaluations: Any
    """Evaluations at each improvement, (n,)."""
    history_cost: Floats
    """The best cost after each, (n,)."""

    @property
    def cost_before(self) -> float:
        """At the estimates."""
        return float(self._dict["cost_before"])

    @property
    def cost(self) -> float:
        """At the optimum."""
        return float(self._dict["cost_after"])

    @property
    def sensors_left_out(self) -> dict[str, list[str]]:
        """Of every test by name, the sensors that took no part: the motions of the model contradict them, whatever its stiffness."""
        return {test["name"]: list(test["sensors_left_out"]) for test in self._dict["tests"]}

    @property
    def termination(self) -> str:
        """Why the search ended."""
        return str(self._dict["termination"])

    @property
    def is_converged(self) -> bool:
        """Whether it ended at an optimum: not by a budget, nor by Ctrl-C."""
        return self._inner.is_converged()

    @property
    def parameters(self) -> dict[str, ParameterEstimate]:
        """Every parameter by name."""
        out: dict[str, ParameterEstimate] = {}
        for p in self._dict["parameters"]:
            interval = p.get("interval")
            out[p["name"]] = ParameterEstimate(
                p["name"],
                p["unit"],
                p["before"],
                p["after"],
                p["lower"],
                p["upper"],
                p["at_bound"],
                p.get("sd"),
                None if interval is None else (interval[0], interval[1]),
                bool(p.get("determined", False)),
            )
        return out

    def __getitem__(self, name: str) -> ParameterEstimate:
        return self.parameters[name]

    @property
    def correlations(self) -> Floats:
        """Correlations of the free parameters, (n_free, n_free); NaN where one has no standard deviation."""
        return self._inner.correlations()

    @property
    def pairs(self) -> list[Pair]:
        """Paired modes at the optimum, of the first test."""
        return _pairs(self._dict["pairs"])

    @property
    def mac(self) -> Floats:
        """MAC at the optimum, of the first test, (n_model_modes, n_test_modes)."""
        return self._mac.values

    @property
    def model(self) -> Model:
        """The updated model: the same file with new values, comments and order kept."""
        return Model._of(self._inner.model())

    def __repr__(self) -> str:
        return f"<UpdateResult: cost {number(self.cost_before)} -> {number(self.cost)}; {self.termination}>"

    def _repr_html_(self) -> str:
        rows = [
            [
                p.name,
                number(p.before),
                number(p.after),
                number(p.sd),
                "–" if p.interval is None else f"{number(p.interval[0])} … {number(p.interval[1])}",
                p.unit,
                "on its bound" if p.at_bound and p.lower is not None else "",
            ]
            for p in self.parameters.values()
        ]
        heads = ["parameter", "before", "after", "± sd", "90 % interval", "unit", ""]
        last = max((p.model_mode for p in self.pairs), default=1)
        caption = f"cost {number(self.cost_before)} → {number(self.cost)}; {self.termination}"
        return table(caption, heads, rows) + _pair_table(self.pairs, "after") + self._mac.picture(last)


class Posterior(Paged):
    """Samples of the posterior of the free parameters, and the evidence of the model."""

    def __init__(self, inner: _core.Sampled, notes: list[str]) -> None:
        super().__init__(inner.json(), notes)
        self._inner = inner
        names = inner.names()
        self.names: list[str] = [name for name, _ in names]
        """The free parameters."""
        self.units: list[str] = [unit for _, unit in names]
        """Their units."""
        self.samples: Floats = inner.samples()
        """Samples of equal weight, in the units, (n_samples, n_free)."""
        self.costs: Floats = inner.costs()
        """Half the squared misfit of each, (n_samples,)."""

    def _page(self) -> str:
        return self._inner.page()

    def __getitem__(self, name: str) -> Floats:
        """Samples of one parameter, in its unit, (n_samples,)."""
        return self.samples[:, self.names.index(name)]

    @property
    def mean(self) -> Floats:
        """(n_free,)."""
        return _array([p["mean"] for p in self._dict["parameters"]])

    @property
    def sd(self) -> Floats:
        """(n_free,)."""
        return _array([p["sd"] for p in self._dict["parameters"]])

    @property
    def log_evidence(self) -> float:
        """ln Z over the bounds."""
        return float(self._dict["log_evidence"])

    @property
    def log_evidence_se(self) -> float:
        """Its standard error."""
        return float(self._dict["log_evidence_se"])

    def to_arviz(self, *others: Posterior) -> Any:
        """ArviZ ``InferenceData``: this run and others, with other seeds, are the chains. Needs ArviZ; R-hat and ESS are then its own.

        Samples of one run are members of one population, weighed and moved together: between runs, and only there, R-hat tells whether they
        have found the same posterior.
        """
        import arviz

        runs = [self, *others]
        if any(run.names != self.names or run.units != self.units for run in runs):
            raise ValueError("the posteriors are of different parameters")
        n = min(len(run.samples) for run in runs)
        draws = {name: np.stack([run[name][:n] for run in runs]) for name in self.names}
        log_likelihood = {"data": np.stack([-run.costs[:n] for run in runs])}
        attributes = {"units": json.dumps(dict(zip(self.names, self.units))), "log_evidence": [run.log_evidence for run in runs]}
        return arviz.from_dict(posterior=draws, sample_stats={"lp": log_likelihood["data"]}, posterior_attrs=attributes)

    def __repr__(self) -> str:
        return f"<Posterior: {len(self.samples)} samples of {', '.join(self.names)}; ln Z {self.log_evidence:.2f}>"

    def _repr_html_(self) -> str:
        rows = []
        for p in self._dict["parameters"]:
            low, high = p["interval"]
            rows.append([p["name"], number(p["mean"]), number(p["sd"]), number(low), number(p["median"]), number(high), p["unit"]])
        caption = f"ln Z = {self.log_evidence:.2f} ± {self.log_evidence_se:.2f}"
        return table(caption, ["parameter", "mean", "sd", "5 %", "50 %", "95 %", "unit"], rows)


class Identification(Paged):
    """Modes of measurements, with the health of the test."""

    def __init__(self, inner: _core.Identified, notes: list[str]) -> None:
        super().__init__(inner.json(), notes)
        self._inner = inner

    def _page(self) -> str:
        return self._inner.page()

    def _of_modes(self, name: str) -> Floats:
        return _array([m.get(name) for m in self._dict.get("modes", [])])

    @property
    def frequencies(self) -> Floats:
        """Hz, (n_modes,), those on the suspension among them."""
        return self._of_modes("frequency_hz")

    @property
    def frequency_sd(self) -> Floats:
        """Standard deviations, Hz, (n_modes,): of the lines alone."""
        return self._of_modes("frequency_sd")

    @property
    def damping(self) -> Floats:
        """Damping ratios, (n_modes,)."""
        return self._of_modes("damping")

    @property
    def findings(self) -> list[dict[str, Any]]:
        """What the check of the test found, worst first: ``level``, ``code``, ``text``, ``remedy``."""
        return list(self._dict.get("findings", []))

    @property
    def test(self) -> Test:
        """The test, for a model: without modes on the suspension, standard deviations with what a repetition would change."""
        return Test._of(self._inner.test())

    @property
    def frfs(self) -> Frfs | None:
        """The functions that it was made of."""
        found = self._inner.frfs()
        return None if found is None else Frfs._of(found)

    def __repr__(self) -> str:
        return f"<Identification: {len(self.frequencies)} modes, {len(self.findings)} findings>"

    def _repr_html_(self) -> str:
        rows = [
            [k + 1, number(m["frequency_hz"]), number(m.get("frequency_sd")), number(m.get("damping")), number(m.get("mpc"))]
            for k, m in enumerate(self._dict.get("modes", []))
        ]
        found = "".join(f"<li>{html.escape(f['level'])}: {html.escape(f['text'])}</li>" for f in self.findings)
        return table(str(self._dict["method"]), ["#", "Hz", "± sd", "damping ratio", "MPC"], rows) + (f"<ul>{found}</ul>" if found else "")


class TwinResult(Result):
    """A synthetic test."""

    def __init__(self, inner: _core.Twin) -> None:
        super().__init__(inner.json(), [])
        self._inner = inner

    @property
    def test(self) -> Test | None:
        """The test with modes, where they were asked for."""
        found = self._inner.test()
        return None if found is None else Test._of(found)

    @property
    def frfs(self) -> Frfs | None:
        """The functions, where they were asked for."""
        found = self._inner.frfs()
        return None if found is None else Frfs._of(found)

    def __repr__(self) -> str:
        return f"<TwinResult (synthetic): {self._dict['modes'] or 0} modes, {self._dict['functions'] or 0} functions>"

    def _repr_html_(self) -> str:
        rows = [[what, self._dict[what]] for what in ("modes", "functions", "sensors") if self._dict[what]]
        return table(str(self._dict["source"]), ["synthetic", "number"], rows)


class Plan(Result):
    """Where to measure and to excite."""

    @property
    def sensors(self) -> dict[str, list[str]]:
        """Chosen places, by the way they were chosen."""
        return {way: list(choice["sensors"]) for way, choice in self._dict["sensors"].items()}

    @property
    def frequencies(self) -> Floats:
        """Target modes, Hz, (n_modes,)."""
        return _array([m["frequency_hz"] for m in self._dict["modes"]])

    @property
    def exciters(self) -> list[str]:
        """Places for the exciter that drive all modes, best first."""
        return [p["at"] for p in self._dict["exciters"][0]["places"] if p["smallest"] > 0.0]

    @property
    def next_sensors(self) -> list[tuple[str, float]]:
        """What one more sensor would tell of the parameters, nats, best first."""
        return [(g["at"], g["nats"]) for g in self._dict["next"]]

    def __repr__(self) -> str:
        return f"<Plan: {len(self.frequencies)} target modes, {len(self._dict['candidates'])} places>"

    def _repr_html_(self) -> str:
        return table("Sensors", ["chosen by", "at"], [[way, ", ".join(at)] for way, at in self.sensors.items()])


class Report(Result):
    """A page with pictures: pairs, MAC, the structure in its modes."""

    def __init__(self, page: str, data: str | None, notes: list[str], height: int = 700) -> None:
        super().__init__(data or "{}", notes)
        self._page = page
        self._height = height

    @property
    def verdict(self) -> str | None:
        """In a sentence."""
        found = self._dict.get("meta", {}).get("verdict")
        return None if found is None else str(found["sentence"])

    def to_html(self) -> str:
        """The page: one file, which asks no network."""
        return self._page

    def widget(self, height: int = 700) -> Any:
        """The page as a widget, whose ``page`` may be set later. Needs anywidget."""
        return page_widget(self._page, height)

    def save_html(self, path: PathLike, *, force: bool = False) -> None:
        """Writes the page; over a file that exists only with ``force``."""
        with open(path, "w" if force else "x", encoding="utf-8") as file:
            file.write(self._page)

    def __repr__(self) -> str:
        return f"<Report: {self.verdict or 'a page'}>"

    def _repr_html_(self) -> str:
        return framed(self._page, self._height)
