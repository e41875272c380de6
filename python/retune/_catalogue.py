"""What there is: the lists of the command."""

from __future__ import annotations

from typing import Literal

from . import _core


def catalogue(of: Literal["effects", "elements", "faults", "optimizers", "residuals"]) -> list[str]:
    """Names of the built-in members of a list, as ``retune list`` prints them.

    >>> "point-mass" in catalogue("effects"), "beam" in catalogue("elements")
    (True, True)

    Beside a member of one's own: ``diagnose(model, test, effects=[*catalogue("effects"), MyEffect()])``.
    """
    return _core.catalogue(of)


__all__ = ["catalogue"]
