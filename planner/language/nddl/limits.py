"""`set_capacity` and `set_limit`: the limits of a resource, for all time or for a part of it.

    r.set_capacity(4.0);            r.set_limit(1.0, 9.0);             at all times
    r.set_capacity(10, 4.0);        r.set_limit(10, 1.0, 9.0);         from a tick on
    r.set_capacity(10, 20, 4.0);    r.set_limit(10, 20, 1.0, 9.0);     from a tick on, until another

They are carried out with the creation of objects, so that a resource has its limits before there is a plan.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from planner.errors import nearest
from planner.language.nddl.errors import Complaint
from planner.language.nddl.objects import Objects
from planner.language.nddl.syntax import Method
from planner.language.nddl.values import is_number
from planner.model.classes import ModelObject

METHODS = {
    "set_capacity": ("capacity",),
    "set_limit": ("level_min", "level_max"),
    "setLimit": ("level_min", "level_max"),
}
_BEGINNING = -(10**12)
"""A tick before all others."""
Pairs = tuple[tuple[float, float], ...]


def set_limits(node: Method, objects: Objects) -> None:
    """Carry out one of these methods."""
    thing = _resource(node, objects)
    members = METHODS[node.method]
    values = [objects.value(argument, None, {}) for argument in node.arguments]
    numbers = [value for value in values if is_number(value)]
    times = len(values) - len(members)
    if not 0 <= times <= 2 or len(numbers) < len(values):
        limits = " and ".join(members)
        raise Complaint(node.at, f"{node.method}: expected up to 2 ticks, then {limits}, all of them numbers")
    span = [*numbers[:times], math.inf] if times else [-math.inf, math.inf]
    start, end = span[0], span[1]
    if any(math.isfinite(tick) and tick != int(tick) for tick in (start, end)) or start >= end:
        raise Complaint(node.at, f"{node.method}: expected ticks in increasing order, found {start:g} and {end:g}")
    for member, value in zip(members, numbers[times:], strict=True):
        if member not in objects.model.members_of(thing.cls):
            raise Complaint(node.at, f"{node.method}: {thing.cls} has no {member}")
        objects.model.set_member(thing, member, _changed(thing.members.get(member), start, end, value))


def _resource(node: Method, objects: Objects) -> ModelObject:
    name = ".".join(node.path)
    found = objects.named(node.path, node.at)
    if not isinstance(found, ModelObject):
        raise Complaint(
            node.at, f"expected a resource, found {name!r}, which is none{nearest(name, objects.model.objects)}"
        )
    if not any(objects.symbols.is_subclass(found.cls, cls) for cls in ("CBReusable", "Reservoir")):
        raise Complaint(node.at, f"{node.method}: {name} is a {found.cls}, expected a resource")
    return found


def _changed(before: object, start: float, end: float, value: float) -> float | Pairs:
    """A limit with another value between two ticks."""
    if start == -math.inf and end == math.inf:
        return value
    pairs: Sequence[tuple[float, float]]
    if is_number(before):
        pairs = ((_BEGINNING, before),)
    else:
        pairs = before if isinstance(before, tuple) else ((_BEGINNING, 0.0),)
    after = [v for tick, v in pairs if tick <= end][-1]
    kept = [(tick, v) for tick, v in pairs if tick < start or tick > end]
    added = [(start, value)] + ([(end, after)] if end < math.inf else [])
    return tuple(sorted([*kept, *added]))
