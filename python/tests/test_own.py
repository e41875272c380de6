"""Members of one's own as Python classes: the same answers as the built-in ones, and errors that name the culprit."""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from conftest import CANTILEVER

import retune

Floats = npt.NDArray[np.float64]


class PlaneBeam(retune.Element):
    """The beam of Euler and Bernoulli in its plane x z: what the built-in one is without shear."""

    name = "plane_beam"
    summary = "A beam that bends in its plane."
    nodes = (("ux", "uy", "uz", "ry"), ("ux", "uy", "uz", "ry"))
    properties = (
        retune.Property("EI", "N m2", "positive", "bending stiffness"),
        retune.Property("mu", "kg/m", "non-negative", "mass per length"),
    )

    def stiffness(self, points: Floats, values: Mapping[str, float]) -> Floats:
        l = float(np.linalg.norm(points[1]))
        k = values["EI"] / l**3 * np.array(
            [[12, -6 * l, -12, -6 * l], [-6 * l, 4 * l * l, 6 * l, 2 * l * l], [-12, 6 * l, 12, 6 * l], [-6 * l, 2 * l * l, 6 * l, 4 * l * l]]
        )
        return self._placed(k)

    def mass(self, points: Floats, values: Mapping[str, float]) -> Floats:
        l = float(np.linalg.norm(points[1]))
        whole = values.get("mu", 0.0) * l
        m = whole / 420 * np.array(
            [
                [156, -22 * l, 54, 13 * l],
                [-22 * l, 4 * l * l, -13 * l, -3 * l * l],
                [54, -13 * l, 156, 22 * l],
                [13 * l, -3 * l * l, 22 * l, 4 * l * l],
            ]
        )
        out = self._placed(m)
        # A body weighs the same in every direction.
        for axis in (0, 1):
            out[np.ix_([axis, axis + 6], [axis, axis + 6])] = whole / 6 * np.array([[2, 1], [1, 2]])
        return out

    def _placed(self, small: Floats) -> Floats:
        rows = [2, 4, 8, 10]
        out = np.zeros((12, 12))
        out[np.ix_(rows, rows)] = small
        return out


def of_own_beams() -> dict[str, Any]:
    """The cantilever of 40 x 5 mm, from beams of one's own."""
    names = ["root", "n1", "n2", "middle", "n4", "n5", "n6", "tip"]
    nodes = {name: [0.6 * k / 7, 0, 0] for k, name in enumerate(names)}
    ei = "416.66666666666667 mm4 * E"
    return {
        **{k: v for k, v in CANTILEVER.items() if k not in ("sections", "beams", "nodes")},
        "nodes": nodes,
        "elements": {
            f"e{k}": {"type": "plane_beam", "nodes": [a, b], "properties": {"EI": ei, "mu": "0.54 kg/m"}}
            for k, (a, b) in enumerate(zip(names, names[1:]))
        },
    }


def test_an_element_is_as_good_as_the_built_in_one() -> None:
    model = retune.Model(of_own_beams(), elements=[PlaneBeam()])
    names = list(of_own_beams()["nodes"])
    built_in = retune.Model(
        {
            **CANTILEVER,
            "nodes": of_own_beams()["nodes"],
            "beams": {f"e{k}": {"nodes": [a, b], "section": "strip"} for k, (a, b) in enumerate(zip(names, names[1:]))},
        }
    )
    # What the built-in one has besides is the rotary inertia of the section, (h/L)² of the mass.
    assert model.modes(n=3).frequencies == pytest.approx(built_in.modes(n=3).frequencies, rel=2e-4)
    assert model.modes({"E": 77e9}, n=1).frequencies[0] == pytest.approx(np.sqrt(1.1) * model.modes(n=1).frequencies[0], rel=1e-12)
    # The same closed form: (1.8751)²/(2π L²) √(EI/μ).
    exact = 1.8751040687**2 / (2 * np.pi * 0.36) * np.sqrt(70e9 * 416.66666666666667e-12 / 0.54)
    assert model.modes(n=1).frequencies[0] == pytest.approx(exact, rel=1e-4)


