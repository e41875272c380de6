"""The command of the package behaves as the binary: streams, exit codes, signals."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from conftest import run

import retune


def test_it_is_on_the_path_of_the_environment(models: Path) -> None:
    command = shutil.which("retune", path=str(Path(sys.executable).parent))
    assert command is not None, "the wheel holds no command"
    done = subprocess.run([command, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == f"retune {retune.__version__}"


def test_exit_codes(models: Path, tmp_path: Path) -> None:
    assert run("check", models / "bff.yaml").returncode == 0
    assert run("compare", models / "bff.yaml", models / "bff_gvt.yaml", "--profile", "common-practice").returncode == 1
    done = run("check", tmp_path / "none.yaml")
    assert done.returncode == 2 and done.stderr.startswith("retune: cannot read")
    assert run("chek").returncode == 2


def test_a_closed_pipe_is_no_error(models: Path) -> None:
    with subprocess.Popen(
        [sys.executable, "-m", "retune", "list", "elements"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        assert process.stdout is not None and process.stderr is not None
        process.stdout.close()
        errors = process.stderr.read()
        assert (process.wait(timeout=60), errors) == (0, b"")


def test_a_full_disk_is_told(models: Path) -> None:
    if not os.path.exists("/dev/full"):
        pytest.skip("skipped: no /dev/full here")
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "retune", "list", "elements"], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert done.returncode == 2 and "cannot write to the standard output" in done.stderr


def test_ctrl_c_keeps_the_best(models: Path, tmp_path: Path) -> None:
    out = tmp_path / "updated.yaml"
    endless = "{differential-evolution: {strategy: classic, population: 1000, generations: 1000000000, tolerance: 0}}"
    words = ["update", models / "bff.yaml", models / "bff_gvt.yaml", "--cost", "paper", "--optimizer", endless, "-o", out]
    with subprocess.Popen(
        [sys.executable, "-m", "retune", *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        time.sleep(3.0)
        process.send_signal(signal.SIGINT)
        output, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    assert "stopping; once more Ctrl-C ends at once" in errors
    assert "written:" in output and out.exists()


def test_ctrl_c_without_a_best_ends_at_once(models: Path) -> None:
    words = ["benchmark", "diagnosis", "--structure", "cantilever", "--effects", "5"]
    with subprocess.Popen(
        [sys.executable, "-m", "retune", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        time.sleep(2.0)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=30)
    assert process.returncode == -signal.SIGINT
