"""Constraints that say something about timepoints alone, posted as temporal constraints: stronger than bounds.

A constraint procedure sees only the bounds of a timepoint. Where the relation is a distance between two timepoints,
the temporal network knows it exactly, so `leq(a.end, b.start)` becomes an edge and not a procedure.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

from planner.constraints.network import (
    AnyVariable,
    ConstraintNetworkManager,
    DurationVariable,
    Owner,
    TimeVariable,
    Variable,
)
from planner.constraints.standard import EQUAL
from planner.domains import Interval

Form = Callable[[ConstraintNetworkManager, Sequence[AnyVariable], Owner], bool]


def post_temporal(network: ConstraintNetworkManager, name: str, scope: Sequence[AnyVariable], owner: Owner) -> bool:
    """Post the constraint of that name as temporal ones if it is one; False when a procedure must do it."""
    form = FORMS.get(name)
    return form is not None and form(network, scope, owner)


def _within(lower: float, upper: float) -> Form:
    def post(network: ConstraintNetworkManager, scope: Sequence[AnyVariable], owner: Owner) -> bool:
        times = [variable for variable in scope if isinstance(variable, TimeVariable)]
        if len(times) < len(scope):
            return False
        for first, second in pairwise(times):
            network.distance(first, second, lower, upper, owner)
        return True

    return post


def _temporal_distance(network: ConstraintNetworkManager, scope: Sequence[AnyVariable], owner: Owner) -> bool:
    """`from + distance = to` with the distance in the middle, as in temporalDistance and addEq."""
    if len(scope) != 3:
        return False
    from_, distance, to = scope
    if not (isinstance(from_, TimeVariable) and isinstance(to, TimeVariable)) or isinstance(distance, TimeVariable):
        return False
    domain = distance.domain
    if domain.is_open or not domain.is_numeric:
        return False
    if domain.is_singleton and isinstance(distance, Variable) and distance.latest < 0:
        network.distance(from_, to, domain.lower, domain.upper, owner)
    else:
        # What the domain is now has reasons of its own, which an edge of this owner would hide.
        between = DurationVariable("distance", from_, to, Interval(-math.inf, math.inf), owner)
        network.post(EQUAL, (distance, between), owner)
    return True


FORMS: dict[str, Form] = {
    "eq": _within(0, 0),
    "concurrent": _within(0, 0),
    "leq": _within(0, math.inf),
    "precedes": _within(0, math.inf),
    "lt": _within(1, math.inf),
    "strictlyPrecedes": _within(1, math.inf),
    "temporalDistance": _temporal_distance,
    "addEq": _temporal_distance,
}
