"""Resources: no schedule that the plan allows leaves the limits of a level, of a rate or of a sum.

What `planner.model.resources` says of the members of resources, judged on the plan's network by `levels.py`. At a tick
where several transactions meet only the level after all of them counts. A resource whose `profile` is grounded is
judged on the schedule of earliest times alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

from planner.checker.levels import RESOLUTION, Event, Excess, Levels
from planner.checker.steps import Steps, constant, steps_of
from planner.checker.transactions import Flow, Transaction, transactions_of
from planner.checker.view import View
from planner.checker.violations import Violation
from planner.model.classes import ModelObject

_DONE: dict[Flow, str] = {"uses": "taken", "produces": "produced", "consumes": "consumed"}
MOST_NAMED = 8
"""How many tokens a sentence names."""


def check_resources(view: View, uses: Iterable[Transaction] = ()) -> Iterator[Violation]:
    """Every resource is kept. `uses`: what configuration constraints use besides the tokens on resources."""
    moved: dict[str, list[Transaction]] = {}
    for transaction in (*transactions_of(view), *uses):
        moved.setdefault(transaction.resource, []).append(transaction)
    levels = Levels(view.network)
    for name, transactions in moved.items():
        yield from _Resource(view, levels, view.model.object_named(name), transactions).violations()


class _Resource:
    """The transactions on one object of a resource class."""

    def __init__(self, view: View, levels: Levels, thing: ModelObject, transactions: Sequence[Transaction]) -> None:
        self.model = view.model
        self.levels = levels
        self.thing = thing
        self.transactions = transactions
        self.grounded = thing.members.get("profile") == "grounded"

    def violations(self) -> Iterator[Violation]:
        """What its transactions break."""
        if any(attribute.kind == "reservoir" for attribute in self.model.attributes_of(self.thing.cls).values()):
            yield from self._reservoir()
        else:
            yield from self._reusable()

    def _member(self, name: str, default: float | None = None) -> Steps:
        return steps_of(self.model, self.thing, name, default)

    def _reusable(self) -> Iterator[Violation]:
        spare = self._member("capacity").minus(self._member("level_min", 0.0))
        events = [
            Event(point, 0, -t.quantity if opens else t.quantity, t, not opens)
            for t in self.transactions
            for point, opens in ((t.start, True), (t.end, False))
        ]
        found = self.levels.excess(events, -1, spare, self.grounded)
        if found is not None:
            using = _under_way(found)
            text = f"has {spare.at(found.tick):g} {_at(found)}, a schedule uses {-found.total:g} at once"
            yield self._violation(f"{self.thing} {text}", using)
        yield from self._rate("uses", "consumption")

    def _reservoir(self) -> Iterator[Violation]:
        initial = self._member("initial").values[0]
        events = [Event(t.start, 0, t.quantity if t.flow == "produces" else -t.quantity, t) for t in self.transactions]
        bottom, top = self._member("level_min", 0.0), self._member("level_max", math.inf)
        found = self.levels.excess(events, -1, constant(initial).minus(bottom), self.grounded)
        if found is not None:
            least = f"at least {bottom.at(found.tick):g} is required"
            yield self._beyond(f"fall to {initial + found.total:g} {_at(found)}, {least}", found, events, -1)
        # The room above a level without a bound has none either.
        room = Steps(top.starts, tuple(value - initial for value in top.values))
        found = self.levels.excess(events, 1, room, self.grounded)
        if found is not None:
            most = f"at most {top.at(found.tick):g} is allowed"
            yield self._beyond(f"rise to {initial + found.total:g} {_at(found)}, {most}", found, events, 1)
        flows: tuple[tuple[Flow, str], ...] = (("consumes", "consumption"), ("produces", "production"))
        for flow, name in flows:
            yield from self._rate(flow, name)
            yield from self._sum(flow, name)

    def _beyond(self, what: str, found: Excess, events: Sequence[Event], sign: int) -> Violation:
        """A level too low or too high: what has happened by then, and what need not have yet."""
        behind = [e.transaction for e in events if e in found.happened and e.step * sign > 0]
        ahead = [e.transaction for e in events if e not in found.happened and e.step * sign < 0]
        text = f"the level of {self.thing} may {what}"
        told = [f"{when} {_listed(them)}" for when, them in (("after", behind), ("before", ahead)) if them]
        return Violation("resource", f"{text}: {', '.join(told)}", _ids([*behind, *ahead]), (self.thing.name,))

    def _rate(self, flow: Flow, name: str) -> Iterator[Violation]:
        """What moves at one tick."""
        most = self._member(f"{name}_rate_max", math.inf)
        events = [
            Event(t.start, offset, -t.quantity if offset else t.quantity, t, bool(offset))
            for t in self.transactions
            if t.flow == flow
            for offset in (0, 1)
        ]
        found = self.levels.excess(events, 1, most, self.grounded)
        if found is not None:
            text = f"{found.total:g} may be {_DONE[flow]} {_at(found)}, at most {most.at(found.tick):g} is allowed"
            yield self._violation(f"{self.thing}: {text} at one tick", _under_way(found))

    def _sum(self, flow: Flow, name: str) -> Iterator[Violation]:
        """What moves over the whole plan."""
        most = self._member(f"{name}_max", math.inf).values[0]
        moved = [t for t in self.transactions if t.flow == flow]
        total = math.fsum(t.quantity for t in moved)
        if total > most + RESOLUTION * max(1.0, abs(most)):
            text = f"{total:g} is {_DONE[flow]} in all, at most {most:g} is allowed"
            yield self._violation(f"{self.thing}: {text}", moved)

    def _violation(self, text: str, blamed: Sequence[Transaction]) -> Violation:
        return Violation("resource", f"{text}: {_listed(blamed)}", _ids(blamed), (self.thing.name,))


def _under_way(found: Excess) -> list[Transaction]:
    """The transactions that have begun and not ended."""
    ended = {id(e.transaction) for e in found.happened if e.closes}
    begun = [e.transaction for e in found.happened if not e.closes and id(e.transaction) not in ended]
    return sorted(begun, key=lambda t: (-t.quantity, t.slot.id))


def _at(found: Excess) -> str:
    return f"at tick {found.tick:g}" if abs(found.tick) < math.inf else "at some time"


def _listed(transactions: Sequence[Transaction]) -> str:
    named = [str(t) for t in transactions[:MOST_NAMED]]
    more = [f"{len(transactions) - MOST_NAMED} more"] if len(transactions) > MOST_NAMED else []
    return ", ".join([*named, *more])


def _ids(transactions: Iterable[Transaction]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(t.slot.id for t in transactions))
