"""Models, tests and results as objects: closed forms, arrays, errors, what survives a process."""

from __future__ import annotations

import concurrent.futures
import multiprocessing
import os
import pickle
import signal
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import CANTILEVER

import retune


def oscillator(k: float, m: float) -> dict[str, Any]:
    """A mass on a spring: ω² = k/m."""
    return {
        "retune": 1,
        "name": "mass on a spring",
        "parameters": {"k": {"value": f"{k!r} N/m", "bounds": [f"{0.1 * k!r} N/m", f"{10 * k!r} N/m"]}},
        "nodes": {"a": [0, 0, 0]},
        "active_dofs": ["uz"],
        "springs": {"support": {"node": "a", "k": {"uz": "k"}}},
        "masses": {"block": {"node": "a", "mass": f"{m!r} kg"}},
    }


def test_an_oscillator_has_its_closed_form() -> None:
    model = retune.Model(oscillator(400.0, 4.0))
    modes = model.modes(n=1)
    assert modes.frequencies == pytest.approx([10.0 / (2 * np.pi)], rel=1e-12)
    assert modes.shapes == pytest.approx(np.array([[0.5]]))  # 1/√m
    assert model.modes({"k": 1600.0}, n=1).frequencies == pytest.approx([20.0 / (2 * np.pi)], rel=1e-12)
    assert model.modes(np.array([1600.0]), n=1).frequencies == pytest.approx([20.0 / (2 * np.pi)], rel=1e-12)
    matrices = model.matrices({"k": 900.0})
    assert (matrices.stiffness[0, 0], matrices.mass[0, 0], matrices.damping) == (900.0, 4.0, None)
    mass = model.mass_properties()
    assert mass is not None and mass.mass == pytest.approx(4.0)


def test_a_function_has_its_closed_form() -> None:
    """A single oscillator: H = -ω²/(k - ω² m + 2iζω√(km))."""
    model = retune.Model(oscillator(400.0, 4.0))
    f = np.linspace(0.1, 5.0, 200)
    w = 2 * np.pi * f
    expected = -(w**2) / (400.0 - w**2 * 4.0 + 2j * 0.02 * w * np.sqrt(400.0 * 4.0))
    found = model.frf(f, "a", damping=0.02)
    assert found.h.shape == (200, 1, 1)
    assert np.allclose(found.h[:, 0, 0], expected, rtol=1e-10)


def test_matrices_give_the_modes(cantilever: retune.Model) -> None:
    from scipy.linalg import eigh

    m = cantilever.matrices()
    values = eigh(m.stiffness.toarray(), m.mass.toarray(), eigvals_only=True)
    assert cantilever.modes(n=4).frequencies == pytest.approx(np.sqrt(values[:4]) / (2 * np.pi), rel=1e-8)
    assert m.dofs == cantilever.dofs and len(m.dofs) == cantilever.n_dof
    assert abs(m.stiffness - m.stiffness.T).max() == 0.0


def test_shapes_at_nodes_are_those_of_the_dofs(cantilever: retune.Model) -> None:
    modes = cantilever.modes(n=2)
    at = modes.at_nodes(0)
    uz = dict(zip(cantilever.dof_nodes, at[:, 2]))
    row = cantilever.dofs.index("tip.uz")
    assert uz["tip"] == modes.shapes[row, 0] and uz["root"] == 0.0
    assert cantilever.nodes["tip"] == pytest.approx([0.6, 0.0, 0.0])


def test_arrays_are_the_callers_own(cantilever: retune.Model) -> None:
    modes = cantilever.modes(n=2)
    modes.shapes[:] = 0.0
    assert np.any(cantilever.modes(n=2).shapes != 0.0)
    assert modes.shapes.flags.f_contiguous and modes.shapes.flags.writeable


