"""A ledger: the steps of one level, the limits it must keep, and what the level may be in the schedules there are.

The upper envelope at a tick is the level after the events that must have happened and the heaviest set of those that
may have and that the temporal network lets happen without the others; the lower envelope likewise (Muscettola, CP
2002). Both are exact: some schedule has that level at that tick. Between two ticks at which some event becomes possible
or certain, or a limit steps, nothing changes. A level that begins beyond its limit is judged from the first event on.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from planner.temporal.network import TemporalNetworkManager
from planner.tokens.resources.closure import elements, heaviest_closure
from planner.tokens.resources.precedence import Precedence
from planner.tokens.resources.steps import Steps
from planner.tokens.resources.transaction import Event, Transaction
from planner.trail import Trail

RESOLUTION = 1e-9
"""Levels this close, relative to the limit, are equal."""


@dataclass(frozen=True, slots=True)
class Band:
    """The lowest and the highest level from a tick on, until the next band."""

    start: float
    lowest: float
    highest: float


@dataclass(frozen=True, slots=True)
class Scenario:
    """Events that have happened at a tick in some schedule, as bits, and the sum of their steps: too low, or high."""

    ledger: Ledger
    low: bool
    tick: int
    happened: int
    total: float

    @property
    def limit(self) -> float:
        """What the sum of the steps must keep at the tick."""
        return self.ledger.limit(self.low).at(self.tick)

    def leaves(self, total: float, limit: float | None = None) -> bool:
        """Whether a sum of steps is too low, or too high, for the limit (the one at the tick when None)."""
        value = self.limit if limit is None else limit
        return total < value - _slack(value) if self.low else total > value + _slack(value)


class Ledger:
    """Events on one level. `floor` and `ceiling` bound the sum of their steps at every tick.

    `uses`: all transactions take and give back. `grounded`: only the schedule of earliest times keeps the limits.
    """

    def __init__(
        self, floor: Steps, ceiling: Steps, uses: bool, grounded: bool, temporal: TemporalNetworkManager, trail: Trail
    ) -> None:
        self.floor = floor
        self.ceiling = ceiling
        self.uses = uses
        self.grounded = grounded
        self.trail = trail
        self.events: list[Event] = []
        self.precedence = Precedence(self.events, temporal, trail)
        # Until when the level is known not to be too low, and not to be too high. Fewer schedules keep that true.
        self._safe = [-math.inf, -math.inf]

    def add(self, transaction: Transaction, steps: Iterable[Event]) -> None:
        """A transaction with its events."""
        for event in steps:
            self.trail.append(self.events, event)
        self._doubt()

    def remove(self, transaction: Transaction) -> None:
        """Take a transaction out, whenever it came."""
        for place in reversed(range(len(self.events))):
            if self.events[place].transaction is transaction:
                self.trail.call(self.events.insert, place, self.events.pop(place))
        self.forget()

    def limit(self, low: bool) -> Steps:
        """The floor, or the ceiling."""
        return self.floor if low else self.ceiling

    def forget(self) -> None:
        """Look at everything again: for when constraints were taken out."""
        self.precedence.forget()
        self._doubt()

    def _doubt(self) -> None:
        for side in (0, 1):
            if self._safe[side] > -math.inf:
                self.trail.set(self._safe, side, -math.inf)

    # Levels

    def envelope(self) -> list[Band]:
        """The least and the greatest sum of steps over time, in all schedules; the first band starts before them."""
        low, high = self._gains(True), self._gains(False)
        bands = [Band(-math.inf, 0.0, 0.0)]
        for tick, closed, pending, _ in self._stretches(self._ticks(), low):
            lowest = self._sum(True, self._worst(low, tick, closed, pending))
            highest = self._sum(False, self._worst(high, tick, closed, pending))
            if (lowest, highest) != (bands[-1].lowest, bands[-1].highest):
                bands.append(Band(tick, lowest, highest))
        return bands

    def profile(self) -> list[Band]:
        """The sums of steps in the schedule of earliest times; their width is that of undecided quantities."""
        bands = [Band(-math.inf, 0.0, 0.0)]
        for tick in sorted({event.earliest for event in self.events}):
            happened = self._by_now(tick)
            lowest, highest = self._sum(True, happened), self._sum(False, happened)
            if (lowest, highest) != (bands[-1].lowest, bands[-1].highest):
                bands.append(Band(tick, lowest, highest))
        return bands

    def _by_now(self, tick: float) -> int:
        return sum(1 << index for index, event in enumerate(self.events) if event.earliest <= tick)

    def _sum(self, low: bool, happened: int) -> float:
        """The sum of steps, lowest or highest. What is taken and given back without a bound adds up to nothing."""
        steps = [self.events[i].step(low) for i in elements(happened)]
        balance = sum(1 if step > 0 else -1 for step in steps if math.isinf(step))
        return balance * math.inf if balance else math.fsum(step for step in steps if math.isfinite(step))

    # Violations

    def violation(self) -> Scenario | None:
        """The first time at which some schedule leaves the limits, and a set of events that does it there."""
        found = [self._first(low) for low in (True, False)]
        return min((f for f in found if f is not None), key=lambda f: f.tick, default=None)

    def _first(self, low: bool) -> Scenario | None:
        side = 0 if low else 1
        limit = self.limit(low)
        # Earliest times move while the plan grows, so what was found of them does not last.
        since = -math.inf if self.grounded else self._safe[side]
        if since == math.inf or all(math.isinf(value) for value in limit.values):
            return None
        ticks = [tick for tick in self._ticks() if tick > since]
        if since > -math.inf:
            ticks.insert(0, int(since))
        found = self._first_of(ticks, low, limit)
        safe = math.inf if found is None else found.tick
        if safe != since:
            self.trail.set(self._safe, side, safe)
        return found

    def _first_of(self, ticks: Iterable[int], low: bool, limit: Steps) -> Scenario | None:
        gains = self._gains(low)
        begins_well = limit.values[0] <= 0 if low else limit.values[0] >= 0
        for tick, closed, pending, most in self._stretches(ticks, gains):
            value = limit.at(tick)
            allowed = (-value if low else value) + _slack(value)
            if self.grounded:
                happened = self._by_now(tick)
            elif most <= allowed:
                continue  # not even if the events had no order
            else:
                happened = self._worst(gains, tick, closed, pending, allowed)
            total = self._sum(low, happened)
            if (-total if low else total) > allowed and (happened or begins_well):
                return Scenario(self, low, tick, happened, total)
        return None

    def hopeless(self, scenario: Scenario) -> bool:
        """Whether every schedule leaves the limit: at the scenario's tick, or at any if the events had no order.

        Never said of uses: what every schedule of theirs does is pruned.
        """
        if self.uses:
            return False
        low, tick, sign = scenario.low, scenario.tick, 1.0 if scenario.low else -1.0
        gains, limit = self._gains(not low), self.limit(low)
        if any(scenario.leaves(sign * most, limit.at(t)) for t, _, _, most in self._stretches(self._ticks(), gains)):
            return True
        _, closed, pending, _ = next(self._stretches([tick], gains))
        self.precedence.update()
        best = closed | heaviest_closure(gains, self.precedence.before, pending)
        return scenario.leaves(self._sum(not low, best))

    # The sets of events that may have happened

    def _ticks(self) -> list[int]:
        """The ticks at which an event becomes possible or certain, or a limit steps."""
        ticks = {tick for span in self._spans() for tick in span}
        ticks |= {int(t) for limit in (self.floor, self.ceiling) for t in limit.starts if t > -math.inf}
        return sorted(ticks)

    def _stretches(self, ticks: Iterable[int], gains: Sequence[float]) -> Iterator[tuple[int, int, int, float]]:
        """For each tick, in order: the events that have happened by then in every schedule, and in some; and how much
        they could gain if they had no order."""
        spans = self._spans()
        opening = sorted([(earliest, index) for index, (earliest, _) in enumerate(spans)])
        closing = sorted([(latest, index) for index, (_, latest) in enumerate(spans)])
        possible = closed = opened = closes = 0
        most = 0.0
        for tick in ticks:
            while opened < len(opening) and opening[opened][0] <= tick:
                index = opening[opened][1]
                possible |= 1 << index
                most += max(gains[index], 0.0)
                opened += 1
            while closes < len(closing) and closing[closes][0] <= tick:
                index = closing[closes][1]
                closed |= 1 << index
                most += min(gains[index], 0.0)
                closes += 1
            yield tick, closed, possible & ~closed, most

    def _spans(self) -> list[tuple[int, int]]:
        """From when an event may have happened and from when it must have."""
        bounds = self.precedence.temporal.bounds
        return [(e.offset - bounds[8 * e.point + 4], e.offset + bounds[8 * e.point]) for e in self.events]

    def _gains(self, low: bool) -> list[float]:
        """What each event adds to the worse; what has no bound counts as more than all the others together."""
        gains = [-event.step(True) if low else event.step(False) for event in self.events]
        if any(map(math.isinf, gains)):
            large = 1.0 + 2.0 * sum(abs(gain) for gain in gains if math.isfinite(gain))
            limits = [abs(v) for limit in (self.floor, self.ceiling) for v in limit.values if math.isfinite(v)]
            large += 2.0 * max(limits, default=0.0)
            gains = [math.copysign(large, gain) if math.isinf(gain) else gain for gain in gains]
        return gains

    def _worst(self, gains: Sequence[float], tick: int, closed: int, pending: int, enough: float = -math.inf) -> int:
        """The events that have happened at a tick in a schedule with the greatest gain there.

        If the gain is at most `enough`, it is a bound on what schedules gain: the set is not tried on the network.
        """
        self.precedence.update()
        certain = math.fsum(gains[i] for i in elements(closed))
        while True:
            chosen = heaviest_closure(gains, self.precedence.before, pending)
            if certain + math.fsum(gains[i] for i in elements(chosen)) <= enough:
                return closed | chosen
            if self.precedence.possible(chosen, pending & ~chosen, tick):
                return closed | chosen


def _slack(limit: float) -> float:
    return RESOLUTION * max(1.0, abs(limit)) if math.isfinite(limit) else 0.0
