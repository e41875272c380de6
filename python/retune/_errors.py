"""What goes wrong, and what is told."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

_Row = tuple[str, str, "int | None", "int | None", str]


@dataclass(frozen=True)
class Problem:
    """One problem of a file, with its place."""

    severity: Literal["error", "warning"]
    """Whether the file can be used in spite of it."""
    key: str
    """Where in the file: ``beams.blade.section``."""
    line: int | None
    """Line, from 1."""
    column: int | None
    """Column, from 1."""
    message: str
    """What is wrong, what was expected, and the nearest right word."""


def problems_of(rows: Iterable[_Row]) -> list[Problem]:
    """Problems from rows of the extension module."""
    return [
        Problem("error" if severity == "error" else "warning", key, line, column, message)
        for severity, key, line, column, message in rows
    ]


class RetuneError(Exception):
    """There is no result, and why.

    >>> import retune
    >>> try:
    ...     retune.Model.from_text("retune: 1\\nname: a\\nnodes: {a: [0, 0, 0]}\\nmases: {}\\n")
    ... except retune.RetuneError as e:
    ...     print(e.line, "masses" in str(e))
    4 True
    """

    def __init__(self, message: str, *, path: str | None = None, problems: Iterable[_Row] = ()) -> None:
        super().__init__(message)
        self._message = message
        self._rows = list(problems)
        self.path: str | None = path
        """The file, where there is one."""
        self.problems: list[Problem] = problems_of(self._rows)
        """Every problem of the file, errors first."""

    @property
    def line(self) -> int | None:
        """Line of the first problem that has one."""
        return next((p.line for p in self.problems if p.line is not None), None)

    @property
    def column(self) -> int | None:
        """Column of the first problem that has one."""
        return next((p.column for p in self.problems if p.column is not None), None)

    @property
    def key(self) -> str | None:
        """Where in the file the first problem stands: ``beams.blade.section``."""
        return next((p.key for p in self.problems if p.key), None)

    def __reduce__(self) -> tuple[object, ...]:
        # Errors travel between the processes of a cluster.
        return (_raise_again, (self._message, self.path, self._rows))


def _raise_again(message: str, path: str | None, rows: list[_Row]) -> RetuneError:
    return RetuneError(message, path=path, problems=rows)


class RetuneWarning(UserWarning):
    """Something is doubtful: a unit, a configuration, a sensor."""


def tell(remarks: Iterable[tuple[str, str]], stacklevel: int = 3) -> list[str]:
    """Warns of warnings, and gives the notes."""
    notes: list[str] = []
    for category, text in remarks:
        if category == "warning":
            warnings.warn(text, RetuneWarning, stacklevel=stacklevel)
        else:
            notes.append(text)
    return notes