def test_a_model_in_its_file_and_in_a_dict_are_one(tmp_path: Path, cantilever: retune.Model) -> None:
    cantilever.save(tmp_path / "c.yaml")
    with pytest.raises(FileExistsError):
        cantilever.save(tmp_path / "c.yaml")
    read = retune.Model(tmp_path / "c.yaml")
    assert np.array_equal(read.modes(n=3).frequencies, cantilever.modes(n=3).frequencies)
    assert list(read.parameters) == ["E"]
    p = read.parameters["E"]
    assert (p.value, p.bounds, p.unit, p.unit_factor) == (70e9, (60e9, 80e9), "GPa", 1e9)


def test_values_effects_and_their_undoing(cantilever: retune.Model) -> None:
    stiffer = cantilever.with_values({"E": 75e9})
    assert stiffer.parameters["E"].value == pytest.approx(75e9, rel=1e-15)
    assert stiffer.modes(n=1).frequencies[0] == pytest.approx(cantilever.modes({"E": 75e9}, n=1).frequencies[0], rel=1e-12)
    added = cantilever.add("point-mass@tip", because="a test")
    assert len(added.parameters) == 2
    assert added.modes(n=2).frequencies == pytest.approx(cantilever.modes(n=2).frequencies, rel=1e-12)
    assert added.undo().to_yaml() == cantilever.to_yaml()


def test_functions_become_a_test_that_a_fit_takes(cantilever: retune.Model) -> None:
    """Functions with noise of a cantilever of 74 GPa: its modes are identified, and the fit finds that, as certain as it says."""
    f = np.linspace(2.0, 400.0, 4000)
    frfs = cantilever.with_values({"E": 74e9}).frf(f, "tip", ["middle", "tip"], damping=0.01)
    noise = 0.005 * np.random.default_rng(5).normal(size=frfs.h.shape)
    noisy = retune.Frfs(f, frfs.h * (1 + noise), frfs.responses, frfs.references, quantity=frfs.quantity, is_synthetic=True)
    test = retune.Test.from_frfs(noisy)
    found = retune.update(cantilever, test)["E"]
    assert found.sd is not None and 0 < found.sd < 0.2
    assert abs(found.after - 74.0) < 4 * found.sd


def test_problems_have_a_place(tmp_path: Path) -> None:
    path = tmp_path / "wrong.yaml"
    path.write_text("retune: 1\nname: wrong\nnodes: {a: [0, 0, 0]}\nmasses: {m: {node: b, mass: 1 kg}}\n")
    with pytest.raises(retune.RetuneError) as raised:
        retune.Model(path)
    error = raised.value
    assert (error.path, error.line, error.key) == (str(path), 4, "masses.m.node")
    assert error.problems[0].severity == "error" and "`b`" in error.problems[0].message
    with pytest.raises(retune.RetuneError, match="no_such_file"):
        retune.Model(tmp_path / "no_such_file.yaml")
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.path, again.line) == (str(error), error.path, error.line)


def test_what_is_wrong_in_a_call_is_said(cantilever: retune.Model, twin: retune.Test) -> None:
    with pytest.raises(retune.RetuneError, match="no parameter `F`"):
        cantilever.modes({"F": 1.0})
    with pytest.raises(retune.RetuneError, match="1 parameters"):
        cantilever.modes([1.0, 2.0])
    with pytest.raises(retune.RetuneError, match="min_mac is 90"):
        retune.compare(cantilever, twin, min_mac=90)
    with pytest.raises(retune.RetuneError, match="given twice"):
        retune.update(cantilever, [twin, twin])
    with pytest.raises(retune.RetuneError, match="did you mean"):
        retune.diagnose(cantilever, twin, effects=["point-mas"])
    with pytest.raises(retune.RetuneError, match="there is no test"):
        retune.update(cantilever, [])
    with pytest.raises(retune.RetuneError, match="no sensor `tipp`"):
        cantilever.frf([1.0], "tipp")