def test_what_follows_from_a_model_has_its_elements(tmp_path: Path) -> None:
    model = retune.Model(of_own_beams(), elements=[PlaneBeam()])
    truth = {"masses": {"forgotten": {"node": "middle", "mass": "0.1 kg"}}}
    made = retune.twin(model, modes=4, patch=truth, noise_frequency="0.2 %", noise_shape="1 %", seed=1)
    assert made.test is not None
    found = retune.diagnose(model, made.test, effects=["point-mass", "ground-spring"], faults=False)
    assert found.hypotheses[0].id == "point-mass@middle"
    learned = retune.learn(model, made.test, effects=["point-mass"], take_best=True, limit=1)
    assert learned.effects == ["point-mass@middle"] and isinstance(learned.model.elements[0], PlaneBeam)
    updated = retune.update(learned.model, made.test)
    assert isinstance(updated.model.with_values({"E": 71e9}).elements[0], PlaneBeam)
    again = pickle.loads(pickle.dumps(model))
    assert np.array_equal(again.modes(n=2).frequencies, model.modes(n=2).frequencies)
    model.save(tmp_path / "own.yaml")
    with pytest.raises(retune.RetuneError, match="plane_beam"):
        retune.Model(tmp_path / "own.yaml")
    assert retune.Model(tmp_path / "own.yaml", elements=[PlaneBeam()]).n_dof == model.n_dof


class Bent(PlaneBeam):
    def __init__(self, what: str) -> None:
        self.what = what

    def stiffness(self, points: Floats, values: Mapping[str, float]) -> Floats:
        k = super().stiffness(points, values)
        if self.what == "raises":
            raise ZeroDivisionError("the bar is too short")
        if self.what == "size":
            return k[:6, :6]
        k[2, 4] += {"skew": 1e3, "nan": np.nan}[self.what]
        return k


@pytest.mark.parametrize(
    ("what", "message"),
    [
        ("raises", "ZeroDivisionError: the bar is too short"),
        ("size", "it is 6 x 6, and 2 nodes make 12 x 12"),
        ("skew", "it is not symmetric in entry"),
        ("nan", "is not finite"),
    ],
)
def test_what_is_wrong_with_an_element_is_said(what: str, message: str) -> None:
    with pytest.raises(retune.RetuneError, match=f"stiffness of `plane_beam`: .*{message}"):
        retune.Model(of_own_beams(), elements=[Bent(what)])


def test_the_contract_of_an_element_is_checked() -> None:
    class Leaky(PlaneBeam):
        samples = (retune.Sample([(0, 0, 0), (2.0, 0, 0)], {"EI": 3.0, "mu": 0.5}, mass=1.0),)

        def mass(self, points: Floats, values: Mapping[str, float]) -> Floats:
            return 2.0 * super().mass(points, values)

    broken = Leaky().check()
    assert any(text.startswith("mass") for text in broken), broken
    with pytest.raises(retune.RetuneError, match="`uy2` is not a dof"):
        type("Odd", (PlaneBeam,), {"nodes": (("uy2",), ("uz",))})().check()


class TipMass(retune.Effect):
    """A mass at a node, as the built-in point-mass is, under a name of its own."""

    name = "glued-mass"
    summary = "A mass that was glued on and that nobody wrote down."
    signature = "Lowers every mode that moves there."
    formulation = "M gains m u² at the node; m = 0 leaves it."
    confusable = ("mass-change",)

    def locations(self, structure: retune.Structure) -> Sequence[retune.Location]:
        return [retune.Location((name,)) for name, node in structure.nodes.items() if "uz" in node.dofs]

    def sizes(self, structure: retune.Structure, at: retune.Location) -> Mapping[str, retune.Size]:
        whole = structure.total_mass
        return {"mass": retune.Size("kg", 0.05 * whole, (0.0, whole), description=f"mass at {at}")}

    def entries(self, structure: retune.Structure, at: retune.Location, sizes: Mapping[str, str]) -> Mapping[str, Mapping[str, Any]]:
        return {"masses": {"": {"node": at.names[0], "mass": sizes["mass"]}}}


@pytest.fixture
def heavier(cantilever: retune.Model) -> retune.Test:
    truth = {"masses": {"forgotten": {"node": "middle", "mass": "0.06 kg"}}}
    made = retune.twin(cantilever, modes=4, patch=truth, noise_frequency="0.2 %", noise_shape="1 %", seed=5)
    assert made.test is not None
    return made.test


def test_an_effect_is_found_as_the_built_in_one_is(cantilever: retune.Model, heavier: retune.Test) -> None:
    own = retune.diagnose(cantilever, heavier, effects=[TipMass(), "stiffness-change"], faults=False)
    built_in = retune.diagnose(cantilever, heavier, effects=["point-mass", "stiffness-change"], faults=False)
    first, other = own.hypotheses[0], built_in.hypotheses[0]
    assert (first.id, other.id) == ("glued-mass@middle", "point-mass@middle")
    assert first.estimate == pytest.approx(other.estimate, rel=1e-3) and first.probability == pytest.approx(other.probability, abs=0.02)
    assert own.to_html().startswith("<!doctype html>")
    learned = retune.learn(cantilever, heavier, effects=[TipMass()], take_best=True, limit=1)
    assert learned.effects == ["glued-mass@middle"] and "glued-mass@middle" in learned.model.to_yaml()
    assert learned.misfits[-1] < 0.1 * learned.misfits[0]


