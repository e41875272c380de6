"""The notebooks are the examples, cell by cell; they run in a kernel from top to bottom, and show what they promise."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest

FOLDER = Path(__file__).resolve().parents[1]
NAMES = ["universal_file_to_effect", "update_another_solver", "posterior"]


def cells_of(text: str) -> list[dict[str, Any]]:
    """The cells of a script: `# %% [markdown]` and `# %%` begin them, as editors and jupytext read them."""
    cells: list[dict[str, Any]] = []
    for k, part in enumerate(("\n" + text).split("\n# %%")[1:]):
        head, _, body = part.partition("\n")
        lines = body.strip("\n").split("\n")
        if head.strip() == "[markdown]":
            lines = [line.removeprefix("#").removeprefix(" ") for line in lines]
        source = [line + "\n" for line in lines[:-1]] + lines[-1:]
        cell: dict[str, Any] = {"cell_type": "markdown", "id": f"cell-{k}", "metadata": {}, "source": source}
        if head.strip() != "[markdown]":
            cell |= {"cell_type": "code", "execution_count": None, "outputs": []}
        cells.append(cell)
    return cells


def notebook_of(name: str) -> str:
    """The text of a notebook, without outputs."""
    content = {
        "cells": cells_of((FOLDER / "examples" / f"{name}.py").read_text(encoding="utf-8")),
        "metadata": {
            "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
            "language_info": {"name": "python"},
        },
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_is_its_example(name: str) -> None:
    path = FOLDER / "notebooks" / f"{name}.ipynb"
    if os.environ.get("RETUNE_WRITE"):
        path.parent.mkdir(exist_ok=True)
        path.write_text(notebook_of(name), encoding="utf-8")
    if not (FOLDER / "examples").is_dir():
        pytest.skip("skipped: the examples are not here")
    assert path.read_text(encoding="utf-8") == notebook_of(name), "RETUNE_WRITE=1 pytest python/tests/test_notebooks.py writes it anew"


PROMISED = {
    "universal_file_to_effect": ["<iframe", "MAC: model Hz by test mode", "<svg", "point-mass@mid_left"],
    "update_another_solver": ["90 % interval", "solver: by_"],
    "posterior": ["ln Z = ", "between runs"],
}


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_runs(name: str, tmp_path: Path) -> None:
    nbclient = pytest.importorskip("nbclient", reason="skipped: `nbclient` is not here")
    pytest.importorskip("ipykernel", reason="skipped: `ipykernel` is not here")
    nbformat = pytest.importorskip("nbformat")
    path = FOLDER / "notebooks" / f"{name}.ipynb"
    if not path.exists():
        pytest.skip(f"skipped: {path} is not here")
    book = nbformat.read(path, as_version=4)
    nbformat.validate(book)
    client = nbclient.NotebookClient(book, timeout=600, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}})
    client.execute()
    shown = json.dumps([cell.get("outputs", []) for cell in book.cells], ensure_ascii=False)
    for what in PROMISED[name]:
        assert what in shown, what
    # For eyes: where a folder is named, the notebook with its outputs.
    if folder := os.environ.get("RETUNE_NOTEBOOKS"):
        nbformat.write(book, Path(folder) / f"{name}.ipynb")