def test_modes_from_arrays_come_back() -> None:
    shapes = np.array([[1.0, 0.3 + 0.1j], [0.5, np.nan]])
    test = retune.Test.from_arrays(
        [10.0, 20.0],
        shapes=shapes,
        sensors=[retune.Sensor("s1", "a", "+x"), retune.Sensor("s2", "b", (0.0, 0.6, 0.8), position=(1.0, 2.0, 3.0))],
        damping=[0.01, 0.02],
        frequency_sd=0.05,
        damping_sd=[0.001, 0.002],
        shape_sd=0.02,
        labels=["first", None],
        source="hammer",
    )
    assert np.array_equal(test.shapes, shapes, equal_nan=True)
    assert np.array_equal(test.frequencies, [10.0, 20.0]) and np.array_equal(test.damping, [0.01, 0.02])
    assert [m.frequency_sd for m in test.modes] == [0.05, 0.05]
    assert [m.damping_sd for m in test.modes] == [0.001, 0.002]
    assert [m.label for m in test.modes] == ["first", None]
    assert test.shape_sd[0, 0] == pytest.approx(0.02)
    s2 = test.sensors[1]
    assert (s2.node, s2.position) == ("b", (1.0, 2.0, 3.0)) and s2.direction == pytest.approx((0.0, 0.6, 0.8))
    assert test.modes[0].source == "hammer" and not test.modes[0].is_synthetic


def test_functions_from_other_libraries() -> None:
    f = np.linspace(1.0, 5.0, 9)
    h = np.random.default_rng(0).normal(size=(9, 2, 1)) + 1j
    ours = retune.Frfs(f, h, ["1.+z", "2.+z"], ["1.+z"])
    uff = [
        {"type": 58, "x": f, "data": h[:, r, 0], "rsp_node": r + 1, "rsp_direct": 3, "ref_node": 1, "ref_direct": 3}
        for r in range(2)
    ]

    class Coordinate:
        node = np.array([[1, 1], [2, 1]])
        direction = np.array([[3, 3], [3, 3]])

    class TransferFunctionArray:
        abscissa = np.array([f, f])
        ordinate = h[:, :, 0].T
        coordinate = Coordinate()

    class Ema:
        freq = f
        frf = h[:, :, 0].T
        frf_form = "accelerance"

    for other in (
        retune.Frfs.from_uff(uff),
        retune.Frfs.from_sdynpy(TransferFunctionArray()),
        retune.Frfs.from_sdypy(Ema(), ["1.+z", "2.+z"], "1.+z"),
    ):
        assert np.array_equal(other.h, ours.h) and other.responses == ours.responses
        assert other.references == ours.references and other.quantity == "accelerance"


def test_functions_that_do_not_fit_are_refused() -> None:
    with pytest.raises(retune.RetuneError, match="3 lines, 1 responses and 1 references"):
        retune.Frfs([1.0, 2.0, 3.0], np.zeros((4, 1, 1)), ["a.+z"], ["a.+z"])


def test_an_update_finds_the_stiffness_of_the_twin(cantilever: retune.Model, twin: retune.Test) -> None:
    found = retune.update(cantilever, twin)
    e = found["E"]
    assert e.sd is not None and e.interval is not None
    assert abs(e.after - 74.0) < 4 * e.sd  # GPa
    assert e.interval[0] < e.after < e.interval[1]
    assert found.is_converged and found.cost < found.cost_before
    assert found.theta == pytest.approx([1e9 * e.after])
    assert found.history_cost[-1] == pytest.approx(found.cost) and np.all(np.diff(found.history_cost) <= 0)
    assert np.all(found.mac.diagonal()[:4] > 0.99)
    assert found.model.modes(n=1).frequencies[0] == pytest.approx(found.pairs[0].model_hz, rel=1e-9)


def test_a_sensor_that_is_turned_over_is_left_out(models: Path) -> None:
    model = retune.Model(models / "frame.yaml")
    for fault, left_out in [((), []), ("sensor-sign@corner_left.uz", ["corner_left.uz"])]:
        made = retune.twin(model, modes=6, seed=3, fault=fault, noise_frequency="0.2 %", noise_shape="1 %")
        test = made.test
        assert test is not None
        assert list(retune.update(model, test).sensors_left_out.values()) == [left_out]