def test_an_effect_is_added_and_taken_out(cantilever: retune.Model) -> None:
    added = cantilever.add(TipMass(), at="tip", because="a test")
    assert list(added.parameters)[-1] == "glued_mass.tip.mass"
    assert added.modes(n=2).frequencies == pytest.approx(cantilever.modes(n=2).frequencies, rel=1e-12)
    assert added.undo().to_yaml() == cantilever.to_yaml()
    with pytest.raises(retune.RetuneError, match="glued-mass"):
        cantilever.add(TipMass(), at="tipp")


def test_the_contract_of_an_effect_is_checked(cantilever: retune.Model) -> None:
    class Whole(TipMass):
        name = "whole-mass"
        references = ("R. D. Blevins, Formulas for Natural Frequency and Mode Shape, 1979",)

    assert Whole().check(cantilever) == []

    class Heavy(Whole):
        def sizes(self, structure: retune.Structure, at: retune.Location) -> Mapping[str, retune.Size]:
            return {"mass": retune.Size("kg", 0.1, (0.0, 0.5), neutral=0.2, description="never absent")}

    class Elsewhere(Whole):
        def entries(self, structure: retune.Structure, at: retune.Location, sizes: Mapping[str, str]) -> Mapping[str, Mapping[str, Any]]:
            return {"masses": {"": {"node": "moon", "mass": sizes["mass"]}}}

    assert any("neutral" in text for text in Heavy().check(cantilever))
    assert any("moon" in text for text in Elsewhere().check(cantilever))
    assert any("no source" in text for text in TipMass().check(cantilever))


def test_what_an_effect_raises_is_raised(cantilever: retune.Model, heavier: retune.Test) -> None:
    class Lost(TipMass):
        name = "lost"

        def locations(self, structure: retune.Structure) -> Sequence[retune.Location]:
            raise LookupError("no nodes today")

    class Odd(TipMass):
        name = "odd"

        def entries(self, structure: retune.Structure, at: retune.Location, sizes: Mapping[str, str]) -> Mapping[str, Mapping[str, Any]]:
            return {"masers": {"": {}}}

    class Strange(TipMass):
        name = "strange"

        def entries(self, structure: retune.Structure, at: retune.Location, sizes: Mapping[str, str]) -> Mapping[str, Mapping[str, Any]]:
            return {"masses": {"": {"node": at.names[0], "weight": sizes["mass"]}}}

    with pytest.raises(retune.RetuneError, match="lost: LookupError: no nodes today") as raised:
        retune.diagnose(cantilever, heavier, effects=[Lost()], faults=False)
    assert isinstance(raised.value.__cause__, LookupError)
    with pytest.raises(retune.RetuneError, match="odd: ValueError: it adds to `masers`"):
        retune.diagnose(cantilever, heavier, effects=[Odd()], faults=False)
    with pytest.raises(retune.RetuneError, match="strange: .*not an entry of a model file: unknown field `weight`"):
        retune.diagnose(cantilever, heavier, effects=[Strange()], faults=False)
    # The next call has nothing of the last one.
    assert retune.diagnose(cantilever, heavier, effects=[TipMass()], faults=False).hypotheses[0].id == "glued-mass@middle"


class AmplifierStep(retune.Fault):
    """An amplifier that stood a step of 10 dB too low."""

    name = "amplifier-step"
    summary = "The amplifier of a channel stood one step of 10 dB below what the test says."
    signature = "Its reading is 3.16 times too small in every mode."

    def remedy(self, place: str) -> str:
        return f"multiply the readings of sensor {place} by 3.162"

    def shape(self, at: retune.At, number: float, shape: npt.NDArray[np.complex128], sd: Floats | None) -> None:
        shape[at.sensors[0]] *= 10**0.5
        if sd is not None:
            sd[at.sensors[0]] *= 10**0.5

    def put_into_shape(self, at: retune.At, number: float, shape: npt.NDArray[np.complex128]) -> None:
        shape[at.sensors[0]] /= 10**0.5


