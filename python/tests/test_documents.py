"""The page of the guide about Python: its blocks run, in the folder of a project that its command begins."""

from __future__ import annotations

import contextlib
import io
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = Path(__file__).resolve().parents[2] / "docs" / "guide" / "python.md"


def blocks(kind: str) -> list[str]:
    """The fenced blocks of a kind."""
    return [part.split("\n", 1)[1] for part in PAGE.read_text().split("```")[1::2] if part.startswith(f"{kind}\n")]


def test_the_guide_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if not PAGE.exists():
        pytest.skip(f"skipped: {PAGE} is not here")
    monkeypatch.chdir(tmp_path)
    for line in "".join(blocks("sh")).split("\n"):
        if line:
            subprocess.run([sys.executable, "-m", *line.split()], check=True, capture_output=True)
    said = io.StringIO()
    names: dict[str, object] = {}
    with contextlib.redirect_stdout(said):
        for block in blocks("python"):
            exec(compile(block, str(PAGE), "exec"), names)
    assert "the model explains the test" in said.getvalue()
    assert names["names"] == ["E", "m_tip"]
    assert (tmp_path / "updated.yaml").exists() and (tmp_path / "verdict.html").exists()
