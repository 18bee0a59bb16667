"""The temporal network manager: timepoints, bounded distances between them, and their exact consequences.

A simple temporal network (Dechter, Meiri and Pearl, "Temporal constraint networks", Artificial Intelligence 49, 1991)
kept at its fixpoint incrementally, with chronological undo, exact removal out of order, and a reason for every bound.
Sign convention, everywhere: a constraint says `minimum <= to - from <= maximum`, in integer ticks.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from planner.temporal import kernel_python as layout
from planner.temporal.cycle import negative_loop
from planner.temporal.kernel import load_kernel

INFINITY = layout.INFINITY
"""Bounds from here on (or from here down, negated) are unbounded."""

LATEST, EARLIEST = 8, 4
"""Where `bounds` has what: the stride from one timepoint to the next, the offset of the negated earliest time."""

_Words = npt.NDArray[np.int64]
_EIGHT = struct.Struct("=8q").pack_into
_FOUR = struct.Struct("=4q").pack_into

_TOP, _POINTS, _CONSTRAINTS, _WATCHES = layout.TOP, layout.POINTS, layout.CONSTRAINTS, layout.WATCHES
_POST, _TIGHTEN, _POINT, _WATCH = layout.POST, layout.TIGHTEN, layout.POINT, layout.WATCH


class TemporalNetworkManager:
    """An incremental simple temporal network.

    Timepoints and constraints are small integers, numbered in order of creation; undoing their creation frees the
    numbers. Every timepoint has finite initial bounds (clamped to the horizon, or to plus or minus 2**50), which are
    given rather than posted: a conflict may rest on them but does not list them.

    Changes are queued, and `propagate` brings them into force in order; the bounds are the exact ones of what is in
    force. A failed `propagate` changes nothing: what it should have brought in stays queued, so undo it, or remove one
    of the constraints.

    `compiled` chooses the numba kernel (True), its plain twin (False), or the better one there is (None); the
    results are the same. Memory is linear in timepoints, constraints and undo records; no constraint is an object.
    """

    ORIGIN = 0

    def __init__(self, horizon: tuple[int, int] | None = None, *, compiled: bool | None = None) -> None:
        earliest, latest = horizon if horizon is not None else (-layout.LIMIT, layout.LIMIT)
        self._earliest = max(earliest, -layout.LIMIT)
        self._latest = min(latest, layout.LIMIT)
        self._kernel = load_kernel(compiled)
        self._labels: _Words = np.zeros(0, np.int64)
        self._points: _Words = np.zeros(0, np.int64)
        self._arcs: _Words = np.zeros(0, np.int64)
        self._owners: _Words = np.zeros(0, np.int64)
        self._pool: _Words = np.zeros(0, np.int64)
        self._trail: _Words = np.zeros(0, np.int64)
        self._walk: list[int] = []
        self._walk_back = 0
        self._reserve(points=4, constraints=8, records=64, entries=64)
        header = self._header
        header[_TOP] = header[layout.DONE] = layout.HEADER_ROWS
        header[layout.CHANGED] = header[layout.EMPTY] = -1
        header[layout.POOLED] = 1
        self._write_point(0, 0, 0)
        header[_POINTS] = 1

    def __repr__(self) -> str:
        kind = "compiled" if self._kernel.compiled else "plain"
        return f"<TemporalNetworkManager {self._header[_POINTS]} timepoints, {kind}>"

    # Construction and change

    @property
    def timepoint_count(self) -> int:
        """How many timepoints there are, the origin included."""
        return int(self._header[_POINTS])

    def add_timepoint(self, lower: int, upper: int) -> int:
        """A new timepoint within `lower .. upper` and the horizon. If that is empty, `propagate` fails from now on."""
        header = self._header
        point = header[_POINTS]
        if point >= self._point_room:
            self._reserve(points=2 * point)
        if header[_TOP] >= self._record_room:
            self._reserve(records=2 * header[_TOP])
        header = self._header
        lower = max(lower, self._earliest)
        upper = min(upper, self._latest)
        if lower > upper:
            # Kept in range all the same: whatever is read before the undo must not overflow.
            lower, upper = min(lower, layout.LIMIT), max(upper, -layout.LIMIT)
            if header[layout.EMPTY] < 0:
                header[layout.EMPTY] = point
        self._write_point(point, lower, upper)
        self._record(_POINT, point, 0, 0)
        header[_POINTS] = point + 1
        return point

    def post(self, from_: int, to: int, minimum: int, maximum: int, owner: int = -1) -> int:
        """Queue `minimum <= to - from_ <= maximum` and return the constraint's id. `owner` is kept, not interpreted."""
        header = self._header
        constraint = header[_CONSTRAINTS]
        top = header[_TOP]
        if constraint >= self._constraint_room or top >= self._record_room:
            self._make_room(constraint, top)
            header = self._header
        count = header[_POINTS]
        if not (0 <= from_ < count and 0 <= to < count):
            raise IndexError(f"constraint {from_} -> {to}: expected timepoints from 0 to {count - 1}")
        if not -INFINITY <= minimum <= INFINITY or not -INFINITY <= maximum <= INFINITY:
            minimum, maximum = _clamped(minimum), _clamped(maximum)
        a = 2 * from_ + layout.APART
        b = 2 * to + layout.APART
        _EIGHT(self._arc_view, 64 * constraint, b, maximum, a + 1, maximum, a, -minimum, b + 1, -minimum)
        self._owner_view[constraint] = owner
        _FOUR(self._trail_view, 32 * top, _POST, constraint, 0, 0)
        header[_TOP] = top + 1
        header[_CONSTRAINTS] = constraint + 1
        return constraint

    def tighten(self, constraint: int, minimum: int, maximum: int) -> None:
        """Queue the intersection of a constraint's bounds with `minimum .. maximum`."""
        header = self._header
        if not 0 <= constraint < header[_CONSTRAINTS] or self._arc_view[8 * constraint + 1] > INFINITY:
            raise IndexError(f"constraint {constraint}: expected one that is posted and not removed")
        top = header[_TOP]
        if top >= self._record_room:
            self._make_room(0, top)
            header = self._header
        if not -INFINITY <= minimum <= INFINITY or not -INFINITY <= maximum <= INFINITY:
            minimum, maximum = _clamped(minimum), _clamped(maximum)
        _FOUR(self._trail_view, 32 * top, _TIGHTEN, constraint, minimum, maximum)
        header[_TOP] = top + 1

    def restrict(self, timepoint: int, lower: int, upper: int, owner: int = -1) -> int:
        """Queue `lower <= timepoint <= upper`, a constraint from the origin; returns its id."""
        return self.post(0, timepoint, lower, upper, owner)

    def propagate(self) -> bool:
        """Bring what is queued into force. False: inconsistent, nothing changed, and `conflict` says why."""
        run = self._kernel.propagate
        while (code := run(*self._buffers)) <= layout.GROW:
            self._enlarge(code)
        if code == layout.OK:
            return True
        header = self._header
        start = 4 * header[_TOP]
        self._walk = self._trail_view[start : start + 4 * header[layout.CYCLE]].tolist()
        self._walk_back = header[layout.CYCLE_BACK]
        return False

    def remove(self, constraints: Sequence[int]) -> None:
        """Take constraints out, whenever they were posted, as if they had never been; takes effect at once.

        Only bounds whose chain of reasons holds one of them are recomputed. The removal is a change like any other:
        `undo_to` undoes it.
        """
        count = self._header[_CONSTRAINTS]
        for constraint in constraints:
            if not 0 <= constraint < count:
                raise IndexError(f"constraint {constraint}: expected one from 0 to {count - 1}")
        ids = np.fromiter(constraints, np.int64, len(constraints))
        buffer = ids if self._kernel.compiled else ids.data
        while (code := self._kernel.remove(*self._buffers, buffer)) <= layout.GROW:
            self._enlarge(code)

    # Undo

    def mark(self) -> int:
        """The present, for `undo_to`."""
        return self._header[_TOP]

    def undo_to(self, mark: int) -> None:
        """Undo every change since `mark`: everything, queue and unread changes included, is as it was then."""
        if not layout.HEADER_ROWS <= mark <= self._header[_TOP]:
            raise ValueError(f"mark {mark}: expected one from {layout.HEADER_ROWS} to {self._header[_TOP]}")
        self._kernel.undo_to(*self._buffers, mark)

    # Bounds and changes

    def lower(self, timepoint: int) -> int:
        """The earliest time of a timepoint, exact for the constraints in force."""
        return -self._label_view[8 * timepoint + 4]

    def upper(self, timepoint: int) -> int:
        """The latest time of a timepoint, exact for the constraints in force."""
        return self._label_view[8 * timepoint]

    @property
    def bounds(self) -> memoryview:
        """For hot loops: t's latest time at `LATEST * t`, minus its earliest EARLIEST on; until the next change."""
        return self._label_view

    def watch(self, timepoint: int) -> None:
        """Report this timepoint in `changed` from now on."""
        self._check(timepoint)
        place = 8 * timepoint + layout.WATCHED
        if self._point_view[place]:
            return
        top = self._header[_TOP]
        if top >= self._record_room:
            self._make_room(0, top)
        self._point_view[place] = 1
        self._header[_WATCHES] += 1
        self._record(_WATCH, timepoint, 0, 0)

    def changed(self) -> list[int]:
        """The watched timepoints whose bounds changed since the last call, in order of their first change."""
        header = self._header
        newest = header[layout.CHANGED]
        if newest < 0:
            return []
        top = header[_TOP]
        if top >= self._record_room:
            self._make_room(0, top)
            header = self._header
        trail = self._trail_view
        points = self._point_view
        result = []
        row = newest
        while row >= 0:
            point = trail[4 * row + 1]
            points[8 * point + layout.NOTED] = 0
            result.append(point)
            row = trail[4 * row + 2]
        self._record(layout.TAKE, 0, newest, 0)
        header[layout.CHANGED] = -1
        result.reverse()
        return result

    # Reasons

    def conflict(self) -> tuple[int, ...]:
        """After a failed `propagate`: the constraints of a simple negative cycle, in its order.

        Together with the initial bounds that the cycle uses, if any, these cannot hold. Empty if the initial
        bounds of some timepoint are empty by themselves.
        """
        return tuple(constraint for _, _, _, constraint in self.conflict_cycle() if constraint >= 0)

    def conflict_cycle(self) -> list[tuple[int, int, int, int]]:
        """The same cycle edge by edge: (from, to, weight, constraint), `to - from <= weight`; -1: an initial bound."""
        rows = [tuple(self._walk[place : place + 4]) for place in range(0, len(self._walk), 4)]
        walk = rows[: self._walk_back][::-1] + rows[self._walk_back :]
        return negative_loop([(row[0], row[1], row[2], row[3]) for row in walk])

    def explain(self, timepoint: int, which: Literal["lower", "upper"]) -> tuple[int, ...]:
        """The constraints on the chain of reasons of a bound, from the timepoint back to the origin."""
        label = 2 * timepoint + (which == "lower")
        labels, arcs = self._label_view, self._arc_view
        chain: list[int] = []
        while (arc := labels[4 * label + layout.REASON]) >= 0:
            chain.append(arc >> 2)
            label = arcs[2 * (arc ^ 2)] & layout.TARGET
        return tuple(dict.fromkeys(chain))

    # Distances

    def distance(self, a: int, b: int) -> tuple[int, int]:
        """The tightest `lo <= b - a <= hi` that the constraints in force imply."""
        self._check(a)
        self._check(b)
        heap = np.zeros(3 * self._header[_POINTS], np.int64)
        buffer = heap if self._kernel.compiled else heap.data
        labels, pool, run = self._buffers[0], self._buffers[3], self._kernel.shortest
        latest = run(labels, pool, buffer, 2 * a, 2 * b, -1)
        return -run(labels, pool, buffer, 2 * b, 2 * a, -1), latest

    def distances_from(self, a: int) -> list[tuple[int, int]]:
        """`distance(a, t)` for every timepoint t, from two searches."""
        later, sooner = self.reach(a, True, -1), self.reach(a, False, -1)
        return [(-sooner(t), later(t)) for t in range(self._header[_POINTS])]

    def reach(self, a: int, latest: bool, most: int) -> Callable[[int], int]:
        """A bound on `t - a` from above (`latest`) or on `a - t`, for any timepoint t: the tightest one for so many
        that are nearest, for the others what bounds tell. It holds until the next change."""
        self._check(a)
        source = 2 * a + (not latest)
        heap = np.zeros(3 * self._header[_POINTS], np.int64)
        self._kernel.shortest(
            self._buffers[0], self._buffers[3], heap if self._kernel.compiled else heap.data, source, -1, most
        )
        found, labels, side = heap.data, self._label_view, source & 1
        mine, through_origin = labels[4 * source], labels[4 * (source ^ 1)]

        def bound(t: int) -> int:
            to = labels[8 * t + 4 * side]
            return int(found[3 * t + 2] + to - mine if found[3 * t + 1] == -2 else to + through_origin)

        return bound

    def probe(self, from_: int, to: int, minimum: int, maximum: int, observed: int = 0) -> tuple[int, int] | None:
        """What the bounds of `observed` would be with `minimum <= to - from_ <= maximum` too; None: inconsistent.

        One call for post, propagate, read and undo: nothing is changed.
        """
        header = self._header
        constraint = header[_CONSTRAINTS]
        if constraint >= self._constraint_room:
            self._make_room(constraint, 0)
            header = self._header
        count = header[_POINTS]
        if not (0 <= from_ < count and 0 <= to < count and 0 <= observed < count):
            raise IndexError(f"probe {from_} -> {to} at {observed}: expected timepoints from 0 to {count - 1}")
        if not -INFINITY <= minimum <= INFINITY or not -INFINITY <= maximum <= INFINITY:
            minimum, maximum = _clamped(minimum), _clamped(maximum)
        run = self._kernel.probe
        while (code := run(*self._buffers, from_, to, minimum, maximum, observed)) <= layout.GROW:
            self._enlarge(code)
            header = self._header
        return (header[layout.PROBE_LOWER], header[layout.PROBE_UPPER]) if code == layout.OK else None

    def constraints(self) -> Iterator[tuple[int, int, int, int, int, int]]:
        """The constraints not removed, (id, from, to, minimum, maximum, owner); tightenings count once in force."""
        arcs, owners = self._arc_view, self._owner_view
        for constraint in range(self._header[_CONSTRAINTS]):
            to_word, maximum, _, _, from_word, negated, _, _ = arcs[8 * constraint : 8 * constraint + 8].tolist()
            if maximum <= INFINITY:
                from_, to = (from_word & layout.TARGET) >> 1, (to_word & layout.TARGET) >> 1
                yield constraint, from_, to, -negated, maximum, owners[constraint]

    # Storage

    def _check(self, timepoint: int) -> None:
        """The compiled kernel checks no bounds."""
        if not 0 <= timepoint < self._header[_POINTS]:
            raise IndexError(f"timepoint {timepoint}: expected one from 0 to {self._header[_POINTS] - 1}")

    def _record(self, kind: int, subject: int, first: int, second: int) -> None:
        top = self._header[_TOP]
        _FOUR(self._trail_view, 32 * top, kind, subject, first, second)
        self._header[_TOP] = top + 1

    def _write_point(self, point: int, lower: int, upper: int) -> None:
        """Initialise a row. Spans stay: they are empty, but their blocks in the pool are kept for the next user."""
        free, view = layout.NOT_QUEUED, self._label_view
        later, earlier = view[8 * point + layout.SPAN], view[8 * point + 4 + layout.SPAN]
        _EIGHT(view, 64 * point, upper, -1, later, free, -lower, -1, earlier, free)
        _FOUR(self._point_view, 64 * point, upper, -lower, 0, 0)

    def _enlarge(self, code: int) -> None:
        """Double the buffer that the kernel found too short."""
        if code == layout.GROW:
            self._reserve(records=2 * self._record_room)
        else:
            self._reserve(entries=len(self._pool))

    def _make_room(self, constraint: int, top: int) -> None:
        """Double what is full."""
        self._reserve(
            constraints=2 * constraint if constraint >= self._constraint_room else 0,
            records=2 * top if top >= self._record_room else 0,
        )

    def _reserve(self, points: int = 0, constraints: int = 0, records: int = 0, entries: int = 0) -> None:
        """Enlarge the buffers to at least these many rows, and renew the views."""
        self._labels = _grown(self._labels, 8 * points)
        self._points = _grown(self._points, 8 * points)
        self._arcs = _grown(self._arcs, 8 * constraints)
        self._owners = _grown(self._owners, constraints)
        self._pool = _grown(self._pool, 2 * entries)
        self._trail = _grown(self._trail, 4 * records)
        self._point_room = len(self._points) // 8
        self._constraint_room = len(self._owners)
        self._record_room = len(self._trail) // 4
        self._label_view = self._labels.data
        self._point_view = self._points.data
        self._arc_view = self._arcs.data
        self._owner_view = self._owners.data
        self._trail_view = self._trail.data
        self._header = self._trail_view[: 4 * layout.HEADER_ROWS]
        arrays = (self._labels, self._arcs, self._points, self._pool, self._trail)
        views = (self._label_view, self._arc_view, self._point_view, self._pool.data, self._trail_view)
        self._buffers: tuple[Any, Any, Any, Any, Any] = arrays if self._kernel.compiled else views


def _clamped(bound: int) -> int:
    return max(-INFINITY, min(INFINITY, bound))


def _grown(words: _Words, size: int) -> _Words:
    if size <= len(words):
        return words
    larger = np.zeros(size, np.int64)
    larger[: len(words)] = words
    return larger
