"""`to_dict()` of every verb is what the command prints with `--json`: to the last bit, from the same files."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import CANTILEVER, printed, run

import retune


@pytest.fixture(autouse=True)
def quiet() -> Iterator[None]:
    """The command warns on standard error, the library by warnings; neither is compared here."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", retune.RetuneWarning)
        yield


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    """A model and a synthetic test of it with a mass that it lacks."""
    model, test = tmp_path / "cantilever.yaml", tmp_path / "twin.yaml"
    retune.Model(CANTILEVER).save(model)
    patch = {"masses": {"forgotten": {"node": "middle", "mass": "40 g"}}}
    made = retune.twin(model, modes=5, patch=patch, noise_frequency="0.1 %", noise_shape="1 %", seed=5)
    assert made.test is not None
    made.test.save(test)
    return model, test


def test_modes(models: Path) -> None:
    model = retune.Model(models / "bff.yaml")
    assert model.modes(n=6).to_dict() == printed("modes", models / "bff.yaml", "-n", 6)


def test_compare(models: Path) -> None:
    model, test = models / "bff.yaml", models / "bff_gvt.yaml"
    assert retune.compare(model, test).to_dict() == printed("compare", model, test)


def test_compare_of_two_tests_with_a_profile(models: Path) -> None:
    model, tests = models / "bff.yaml", [models / "bff_gvt.yaml", models / "bff_bench.yaml"]
    found = retune.compare(model, tests, profile="common-practice", everything=True)
    assert found.to_dict() == printed("compare", model, *tests, "--profile", "common-practice", "--all")
    assert not found.passed


def test_compare_with_functions(files: tuple[Path, Path], tmp_path: Path) -> None:
    model, test = files
    unv = tmp_path / "functions.unv"
    run("twin", model, "--frf", unv, "--band", 5, 300, "--lines", 400, "--noise-response", "1 %", code=0)
    assert retune.compare(model, test, frf=unv).to_dict() == printed("compare", model, test, "--frf", unv)


def test_update(models: Path, tmp_path: Path) -> None:
    model, test = models / "bff.yaml", models / "bff_gvt.yaml"
    out = tmp_path / "updated.yaml"
    theirs = printed("update", model, test, "--budget", 400, "--seed", 2, "-o", out)
    ours = retune.update(model, test, budget=400, seed=2)
    assert ours.to_dict() == theirs
    assert ours.model.to_yaml() == out.read_text()


def test_update_of_two_tests(models: Path) -> None:
    model, tests = models / "bff.yaml", [models / "bff_gvt.yaml", models / "bff_bench.yaml"]
    assert retune.update(model, tests, budget=200).to_dict() == printed("update", model, *tests, "--budget", 200)


def test_update_by_the_costs_of_the_paper(files: tuple[Path, Path]) -> None:
    model, test = files
    for cost in ("paper", "frequencies"):
        theirs = printed("update", model, test, "--cost", cost, "--budget", 500, "--optimizer", "nelder-mead")
        ours = retune.update(model, test, cost=cost, budget=500, optimizer="nelder-mead")  # type: ignore[arg-type]
        assert ours.to_dict() == theirs


def test_sample(files: tuple[Path, Path], tmp_path: Path) -> None:
    model, test = files
    csv = tmp_path / "samples.csv"
    theirs = printed("sample", model, test, "--samples", 100, "--seed", 4, "-o", csv)
    ours = retune.sample(model, test, samples=100, seed=4)
    assert ours.to_dict() == theirs
    table = np.loadtxt(csv, delimiter=",", skiprows=1)
    assert np.array_equal(table, np.column_stack([ours.samples, ours.costs]))


def test_diagnose(files: tuple[Path, Path]) -> None:
    model, test = files
    assert retune.diagnose(model, test, seed=1).to_dict() == printed("diagnose", model, test, "--seed", 1)


def test_diagnose_narrowed(files: tuple[Path, Path]) -> None:
    model, test = files
    theirs = printed("diagnose", model, test, "--effects", "point-mass,mass-change", "--places", "middle", "--no-faults")
    ours = retune.diagnose(model, test, effects=["point-mass", "mass-change"], places=["middle"], faults=False)
    assert ours.to_dict() == theirs


