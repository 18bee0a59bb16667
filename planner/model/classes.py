"""What a domain model is made of (paper, section 2): classes, attributes, predicates, objects, as plain values."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from planner.domains import Domain, Interval
from planner.model.rules import Rule, Statement

# What tokens of an attribute mean to each other: on a timeline they are in total order; on an `unordered` attribute
# each stands alone; on a resource each is a transaction.
Kind = Literal["timeline", "unordered", "reusable", "reservoir"]

Type = str | Domain
"""The name of a basic type (int, float, bool, string), enumeration or class, or a domain written out."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of a predicate and the values it may take."""

    name: str
    type: Type


@dataclass(frozen=True, slots=True)
class Predicate:
    """A value pattern of an attribute. `body`: its parameter constraints, which hold for every token of it.

    `duration`: bounds in ticks. `contingent`: nature decides the duration, within its bounds. `exogenous`: no plan can
    bring it about; it holds where the problem says so, and other tokens may only be codesignated with it. `solitary`:
    no two tokens of it are ever codesignated: each use of a resource is one of its own.
    """

    cls: str
    name: str
    attribute: str
    parameters: tuple[Parameter, ...] = ()
    body: tuple[Statement, ...] = ()
    duration: tuple[float, float] = (1, float("inf"))
    contingent: bool = False
    exogenous: bool = False
    solitary: bool = False

    @property
    def full_name(self) -> str:
        """`Class.predicate`."""
        return f"{self.cls}.{self.name}"


@dataclass(frozen=True, slots=True)
class Attribute:
    """A part of the world that changes over time; every object of the class has one timeline for it."""

    name: str
    kind: Kind = "timeline"


@dataclass(slots=True)
class ModelClass:
    """A named set of attributes and members, with what it inherits from its parent left out."""

    name: str
    parent: str | None
    attributes: dict[str, Attribute] = field(default_factory=dict)
    members: dict[str, Type] = field(default_factory=dict)
    predicates: dict[str, Predicate] = field(default_factory=dict)
    rules: dict[str, list[Rule]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False, slots=True)
class ModelObject:
    """An instance of a model class. `members`: a value, another object, or a domain of which one value holds.

    `parent`: the object that it is part of, or None.
    """

    name: str
    cls: str
    members: dict[str, Any] = field(default_factory=dict)
    parent: ModelObject | None = None

    def __repr__(self) -> str:
        return self.name

    def __str__(self) -> str:
        return self.name


def objects_in(domain: Domain) -> list[ModelObject]:
    """The model objects among a domain's values, in its order."""
    return [] if isinstance(domain, Interval) else [v for v in domain.values() if isinstance(v, ModelObject)]
