"""An effect of the user's own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from . import _core
from ._convert import dumps
from ._own import Own

if TYPE_CHECKING:
    from ._model import Model

Kind = Literal["node", "element", "chain", "group", "mass", "pair", "end", "whole"]


@dataclass(frozen=True)
class Node:
    """A node of a structure."""

    position: tuple[float, float, float]
    """m."""
    dofs: tuple[str, ...]
    """Those of ``ux`` ... ``rz`` that move."""
    is_supported: bool
    """Whether a support holds it in a direction in which others move."""


@dataclass(frozen=True)
class Part:
    """A named part of a structure: a member, an element, a group, a point mass."""

    name: str
    kind: Literal["element", "chain", "group", "mass"]
    nodes: tuple[str, ...]
    """Nodes of the file that it joins."""
    is_member: bool
    """Whether it is a whole member of beams."""
    partner: str | None
    """Its mirror image."""


@dataclass(frozen=True)
class Structure:
    """A model as an effect sees it."""

    nodes: Mapping[str, Node]
    """Nodes of the file."""
    parts: Sequence[Part]
    """Its parts, in file order."""
    total_mass: float
    """kg."""
    extent: float
    """Its largest dimension, m."""
    omega2: float
    """Square of a characteristic angular frequency, rad²/s²: an order of magnitude, for typical sizes."""
    sensors: Sequence[str]
    """Nodes that carry sensors of the test."""
    frequencies: Sequence[float]
    """Frequencies of the test, Hz."""

    def part(self, name: str) -> Part:
        """The part of a name."""
        return next(p for p in self.parts if p.name == name)


@dataclass(frozen=True)
class Location:
    """Where an effect acts: names of the file, several where symmetric partners share its sizes, and a direction where one matters."""

    names: tuple[str, ...]
    """Names of nodes or parts."""
    kind: Kind = "node"
    """What they are."""
    direction: str | None = None
    """A dof such as ``"uz"``, an axis, or a word of the effect."""

    def __str__(self) -> str:
        place = "+".join(self.names) or "whole"
        return place if self.direction is None else f"{place}.{self.direction}"


@dataclass(frozen=True)
class Size:
    """A number of an effect, which is fitted."""

    unit: str
    """SI unit; ``"1"`` for a pure number."""
    typical: float
    """A size that an engineer would expect."""
    bounds: tuple[float, float]
    """Between which it may be."""
    neutral: float = 0.0
    """The value at which the model is unchanged."""
    description: str = ""
    """What it is."""
    starts: Sequence[float] = ()
    """Other sizes worth a start."""


class Effect(Own[_core.OwnEffect]):
    """A physical effect as a Python class: a hypothesis of what models lack. Subclass it, and give it to ``diagnose`` and ``learn``.

    ``locations`` says where on a structure it could act, ``sizes`` what is estimated there, ``entries`` what it adds to the model file: at
    the neutral sizes the model must be unchanged.

    >>> import retune
    >>> class TankLiquid(Effect):
    ...     '''Liquid left in a tank: mass without a moment of inertia, wherever the file has a mass.'''
    ...     name = "tank-liquid"
    ...     summary = "Liquid left in a tank at a node: mass without a moment of inertia of its own."
    ...     signature = "Lowers modes with motion of the tank."
    ...     formulation = "M gains m u² at the node of the tank; m = 0 leaves it."
    ...     confusable = ("point-mass",)
    ...     def locations(self, structure):
    ...         return [Location((p.name,), "mass") for p in structure.parts if p.kind == "mass"]
    ...     def sizes(self, structure, at):
    ...         return {"mass": Size("kg", 0.05, (0.0, 0.5), description=f"liquid in the tank at {at}")}
    ...     def entries(self, structure, at, sizes):
    ...         [node] = structure.part(at.names[0]).nodes
    ...         return {"masses": {"": {"node": node, "mass": sizes["mass"]}}}
    >>> model = retune.Model({"retune": 1, "name": "tank on a spring", "nodes": {"a": [0, 0, 0]}, "active_dofs": ["uz"],
    ...     "springs": {"s": {"node": "a", "k": {"uz": "100 N/m"}}}, "masses": {"tank": {"node": "a", "mass": "1 kg"}}})
    >>> added = model.add(TankLiquid(), at="tank")
    >>> list(added.parameters)
    ['tank_liquid.tank.mass']
    >>> full = added.with_values({"tank_liquid.tank.mass": 0.21})  # f ~ 1/√m
    >>> float(round((model.modes(n=1).frequencies / full.modes(n=1).frequencies)[0], 12))
    1.1
    """

    name: str = ""
    """Its name, ``kebab-case``."""
    summary: str = ""
    """One or two sentences: what it is."""
    signature: str = ""
    """Its trace in the data: which modes move and which do not."""
    formulation: str = ""
    """The equation, the sizes and their neutral values."""
    confusable: Sequence[str] = ()
    """Names of effects that look alike."""
    references: Sequence[str] = ()
    """Author, title, year."""
    belongs_to: Literal["structure", "support", "rig"] = "structure"
    """What it belongs to: between configurations, the supports and the rig differ."""
    needs_sensors: bool = False
    """Whether it acts where the sensors of a test stand."""

    def locations(self, structure: Structure) -> Sequence[Location]:
        """Where it could act, in file order; only where its typical size changes K, M or C."""
        raise NotImplementedError

    def sizes(self, structure: Structure, at: Location) -> Mapping[str, Size]:
        """What is estimated at one of its locations, by quantity: ``{"mass": Size(...)}``."""
        raise NotImplementedError

    def entries(self, structure: Structure, at: Location, sizes: Mapping[str, str]) -> Mapping[str, Mapping[str, Any]]:
        """What it adds to the model file: ``{"masses": {"": {"node": "tip", "mass": sizes["mass"]}}}``.

        Blocks are ``nodes``, ``masses``, ``springs``, ``elements``, ``overrides``, ``rigid_links`` and ``supports``. An entry is called
        after the effect and the place; the keys tell several apart, and may be empty for one.

        * ``sizes``: names of the parameters of ``sizes``, by quantity, as entries refer to them
        """
        raise NotImplementedError

    def check(self, model: Model) -> list[str]:
        """What it breaks on a model of the contract of every effect, a sentence each: texts that say what it is, sizes inside their bounds, the
        unchanged model at the neutral sizes, another one at the typical ones, entries that are taken out again to the byte.
        """
        return model._inner.check_effect(self._core())

    def _counterpart(self) -> _core.OwnEffect:
        return _core.OwnEffect(
            (self.name, self.summary, self.signature, self.formulation),
            list(self.confusable),
            list(self.references),
            self.belongs_to,
            self.needs_sensors,
            self._locations,
            self._patch,
        )

    def _locations(self, seen: dict[str, Any]) -> list[tuple[str, list[str], str | None]]:
        return [(at.kind, list(at.names), at.direction) for at in self.locations(_structure(seen))]

    def _patch(self, seen: dict[str, Any], place: tuple[Kind, list[str], str | None]) -> str:
        structure = _structure(seen)
        at = Location(tuple(place[1]), place[0], place[2])
        word = str(at).replace("+", "_and_")
        stem = f"{self.name.replace('-', '_')}.{''.join(c if c.isalnum() or c in '_.:' else '_' for c in word)}"
        sizes = self.sizes(structure, at)
        names = {quantity: f"{stem}.{quantity}" for quantity in sizes}
        edits: list[dict[str, Any]] = [
            {
                "add_parameter": {
                    "name": names[quantity],
                    "unit": size.unit,
                    "neutral": float(size.neutral),
                    "typical": float(size.typical),
                    "bounds": [float(b) for b in size.bounds],
                    "grid": [float(v) for v in size.starts],
                    "description": size.description,
                }
            }
            for quantity, size in sizes.items()
        ]
        for block, entries in self.entries(structure, at, names).items():
            if block not in _EDITS:
                raise ValueError(f"it adds to `{block}`; an effect adds to {', '.join(_EDITS)}")
            edits += [{_EDITS[block]: {"name": f"{stem}.{key}" if key else stem, "entry": entry}} for key, entry in entries.items()]
        return dumps({"edits": edits})


_EDITS = {
    "nodes": "add_node",
    "masses": "add_mass",
    "springs": "add_spring",
    "elements": "add_element",
    "overrides": "add_override",
    "rigid_links": "add_rigid_link",
    "supports": "add_support",
}


def _structure(seen: dict[str, Any]) -> Structure:
    return Structure(
        {name: Node(tuple(position), tuple(dofs), held) for name, position, dofs, held in seen["nodes"]},
        [Part(name, kind, tuple(nodes), is_member, partner) for name, kind, nodes, is_member, partner in seen["parts"]],
        seen["total_mass"],
        seen["extent"],
        seen["omega2"],
        seen["sensors"],
        seen["frequencies"],
    )
