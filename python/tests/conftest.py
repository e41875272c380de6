"""Models and tests of the repository, and the command of this package."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import retune

# Jobs that a script starts in the background ignore Ctrl-C, and so would a search in these tests that is to be stopped by it.
signal.signal(signal.SIGINT, signal.default_int_handler)

MODELS = Path(__file__).resolve().parents[2] / "models"


@pytest.fixture
def models() -> Path:
    if not MODELS.is_dir():
        pytest.skip(f"skipped: {MODELS} is not here, the models of the repository")
    return MODELS


def run(*words: object, code: int | None = None, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """The command of this package, as a process."""
    done = subprocess.run(
        [sys.executable, "-m", "retune", *map(str, words)],
        capture_output=True,
        text=True,
        cwd=cwd,
        env={**os.environ, "NO_COLOR": "1"},
        timeout=600,
        check=False,
    )
    if code is not None:
        assert done.returncode == code, done.stderr
    return done


def printed(*words: object) -> Any:
    """What the command prints with `--json`."""
    done = run(*words, "--json")
    assert done.returncode in (0, 1), done.stderr
    return json.loads(done.stdout)


CANTILEVER: dict[str, Any] = {
    "retune": 1,
    "name": "cantilever",
    "parameters": {"E": {"value": "70 GPa", "bounds": ["60 GPa", "80 GPa"], "prior_sd": "2 GPa"}},
    "sections": {
        "strip": {
            "E": "E",
            "G": "26 GPa",
            "density": "2700 kg/m3",
            "shape": {"rectangle": {"width": "40 mm", "height": "5 mm"}},
        }
    },
    "nodes": {"root": [0, 0, 0], "middle": [0.3, 0, 0], "tip": [0.6, 0, 0]},
    "beams": {
        "inner": {"nodes": ["root", "middle"], "section": "strip", "subdivide": 4},
        "outer": {"nodes": ["middle", "tip"], "section": "strip", "subdivide": 4},
    },
    "active_dofs": ["uz", "ry"],
    "supports": {"clamp": {"node": "root"}},
}


@pytest.fixture
def cantilever() -> retune.Model:
    return retune.Model(CANTILEVER)


@pytest.fixture
def twin(cantilever: retune.Model) -> retune.Test:
    """A synthetic test of a stiffer cantilever."""
    made = retune.twin(cantilever, modes=4, set={"E": "74 GPa"}, noise_frequency="0.2 %", noise_shape="1 %", seed=3)
    assert made.test is not None
    return made.test
