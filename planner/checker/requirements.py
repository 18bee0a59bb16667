"""Whether a required relation holds in every schedule of the plan.

Between timepoints a relation is a distance, which the network decides exactly. Otherwise the constraint procedure
decides on assigned values; where it speaks of times that the plan leaves open, it must hold in the earliest and the
latest schedule and, for each duration, in the earliest one that makes it longest and the latest one that makes it
shortest: necessary in general, and sufficient for relations that hold in between wherever they hold at the extremes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from planner.checker.expressions import UNBOUNDED, Expressions, Names, Path, Quantity, Times, Wanted
from planner.checker.view import Slot
from planner.domains import Domain, Interval
from planner.model.relations import Distance, distances
from planner.model.rules import Expression, Ref

FORMS = {
    "eq": (0.0, 0.0),
    "concurrent": (0.0, 0.0),
    "leq": (0.0, math.inf),
    "precedes": (0.0, math.inf),
    "lt": (1.0, math.inf),
    "strictlyPrecedes": (1.0, math.inf),
}

Point = int | tuple[str, str]
"""A timepoint of the plan's network, or the (name, start or end) of a token that the plan need not have."""


@dataclass(frozen=True, slots=True)
class Link:
    """`minimum <= to - from_ <= maximum`."""

    from_: Point
    to: Point
    minimum: float
    maximum: float


class Requirements:
    """Judges relations over the expressions of one token's configuration constraint."""

    def __init__(self, expressions: Expressions) -> None:
        self.expressions = expressions
        self.network = expressions.view.network

    def point(self, token: Slot | Wanted, which: str) -> Point:
        """A token's start or end."""
        return self.network.point(token.id, which) if isinstance(token, Slot) else (token.name, which)

    def relation(
        self, name: str, bounds: Sequence[tuple[float, float]], origin: Slot | Wanted, target: Slot | Wanted
    ) -> list[Link]:
        """The distances of a temporal relation between two tokens."""
        sides = {"o": origin, "t": target}

        def at(side: str) -> Point:
            token, _, which = side.partition(".")
            return self.point(sides[token], which)

        table: Sequence[Distance] = distances(name, bounds)
        return [Link(at(d.from_), at(d.to), d.minimum, d.maximum) for d in table]

    def unsettled(self, links: Sequence[Link]) -> list[Link] | None:
        """The links that concern tokens outside the plan, if the others hold in every schedule; else None."""
        rest = []
        for link in links:
            if isinstance(link.from_, int) and isinstance(link.to, int):
                if not self.network.within(link.from_, link.to, link.minimum, link.maximum):
                    return None
            else:
                rest.append(link)
        return rest

    def links(self, procedure: str, arguments: Sequence[Expression], names: Names, path: Path) -> list[Link] | None:
        """A relation as distances between timepoints; None when it is not of that form."""
        if procedure in FORMS:
            points = [self._timepoint(argument, names, path) for argument in arguments]
            known = [p for p in points if p is not None]
            if len(known) != len(points):
                return None
            return [Link(a, b, *FORMS[procedure]) for a, b in pairwise(known)]
        if procedure not in ("temporalDistance", "addEq"):
            return None
        from_, to = self._timepoint(arguments[0], names, path), self._timepoint(arguments[2], names, path)
        if from_ is None or to is None or [*self.expressions.quantities(arguments[1:2], names, path)]:
            return None
        between = self.expressions.domain(arguments[1], names, path, _never)
        if between is None or not between.is_numeric:
            return None
        return [Link(from_, to, between.lower, between.upper)]

    def _timepoint(self, expression: Expression, names: Names, path: Path) -> Point | None:
        found = self.expressions.resolve(expression, names, path) if isinstance(expression, Ref) else None
        if isinstance(found, Quantity) and found.which != "duration":
            return self.point(found.token, found.which)
        return None

    def decide(
        self, procedure: str, arguments: Sequence[Expression], names: Names, path: Path, times: Times
    ) -> bool | None:
        """Whether a relation holds under given times; None when values that it depends on are open."""
        declared = self.expressions.model.procedures.get(procedure)
        declared.check_scope(len(arguments))
        domains = [self.expressions.domain(argument, names, path, times) for argument in arguments]
        known: list[Domain] = [d for d in domains if d is not None]
        if len(known) < len(domains):
            return None
        narrowed = declared.narrow(known)
        if narrowed is None or any(d.is_empty for d in narrowed):
            return False
        return True if all(d.is_singleton for d in known) else None

    def holds(self, procedure: str, arguments: Sequence[Expression], names: Names, path: Path) -> bool:
        """Whether nothing speaks against a relation in any schedule."""
        expressions = self.expressions
        if self.decide(procedure, arguments, names, path, expressions.range_of) is False:
            return False
        quantities = [q for q in expressions.quantities(arguments, names, path) if isinstance(q.token, Slot)]
        flexible = {q for q in quantities if not expressions.range_of(q).is_singleton}
        if not flexible:
            return True
        views = [self._times(schedule) for schedule in self._schedules(flexible)]
        return all(self.decide(procedure, arguments, names, path, times) is not False for times in views)

    def _schedules(self, flexible: Iterable[Quantity]) -> Iterator[Sequence[float]]:
        """Schedules that differ most in the times that are asked about."""
        yield from (self.network.earliest, self.network.latest)
        for quantity in flexible:
            if quantity.which == "duration" and isinstance(quantity.token, Slot):
                ends = [self.network.point(quantity.token.id, which) for which in ("start", "end")]
                yield from (self.network.stretched(*ends), self.network.shrunk(*ends))

    def _times(self, schedule: Sequence[float]) -> Times:
        def times(quantity: Quantity) -> Domain:
            if isinstance(quantity.token, Wanted):
                return UNBOUNDED
            start, end = (schedule[self.network.point(quantity.token.id, w)] for w in ("start", "end"))
            value = {"start": start, "end": end, "duration": end - start}[quantity.which]
            return Interval(value, value)

        return times


def _never(quantity: Quantity) -> Domain:
    raise AssertionError(f"{quantity} was not expected")
