"""Deciding and propagating on flat arrays: compiled where numba is there, the same loops interpreted where it is not.

What an instant asks for is one call, with few arrays: a call costs as much as what it does. Times are ticks; `NEVER` is
beyond all of them.

`state`: a row a timepoint, which is two lines of the cache, and a column a quantity; the last row closes the ranges.
`ready`: the timepoints that may be performed now, in no order; their number comes last.
`edges`: rows other end, weight; first those that leave a timepoint, by timepoint, then those that enter it.
`waits`: rows of `WAIT_COLUMNS`, by the activation of what is waited for.
`done`, `told`: rows timepoint, earliest, latest: what happened in this call, with the window that it had; what has yet
to happen and has another window now.
"""

# Compiled functions take their state as plain arguments: ruff: noqa: PLR0917

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.int64]
Function = TypeVar("Function", bound=Callable[..., object])

# Far enough from the ends of int64 that an edge may be added to it.
NEVER = 1 << 62
# Columns of `state`. TIME: when it happened. LOWER, UPPER: what neighbours that have happened allow. WAITED: until when
# its waits hold. BLOCKED: how many edges and waits lead to what must come first and has not. OPEN: may be performed,
# which nature's never are. WISH: when it is wanted. PLACE: where in `ready` it is, or -1. LEAVING, ENTERING: its first
# rows of `edges`. BEGINS: its first row of the waits that begin with it. ENDS, ENDED: from which row to which row of
# them end with it. WAITER: its first place in the waits' column BY_WAITER. TOLD: whether it is in `told`.
# SPARED: not to be performed in this call.
TIME, LOWER, UPPER, WAITED, BLOCKED, OPEN, WISH, PLACE = range(8)
LEAVING, ENTERING, BEGINS, ENDS, ENDED, WAITER, TOLD, SPARED, COLUMNS = range(8, 17)
# Columns of `waits`. WAITS: who waits. WEIGHT: minus how long, from the activation on. FOR: the end that it waits for.
# UNTIL: when the wait is over, -NEVER while it does not run. BY_WAITER: the rows in the order of who waits.
WAITS, WEIGHT, FOR, UNTIL, BY_WAITER, WAIT_COLUMNS = range(6)
EARLIEST, LATEST, WISHED = range(3)


def _compiled(function: Function) -> Function:
    """`numba.njit` that keeps the function's type; the function itself without numba.

    Its cache watches this file alone, and nothing is from another.
    """
    try:
        from numba import njit
    except ImportError:
        return function
    return cast(Function, njit(cache=True)(function))


@_compiled
def admit(state: IntArray, ready: IntArray, node: int) -> None:
    """Put a timepoint among those that may be performed, if nothing stands in its way any more."""
    if state[node, OPEN] != 0 and state[node, BLOCKED] == 0 and state[node, PLACE] < 0:
        last = ready.shape[0] - 1
        state[node, PLACE] = ready[last]
        ready[ready[last]] = node
        ready[last] += 1


@_compiled
def dismiss(state: IntArray, ready: IntArray, node: int) -> None:
    """Take a timepoint that has happened away from them."""
    place, last = state[node, PLACE], ready.shape[0] - 1
    if place >= 0:
        ready[last] -= 1
        moved = ready[ready[last]]
        ready[place] = moved
        state[moved, PLACE] = place
        state[node, PLACE] = -1


@_compiled
def wanted_time(state: IntArray, node: int, choice: int) -> int:
    """When a timepoint should be performed, by its window as it is now."""
    earliest = max(state[node, LOWER], state[node, WAITED])
    latest = state[node, UPPER]
    if choice == LATEST and latest != NEVER:
        return int(max(earliest, latest))
    if choice == WISHED:
        return int(max(earliest, min(latest, state[node, WISH])))
    return int(earliest)


@_compiled
def decide(state: IntArray, ready: IntArray, now: int, choice: int, done: IntArray, first: int) -> tuple[int, int, int]:
    """The enabled timepoints to perform next: how many (they are in `done` from row `first` on, ascending), when, and
    the first end of a window.
    """
    count, due, deadline = ready[ready.shape[0] - 1], NEVER, NEVER
    for i in range(count):
        deadline = min(deadline, state[ready[i], UPPER])
        due = min(due, wanted_time(state, ready[i], choice))
    time, found = max(now, due), 0
    for i in range(count):
        node = ready[i]
        if wanted_time(state, node, choice) <= time:
            place = first + found
            while place > first and done[place - 1, 0] > node:
                done[place, 0] = done[place - 1, 0]
                place -= 1
            done[place, 0] = node
            found += 1
    return found, time, deadline


