"""A resource that some schedule overdraws: why, and what could be done about it.

Of the events that have happened in such a schedule, the *pushers* make the level worse; of those that have not, the
*relievers* would make it better. Take the fewest pushers that are still too much for the limit. In every schedule that
keeps the limit one of the relievers comes no later than one of these pushers, for otherwise the level leaves the limit
when the last pusher comes. So an order for each such pair is a complete set of remedies (Laborie, "Algorithms for
propagating resource constraints in AI planning and scheduling", Artificial Intelligence 143, 2003, section 6: minimal
critical sets). Among uses the relievers that matter are the ends of the same few, since intervals that overlap pairwise
have a tick in common. Where the limit steps, a pusher may also come after the stretch in which it is too tight, or a
reliever before it; and an undecided quantity that counts may be narrowed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from planner.constraints.network import AnyVariable, ConstraintNetworkManager, Owner, TimeVariable
from planner.domains import Interval
from planner.tokens.resources.closure import elements
from planner.tokens.resources.ledger import RESOLUTION, Scenario
from planner.tokens.resources.transaction import Event, Transaction

if TYPE_CHECKING:
    from planner.tokens.resources.resource import Resource


@dataclass(frozen=True, slots=True)
class Precede:
    """Let `first` come at least `gap` ticks before `second`."""

    first: TimeVariable
    second: TimeVariable
    gap: int


@dataclass(frozen=True, slots=True)
class Within:
    """Keep a time or a quantity within an interval."""

    variable: AnyVariable
    domain: Interval


Remedy = Precede | Within


class Clash:
    """Transactions that together overdraw a resource: the reason of an inconsistency or a narrowing, or a flaw.

    `what`: what is wrong with the level, in words. `pushers`, `relievers`, `scenario`: what remedies come from, if any.
    """

    __slots__ = ("owner", "pushers", "queued", "relievers", "resource", "scenario", "scope", "transactions", "what")

    def __init__(
        self,
        resource: Resource,
        what: str,
        transactions: Sequence[Transaction],
        scenario: Scenario | None = None,
        pushers: Sequence[Event] = (),
        relievers: Sequence[Event] = (),
    ) -> None:
        self.resource = resource
        self.what = what
        self.transactions = tuple(dict.fromkeys(transactions))
        self.scenario = scenario
        self.pushers = tuple(pushers)
        self.relievers = tuple(relievers)
        self.owner = self
        self.queued = False
        self.scope: tuple[AnyVariable, ...] = tuple(v for t in self.transactions for v in t.scope)

    @property
    def causes(self) -> list[Owner]:
        """Who asked for the transactions, and the decisions that made them such."""
        return [cause for transaction in self.transactions for cause in transaction.causes]

    def run(self, network: ConstraintNetworkManager) -> None:
        """Nothing to do: a clash is found, not propagated."""

    def __repr__(self) -> str:
        return f"{self.resource}: {self.what}: {', '.join(map(repr, self.transactions))}"

    def remedies(self) -> Iterator[Remedy]:
        """What could be done, least restricting first: one of these holds in every schedule that keeps the limit.

        None at all if no schedule does.
        """
        scenario = self.scenario
        if scenario is None or not scenario.ledger.hopeless(scenario):
            if scenario is not None:
                yield from self._orders(scenario)
            yield from self._narrowings()

    def _orders(self, scenario: Scenario) -> Iterator[Remedy]:
        """Orders and times, those that leave most room first."""
        found: list[tuple[float, int, Remedy]] = []
        for pusher in self.pushers:
            distances = pusher.time.temporal.distances_from(pusher.point)
            for reliever in self.relievers:
                if reliever.transaction is pusher.transaction:
                    continue
                gap = reliever.offset - pusher.offset
                room = -distances[reliever.point][0] - gap
                if room >= 0:
                    found.append((-room, len(found), Precede(reliever.time, pusher.time, gap)))
        since, until = self._tight(scenario)
        for pusher in self.pushers:
            if pusher.latest >= until:
                domain = Interval(until - pusher.offset, math.inf)
                found.append((until - pusher.latest, len(found), Within(pusher.time, domain)))
        for reliever in self.relievers:
            if reliever.earliest <= since:
                domain = Interval(-math.inf, since - reliever.offset)
                found.append((reliever.earliest - since, len(found), Within(reliever.time, domain)))
        yield from (remedy for _, _, remedy in sorted(found, key=lambda f: f[:2]))

    def _tight(self, scenario: Scenario) -> tuple[float, float]:
        """The stretch of time around the scenario's tick in which the limit is too tight for the pushers."""
        ledger, low = scenario.ledger, scenario.low
        if ledger.uses:
            total = math.fsum(event.step(low) for event in self.pushers)
        else:
            total = math.fsum(e.step(low) for e in _involved(scenario, self.pushers))
        slack = RESOLUTION * max(1.0, abs(scenario.limit))
        if low:
            return ledger.floor.stretch(scenario.tick, lambda limit: total < limit - slack)
        return ledger.ceiling.stretch(scenario.tick, lambda limit: total > limit + slack)

    def _narrowings(self) -> Iterator[Remedy]:
        """The least harmful quantity, then either half, of the transaction whose quantity is the most open."""
        unsettled = [t for t in self.transactions if not t.quantity.domain.is_singleton]
        if not unsettled:
            return
        transaction = max(unsettled, key=lambda t: t.most - t.least)
        least, most, integer = transaction.least, transaction.most, _is_integer(transaction.quantity)
        lessen = transaction.flow != "produces" if self.scenario is None or self.scenario.low else True
        if self.scenario is not None and not self.scenario.low and transaction.flow == "consumes":
            lessen = False
        best = least if lessen or math.isinf(most) else most
        yield Within(transaction.quantity, Interval(best, best, integer))
        middle = (least + most) / 2 if math.isfinite(most) else max(1.0, 2.0 * least)
        halves = [Interval(least, middle, integer), Interval(middle, most, integer)]
        if integer:
            halves[1] = Interval(math.floor(middle) + 1, most)
        for half in halves if lessen else reversed(halves):
            yield Within(transaction.quantity, half)


