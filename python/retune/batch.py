"""Many diagnoses or updates, on one machine or a cluster: each result is a file that is named by what it was made of.

A job is a verb, a model, tests and options. Its name is the hash of the texts of its files, its options and the version of retune; its
result is written whole or not at all under that name. A job that has been killed is done again, one that has been finished is not, whoever
runs it and wherever; what is merged is the same to the byte as what one process makes alone.

From a program, with any engine that maps a function over a list:

>>> import tempfile
>>> import retune
>>> model = retune.Model({"retune": 1, "name": "mass on a spring", "nodes": {"a": [0, 0, 0]}, "active_dofs": ["uz"],
...     "parameters": {"k": {"value": "100 N/m", "bounds": ["10 N/m", "1000 N/m"]}},
...     "springs": {"s": {"node": "a", "k": {"uz": "k"}}}, "masses": {"b": {"node": "a", "mass": "1 kg"}}})
>>> jobs = [Job("update", model, [retune.Test.from_arrays([f], frequency_sd=0.01)]) for f in (1.9, 2.0, 2.1)]
>>> with tempfile.TemporaryDirectory() as folder:
...     for job in shard(jobs, 1, 2):
...         _ = run(job, folder)
...     missing = [len(pending(jobs, folder))]
...     for job in pending(jobs, folder):
...         _ = run(job, folder)
...     results = merge(jobs, folder)
>>> missing, [round(r["result"]["parameters"][0]["after"], 1) for r in results]
([1], [142.5, 157.9, 174.1])

From a shell, or the array of a queue, ``retune batch`` does the same for one model and a test a job.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import tempfile
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from . import _core, _verbs
from ._convert import PathLike
from ._errors import RetuneError, RetuneWarning
from ._model import Model
from ._test import Test

Verb = Literal["compare", "diagnose", "learn", "sample", "update"]
VERBS: tuple[Verb, ...] = ("compare", "diagnose", "learn", "sample", "update")


@dataclass(frozen=True)
class Job:
    """One call of a verb. It can be pickled: models and tests travel as the texts of their files."""

    verb: Verb
    """What is done."""
    model: Model
    """The model."""
    tests: Sequence[Test]
    """The tests."""
    options: dict[str, Any] = field(default_factory=dict)
    """Keyword arguments of the verb, as JSON can hold them: `{"seed": 3}`. Members of one's own have no place here: what their code does is
    no part of a hash."""

    @property
    def key(self) -> str:
        """SHA-256 of everything that the result depends on, as hexadecimal digits.

        Files that a model or test names are part of it by their bytes, as far as they lie in its folder.
        """
        content = {
            "version": _core.__version__,
            "verb": self.verb,
            "model": _said(self.model),
            "configuration": self.model.configuration,
            "elements": [f"{type(e).__module__}.{type(e).__qualname__}" for e in self.model.elements],
            "tests": [_said(test) for test in self.tests],
            "options": self.options,
        }
        text = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
        return hashlib.sha256(text.encode()).hexdigest()


def _said(thing: Model | Test) -> dict[str, Any]:
    """The text of a file, and the hashes of the files that it names."""
    text = thing.to_yaml()
    named: dict[str, str] = {}
    if thing.path is not None:
        folder = Path(thing.path).parent
        for word in sorted(set(re.findall(r"[\w./+-]+\.\w+", text))):
            file = folder / word
            if file.is_file():
                named[word] = hashlib.sha256(file.read_bytes()).hexdigest()
    return {"text": text, "files": named}


def shard(jobs: Sequence[Job], index: int, of: int) -> list[Job]:
    """Every `of`-th job from the `index`-th on, from 1: together the shards are all jobs, each once."""
    if not 1 <= index <= of:
        raise ValueError(f"shard {index}/{of}: the shards of {of} are 1/{of} ... {of}/{of}")
    return list(jobs[index - 1 :: of])


def _path(job: Job, folder: PathLike) -> Path:
    return Path(folder) / f"{job.key}.json"


def pending(jobs: Sequence[Job], folder: PathLike) -> list[Job]:
    """The jobs whose results are not there yet, each once."""
    seen: set[str] = set()
    out = []
    for job in jobs:
        key = job.key
        if key not in seen and not _path(job, folder).exists():
            out.append(job)
        seen.add(key)
    return out


def run(job: Job, folder: PathLike) -> str:
    """Does a job, unless its result is there, and gives its key.

    A call that has no result is a result, too: what was wrong. Only what stops a process leaves nothing behind.
    """
    path = _path(job, folder)
    if path.exists():
        return path.stem
    content: dict[str, Any] = {"key": path.stem, "verb": job.verb, "tests": [test.name for test in job.tests]}
    try:
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", RetuneWarning)
            result = getattr(_verbs, job.verb)(job.model, list(job.tests), **job.options)
        content |= {"result": result.to_dict(), "error": None}
        content["warnings"] = [str(w.message) for w in told if issubclass(w.category, RetuneWarning)]
    except RetuneError as e:
        content |= {"result": None, "error": str(e), "warnings": []}
    Path(folder).mkdir(parents=True, exist_ok=True)
    text = json.dumps(content, separators=(",", ":"), ensure_ascii=False) + "\n"
    # A name appears with all that belongs to it, or not at all; two that do the same job write the same.
    handle, temporary = tempfile.mkstemp(prefix=".part-", dir=folder)
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise
    return path.stem


def merged(jobs: Sequence[Job], folder: PathLike) -> bytes:
    """The results in the order of the jobs, a line of JSON each: the same bytes whoever ran them.

    Raises `RetuneError` where results are missing, and says how many.
    """
    missing = pending(jobs, folder)
    if missing:
        raise RetuneError(f"{len(missing)} of {len(jobs)} jobs have no result in {os.fspath(folder)}, the first is {missing[0].key}")
    return b"".join(_path(job, folder).read_bytes() for job in jobs)


def merge(jobs: Sequence[Job], folder: PathLike) -> list[dict[str, Any]]:
    """`merged`, read."""
    return [json.loads(line) for line in merged(jobs, folder).splitlines()]
