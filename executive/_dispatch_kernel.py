"""Deciding and propagating on flat arrays: compiled where numba is there, the same loops interpreted where it is not.

`state` has one row a quantity and one column a timepoint. Times are ticks; `NEVER` is beyond all of them.
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
# Rows of `state`. TIME: when it happened. LOWER, UPPER: what neighbours that have happened allow. WAITED: until when
# its waits hold. BLOCKED: how many edges and waits lead to what must come first and has not. OPEN: may be performed,
# which nature's never are. WISH: when it is wanted.
TIME, LOWER, UPPER, WAITED, BLOCKED, OPEN, WISH, ROWS = range(8)
EARLIEST, LATEST, WISHED = range(3)


def _compiled(function: Function) -> Function:
    """`numba.njit` that keeps the function's type; the function itself without numba."""
    try:
        from numba import njit
    except ImportError:
        return function
    return cast(Function, njit(cache=True)(function))


@_compiled
def decide(state: IntArray, now: int, choice: int, chosen: IntArray) -> tuple[int, int, int]:
    """The enabled timepoints to perform next: how many (they are in `chosen`), when, and the first end of a window."""
    count, due, deadline = 0, NEVER, NEVER
    for node in range(state.shape[1]):
        if state[OPEN, node] == 0 or state[BLOCKED, node] != 0:
            continue
        count += 1
        earliest = max(state[LOWER, node], state[WAITED, node])
        latest = state[UPPER, node]
        deadline = min(deadline, latest)
        wanted = earliest
        if choice == LATEST and latest != NEVER:
            wanted = max(earliest, latest)
        elif choice == WISHED:
            wanted = max(earliest, min(latest, state[WISH, node]))
        state[TIME, node] = wanted  # of one that has not happened; put back below
        due = min(due, wanted)
    time, found = max(now, due), 0
    if count:
        for node in range(state.shape[1]):
            if state[OPEN, node] != 0 and state[BLOCKED, node] == 0:
                if state[TIME, node] <= time:
                    chosen[found] = node
                    found += 1
                state[TIME, node] = NEVER
    return found, time, deadline


@_compiled
def propagate(
    state: IntArray,
    node: int,
    time: int,
    edges: IntArray,
    leaving: IntArray,
    by_target: IntArray,
    entering: IntArray,
    changed: IntArray,
) -> int:
    """`node` happens at `time`: its neighbours' windows and what they wait for; returns how many windows changed."""
    count = 0
    state[TIME, node] = time
    state[OPEN, node] = 0
    for row in range(leaving[node], leaving[node + 1]):
        other, bound = edges[row, 1], time + edges[row, 2]
        if bound < state[UPPER, other]:
            state[UPPER, other] = bound
            changed[count] = other
            count += 1
    for row in range(entering[node], entering[node + 1]):
        other, bound = by_target[row, 0], time - by_target[row, 2]
        if bound > state[LOWER, other]:
            state[LOWER, other] = bound
            changed[count] = other
            count += 1
        if bound > time:
            state[BLOCKED, other] -= 1
    return count


@_compiled
def begin_waits(
    state: IntArray, waits: IntArray, wait_end: IntArray, first: int, last: int, end: int, time: int, changed: IntArray
) -> int:
    """A contingent link begins: its waits (rows `first` to `last`) run unless `end` has happened already."""
    count = 0
    for row in range(first, last):
        node, until = waits[row, 1], time - waits[row, 2]
        state[BLOCKED, node] -= 1
        if state[TIME, end] == NEVER:
            wait_end[row] = until
            if until > state[WAITED, node]:
                state[WAITED, node] = until
                changed[count] = node
                count += 1
    return count


@_compiled
def end_waits(
    state: IntArray,
    waits: IntArray,
    wait_end: IntArray,
    first: int,
    last: int,
    by_waiter: IntArray,
    of_waiter: IntArray,
    changed: IntArray,
) -> int:
    """A contingent link ends: nothing waits for it any more. `by_waiter`: rows of waits, those of x from
    `of_waiter[x]` on."""
    count = 0
    for row in range(first, last):
        node, until = waits[row, 1], wait_end[row]
        wait_end[row] = -NEVER
        if until == -NEVER or until != state[WAITED, node]:
            continue
        left = -NEVER
        for place in range(of_waiter[node], of_waiter[node + 1]):
            left = max(left, wait_end[by_waiter[place]])
        state[WAITED, node] = left
        changed[count] = node
        count += 1
    return count