def overdraft(resource: Resource, scenario: Scenario) -> Clash:
    """The clash of a scenario: its fewest pushers, the greatest first, and the relievers that could come before."""
    events, low = scenario.ledger.events, scenario.low
    happened = [event for i in elements(scenario.happened) if (event := events[i])]
    if scenario.ledger.uses:
        ended = {event.transaction for event in happened if event.sign > 0}
        running = [event for event in happened if event.sign < 0 and event.transaction not in ended]
        pushers = _fewest(running, 0.0, scenario)
        chosen = {event.transaction for event in pushers}
        relievers = [event for event in events if event.sign > 0 and event.transaction in chosen]
        involved: list[Event] = pushers
    else:
        sign = -1 if low else 1
        settled = math.fsum(event.step(low) for event in happened if event.sign != sign)
        pushers = _fewest([event for event in happened if event.sign == sign], settled, scenario)
        done = set(map(id, happened))
        relievers = [event for event in events if event.sign != sign and id(event) not in done]
        involved = _involved(scenario, pushers)
    what = resource.complaint(scenario, math.fsum(event.step(low) for event in involved))
    return Clash(resource, what, [e.transaction for e in involved], scenario, pushers, relievers)


def _involved(scenario: Scenario, pushers: Sequence[Event]) -> list[Event]:
    """The pushers, and what has happened for the better all the same."""
    events = scenario.ledger.events
    sign = pushers[0].sign if pushers else 0
    return [*pushers, *(events[i] for i in elements(scenario.happened) if events[i].sign != sign)]


def _fewest(candidates: Sequence[Event], settled: float, scenario: Scenario) -> list[Event]:
    """The greatest steps that suffice to leave the limit, none of them in vain; ties as they came."""
    low, limit = scenario.low, scenario.limit
    slack = RESOLUTION * max(1.0, abs(limit))
    total, chosen = settled, list[Event]()
    for event in sorted(candidates, key=lambda e: -abs(e.step(low))):
        if total < limit - slack if low else total > limit + slack:
            break
        total += event.step(low)
        chosen.append(event)
    return chosen


def _is_integer(variable: AnyVariable) -> bool:
    domain = variable.domain
    return isinstance(domain, Interval) and domain.integer