def wrong_at(model: retune.Model, sensor: str) -> retune.Test:
    made = retune.twin(model, modes=6, noise_frequency="0.3 %", noise_shape="2 %", seed=1).test
    assert made is not None
    shapes = made.shapes.real.copy()
    shapes[[s.name for s in made.sensors].index(sensor)] /= 10**0.5
    return retune.Test.from_arrays(
        made.frequencies,
        shapes=shapes,
        sensors=made.sensors,
        frequency_sd=[m.frequency_sd for m in made.modes],
        shape_sd=made.shape_sd,
        is_synthetic=True,
    )


def test_a_fault_of_ones_own_is_named(models: Path) -> None:
    model = retune.Model(models / "frame.yaml")
    test = wrong_at(model, "mid_left.ux")
    faults: list[str | retune.Fault] = [*retune.catalogue("faults"), AmplifierStep()]
    found = retune.diagnose(model, test, effects=["point-mass", "joint-flexibility"], faults=faults)
    # A step that is known beforehand is more probable than a gain of any size.
    assert found.hypotheses[0].id == "amplifier-step@mid_left.ux"
    with pytest.raises(retune.RetuneError, match="did you mean `sensor-gain`"):
        retune.diagnose(model, test, faults=["sensor-gian"])

    class Broken(AmplifierStep):
        def shape(self, at: retune.At, number: float, shape: npt.NDArray[np.complex128], sd: Floats | None) -> None:
            raise RuntimeError("no such channel")

    with pytest.raises(retune.RetuneError, match="amplifier-step: RuntimeError: no such channel"):
        retune.diagnose(model, test, effects=["point-mass"], faults=[Broken()])


class Frequencies(retune.Residual):
    """The built-in term `frequency` again."""

    name = "own-frequency"
    summary = "natural frequencies of paired modes, each over its standard deviation"

    def rows(self, test: retune.Measured) -> Sequence[str]:
        return [f"frequency of mode {k + 1}" for k in range(len(test.frequencies))]

    def evaluate(self, test: retune.Measured, model: retune.Predicted) -> Floats:
        r = (model.frequencies - test.frequencies) / test.frequency_sd
        return np.where(test.is_aside, 0.0, np.where(np.isfinite(r), r, 2.648))


class Sines(retune.Residual):
    """The built-in term `mac` again."""

    name = "own-mac"
    summary = "sine of the angle between paired shapes, over 0.1"

    def rows(self, test: retune.Measured) -> Sequence[str]:
        return [f"MAC of mode {k + 1}" for k in range(len(test.frequencies))]

    def evaluate(self, test: retune.Measured, model: retune.Predicted) -> Floats:
        a, b = model.shapes, test.shapes
        mac = np.nansum(a * b, axis=0) ** 2 / (np.nansum(a * a, axis=0) * np.nansum(b * b, axis=0))
        return np.sqrt(np.maximum(1.0 - mac, 0.0)) / 0.1


def test_a_residual_is_the_built_in_one(models: Path) -> None:
    model = retune.Model(models / "frame.yaml")
    made = retune.twin(model, modes=5, set={"E_columns": "212 GPa", "m_machine": "13 kg"}, noise_frequency="0.3 %", noise_shape="2 %", seed=4).test
    assert made is not None
    own = retune.Objective(model, made, objective={"terms": {"own-frequency": 1, "own-mac": 0.5}}, residuals=[Frequencies(), Sines()])
    built_in = retune.Objective(model, made, objective={"terms": {"frequency": 1, "mac": 0.5}})
    assert own.n_residuals == built_in.n_residuals
    for x in ([0.3, 0.6, 0.2], [0.7, 0.4, 0.5]):
        r, jacobian = own.linearize(x)
        expected, slopes = built_in.linearize(x)
        # Rows of a list stand in its order.
        assert np.sort(r) == pytest.approx(np.sort(expected), rel=1e-9, abs=1e-9)
        assert own.cost(x) == pytest.approx(built_in.cost(x), rel=1e-9)
        # Central differences of a smooth function: h² r'''/6 and ε r/h.
        assert jacobian.T @ r == pytest.approx(slopes.T @ expected, rel=1e-5)
    ours = retune.update(model, made, objective={"terms": {"own-frequency": 1}}, residuals=[Frequencies()])
    theirs = retune.update(model, made, objective={"terms": {"frequency": 1}})
    assert ours.cost == pytest.approx(theirs.cost, rel=1e-6) and ours.theta == pytest.approx(theirs.theta, rel=1e-4)
    # Beside the usual terms, where none are stated.
    assert retune.Objective(model, made, residuals=[Frequencies()]).n_residuals == retune.Objective(model, made).n_residuals + 5


