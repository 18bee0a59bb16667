"""The classes of resources that every model has, as data.

A resource has a level that transactions change in steps. Its members are numbers; those marked *steps* below may
instead be a sequence of (tick, value) pairs in increasing order of ticks, each value holding from its tick on, the
first one before it too.

- `CBReusable`: `capacity` (steps), `level_min` = 0 (steps), `consumption_rate_max`. A rule's constraint
  `uses(resource, quantity, start, end)` takes a quantity from start to end. The level is the capacity less what is in
  use; it may not fall below `level_min`.
- `Reusable`: the same, and a predicate `uses{quantity}` whose tokens take at their start and give back at their end.
- `Unary`: capacity 1, and a predicate `use{}` whose tokens take all of it.
- `UnaryResource`: a timeline with the predicate `uses{}`.
- `Reservoir`: `initial`, `level_min` = 0 (steps), `level_max` (steps), `production_rate_max` and `consumption_rate_max`
  (steps), `production_max`, `consumption_max`; predicates `produce{quantity}` and `consume{quantity}`, whose tokens are
  instants. A rate is what is produced, or consumed, at one tick; the sums are over the whole plan.

At a tick where several transactions meet, only the level after all of them counts: what is given back at a tick can be
taken at that tick. `profile` says for which schedules the level must hold: `envelope` (the default), all that the
flexible plan allows, or `grounded`, the one of earliest times.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from planner.constraints.procedure import ConstraintProcedure
from planner.domains import Domain, Interval
from planner.model.classes import Attribute, Kind, ModelClass, Parameter, Type

if TYPE_CHECKING:
    from planner.model.manager import ModelManager

LEVEL = "level"
"""The attribute of a resource on which its transactions are."""
ENVELOPE, GROUNDED = "envelope", "grounded"
PROFILES = (ENVELOPE, GROUNDED)

_REUSABLE: dict[str, Type] = {
    "capacity": "float",
    "level_min": "float",
    "consumption_rate_max": "float",
    "profile": "string",
}
_RESERVOIR: dict[str, Type] = {
    "initial": "float",
    "level_min": "float",
    "level_max": "float",
    "production_rate_max": "float",
    "consumption_rate_max": "float",
    "production_max": "float",
    "consumption_max": "float",
    "profile": "string",
}
_CLASSES: tuple[tuple[str, str, Kind | None, dict[str, Type]], ...] = (
    ("CBReusable", "Object", "reusable", _REUSABLE),
    ("Reusable", "CBReusable", None, {}),
    ("Unary", "CBReusable", None, {"capacity": Interval(1, 1)}),
    ("UnaryResource", "Timeline", None, {}),
    ("Reservoir", "Object", "reservoir", _RESERVOIR),
)


def _uses(domains: Sequence[Domain]) -> Sequence[Domain]:
    """(resource, quantity, start, end): the quantity is taken from the resource at start and given back at end."""
    return domains


USES = ConstraintProcedure("uses", _uses, 4, 4)
"""Stands in a model for the transaction, which narrows nothing by itself: the token network posts it."""


def resource_classes() -> list[ModelClass]:
    """The classes, without their predicates."""
    classes = []
    for name, parent, kind, members in _CLASSES:
        found = ModelClass(name, parent, members=dict(members))
        if kind is not None:
            found.attributes[LEVEL] = Attribute(LEVEL, kind)
        classes.append(found)
    return classes


def add_resource_predicates(model: ModelManager) -> None:
    """The predicates of the classes: what transactions are."""
    quantity = Parameter("quantity", Interval(0, math.inf, integer=False))
    model.add_predicate("Reusable", "uses", (quantity,), attribute=LEVEL)
    model.add_predicate("Unary", "use", (), attribute=LEVEL)
    model.add_predicate("UnaryResource", "uses", (), solitary=True)
    for name in ("produce", "consume"):
        model.add_predicate("Reservoir", name, (quantity,), attribute=LEVEL, duration=(0, 0))
