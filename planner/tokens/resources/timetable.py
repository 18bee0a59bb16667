"""Pruning of uses: what no schedule allows, from the parts of uses that happen in every schedule.

A use surely lasts from its latest start to its earliest end. What these compulsory parts leave of the capacity bounds
the quantity of every use that shares time with them, and keeps a use whose quantity no longer fits out of that time
(Lahrichi, "Scheduling: the notions of hump, compulsory parts and their use in cumulative problems", 1982; timetabling
in Laborie 2003, section 3.2).
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from planner.constraints.network import ConstraintNetworkManager, Inconsistency
from planner.domains import Interval
from planner.tokens.resources.clash import Clash
from planner.tokens.resources.ledger import RESOLUTION, Ledger
from planner.tokens.resources.transaction import Event, Transaction

if TYPE_CHECKING:
    from planner.tokens.resources.resource import Resource


@dataclass(frozen=True, slots=True)
class _Use:
    """A use and its times now: [first, last) holds it, [surely, surely_end) is in it, if that is not empty."""

    start: Event
    end: Event
    first: int
    surely: int
    surely_end: int
    last: int
    least: float

    @property
    def transaction(self) -> Transaction:
        return self.start.transaction

    @property
    def shortest(self) -> int:
        if self.start.time is self.end.time:
            return self.end.offset - self.start.offset
        return self.transaction.shortest

    @property
    def is_compulsory(self) -> bool:
        return self.surely < self.surely_end and self.least > 0


class Timetable:
    """The compulsory parts of the uses on a ledger as they are now, and what they leave."""

    def __init__(self, resource: Resource, ledger: Ledger, network: ConstraintNetworkManager) -> None:
        self.resource = resource
        self.network = network
        pairs = zip(ledger.events[::2], ledger.events[1::2], strict=True)
        self.uses = [_Use(a, b, a.earliest, a.latest, b.earliest, b.latest, a.transaction.least) for a, b in pairs]
        self.parts = [use for use in self.uses if use.is_compulsory]
        self.limit = ledger.floor.negated()
        edges = {float(t) for use in self.parts for t in (use.surely, use.surely_end)}
        # Stretch k is [edges[k], edges[k + 1]); the first one begins before all time and the last one never ends.
        self.edges = sorted({*edges, *self.limit.starts, -math.inf})
        self.left = [self.limit.at(edge) for edge in self.edges]
        for use in self.parts:
            for k in range(bisect_left(self.edges, use.surely), bisect_left(self.edges, use.surely_end)):
                self.left[k] -= use.least
        self.slack = RESOLUTION * max(1.0, *(abs(v) for v in self.limit.values if math.isfinite(v)), 0.0)

    def narrow(self) -> None:
        """Narrow quantities and times; Inconsistency where compulsory parts alone are too much."""
        tightest = min(self.left)
        if tightest < -self.slack:
            k = self.left.index(tightest)
            raise Inconsistency(because=self._clash([k], None))
        for use in self.uses:
            if use.transaction.most > tightest:
                self._narrow_quantity(use)
                if use.least > tightest + self.slack:
                    self._delay_start(use)
                    self._advance_end(use)

    def _stretches(self, first: float, last: float) -> range:
        """The stretches that [first, last) touches."""
        return range(bisect_right(self.edges, first) - 1, bisect_left(self.edges, last)) if first < last else range(0)

    def _left_for(self, use: _Use, k: int) -> float:
        own = use.is_compulsory and use.surely <= self.edges[k] < use.surely_end
        return self.left[k] + use.least if own else self.left[k]

    def _narrow_quantity(self, use: _Use) -> None:
        """At most what is left throughout its own compulsory part, and what is left at best anywhere that it may be."""
        room, blamed = math.inf, range(0)
        inside = self._stretches(use.surely, use.surely_end)
        if inside:
            k = min(inside, key=lambda k: self._left_for(use, k))
            room, blamed = self._left_for(use, k), range(k, k + 1)
        if use.shortest > 0 or inside:
            anywhere = self._stretches(use.first, use.last)
            best = max((self._left_for(use, k) for k in anywhere), default=math.inf)
            if best < room:
                room, blamed = best, anywhere
        quantity = use.transaction.quantity
        if use.transaction.most > room + self.slack:
            self.network.restrict(quantity, Interval(-math.inf, room, integer=False), self._clash(blamed, use))

    def _delay_start(self, use: _Use) -> None:
        """Past every stretch that it cannot share, as long as its earliest position covers one."""
        start, blamed = float(use.first), list[int]()
        for k in self._stretches(use.first, use.last):
            past = self.edges[k + 1] if k + 1 < len(self.edges) else math.inf
            if self.edges[k] >= max(use.surely_end, start + use.shortest):
                break
            if past <= start or use.least <= self._left_for(use, k) + self.slack:
                continue
            if use.shortest == 0 and past > use.surely_end:
                break  # it may have no length, and then it uses nothing
            start = past
            blamed.append(k)
        if start == math.inf:
            raise Inconsistency(because=self._clash(blamed, use))
        if blamed:
            domain = Interval(start - use.start.offset, math.inf)
            self.network.restrict(use.start.time, domain, self._clash(blamed, use))

    def _advance_end(self, use: _Use) -> None:
        """Before every stretch that it cannot share, as long as its latest position covers one."""
        end, blamed = float(use.last), list[int]()
        for k in reversed(self._stretches(use.first, use.last)):
            since = self.edges[k]
            past = self.edges[k + 1] if k + 1 < len(self.edges) else math.inf
            if past <= min(use.surely, end - use.shortest):
                break
            if since >= end or use.least <= self._left_for(use, k) + self.slack:
                continue
            if use.shortest == 0 and since < use.surely:
                break
            end = since
            blamed.append(k)
        if end == -math.inf:
            raise Inconsistency(because=self._clash(blamed, use))
        if blamed:
            domain = Interval(-math.inf, end - use.end.offset)
            self.network.restrict(use.end.time, domain, self._clash(blamed, use))

    def _clash(self, stretches: Sequence[int], use: _Use | None) -> Clash:
        """The uses whose compulsory parts are in those stretches, and the use that they narrow."""
        edges = [self.edges[k] for k in stretches]
        blamed = [] if use is None else [use]
        blamed += [
            part for part in self.parts if part is not use and any(part.surely <= t < part.surely_end for t in edges)
        ]
        return Clash(self.resource, [use.transaction for use in blamed], self._told(edges))

    def _told(self, edges: Sequence[float]) -> str:
        first = edges[0] if edges and math.isfinite(edges[0]) else None
        return "more than there is at the same time" + (f", at {first:g}" if first is not None else "")
