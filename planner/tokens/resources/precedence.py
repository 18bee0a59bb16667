"""Which events of a resource cannot happen without which others having happened: what the temporal network implies.

Event j precedes event i when j is never later than i: then at every tick at which i has happened, so has j. The sets of
events that may have happened together are exactly the sets closed under this relation (Muscettola, "Computing the
envelope for stepwise-constant resource allocations", CP 2002, theorem 1), since between ticks t and t + 1 a cycle of
the temporal network can only run through one event before and one after.

The relation grows as constraints are added, so what is known stays true; it may be less than all that is true. A set of
events that the known relation allows is therefore tried on the network itself. If the network refuses, its negative
cycle names a pair that is not known yet.
"""

from __future__ import annotations

from collections.abc import Sequence

from planner.temporal.network import INFINITY, TemporalNetworkManager
from planner.tokens.resources.closure import elements
from planner.tokens.resources.transaction import Event
from planner.trail import Trail


class Precedence:
    """The known part of the relation. `before[i]`: the events known to precede event i, as bits, closed transitively.

    `before` is replaced as a whole and trailed.
    """

    def __init__(self, events: Sequence[Event], temporal: TemporalNetworkManager, trail: Trail) -> None:
        self.events = events
        self.temporal = temporal
        self.trail = trail
        self.before: list[int] = []

    def update(self) -> None:
        """Take in the events that are new, from their distances to all others."""
        events = self.events
        if len(self.before) == len(events):
            return
        before = list(self.before)
        for index in range(len(before), len(events)):
            event = events[index]
            distances = self.temporal.distances_from(event.point)
            row = later = 0
            for other in range(index):
                shift = events[other].offset - event.offset
                least, most = distances[events[other].point]
                if most + shift <= 0:
                    row |= 1 << other
                if least + shift >= 0:
                    later |= 1 << other
            for other in elements(row):
                row |= before[other]
            before.append(row)
            for other in elements(later):
                before[other] |= row | 1 << index
        self.trail.assign(self, "before", before)

    def possible(self, happened: int, rest: int, tick: int) -> bool:
        """Whether some schedule has those events, and no one of the rest, at a tick; a pair that forbids it is learned.

        All of them may each by itself have happened at the tick, or not have.
        """
        temporal, events = self.temporal, self.events
        mark = temporal.mark()
        posted: dict[int, int] = {}
        for index in elements(happened):
            event = events[index]
            posted[temporal.restrict(event.point, -INFINITY, tick - event.offset)] = index
        for index in elements(rest):
            event = events[index]
            posted[temporal.restrict(event.point, tick + 1 - event.offset, INFINITY)] = index
        holds = temporal.propagate()
        cycle = () if holds else temporal.conflict()
        temporal.undo_to(mark)
        if not holds:
            pair = [posted[constraint] for constraint in cycle if constraint in posted]
            later, earlier = sorted(pair, key=lambda index: happened >> index & 1, reverse=True)
            self._learn(earlier, later)
        return holds

    def _learn(self, earlier: int, later: int) -> None:
        gained = self.before[earlier] | 1 << earlier
        before = [row | gained if index == later or row >> later & 1 else row for index, row in enumerate(self.before)]
        self.trail.assign(self, "before", before)

    def extreme(self, events: Sequence[Event], latest: bool) -> list[Event]:
        """Those that no other of these events is known to come after (or before); one of any that always coincide."""
        wanted = set(map(id, events))
        places = {index: event for index, event in enumerate(self.events) if id(event) in wanted}
        kept = []
        for index, event in places.items():
            row = self.before[index]
            for other in places:
                earlier, later = row >> other & 1, self.before[other] >> index & 1
                if other != index and (later if latest else earlier) and (earlier != later or other < index):
                    break
            else:
                kept.append(event)
        return kept

    def forget(self) -> None:
        """Nothing is known any more: for when constraints were taken out."""
        self.trail.assign(self, "before", [])