def test_what_is_wrong_with_a_residual_is_said(cantilever: retune.Model, twin: retune.Test) -> None:
    class Short(Frequencies):
        def evaluate(self, test: retune.Measured, model: retune.Predicted) -> Floats:
            return super().evaluate(test, model)[:1]

    class Broken(Frequencies):
        def evaluate(self, test: retune.Measured, model: retune.Predicted) -> Floats:
            raise KeyError("tip")

    with pytest.raises(retune.RetuneError, match="own-frequency: .*it gives 1 rows; it names 4"):
        retune.update(cantilever, twin, residuals=[Short()])
    with pytest.raises(retune.RetuneError, match="own-frequency: KeyError: 'tip'"):
        retune.Objective(cantilever, twin, residuals=[Broken()]).residuals([0.5])
    with pytest.raises(retune.RetuneError, match="`own-frequenzy` is not a residual term; did you mean `own-frequency`"):
        retune.update(cantilever, twin, objective={"terms": {"own-frequenzy": 1}}, residuals=[Frequencies()])
    with pytest.raises(retune.RetuneError, match="terms of the cost least-squares"):
        retune.update(cantilever, twin, cost="paper", residuals=[Frequencies()])


class Compass(retune.Optimizer):
    """Goes to the best neighbour, halves its step when none is better."""

    name = "compass"

    def minimize(self, start: Floats, run: retune.Run) -> bool:
        x, cost, step = start, run.cost(start), 0.25
        while step > 1e-7:
            around = np.clip(x + step * np.vstack([np.eye(len(x)), -np.eye(len(x))]), 0, 1)
            costs = run.costs(around)
            if costs.min() < cost:
                x, cost = around[costs.argmin()], float(costs.min())
            else:
                step /= 2
        return True


class GaussNewton(retune.Optimizer):
    name = "gauss-newton"

    def minimize(self, start: Floats, run: retune.Run) -> bool:
        x = start
        for _ in range(20):
            run.cost(x)
            found = run.linearize(x)
            assert found is not None
            r, jacobian = found
            step = np.linalg.lstsq(jacobian, r, rcond=None)[0]
            x = np.clip(x - step, 0, 1)
        return bool(np.abs(step).max() < 1e-8)


class Chance(retune.Optimizer):
    name = "chance"

    def minimize(self, start: Floats, run: retune.Run) -> None:
        numbers = run.rng()
        while True:
            run.costs(numbers.random((10, run.n_parameters)))


def test_an_optimizer_finds_what_the_built_in_ones_find(cantilever: retune.Model, twin: retune.Test) -> None:
    theirs = retune.update(cantilever, twin)
    for own in (Compass(), GaussNewton()):
        ours = retune.update(cantilever, twin, optimizer=own)
        assert ours.cost == pytest.approx(theirs.cost, rel=1e-6), own.name
        assert ours["E"].after == pytest.approx(theirs["E"].after, rel=1e-4)
        assert ours.is_converged and ours["E"].sd == pytest.approx(theirs["E"].sd, rel=1e-3)


def test_a_budget_ends_an_endless_search(cantilever: retune.Model, twin: retune.Test) -> None:
    found = retune.update(cantilever, twin, optimizer=Chance(), budget=55, seed=3)
    assert not found.is_converged and found.cost < found.cost_before and "budget" in found.termination
    again = retune.update(cantilever, twin, optimizer=Chance(), budget=55, seed=3)
    assert again.to_dict() == found.to_dict()
    assert retune.update(cantilever, twin, optimizer=Chance(), budget=55, seed=4).theta != pytest.approx(found.theta, rel=1e-12)


def test_what_an_optimizer_raises_is_raised(cantilever: retune.Model, twin: retune.Test) -> None:
    class Broken(retune.Optimizer):
        name = "broken"

        def minimize(self, start: Floats, run: retune.Run) -> None:
            run.cost(start + 2.0)

    with pytest.raises(retune.RetuneError, match=r"broken: .*x\[0\] is .*; points are of the unit box"):
        retune.update(cantilever, twin, optimizer=Broken())

    class Kept(retune.Optimizer):
        name = "kept"
        run: retune.Run

        def minimize(self, start: Floats, run: retune.Run) -> None:
            run.cost(start)
            self.run = run

    kept = Kept()
    retune.update(cantilever, twin, optimizer=kept)
    with pytest.raises(retune.SearchEnded):
        kept.run.cost([0.5])
