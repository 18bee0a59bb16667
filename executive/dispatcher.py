"""Real-time execution of a dispatchable network: which timepoints may, must and may not happen now.

The semantics is RTE* (Hunsberger and Posenato, "Foundations of dispatchability for simple temporal networks with
uncertainty", ICAART 2024): a timepoint is enabled when every negative edge leaving it, waits included, leads to one
that has happened; its window is what its neighbours that have happened allow; a wait holds until its contingent
timepoint has happened or its time is over. An enabled timepoint may be performed anywhere in its window, no later than
the end of any other enabled one's. What nature does at the same instant is observed first.

Logic alone: the clock and what happened are told from outside. Times are whole ticks, on any origin.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from planner.temporal.controllability import DispatchableNetwork

IntArray = NDArray[np.int64]
Choice = Literal["earliest", "latest"] | Mapping[int, int]

# Beyond every time, and far enough from the ends of int64 that an edge may be added to it.
_NEVER = 1 << 62


class Window(NamedTuple):
    """The times at which a timepoint may happen as far as is known now; None where nothing bounds it yet."""

    earliest: int | None
    latest: int | None


@dataclass(frozen=True, slots=True)
class Decision:
    """What to perform next: the timepoints (indices, ascending), at `time` unless something is observed by then.

    `deadline`: the first end of an enabled timepoint's window: waiting longer than this breaks a constraint.
    """

    time: int
    timepoints: tuple[int, ...]
    deadline: int | None


@dataclass(frozen=True, slots=True)
class Violation:
    """A timepoint that happened outside of its window, or before the timepoints that had to come first."""

    timepoint: int
    time: int
    window: Window
    out_of_order: tuple[int, ...] = ()


class Dispatcher:
    """The execution of one network so far. An event costs its neighbours, a decision one pass over the timepoints."""

    def __init__(self, network: DispatchableNetwork) -> None:
        n = len(network.timepoints)
        self._network = network
        self._time = np.full(n, _NEVER)
        self._lower = np.full(n, -_NEVER)
        self._upper = np.full(n, _NEVER)
        edges, waits, contingents = network.edges, network.waits, network.contingents
        self._leaving, self._entering, self._waiting = network.leaving, network.entering, network.waiting
        self._by_target = network.by_target
        # How many negative edges and waits lead from each timepoint to one that has not happened.
        self._blocked = np.bincount(edges[edges[:, 2] < 0, 0], minlength=n) + np.bincount(waits[:, 1], minlength=n)
        self._wait_end = np.full(len(waits), -_NEVER)
        self._by_waiter = np.argsort(waits[:, 1], kind="stable")
        self._waiters, self._first_wait = np.unique(waits[self._by_waiter, 1], return_index=True)
        self._waited = np.full(n, -_NEVER)
        self._open = np.ones(n, dtype=np.bool_)
        self._open[contingents[:, 1]] = False
        self._activates: dict[int, list[int]] = {}
        for number, (activation, *_) in enumerate(contingents.tolist()):
            self._activates.setdefault(activation, []).append(number)
        self._ends = {end: number for number, end in enumerate(contingents[:, 1].tolist())}
        self._changed: list[IntArray] = [np.empty(0, dtype=np.int64)]

    def __repr__(self) -> str:
        return f"Dispatcher({np.count_nonzero(self._time != _NEVER)} of {len(self._time)} timepoints have happened)"

    @property
    def network(self) -> DispatchableNetwork:
        """The network in execution."""
        return self._network

    @property
    def narrowed(self) -> tuple[int, ...]:
        """The timepoints yet to come whose window the last event changed, ascending."""
        touched = np.unique(np.concatenate(self._changed))
        return tuple(touched[self._time[touched] == _NEVER].tolist())

    @property
    def finished(self) -> bool:
        """Whether every timepoint has happened."""
        return not (self._time == _NEVER).any()

    def time(self, timepoint: int) -> int | None:
        """When the timepoint happened, None if it has not."""
        time = int(self._time[timepoint])
        return None if time == _NEVER else time

    def is_natural(self, timepoint: int) -> bool:
        """Whether the timepoint ends a contingent link, so that it is observed and never performed."""
        return timepoint in self._ends

    def enabled(self) -> tuple[int, ...]:
        """The timepoints that nothing yet to come must precede, the natural ones left out, ascending."""
        return tuple(np.nonzero(self._open & (self._blocked == 0))[0].tolist())

    def window(self, timepoint: int) -> Window:
        """When the timepoint may happen, by the neighbours that have happened and its waits; exact once it is enabled.

        Of one that has happened, that time.
        """
        known = self.time(timepoint)
        return Window(known, known) if known is not None else self._window(timepoint)

    def _window(self, timepoint: int) -> Window:
        earliest = max(int(self._lower[timepoint]), int(self._waited[timepoint]))
        latest = int(self._upper[timepoint])
        return Window(None if earliest == -_NEVER else earliest, None if latest == _NEVER else latest)

    def next_decision(self, now: int, choice: Choice = "earliest") -> Decision | None:
        """What to perform next unless nature moves by then. None: only nature can move, or all has happened.

        `choice`: each timepoint as early or as late as its window allows, or as near as it allows to a preferred time
        (ticks by timepoint; those without one go early). One whose window has no end goes early too.
        """
        candidates = np.nonzero(self._open & (self._blocked == 0))[0]
        if not len(candidates):
            return None
        earliest = np.maximum(self._lower[candidates], self._waited[candidates])
        latest = self._upper[candidates]
        due = earliest
        if choice == "latest":
            due = np.where(latest == _NEVER, earliest, np.maximum(earliest, latest))
        elif choice != "earliest":
            wished = np.array([choice.get(node, -_NEVER) for node in candidates.tolist()])
            due = np.maximum(earliest, np.minimum(latest, wished))
        deadline = int(latest.min())
        time = max(now, int(due.min()))
        chosen = candidates[due <= time]
        return Decision(time, tuple(chosen.tolist()), None if deadline == _NEVER else deadline)

    def execute(self, timepoint: int, time: int) -> Violation | None:
        """The executive performed the timepoint at `time`. ValueError if it had happened or is nature's."""
        if timepoint in self._ends:
            raise ValueError(
                f"{self._network.timepoints[timepoint]}: is nature's to decide, so observed, not performed"
            )
        return self.happened(timepoint, time)

    def happened(self, timepoint: int, time: int) -> Violation | None:
        """The timepoint happened at `time`, observed or performed by someone else; the violation if it may not have.

        Propagates to the neighbours in any case. ValueError if it had happened before.
        """
        if self._time[timepoint] != _NEVER:
            known = int(self._time[timepoint])
            raise ValueError(f"{self._network.timepoints[timepoint]}: happened at {known}, told again at {time}")
        violation = self._violation(timepoint, time)
        self._time[timepoint] = time
        self._open[timepoint] = False
        self._changed = changed = self._propagate(timepoint, time)
        for number in self._activates.get(timepoint, ()):
            changed.append(self._begin_waits(number, time))
        if timepoint in self._ends:
            changed.append(self._end_waits(self._ends[timepoint]))
        return violation

    def slack_if(self, timepoint: int, time: int) -> int:
        """The narrowest window left among the neighbours to come if the timepoint happened at `time`; for forecasts.

        Negative: one of them could no longer happen in time. 2**62 where no window would be bounded.
        """
        upper_of, upper, lower_of, lower = self._bounds_from(timepoint, time)
        low, high = self._lower.copy(), self._upper.copy()
        high[upper_of] = np.minimum(high[upper_of], upper)
        low[lower_of] = np.maximum(low[lower_of], lower)
        touched = np.concatenate((upper_of, lower_of))
        touched = touched[(self._time[touched] == _NEVER) & (low[touched] != -_NEVER) & (high[touched] != _NEVER)]
        return int((high[touched] - low[touched]).min()) if len(touched) else _NEVER

    def _bounds_from(self, timepoint: int, time: int) -> tuple[IntArray, IntArray, IntArray, IntArray]:
        """Neighbours with an upper bound from `timepoint` at `time`, these bounds; the same for lower bounds."""
        network = self._network
        leaving = network.edges[self._leaving[timepoint] : self._leaving[timepoint + 1]]
        entering = self._by_target[self._entering[timepoint] : self._entering[timepoint + 1]]
        return leaving[:, 1], time + leaving[:, 2], entering[:, 0], time - entering[:, 2]

    def _propagate(self, timepoint: int, time: int) -> list[IntArray]:
        """Narrow the neighbours' windows and unblock those that had to follow; the neighbours that changed."""
        upper_of, upper, lower_of, lower = self._bounds_from(timepoint, time)
        lowered, raised = upper_of[upper < self._upper[upper_of]], lower_of[lower > self._lower[lower_of]]
        self._upper[upper_of] = np.minimum(self._upper[upper_of], upper)
        self._lower[lower_of] = np.maximum(self._lower[lower_of], lower)
        self._blocked[lower_of[lower > time]] -= 1
        return [lowered, raised]

    def _begin_waits(self, contingent: int, time: int) -> IntArray:
        network = self._network
        rows = slice(self._waiting[contingent], self._waiting[contingent + 1])
        waiting, until = network.waits[rows, 1], time - network.waits[rows, 2]
        self._blocked[waiting] -= 1
        if self._time[network.contingents[contingent, 1]] != _NEVER:
            return waiting[:0]
        changed: IntArray = waiting[until > self._waited[waiting]]
        self._wait_end[rows] = until
        self._waited[waiting] = np.maximum(self._waited[waiting], until)
        return changed

    def _end_waits(self, contingent: int) -> IntArray:
        network = self._network
        rows = slice(self._waiting[contingent], self._waiting[contingent + 1])
        waiting, until = network.waits[rows, 1], self._wait_end[rows]
        released: IntArray = waiting[(until == self._waited[waiting]) & (until != -_NEVER)]
        self._wait_end[rows] = -_NEVER
        if len(released):
            self._waited[self._waiters] = np.maximum.reduceat(self._wait_end[self._by_waiter], self._first_wait)
        return released

    def _violation(self, timepoint: int, time: int) -> Violation | None:
        window = self._window(timepoint)
        early = window.earliest is not None and time < window.earliest
        late = window.latest is not None and time > window.latest
        missing = self._missing(timepoint) if self._blocked[timepoint] else ()
        return Violation(timepoint, time, window, missing) if early or late or missing else None

    def _missing(self, timepoint: int) -> tuple[int, ...]:
        """The timepoints that had to happen before this one and have not."""
        network = self._network
        leaving = network.edges[self._leaving[timepoint] : self._leaving[timepoint + 1]]
        before = leaving[leaving[:, 2] < 0, 1]
        waits = network.waits[network.waits[:, 1] == timepoint, 0]
        before = np.unique(np.concatenate((before, network.contingents[waits, 0])))
        return tuple(before[self._time[before] == _NEVER].tolist())