def test_results_draw_themselves(cantilever: retune.Model, twin: retune.Test) -> None:
    compared, updated = retune.compare(cantilever, twin), retune.update(cantilever, twin, budget=50)
    for shown in (cantilever, cantilever.modes(n=2), twin, compared, updated, retune.pretest(cantilever, modes=3)):
        assert "<table" in shown._repr_html_()
        assert repr(shown)
    assert "<svg" in compared._repr_html_()
    page = updated.to_html()
    assert page.startswith("<!doctype html>") and "cantilever" in page
    frame = updated.show()._repr_html_()
    assert frame.startswith("<iframe") and 'sandbox="allow-scripts"' in frame
    assert "&lt;!doctype html&gt;" in frame and "<!doctype" not in frame


def test_hostile_names_stay_text(twin: retune.Test) -> None:
    hostile = retune.Model({**CANTILEVER, "name": "<script>alert(1)</script>"})
    assert "<script>" not in hostile._repr_html_()


def test_progress_is_told_and_may_stop(cantilever: retune.Model, twin: retune.Test) -> None:
    told: list[tuple[str, int | None, float | None]] = []
    retune.update(cantilever, twin, optimizer="differential-evolution", progress=lambda *what: told.append(what))
    retune.diagnose(cantilever, twin, progress=lambda *what: told.append(what))
    assert any(evaluations for _, evaluations, _ in told) and all(isinstance(text, str) for text, *_ in told)

    def refuse(*_: object) -> None:
        raise ValueError("enough")

    with pytest.raises(ValueError, match="enough"):
        retune.update(cantilever, twin, optimizer="differential-evolution", progress=refuse)


@pytest.mark.filterwarnings("ignore::retune.RetuneWarning")
def test_ctrl_c_keeps_the_best(models: Path) -> None:
    """The first Ctrl-C ends a search that would go on for days; what it has found so far is the answer."""
    model, test = retune.Model(models / "bff.yaml"), retune.Test(models / "bff_gvt.yaml")
    endless = {"differential-evolution": {"strategy": "classic", "population": 1_000, "generations": 1_000_000_000, "tolerance": 0}}
    threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT)).start()
    begun = time.perf_counter()
    found = retune.update(model, test, cost="paper", optimizer=endless)
    assert time.perf_counter() - begun < 60.0
    assert not found.is_converged and found.cost < found.cost_before
    assert "stopped" in found.termination


@pytest.mark.filterwarnings("ignore::retune.RetuneWarning")
def test_other_threads_run_meanwhile(models: Path) -> None:
    """The GIL is released: a thread of Python goes on while a search runs."""
    model, test = retune.Model(models / "bff.yaml"), retune.Test(models / "bff_gvt.yaml")
    ticks = 0
    is_over = threading.Event()

    def tick() -> None:
        nonlocal ticks
        while not is_over.wait(0.005):
            ticks += 1

    thread = threading.Thread(target=tick)
    thread.start()
    begun = time.perf_counter()
    retune.update(model, test, budget=3000)
    seconds = time.perf_counter() - begun
    is_over.set()
    thread.join()
    # One tick takes 5 ms and the time to be scheduled on a busy machine.
    assert ticks > 0.1 * seconds / 0.005


def _lowest(model: retune.Model, test: retune.Test) -> float:
    return retune.update(model, test).cost


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_models_and_tests_travel_to_other_processes(cantilever: retune.Model, twin: retune.Test, method: str) -> None:
    here = _lowest(cantilever, twin)
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"skipped: no {method} here")
    context = multiprocessing.get_context(method)
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=context) as pool:
        assert pool.submit(_lowest, cantilever, twin).result(timeout=120) == here


def test_a_call_costs_little_beyond_the_solution(models: Path) -> None:
    """27 dofs: what Python adds to a solution. The bar is 15 us; the fastest of many rounds, for the machine may be busy."""
    model = retune.Model(models / "wing_on_spring.yaml")
    assert model.n_dof == 27
    rounds, calls = 30, 50
    added = []
    for _ in range(rounds):
        alone = model._inner.seconds_of_modes(10, calls)
        begun = time.perf_counter()
        for _ in range(calls):
            model.modes(n=10)
        added.append((time.perf_counter() - begun) / calls - alone)
    assert sorted(added)[rounds // 4] < 15e-6, sorted(added)
