"""Whether any schedule of a plan takes a sum of steps beyond a limit that changes over time: exactly.

Let tau be a tick at which the limit has one value, and H the events that have happened by then. Some schedule has just
these behind it at such a tick exactly when the network with `e <= tau` for e in H and `tau + 1 <= f` for the others has
no negative cycle. A simple cycle passes tau once, so it is in the way for one of three reasons: an event of H comes
after the stretch in every schedule, one outside of H before it, or there are e in H and f outside with `f <= e` in
every schedule. So the sets H are the closed sets of a partial order, and the worst is the heaviest of them (Muscettola,
"Computing the Envelope for Stepwise-Constant Resource Allocations", 2002).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from planner.checker.closure import heaviest_closed_set
from planner.checker.network import PlanNetwork
from planner.checker.steps import Steps
from planner.checker.transactions import Transaction

RESOLUTION = 1e-9
"""Levels this close, relative to the limit, are equal."""


@dataclass(frozen=True, slots=True)
class Event:
    """A level changes by `step` at `offset` ticks after a timepoint. `closes`: the transaction is over then."""

    point: int
    offset: int
    step: float
    transaction: Transaction
    closes: bool = False


@dataclass(frozen=True, slots=True)
class Excess:
    """What some schedule does at a tick: the sum of all steps by then, and the events that have happened."""

    tick: float
    total: float
    happened: frozenset[Event]


class Levels:
    """Judges sums of steps on one plan's network."""

    def __init__(self, network: PlanNetwork) -> None:
        self.network = network
        self._rows: dict[int, npt.NDArray[np.float64]] = {}

    def excess(self, events: Sequence[Event], sign: int, allowed: Steps, grounded: bool = False) -> Excess | None:
        """A schedule in which `sign` times the sum of steps is above what is allowed; None when there is none.

        `grounded`: only the schedule in which everything is as early as can be is looked at. A level that is beyond its
        limit from the beginning is judged from the first event on.
        """
        begins_well = allowed.values[0] >= 0
        gains = [sign * event.step for event in events]
        early = [self.network.lower[e.point] + e.offset for e in events]
        late = early if grounded else [self.network.upper[e.point] + e.offset for e in events]
        for first, last, limit in allowed.stretches():
            if limit == math.inf:
                continue
            bound = limit + RESOLUTION * max(1.0, abs(limit))
            for run in _hot_runs(gains, early, late, (first, last), bound):
                happened = self._worst(events, gains, early, late, run)
                total = math.fsum(gains[i] for i in happened)
                if total > bound and (happened or begins_well):
                    tick = max([run[0], *(early[i] for i in happened)])
                    return Excess(tick, sign * total, frozenset(events[i] for i in happened))
        return None

    def _worst(
        self,
        events: Sequence[Event],
        gains: Sequence[float],
        early: Sequence[float],
        late: Sequence[float],
        run: tuple[float, float],
    ) -> set[int]:
        """The events that have happened at a tick of a run in a schedule with the greatest gain there."""
        certain = {i for i in range(len(events)) if late[i] <= run[0]}
        pending = [i for i in range(len(events)) if early[i] <= run[1] and i not in certain]
        implied = self._no_later([events[i] for i in pending])
        return certain | {pending[n] for n in heaviest_closed_set([gains[i] for i in pending], implied)}

    def _no_later(self, events: Sequence[Event]) -> list[int]:
        """For each event, as bits, the others that come no later than it in every schedule."""
        points = np.array([event.point for event in events], int)
        offsets = np.array([event.offset for event in events], float)
        found = []
        for number, event in enumerate(events):
            if event.point not in self._rows:
                self._rows[event.point] = np.array(self.network.distances_from(event.point))
            row = self._rows[event.point][points] + offsets <= event.offset
            row[number] = False
            found.append(int.from_bytes(np.packbits(row, bitorder="little").tobytes(), "little"))
        return found


def _hot_runs(
    gains: Sequence[float],
    early: Sequence[float],
    late: Sequence[float],
    stretch: tuple[float, float],
    bound: float,
) -> Iterator[tuple[float, float]]:
    """The parts of a stretch of time where the bound could be passed if events had no order."""
    first, last = stretch
    changes = sorted({first, *(tick for tick in (*early, *late) if first < tick <= last)})
    hot: list[tuple[float, float]] = []
    opening = sorted(range(len(gains)), key=lambda i: early[i], reverse=True)
    closing = sorted(range(len(gains)), key=lambda i: late[i], reverse=True)
    rises: list[float] = []
    for number, tick in enumerate(changes):
        while opening and early[opening[-1]] <= tick:
            rises.append(max(gains[opening.pop()], 0.0))
        while closing and late[closing[-1]] <= tick:
            rises.append(min(gains[closing.pop()], 0.0))
        if math.fsum(rises) > bound:
            until = changes[number + 1] - 1 if number + 1 < len(changes) else last
            if hot and hot[-1][1] == tick - 1:
                hot[-1] = hot[-1][0], until
            else:
                hot.append((tick, until))
    yield from hot