@_compiled
def perform(
    state: IntArray,
    ready: IntArray,
    edges: IntArray,
    waits: IntArray,
    now: int,
    choice: int,
    done: IntArray,
    told: IntArray,
) -> tuple[int, int, int]:
    """Decide and perform until nothing is due any more: how many rows of `done`, of `told`, and the next decision's
    time, `NEVER` if there is none.
    """
    count = touched = 0
    while True:
        found, time, _ = decide(state, ready, now, choice, done, count)
        if found == 0 or time > now:
            return count, settle(state, told, touched), time if found else NEVER
        first = count
        for i in range(first, first + found):
            node = done[i, 0]
            if state[node, SPARED] == 0:
                enter(state, node, done, count)
                touched = propagate(state, ready, edges, waits, node, now, told, touched)
                count += 1
        if count == first:
            return count, settle(state, told, touched), time


@_compiled
def happen(
    state: IntArray, ready: IntArray, edges: IntArray, waits: IntArray, node: int, time: int, told: IntArray
) -> tuple[int, int, int, int]:
    """One timepoint happens: how many rows of `told`, or -1 if it had happened; its window and BLOCKED until then."""
    if state[node, TIME] != NEVER:
        return -1, 0, 0, 0
    blocked, earliest, latest = state[node, BLOCKED], max(state[node, LOWER], state[node, WAITED]), state[node, UPPER]
    count = propagate(state, ready, edges, waits, node, time, told, 0)
    return settle(state, told, count), earliest, latest, blocked


@_compiled
def enter(state: IntArray, node: int, rows: IntArray, place: int) -> None:
    """Write a timepoint and its window into a row."""
    rows[place, 0] = node
    rows[place, 1] = max(state[node, LOWER], state[node, WAITED])
    rows[place, 2] = state[node, UPPER]


@_compiled
def touch(state: IntArray, node: int, told: IntArray, count: int) -> int:
    """Note once that a window has changed; returns how many have."""
    if state[node, TOLD] != 0:
        return count
    state[node, TOLD] = 1
    told[count, 0] = node
    return count + 1


@_compiled
def settle(state: IntArray, told: IntArray, count: int) -> int:
    """Of the windows that changed leave those of what is yet to come, as they are now; returns how many."""
    left = 0
    for i in range(count):
        node = told[i, 0]
        state[node, TOLD] = 0
        if state[node, TIME] == NEVER:
            enter(state, node, told, left)
            left += 1
    return left


@_compiled
def propagate(
    state: IntArray, ready: IntArray, edges: IntArray, waits: IntArray, node: int, time: int, told: IntArray, count: int
) -> int:
    """`node` happens at `time`: its neighbours' windows, what they wait for, the waits that begin or end with it."""
    state[node, TIME] = time
    state[node, OPEN] = 0
    dismiss(state, ready, node)
    for row in range(state[node, LEAVING], state[node + 1, LEAVING]):
        other, bound = edges[row, 0], time + edges[row, 1]
        if bound < state[other, UPPER]:
            state[other, UPPER] = bound
            count = touch(state, other, told, count)
    for row in range(state[node, ENTERING], state[node + 1, ENTERING]):
        other, bound = edges[row, 0], time - edges[row, 1]
        if bound > state[other, LOWER]:
            state[other, LOWER] = bound
            count = touch(state, other, told, count)
        if bound > time:
            state[other, BLOCKED] -= 1
            admit(state, ready, other)
    count = begin_waits(state, ready, waits, node, time, told, count)
    return end_waits(state, waits, node, told, count)


@_compiled
def begin_waits(
    state: IntArray, ready: IntArray, waits: IntArray, node: int, time: int, told: IntArray, count: int
) -> int:
    """The contingent links that `node` activates begin: their waits run unless the end has happened already."""
    for row in range(state[node, BEGINS], state[node + 1, BEGINS]):
        waiter, until = waits[row, WAITS], time - waits[row, WEIGHT]
        state[waiter, BLOCKED] -= 1
        admit(state, ready, waiter)
        if state[waits[row, FOR], TIME] == NEVER:
            waits[row, UNTIL] = until
            if until > state[waiter, WAITED]:
                state[waiter, WAITED] = until
                count = touch(state, waiter, told, count)
    return count


@_compiled
def end_waits(state: IntArray, waits: IntArray, node: int, told: IntArray, count: int) -> int:
    """The contingent link that `node` ends, if there is one, is over: nothing waits for it any more."""
    for row in range(state[node, ENDS], state[node, ENDED]):
        waiter, until = waits[row, WAITS], waits[row, UNTIL]
        waits[row, UNTIL] = -NEVER
        if until == -NEVER or until != state[waiter, WAITED]:
            continue
        left = -NEVER
        for place in range(state[waiter, WAITER], state[waiter + 1, WAITER]):
            left = max(left, waits[waits[place, BY_WAITER], UNTIL])
        state[waiter, WAITED] = left
        count = touch(state, waiter, told, count)
    return count
