"""Numbers of which a variable has endlessly many left: given a value once a plan is complete, where one is found.

A search decides what has finitely many values. What narrows an interval by its bounds does not promise that all of
the interval, or any of it, keeps a relation; a value does.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from planner.constraints.network import Inconsistency, Variable
from planner.database import PlanDatabase
from planner.domains import Interval
from planner.search.flaws import next_flaw

ARBITRARY = "a value for what the plan leaves open"
"""The owner of such an assignment."""


def assign_endless(database: PlanDatabase) -> None:
    """Give each number that a complete plan leaves open the first value tried that keeps the plan complete.

    As an acceptance of a search it refuses nothing: a number for which none of the values tried is right stays open.
    """
    for variable in list(database.tokens.still_undecided()):
        domain = variable.domain
        if isinstance(domain, Interval) and not domain.is_singleton:
            any(_assigned(database, variable, value) for value in _values(domain))


def _assigned(database: PlanDatabase, variable: Variable, value: float) -> bool:
    integer = variable.domain.integer if isinstance(variable.domain, Interval) else False
    tokens = database.tokens
    before, level = (len(tokens.tokens), len(tokens.undecided)), database.trail.push()
    try:
        database.network.restrict(variable, Interval(value, value, integer), ARBITRARY)
        database.network.propagate()
        if (len(tokens.tokens), len(tokens.undecided)) == before or next_flaw(database) is None:
            return True
    except Inconsistency:
        pass
    database.trail.pop_to(level)
    return False


def _values(domain: Interval) -> Iterator[float]:
    """A few values of an interval: the ends that it has, zero, the middle, those beside the ends."""
    whole = int if domain.integer else float
    ends = [end for end in (domain.lower, domain.upper) if math.isfinite(end)]
    found = [*ends, 0.0]
    found += [math.fsum(ends) / 2] if len(ends) == 2 else []
    found += [end + step for end in ends or [0.0] for step in (1.0, -1.0)]
    for value in dict.fromkeys(whole(value) for value in found):
        if domain.lower <= value <= domain.upper:
            yield value
