"""Deciding and propagating on flat arrays: compiled where numba is there, the same loops interpreted where it is not.

`state` has one row a timepoint, which is one line of the cache, and one column a quantity. `ready`: the timepoints that
may be performed now, in no order; their number comes last. Times are ticks; `NEVER` is beyond all of them.
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
# which nature's never are. WISH: when it is wanted. PLACE: where in `ready` it is, or -1.
TIME, LOWER, UPPER, WAITED, BLOCKED, OPEN, WISH, PLACE, COLUMNS = range(9)
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
def decide(state: IntArray, ready: IntArray, now: int, choice: int, chosen: IntArray) -> tuple[int, int, int]:
    """The enabled timepoints to perform next: how many (they are in `chosen`, ascending), when, and the first end of a
    window.
    """
    count, due, deadline = ready[ready.shape[0] - 1], NEVER, NEVER
    for i in range(count):
        deadline = min(deadline, state[ready[i], UPPER])
        due = min(due, wanted_time(state, ready[i], choice))
    time, found = max(now, due), 0
    for i in range(count):
        node = ready[i]
        if wanted_time(state, node, choice) <= time:
            place = found
            while place > 0 and chosen[place - 1] > node:
                chosen[place] = chosen[place - 1]
                place -= 1
            chosen[place] = node
            found += 1
    return found, time, deadline


@_compiled
def propagate(
    state: IntArray,
    ready: IntArray,
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
    state[node, TIME] = time
    state[node, OPEN] = 0
    dismiss(state, ready, node)
    for row in range(leaving[node], leaving[node + 1]):
        other, bound = edges[row, 1], time + edges[row, 2]
        if bound < state[other, UPPER]:
            state[other, UPPER] = bound
            changed[count] = other
            count += 1
    for row in range(entering[node], entering[node + 1]):
        other, bound = by_target[row, 0], time - by_target[row, 2]
        if bound > state[other, LOWER]:
            state[other, LOWER] = bound
            changed[count] = other
            count += 1
        if bound > time:
            state[other, BLOCKED] -= 1
            admit(state, ready, other)
    return count


@_compiled
def begin_waits(
    state: IntArray,
    ready: IntArray,
    waits: IntArray,
    wait_end: IntArray,
    first: int,
    last: int,
    end: int,
    time: int,
    changed: IntArray,
) -> int:
    """A contingent link begins: its waits (rows `first` to `last`) run unless `end` has happened already."""
    count = 0
    for row in range(first, last):
        node, until = waits[row, 1], time - waits[row, 2]
        state[node, BLOCKED] -= 1
        admit(state, ready, node)
        if state[end, TIME] == NEVER:
            wait_end[row] = until
            if until > state[node, WAITED]:
                state[node, WAITED] = until
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
        if until == -NEVER or until != state[node, WAITED]:
            continue
        left = -NEVER
        for place in range(of_waiter[node], of_waiter[node + 1]):
            left = max(left, wait_end[by_waiter[place]])
        state[node, WAITED] = left
        changed[count] = node
        count += 1
    return count
