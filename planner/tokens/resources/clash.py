"""A resource that some schedule overdraws: why, and what could be done about it.

Of the events that have happened in such a schedule, the *pushers* make the level worse; of those that have not, the
*relievers* would make it better. Take the fewest pushers that are still too much for the limit. In every schedule that
keeps the limit one of the relievers comes no later than one of these pushers, for otherwise the level leaves the limit
when the last pusher comes. So an order for each such pair is a complete set of remedies (Laborie, "Algorithms for
propagating resource constraints in AI planning and scheduling", Artificial Intelligence 143, 2003, section 6: minimal
critical sets). Among uses the relievers that matter are the ends of the same few, since intervals that overlap pairwise
have a tick in common; one's own end counts where a use may have no length. Where the limit steps, a pusher may also
come after the stretch in which it is too tight, or a reliever before it; and an undecided quantity that counts may be
narrowed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from planner.constraints.network import AnyVariable, ConstraintNetworkManager, Owner, TimeVariable
from planner.domains import Interval
from planner.tokens.resources.closure import elements
from planner.tokens.resources.ledger import Scenario
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


@dataclass(frozen=True, slots=True)
class Overdraft:
    """What a schedule does to a level: `pushers` make it leave the limit, `settled` could not prevent it, `relievers`
    have not happened. `side`: which end of the quantities counts, as in `Event.step`."""

    scenario: Scenario
    side: bool
    pushers: Sequence[Event]
    settled: Sequence[Event]
    relievers: Sequence[Event]

    @property
    def total(self) -> float:
        """The sum of the steps to blame."""
        return math.fsum(event.step(self.side) for event in (*self.pushers, *self.settled))

    @property
    def certain(self) -> bool:
        """No quantity that is left keeps the limit."""
        return self.side != self.scenario.low

    def tight(self) -> tuple[float, float]:
        """The stretch of time around the scenario's tick in which the limit is too tight."""
        total = self.total
        limit = self.scenario.ledger.limit(self.scenario.low)
        return limit.stretch(self.scenario.tick, lambda value: self.scenario.leaves(total, value))


class Clash:
    """Transactions that together overdraw a resource: the reason of an inconsistency or a narrowing, or a flaw.

    `what`: an overdraft, or in words what is wrong and no order can help.
    """

    __slots__ = ("owner", "queued", "resource", "scope", "transactions", "what")

    def __init__(self, resource: Resource, transactions: Sequence[Transaction], what: Overdraft | str) -> None:
        self.resource = resource
        self.transactions = tuple(dict.fromkeys(transactions))
        self.what = what
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
        what = self.what if isinstance(self.what, str) else self.resource.complaint(self.what)
        return f"{self.resource}: {what}: {', '.join(map(repr, self.transactions))}"

    def remedies(self) -> Iterator[Remedy]:
        """What could be done, least restricting first: one of these holds in every schedule that keeps the limit.

        None at all if no schedule does.
        """
        overdraft = self.what
        if isinstance(overdraft, str):
            yield from self._narrowings(True)
        elif not overdraft.scenario.ledger.hopeless(overdraft.scenario):
            yield from _orders(overdraft)
            if not overdraft.certain:
                yield from self._narrowings(overdraft.scenario.low)

    def _narrowings(self, low: bool) -> Iterator[Remedy]:
        """The least harmful quantity, then either half, of the transaction whose quantity is the most open."""
        unsettled = [t for t in self.transactions if not t.quantity.domain.is_singleton]
        if not unsettled:
            return
        chosen = max(unsettled, key=lambda t: t.most - t.least)
        least, most, integer = chosen.least, chosen.most, _is_integer(chosen.quantity)
        small = (chosen.flow == "produces") != low or math.isinf(most) or isinstance(self.what, str)
        best = least if small else most
        yield Within(chosen.quantity, Interval(best, best, integer))
        middle = (least + most) / 2 if math.isfinite(most) else max(1.0, 2.0 * least)
        halves = [Interval(least, middle, integer), Interval(middle, most, integer)]
        if integer:
            halves[1] = Interval(math.floor(middle) + 1, most)
        for half in halves if small else reversed(halves):
            yield Within(chosen.quantity, half)


def _orders(overdraft: Overdraft) -> Iterator[Remedy]:
    """Orders and times, those that leave most room first."""
    precedence = overdraft.scenario.ledger.precedence
    precedence.update()
    # What holds of a later reliever or an earlier pusher holds of the earlier or the later one too.
    pushers = precedence.extreme(overdraft.pushers, latest=True)
    relievers = precedence.extreme(overdraft.relievers, latest=False)
    found: list[tuple[float, int, Remedy]] = []
    for pusher in pushers:
        distances = pusher.time.temporal.distances_from(pusher.point)
        for reliever in relievers:
            gap = reliever.offset - pusher.offset
            lack = distances[reliever.point][0] + gap
            if lack <= 0:
                found.append((lack, len(found), Precede(reliever.time, pusher.time, gap)))
    since, until = overdraft.tight()
    for pusher in pushers:
        if pusher.latest >= until:
            domain = Interval(until - pusher.offset, math.inf)
            found.append((until - pusher.latest, len(found), Within(pusher.time, domain)))
    for reliever in relievers:
        if reliever.earliest <= since:
            domain = Interval(-math.inf, since - reliever.offset)
            found.append((reliever.earliest - since, len(found), Within(reliever.time, domain)))
    yield from (remedy for _, _, remedy in sorted(found, key=lambda f: f[:2]))


def overdraft_of(resource: Resource, scenario: Scenario) -> Clash:
    """The clash of a scenario: its fewest pushers, the greatest first, and the relievers that could come before.

    If the least harmful quantities are too much already, these are what counts, and only an order can help.
    """
    events = scenario.ledger.events
    happened = [events[i] for i in elements(scenario.happened)]
    sign = -1 if scenario.low else 1
    if scenario.ledger.uses:
        ended = {event.transaction for event in happened if event.sign != sign}
        settled: list[Event] = []
        candidates = [event for event in happened if event.sign == sign and event.transaction not in ended]
    else:
        settled = [event for event in happened if event.sign != sign]
        candidates = [event for event in happened if event.sign == sign]
    certain = scenario.leaves(math.fsum(e.step(not scenario.low) for e in (*settled, *candidates)))
    side = not scenario.low if certain else scenario.low
    pushers = _fewest(candidates, settled, scenario, side)
    chosen, done = {event.transaction for event in pushers}, set(map(id, happened))
    if scenario.ledger.uses:
        relievers = [event for event in events if event.sign != sign and event.transaction in chosen]
    else:
        relievers = [event for event in events if event.sign != sign and id(event) not in done]
    involved = [event.transaction for event in (*pushers, *settled)]
    return Clash(resource, involved, Overdraft(scenario, side, pushers, settled, relievers))


def _fewest(candidates: Sequence[Event], settled: Sequence[Event], scenario: Scenario, side: bool) -> list[Event]:
    """The greatest steps that suffice to leave the limit, none of them in vain; ties as they came."""
    total, chosen = math.fsum(event.step(side) for event in settled), list[Event]()
    for event in sorted(candidates, key=lambda e: -abs(e.step(side))):
        if scenario.leaves(total):
            break
        total += event.step(side)
        chosen.append(event)
    return chosen


def _is_integer(variable: AnyVariable) -> bool:
    domain = variable.domain
    return isinstance(domain, Interval) and domain.integer
