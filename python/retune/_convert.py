"""Arguments of users on their way to the extension module."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._errors import RetuneError

if TYPE_CHECKING:
    from ._external import ParametricModel
    from ._model import Model
    from ._test import Test

Floats = npt.NDArray[np.float64]
Complexes = npt.NDArray[np.complex128]
PathLike = Union[str, "os.PathLike[str]"]
Theta = Union[Mapping[str, float], npt.ArrayLike, None]
Tests = Union["Test", PathLike, Sequence[Union["Test", PathLike]]]

AXES = {
    f"{sign}{axis}": tuple((-1.0 if sign == "-" else 1.0) * float(i == k) for i in range(3))
    for k, axis in enumerate("xyz")
    for sign in ("+", "-", "")
}


def direction_of(direction: str | npt.ArrayLike) -> list[float]:
    """A signed axis, ``"+z"``, or a vector, as a unit vector."""
    if isinstance(direction, str):
        if direction not in AXES:
            raise ValueError(f"direction is {direction!r}; it is +x, -x ... -z, or a vector")
        return list(AXES[direction])
    vector = np.asarray(direction, dtype=np.float64)
    norm = float(np.linalg.norm(vector)) if vector.shape == (3,) else 0.0
    if not (np.isfinite(norm) and norm > 0.0):
        raise ValueError(f"direction is {direction!r}; it is +x, -x ... -z, or a vector of three numbers, not zero")
    return [float(v) for v in vector / norm]


def vector(values: npt.ArrayLike, what: str) -> Floats:
    """A vector of numbers."""
    out = np.asarray(values, dtype=np.float64)
    if out.ndim != 1:
        raise ValueError(f"{what} has the shape {out.shape}; it is a vector")
    return out


def text_of(value: str | Mapping[str, Any] | None) -> str | None:
    """YAML text, or what it would say as a dict."""
    return value if value is None or isinstance(value, str) else _core.yaml_of_json(dumps(value))


def dumps(value: object) -> str:
    """JSON of a dict that may hold NumPy numbers and arrays."""

    def other(item: object) -> object:
        if isinstance(item, (np.ndarray, np.generic)):
            return item.tolist()
        raise TypeError(f"{type(item).__name__} has no place in a model or test file")

    return json.dumps(value, default=other, allow_nan=False)


def part_of(text: str) -> tuple[int, int]:
    """A part of several, counted from 1.

    >>> part_of("3/8")
    (3, 8)
    """
    index, slash, of = text.partition("/")
    if not (slash and index.strip().isdigit() and of.strip().isdigit()):
        raise ValueError(f"shard is {text!r}: a part of several is expected, counted from 1: 3/8")
    return int(index), int(of)


def percent_of(value: float | str) -> str:
    """A share as it stands in a test file: ``"0.3 %"`` as it is, 0.003 as text."""
    return value if isinstance(value, str) else repr(float(value))


def model_of(model: Model | PathLike) -> _core.Model:
    """A model, or the path of its file."""
    from ._model import Model

    return (model if isinstance(model, Model) else Model.from_file(model))._inner


def parametric_of(model: Model | ParametricModel | PathLike) -> _core.Model | _core.External:
    """The same, or a model around another solver."""
    from ._external import ParametricModel

    return model._inner if isinstance(model, ParametricModel) else model_of(model)


def tests_of(tests: Tests) -> list[_core.Test]:
    """One test or several, or the paths of their files."""
    from ._test import Test

    if isinstance(tests, (Test, str, os.PathLike)):
        tests = [tests]
    out = [(t if isinstance(t, Test) else Test.from_file(t))._inner for t in tests]
    if not out:
        raise RetuneError("there is no test")
    return out