def test_learn(files: tuple[Path, Path], tmp_path: Path) -> None:
    model, test = files
    theirs = printed("learn", model, test, "--take-best", "--limit", 1, "-o", tmp_path / "learned.yaml")
    ours = retune.learn(model, test, take_best=True, limit=1)
    written = theirs.pop("written")
    assert {k: v for k, v in ours.to_dict().items() if k != "written"} == theirs
    texts = [Path(path).read_text() for path in written if "test" not in Path(path).name]
    assert [m.to_yaml() for m in ours.models] == texts


def test_twin(models: Path, tmp_path: Path) -> None:
    model, sensors, out, unv = models / "bff.yaml", models / "bff_gvt.yaml", tmp_path / "twin.yaml", tmp_path / "twin.unv"
    theirs = printed(
        "twin", model, "-o", out, "--frf", unv, "--sensors", sensors, "--band", 3, 35, "--lines", 200, "--exciter", "p12",
        "--noise-frequency", "0.3 %", "--noise-shape", "2 %", "--noise-response", "1 %", "--set", "m8_13=70 g", "--fault",
        "sensor-sign@p11", "--seed", 9,
    )  # fmt: skip
    ours = retune.twin(
        model,
        sensors=sensors,
        band=(3, 35),
        frequencies=3 + (35.0 - 3) * np.arange(200) / 199,
        exciter="p12",
        noise_frequency="0.3 %",
        noise_shape="2 %",
        noise_response="1 %",
        set={"m8_13": "70 g"},
        fault="sensor-sign@p11",
        seed=9,
    )
    assert ours.to_dict() == theirs
    assert ours.test is not None and ours.test.to_yaml() == out.read_text()
    assert ours.frfs is not None
    read = retune.read_frfs(unv)
    order = [[c.name for c in read.responses].index(c.name) for c in ours.frfs.responses]
    # A line of the file holds seven digits of the smaller of real and imaginary part.
    assert np.allclose(read.h[:, order], ours.frfs.h, rtol=1e-6)


def test_identify(files: tuple[Path, Path], tmp_path: Path) -> None:
    model, _ = files
    unv, out = tmp_path / "functions.unv", tmp_path / "found.yaml"
    run("twin", model, "--frf", unv, "--band", 5, 500, "--noise-response", "0.5 %", "--exciter", "tip", code=0)
    theirs = printed("identify", unv, "-o", out)
    ours = retune.identify(unv)
    assert ours.to_dict() == theirs
    assert ours.test.to_yaml() == out.read_text()


def test_identify_of_held_modes(tmp_path: Path) -> None:
    csv = tmp_path / "shapes.csv"
    csv.write_text("point,frequency_hz,a,b,c\n,10.0,,,\n")
    done = run("identify", csv, "--direction", "+z", "--json")
    try:
        ours: Any = retune.identify(csv, direction="+z").to_dict()
    except retune.RetuneError as e:
        assert done.returncode == 2
        assert str(e).splitlines()[0][:40] in done.stderr
    else:
        assert ours == json.loads(done.stdout)


def test_pretest(models: Path) -> None:
    theirs = printed("pretest", models / "frame.yaml", "-n", 4)
    assert retune.pretest(models / "frame.yaml", modes=4).to_dict() == theirs
    theirs = printed("pretest", models / "frame.yaml", "--sensors", 6, "--by", "auto-mac", "--noise-shape", "1 %")
    ours = retune.pretest(models / "frame.yaml", sensors=6, by="auto-mac", noise_shape="1 %")
    assert ours.to_dict() == theirs


def test_report(files: tuple[Path, Path], tmp_path: Path) -> None:
    model, test = files
    data = tmp_path / "report.json"
    run("report", model, test, "--data", data, "-o", tmp_path / "report.html", code=0)
    theirs = json.loads(data.read_text())
    ours = retune.report(model, test).to_dict()
    # A call is not a command line.
    assert ours["meta"].pop("commands") == ["retune.report"]
    assert len(theirs["meta"].pop("commands")) == 1
    assert ours == theirs
