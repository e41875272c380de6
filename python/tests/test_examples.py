"""The examples run, and find what they hide."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


def output_of(name: str, folder: Path) -> str:
    script = EXAMPLES / f"{name}.py"
    if not script.exists():
        pytest.skip(f"skipped: {script} is not here")
    done = subprocess.run([sys.executable, str(script)], cwd=folder, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_from_frfs_to_a_verdict_and_a_page(models: Path, tmp_path: Path) -> None:
    assert "s4" in output_of("from_frfs_to_verdict", tmp_path)
    assert (tmp_path / "verdict.html").read_text().startswith("<!doctype html>")
    code = (EXAMPLES / "from_frfs_to_verdict.py").read_text().splitlines()
    assert len([line for line in code if line.strip()]) <= 20


def test_from_a_universal_file_to_an_effect(models: Path, tmp_path: Path) -> None:
    assert "point-mass@mid_left" in output_of("universal_file_to_effect", tmp_path).splitlines()[-1]
    assert (tmp_path / "learned.html").exists()


def test_a_model_of_another_solver(models: Path, tmp_path: Path) -> None:
    assert "solver: by_" in output_of("update_another_solver", tmp_path)


def test_a_posterior(models: Path, tmp_path: Path) -> None:
    assert "Posterior" in output_of("posterior", tmp_path)
