"""Real-time execution of a dispatchable network: which timepoints may, must and may not happen now.

The semantics is RTE* (Hunsberger and Posenato, "Foundations of dispatchability for simple temporal networks with
uncertainty", ICAART 2024): a timepoint is enabled when every negative edge leaving it, waits included, leads to one
that has happened; its window is what its neighbours that have happened allow; a wait holds until its contingent
timepoint has happened or its time is over. An enabled timepoint may be performed anywhere in its window, no later than
the end of any other enabled one's. What nature does at the same instant is observed first.

Logic alone: the clock and what happened are told from outside. Times are whole ticks, on any origin.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
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


class Happened(NamedTuple):
    """A timepoint that happened, the window that it had until then, and how it broke that."""

    timepoint: int
    window: Window
    violation: Violation | None = None


class Performed(NamedTuple):
    """What was performed at one instant, and when the next decision is due; None: only nature can move.

    `rows`: a timepoint and the ticks between which it had to happen, in the order in which they did.
    """

    time: int
    rows: list[list[int]]
    next: int | None

    @property
    def happened(self) -> tuple[Happened, ...]:
        """The timepoints, in order."""
        return tuple(_happened(node, low, high, self.time) for node, low, high in self.rows)


@cache
def prepare() -> None:
    """Compile what decides, or load what was compiled, so that no decision has to wait for it."""
    network = check(Stnu.from_ticks("abcd", [(0, 1, 1, 2, True), (1, 2, 0, 5, False), (3, 1, 1, 9, False)])).network
    assert network is not None
    dispatcher = Dispatcher(network)
    dispatcher.next_decision(0)
    dispatcher.perform_due(0)
    dispatcher.observe(1, 1)


class Dispatcher:
    """The execution of one network so far. An event costs its neighbours, a decision those that may be performed."""

    def __init__(self, network: DispatchableNetwork) -> None:
        n = len(network.timepoints)
        self._network = network
        self._size = n
        self._cells = np.zeros((n + 1, kernel.COLUMNS), dtype=np.int64)
        self._state = state = self._cells.T[:, :n]  # a quantity a row
        self._edges = np.concatenate((network.edges[:, 1:], network.by_target[:, ::2]))
        self._cells[:, kernel.LEAVING] = network.leaving
        self._cells[:, kernel.ENTERING] = len(network.edges) + network.entering
        self._waits = self._ordered_waits()
        contingents = network.contingents
        state[kernel.TIME] = state[kernel.UPPER] = _NEVER
        state[kernel.LOWER] = state[kernel.WAITED] = state[kernel.WISH] = -_NEVER
        # How many negative edges and waits lead from each timepoint to one that has not happened.
        state[kernel.BLOCKED] = np.bincount(network.edges[network.edges[:, 2] < 0, 0], minlength=n)
        state[kernel.BLOCKED] += np.bincount(network.waits[:, 1], minlength=n)
        state[kernel.OPEN] = 1
        state[kernel.OPEN, contingents[:, 1]] = 0
        state[kernel.PLACE] = -1
        self._ready = np.zeros(n + 1, dtype=np.int64)
        for node in np.nonzero(state[kernel.BLOCKED] == 0)[0].tolist():
            kernel.admit(self._cells, self._ready, node)
        self._natural = frozenset(contingents[:, 1].tolist())
        self._wishes: Choice = {}
        self._done = np.empty((n, 3), dtype=np.int64)
        self._told = np.empty((n, 3), dtype=np.int64)
        self._changed = 0

    def _ordered_waits(self) -> np.ndarray[tuple[int, int], np.dtype[np.int64]]:
        """The waits as the kernel has them, and each timepoint's ranges of them."""
        n, waits, contingents = self._size, self._network.waits, self._network.contingents
        activations, ends = contingents[:, 0], contingents[:, 1]
        waits = waits[np.lexsort((waits[:, 0], activations[waits[:, 0]]))]
        rows = np.empty((len(waits), kernel.WAIT_COLUMNS), dtype=np.int64)
        rows[:, kernel.WAITS], rows[:, kernel.WEIGHT], rows[:, kernel.FOR] = waits[:, 1], waits[:, 2], ends[waits[:, 0]]
        rows[:, kernel.UNTIL] = -_NEVER
        rows[:, kernel.BY_WAITER] = by_waiter = np.argsort(waits[:, 1], kind="stable")
        every = np.arange(n + 1)
        self._cells[:, kernel.BEGINS] = np.searchsorted(activations[waits[:, 0]], every)
        self._cells[:, kernel.WAITER] = np.searchsorted(waits[by_waiter, 1], every)
        numbers, first, count = np.unique(waits[:, 0], return_index=True, return_counts=True)
        self._cells[ends[numbers], kernel.ENDS] = first
        self._cells[ends[numbers], kernel.ENDED] = first + count
        return rows

    def __repr__(self) -> str:
        happened = np.count_nonzero(self._state[kernel.TIME] != _NEVER)
        return f"Dispatcher({happened} of {self._size} timepoints have happened)"

    @property
    def network(self) -> DispatchableNetwork:
        """The network in execution."""
        return self._network

    @property
    def narrowed(self) -> dict[int, Window]:
        """The timepoints yet to come whose window the last call that made something happen changed, with the window."""
        return {node: _window(earliest, latest) for node, earliest, latest in self._told[: self._changed].tolist()}

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
        return timepoint in self._natural

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
        return _window(earliest, int(state[kernel.UPPER, timepoint]))

    def next_decision(self, now: int, choice: Choice = "earliest") -> Decision | None:
        """What to perform next unless nature moves by then. None: only nature can move, or all has happened.

        `choice`: each timepoint as early or as late as its window allows, or as near as it allows to a preferred time
        (ticks by timepoint; those without one go early). One whose window has no end goes early too.
        """
        how = self._how(choice)
        found, time, deadline = kernel.decide(self._cells, self._ready, now, how, self._done, 0)
        if not found:
            return None
        return Decision(int(time), tuple(self._done[:found, 0].tolist()), None if deadline == _NEVER else int(deadline))

    def perform_due(self, now: int, choice: Choice = "earliest", spared: Collection[int] = ()) -> Performed:
        """Perform what is due, and what is due in consequence, until nothing is: `next_decision` and `execute` in one.

        `spared` are decided upon, but never performed: if only such are left, the next decision stays theirs.
        """
        if spared:
            self._state[kernel.SPARED, list(spared)] = 1
        count, self._changed, time = kernel.perform(
            self._cells, self._ready, self._edges, self._waits, now, self._how(choice), self._done, self._told
        )
        if spared:
            self._state[kernel.SPARED] = 0
        return Performed(now, self._done[:count].tolist() if count else [], None if time == _NEVER else int(time))

    def _how(self, choice: Choice) -> int:
        if isinstance(choice, str):
            return kernel.LATEST if choice == "latest" else kernel.EARLIEST
        if choice is not self._wishes:
            self._wishes = choice
            self._state[kernel.WISH] = -_NEVER
            self._state[kernel.WISH, list(choice)] = list(choice.values())
        return kernel.WISHED

    def execute(self, timepoint: int, time: int) -> Violation | None:
        """The executive performed the timepoint at `time`. ValueError if it had happened or is nature's."""
        if timepoint in self._natural:
            raise ValueError(
                f"{self._network.timepoints[timepoint]}: is nature's to decide, so observed, not performed"
            )
        return self.happened(timepoint, time)

    def happened(self, timepoint: int, time: int) -> Violation | None:
        """The timepoint happened at `time`, observed or performed by someone else; the violation if it may not have.

        Propagates to the neighbours in any case. ValueError if it had happened before.
        """
        return self.observe(timepoint, time).violation

    def observe(self, timepoint: int, time: int) -> Happened:
        """`happened` with the window that the timepoint had until then."""
        changed, earliest, latest, blocked = kernel.happen(
            self._cells, self._ready, self._edges, self._waits, timepoint, time, self._told
        )
        if changed < 0:
            name, known = self._network.timepoints[timepoint], self.time(timepoint)
            raise ValueError(f"{name}: happened at {known}, told again at {time}")
        self._changed = changed
        missing = self._missing(timepoint) if blocked else ()
        return _happened(timepoint, int(earliest), int(latest), time, missing)

    def slack_if(self, timepoint: int, time: int) -> int:
        """The narrowest window left among the neighbours to come if the timepoint happened at `time`; for forecasts.

        Negative: one of them could no longer happen in time. 2**62 where no window would be bounded.
        """
        network = self._network
        after = network.edges[network.leaving[timepoint] : network.leaving[timepoint + 1]]
        before = network.by_target[network.entering[timepoint] : network.entering[timepoint + 1]]
        low, high = self._state[kernel.LOWER].copy(), self._state[kernel.UPPER].copy()
        high[after[:, 1]] = np.minimum(high[after[:, 1]], time + after[:, 2])
        low[before[:, 0]] = np.maximum(low[before[:, 0]], time - before[:, 2])
        touched = np.concatenate((after[:, 1], before[:, 0]))
        open_ended = self._state[kernel.TIME, touched] != _NEVER
        touched = touched[~open_ended & (low[touched] != -_NEVER) & (high[touched] != _NEVER)]
        return int((high[touched] - low[touched]).min()) if len(touched) else _NEVER

    def _missing(self, timepoint: int) -> tuple[int, ...]:
        """The timepoints that had to happen before this one and have not."""
        network = self._network
        leaving = network.edges[network.leaving[timepoint] : network.leaving[timepoint + 1]]
        before = leaving[leaving[:, 2] < 0, 1]
        waits = network.waits[network.waits[:, 1] == timepoint, 0]
        before = np.unique(np.concatenate((before, network.contingents[waits, 0])))
        return tuple(before[self._state[kernel.TIME, before] == _NEVER].tolist())


def _window(earliest: int, latest: int) -> Window:
    return Window(None if earliest == -_NEVER else earliest, None if latest == _NEVER else latest)


def _happened(timepoint: int, earliest: int, latest: int, time: int, missing: tuple[int, ...] = ()) -> Happened:
    window = _window(earliest, latest)
    if earliest <= time <= latest and not missing:
        return Happened(timepoint, window)
    return Happened(timepoint, window, Violation(timepoint, time, window, missing))
