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
from functools import cache
from typing import Literal, NamedTuple

import numpy as np

from executive import _dispatch_kernel as kernel
from planner.temporal.controllability import DispatchableNetwork, check
from planner.temporal.stnu import Stnu

Choice = Literal["earliest", "latest"] | Mapping[int, int]

_NEVER = kernel.NEVER


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


@cache
def prepare() -> None:
    """Compile what decides, or load what was compiled, so that no decision has to wait for it."""
    network = check(Stnu.from_ticks("abcd", [(0, 1, 1, 2, True), (1, 2, 0, 5, False), (3, 1, 1, 9, False)])).network
    assert network is not None
    dispatcher = Dispatcher(network)
    dispatcher.next_decision(0)
    for timepoint, time in ((0, 0), (3, 0), (1, 1), (2, 1)):
        dispatcher.happened(timepoint, time)


class Dispatcher:
    """The execution of one network so far. An event costs its neighbours, a decision those that may be performed."""

    def __init__(self, network: DispatchableNetwork) -> None:
        n = len(network.timepoints)
        self._network = network
        edges, waits, contingents = network.edges, network.waits, network.contingents
        self._graph = (edges, network.leaving, network.by_target, network.entering)
        self._waits, self._waiting = waits, network.waiting
        self._cells = np.zeros((n, kernel.COLUMNS), dtype=np.int64)
        self._state = state = self._cells.T  # a quantity a row
        state[kernel.TIME] = state[kernel.UPPER] = _NEVER
        state[kernel.LOWER] = state[kernel.WAITED] = state[kernel.WISH] = -_NEVER
        # How many negative edges and waits lead from each timepoint to one that has not happened.
        state[kernel.BLOCKED] = np.bincount(edges[edges[:, 2] < 0, 0], minlength=n)
        state[kernel.BLOCKED] += np.bincount(waits[:, 1], minlength=n)
        state[kernel.OPEN] = 1
        state[kernel.OPEN, contingents[:, 1]] = 0
        state[kernel.PLACE] = -1
        self._ready = np.zeros(n + 1, dtype=np.int64)
        for node in np.nonzero(state[kernel.BLOCKED] == 0)[0].tolist():
            kernel.admit(self._cells, self._ready, node)
        self._wait_end = np.full(len(waits), -_NEVER)
        self._by_waiter = np.argsort(waits[:, 1], kind="stable")
        self._of_waiter = np.searchsorted(waits[self._by_waiter, 1], np.arange(n + 1))
        self._activates: dict[int, list[int]] = {}
        for number, (activation, *_) in enumerate(contingents.tolist()):
            self._activates.setdefault(activation, []).append(number)
        self._ends = {end: number for number, end in enumerate(contingents[:, 1].tolist())}
        self._wishes: Choice = {}
        self._chosen = np.empty(n, dtype=np.int64)
        self._touched = np.empty(2 * n + len(waits), dtype=np.int64)
        self._changed: set[int] = set()

    def __repr__(self) -> str:
        happened = np.count_nonzero(self._state[kernel.TIME] != _NEVER)
        return f"Dispatcher({happened} of {len(self._cells)} timepoints have happened)"

    @property
    def network(self) -> DispatchableNetwork:
        """The network in execution."""
        return self._network

    @property
    def narrowed(self) -> tuple[int, ...]:
        """The timepoints yet to come whose window the last event changed, ascending."""
        times = self._state[kernel.TIME]
        return tuple(node for node in sorted(self._changed) if times[node] == _NEVER)

    @property
    def finished(self) -> bool:
        """Whether every timepoint has happened."""
        return not (self._state[kernel.TIME] == _NEVER).any()

    def time(self, timepoint: int) -> int | None:
        """When the timepoint happened, None if it has not."""
        time = int(self._state[kernel.TIME, timepoint])
        return None if time == _NEVER else time

    def is_natural(self, timepoint: int) -> bool:
        """Whether the timepoint ends a contingent link, so that it is observed and never performed."""
        return timepoint in self._ends

    def enabled(self) -> tuple[int, ...]:
        """The timepoints that nothing yet to come must precede, the natural ones left out, ascending."""
        return tuple(np.nonzero((self._state[kernel.OPEN] != 0) & (self._state[kernel.BLOCKED] == 0))[0].tolist())

    def window(self, timepoint: int) -> Window:
        """When the timepoint may happen, by the neighbours that have happened and its waits; exact once it is enabled.

        Of one that has happened, that time.
        """
        known = self.time(timepoint)
        return Window(known, known) if known is not None else self._window(timepoint)

    def _window(self, timepoint: int) -> Window:
        state = self._state
        earliest = max(int(state[kernel.LOWER, timepoint]), int(state[kernel.WAITED, timepoint]))
        latest = int(state[kernel.UPPER, timepoint])
        return Window(None if earliest == -_NEVER else earliest, None if latest == _NEVER else latest)

    def next_decision(self, now: int, choice: Choice = "earliest") -> Decision | None:
        """What to perform next unless nature moves by then. None: only nature can move, or all has happened.

        `choice`: each timepoint as early or as late as its window allows, or as near as it allows to a preferred time
        (ticks by timepoint; those without one go early). One whose window has no end goes early too.
        """
        how = kernel.WISHED
        if isinstance(choice, str):
            how = kernel.LATEST if choice == "latest" else kernel.EARLIEST
        elif choice is not self._wishes:
            self._wish(choice)
        found, time, deadline = kernel.decide(self._cells, self._ready, now, how, self._chosen)
        if not found:
            return None
        return Decision(int(time), tuple(self._chosen[:found].tolist()), None if deadline == _NEVER else int(deadline))

    def _wish(self, choice: Mapping[int, int]) -> None:
        self._wishes = choice
        self._state[kernel.WISH] = -_NEVER
        for node, time in choice.items():
            self._state[kernel.WISH, node] = time

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
        state = self._state
        if state[kernel.TIME, timepoint] != _NEVER:
            known = int(state[kernel.TIME, timepoint])
            raise ValueError(f"{self._network.timepoints[timepoint]}: happened at {known}, told again at {time}")
        violation = self._violation(timepoint, time)
        touched = self._touched
        count = kernel.propagate(self._cells, self._ready, timepoint, time, *self._graph, touched)
        self._changed = set(touched[:count].tolist())
        for number in self._activates.get(timepoint, ()):
            rows = int(self._waiting[number]), int(self._waiting[number + 1])
            end = int(self._network.contingents[number, 1])
            count = kernel.begin_waits(self._cells, self._ready, self._waits, self._wait_end, *rows, end, time, touched)
            self._changed.update(touched[:count].tolist())
        if (ended := self._ends.get(timepoint)) is not None:
            rows = int(self._waiting[ended]), int(self._waiting[ended + 1])
            count = kernel.end_waits(
                self._cells, self._waits, self._wait_end, *rows, self._by_waiter, self._of_waiter, touched
            )
            self._changed.update(touched[:count].tolist())
        return violation

    def slack_if(self, timepoint: int, time: int) -> int:
        """The narrowest window left among the neighbours to come if the timepoint happened at `time`; for forecasts.

        Negative: one of them could no longer happen in time. 2**62 where no window would be bounded.
        """
        edges, leaving, by_target, entering = self._graph
        after = edges[leaving[timepoint] : leaving[timepoint + 1]]
        before = by_target[entering[timepoint] : entering[timepoint + 1]]
        low, high = self._state[kernel.LOWER].copy(), self._state[kernel.UPPER].copy()
        high[after[:, 1]] = np.minimum(high[after[:, 1]], time + after[:, 2])
        low[before[:, 0]] = np.maximum(low[before[:, 0]], time - before[:, 2])
        touched = np.concatenate((after[:, 1], before[:, 0]))
        open_ended = self._state[kernel.TIME, touched] != _NEVER
        touched = touched[~open_ended & (low[touched] != -_NEVER) & (high[touched] != _NEVER)]
        return int((high[touched] - low[touched]).min()) if len(touched) else _NEVER

    def _violation(self, timepoint: int, time: int) -> Violation | None:
        window = self._window(timepoint)
        early = window.earliest is not None and time < window.earliest
        late = window.latest is not None and time > window.latest
        missing = self._missing(timepoint) if self._state[kernel.BLOCKED, timepoint] else ()
        return Violation(timepoint, time, window, missing) if early or late or missing else None

    def _missing(self, timepoint: int) -> tuple[int, ...]:
        """The timepoints that had to happen before this one and have not."""
        network = self._network
        leaving = network.edges[network.leaving[timepoint] : network.leaving[timepoint + 1]]
        before = leaving[leaving[:, 2] < 0, 1]
        waits = network.waits[network.waits[:, 1] == timepoint, 0]
        before = np.unique(np.concatenate((before, network.contingents[waits, 0])))
        return tuple(before[self._state[kernel.TIME, before] == _NEVER].tolist())
