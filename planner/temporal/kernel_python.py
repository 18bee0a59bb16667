"""The temporal kernel: an incremental simple temporal network on flat integer buffers, in plain Python.

Every function here works on buffers of 64-bit integers and calls nothing but its neighbours, so that one source serves
twice: `kernel` compiles it with numba for arrays, and without numba it runs as it stands on memoryviews, with the same
result bit by bit.

Labels. Timepoint t has two labels: 2t holds its upper bound, 2t+1 its negated lower bound. A constraint
`to - from <= w` is then two arcs that look alike: `2*from -> 2*to` and `2*to+1 -> 2*from+1`, both of weight w, and a
network is consistent with exact bounds when no arc can lower a label. Timepoint 0 is the origin; its labels stay 0.

Buffers (rows of 64-bit integers, one after the other):

labels  4 a label        VALUE, REASON (arc that set it; -1: initial bound), SPAN of the arcs out of it, LINK (queue)
arcs    2 an arc         place in the pool * 2**32 + target label (place -1: not in force); weight. Constraint c owns
                         arcs 4c to 4c+3: `to - from <= max` on both sides, then `from - to <= -min` on both sides. So
                         arc ^ 1 is the same edge on the other side, and the source of an arc is the target of arc ^ 2.
pool    2 an entry       the arcs in force, those of one source side by side: arc * 2**32 + target label; weight. A span
                         is block * 2**32 + count: the entries follow the block's first one, which holds its capacity.
points  8 a timepoint    initial values of both labels, WATCHED, NOTED, and the spans of the arcs into the origin, from
                         label 2t and from label 2t+1. Arcs out of the origin are in no span (it never moves).
trail   4 a record       HEADER_ROWS rows of header, then one record for every change, newest last. A queued post or
                         tightening is itself a record, so a mark is nothing but a length of the trail.

Adding an edge propagates from it alone, first in first out; the edge closes a negative cycle if and only if the
label of its own source would be lowered (Cesta and Oddi, "Gaining efficiency and flexibility in the simple temporal
problem", TIME 1996) or a bound crosses its opposite. Hence edges enter one at a time.

Pairwise distances (`shortest`): the exact bounds are a potential under which no arc is negative, so Dijkstra's
algorithm applies (Johnson, "Efficient algorithms for shortest paths in sparse networks", Journal of the ACM 24, 1977).

The file is longer than most because numba's cache looks at the file that a function is in, and at no other: a caller
elsewhere would go on with the old compiled code of a callee changed here, and with the old values of the constants.
"""

from __future__ import annotations

from typing import Protocol

INFINITY = 1 << 60
"""A weight from here on is no edge."""
LIMIT = 1 << 50
"""Bounds of timepoints are clamped to plus or minus this, so that sums never overflow."""
DEAD = INFINITY + 1
"""The weight of the arcs of a removed constraint."""

TARGET = (1 << 32) - 1
"""Mask of the target label in the first word of an arc, and of the count in a span."""
APART = -1 << 32
"""Place of an arc that is not in the pool."""
NOT_QUEUED = -2

VALUE, REASON, SPAN, LINK = range(4)
INITIAL, WATCHED, NOTED, INWARD = 0, 2, 3, 4

HEADER_ROWS = 4
TOP, DONE, POINTS, CONSTRAINTS, WATCHES, CHANGED, CYCLE, CYCLE_BACK, EMPTY, PROBE_UPPER, PROBE_LOWER, POOLED = range(12)
"""Header: trail length; trail length up to which queued records are propagated; number of timepoints, of constraints,
of watched timepoints; newest unread record of a watched change; length of the last conflict's walk and of its part
before the crossing; first timepoint with empty initial bounds; bounds read by the last probe;
length of the pool."""

SET, LINKED, UNLINKED, WEIGHED, POST, TIGHTEN, PROPAGATED, POINT, WATCH, NOTE, TAKE = range(11)
"""Kinds of trail record."""

OK, INCONSISTENT, GROW, GROW_POOL = -1, -2, -3, -4
"""Results. GROW: the trail or the pool is too short; nothing has changed; enlarge it and call again."""


class Buffer(Protocol):
    """A flat buffer of 64-bit integers: a memoryview here, an array in the compiled kernel."""

    def __len__(self) -> int: ...
    def __getitem__(self, index: int, /) -> int: ...
    def __setitem__(self, index: int, value: int, /) -> None: ...


def push(trail: Buffer, kind: int, subject: int, first: int, second: int) -> None:
    """Append a record; the caller has made sure of the room."""
    top = trail[TOP]
    trail[4 * top] = kind
    trail[4 * top + 1] = subject
    trail[4 * top + 2] = first
    trail[4 * top + 3] = second
    trail[TOP] = top + 1


def span_of(labels: Buffer, arcs: Buffer, points: Buffer, arc: int) -> int:
    """The span of the arcs that share this one's source (and go into the origin, if it does)."""
    source = arcs[2 * (arc ^ 2)] & TARGET
    if arcs[2 * arc] & TARGET < 2:
        return points[8 * (source >> 1) + INWARD + (source & 1)]
    return labels[4 * source + SPAN]


def set_span(labels: Buffer, arcs: Buffer, points: Buffer, arc: int, span: int) -> None:
    """Change the span that `span_of` reads."""
    source = arcs[2 * (arc ^ 2)] & TARGET
    if arcs[2 * arc] & TARGET < 2:
        points[8 * (source >> 1) + INWARD + (source & 1)] = span
    else:
        labels[4 * source + SPAN] = span


def put(arcs: Buffer, pool: Buffer, place: int, arc: int) -> None:
    """Write an arc to its place in the pool."""
    target = arcs[2 * arc] & TARGET
    pool[2 * place] = (arc << 32) | target
    pool[2 * place + 1] = arcs[2 * arc + 1]
    arcs[2 * arc] = (place << 32) | target


def link(labels: Buffer, arcs: Buffer, points: Buffer, pool: Buffer, trail: Buffer, arc: int) -> int:
    """Append an arc to its source's span, which moves to a block of twice the size if it is full. OK or GROW_POOL."""
    if arcs[2 * (arc ^ 2)] & TARGET < 2:
        return OK
    span = span_of(labels, arcs, points, arc)
    block = span >> 32
    count = span & TARGET
    capacity = pool[2 * block]
    if count == capacity:
        capacity = max(2 * capacity, 3)
        larger = trail[POOLED]
        if larger + 1 + capacity > len(pool) // 2:
            return GROW_POOL
        trail[POOLED] = larger + 1 + capacity
        pool[2 * larger] = capacity
        for offset in range(1, count + 1):
            put(arcs, pool, larger + offset, pool[2 * (block + offset)] >> 32)
        block = larger
    put(arcs, pool, block + count + 1, arc)
    set_span(labels, arcs, points, arc, (block << 32) | (count + 1))
    return OK


def unlink_last(labels: Buffer, arcs: Buffer, points: Buffer, arc: int) -> None:
    """Take back the last `link`."""
    if arcs[2 * arc] >> 32 >= 0:
        arcs[2 * arc] = APART | (arcs[2 * arc] & TARGET)
        set_span(labels, arcs, points, arc, span_of(labels, arcs, points, arc) - 1)


def unlink(labels: Buffer, arcs: Buffer, points: Buffer, pool: Buffer, trail: Buffer, arc: int) -> None:
    """Take an arc out of its span, if it is in one: the last one takes its place. Recorded."""
    place = arcs[2 * arc] >> 32
    if place < 0:
        return
    span = span_of(labels, arcs, points, arc)
    put(arcs, pool, place, pool[2 * ((span >> 32) + (span & TARGET))] >> 32)
    arcs[2 * arc] = APART | (arcs[2 * arc] & TARGET)
    set_span(labels, arcs, points, arc, span - 1)
    push(trail, UNLINKED, arc, place - (span >> 32), 0)


def relink(labels: Buffer, arcs: Buffer, points: Buffer, pool: Buffer, arc: int, offset: int) -> None:
    """Undo `unlink`."""
    span = span_of(labels, arcs, points, arc) + 1
    place = (span >> 32) + offset
    end = (span >> 32) + (span & TARGET)
    if place != end:
        put(arcs, pool, end, pool[2 * place] >> 32)
    put(arcs, pool, place, arc)
    set_span(labels, arcs, points, arc, span)


def set_weight(arcs: Buffer, pool: Buffer, edge: int, weight: int) -> None:
    """Change the weight of both arcs of an edge."""
    for arc in range(edge, edge + 2):
        arcs[2 * arc + 1] = weight
        place = arcs[2 * arc] >> 32
        if place >= 0:
            pool[2 * place + 1] = weight


def settle(labels: Buffer, pool: Buffer, trail: Buffer, first: int, last: int, source: int) -> int:
    """Propagate from the queue `first .. last` to the fixpoint.

    Returns OK, GROW, or the arc that closes a negative cycle: the one that would lower `source` (the source of the
    edge being added; -1: none) or push a bound beyond its opposite. The queue is empty afterwards in every case.
    """
    top = trail[TOP]
    room = len(trail) // 4
    result = OK
    while first >= 0:
        label = first
        first = labels[4 * label + LINK]
        labels[4 * label + LINK] = NOT_QUEUED
        if result != OK:
            continue
        value = labels[4 * label]
        span = labels[4 * label + SPAN]
        for place in range((span >> 32) + 1, (span >> 32) + (span & TARGET) + 1):
            word = pool[2 * place]
            target = word & TARGET
            reached = value + pool[2 * place + 1]
            if reached < labels[4 * target]:
                if target == source or reached + labels[4 * (target ^ 1)] < 0:
                    result = word >> 32
                    break
                if top >= room:
                    result = GROW
                    break
                trail[4 * top] = SET
                trail[4 * top + 1] = target
                trail[4 * top + 2] = labels[4 * target]
                trail[4 * top + 3] = labels[4 * target + REASON]
                top += 1
                labels[4 * target] = reached
                labels[4 * target + REASON] = word >> 32
                if labels[4 * target + LINK] == NOT_QUEUED:
                    labels[4 * target + LINK] = -1
                    if first < 0:
                        first = target
                    else:
                        labels[4 * last + LINK] = target
                    last = target
    trail[TOP] = top
    return result


def assert_arc(labels: Buffer, arcs: Buffer, pool: Buffer, trail: Buffer, arc: int) -> int:
    """Let a new or tightened arc take effect. Returns as `settle`."""
    source = arcs[2 * (arc ^ 2)] & TARGET
    target = arcs[2 * arc] & TARGET
    reached = labels[4 * source] + arcs[2 * arc + 1]
    if reached >= labels[4 * target]:
        return OK
    if target == source or reached + labels[4 * (target ^ 1)] < 0:
        return arc
    if trail[TOP] >= len(trail) // 4:
        return GROW
    push(trail, SET, target, labels[4 * target], labels[4 * target + REASON])
    labels[4 * target] = reached
    labels[4 * target + REASON] = arc
    labels[4 * target + LINK] = -1
    return settle(labels, pool, trail, target, target, source)


def write_edge(arcs: Buffer, points: Buffer, trail: Buffer, row: int, label: int, arc: int) -> None:
    """Write an edge of a conflict as a row (from, to, weight, constraint); no arc: the initial bound of `label`."""
    if arc >= 0:
        edge = arc & ~1
        trail[4 * row] = (arcs[2 * (edge ^ 2)] & TARGET) >> 1
        trail[4 * row + 1] = (arcs[2 * edge] & TARGET) >> 1
        trail[4 * row + 2] = arcs[2 * edge + 1]
        trail[4 * row + 3] = arc >> 2
    else:
        trail[4 * row] = (label >> 1) * (label & 1)
        trail[4 * row + 1] = (label >> 1) * (1 - (label & 1))
        trail[4 * row + 2] = points[8 * (label >> 1) + INITIAL + (label & 1)]
        trail[4 * row + 3] = -1


def write_cycle(labels: Buffer, arcs: Buffer, points: Buffer, trail: Buffer, closing: int, added: int) -> int:
    """Write, above the trail, the closed walk that `closing` completes while `added` was being asserted.

    First the edges from `closing` back along the reasons to the added edge's source or to the origin, newest first,
    then, if it was a crossing, the opposite bound's reasons. INCONSISTENT, or GROW for want of room.
    """
    row = trail[TOP]
    room = len(trail) // 4
    loop = arcs[2 * closing] & TARGET == arcs[2 * (added ^ 2)] & TARGET
    label = arcs[2 * closing] & TARGET
    arc = closing
    for part in range(2):
        while row < room:
            write_edge(arcs, points, trail, row, label, arc)
            row += 1
            if arc < 0 or (loop and arc == added):
                break
            label = arcs[2 * (arc ^ 2)] & TARGET
            if label < 2:
                break
            arc = labels[4 * label + REASON]
        if part == 0:
            trail[CYCLE_BACK] = row - trail[TOP]
            label = (arcs[2 * closing] & TARGET) ^ 1
            if loop or label < 2:
                break
            arc = labels[4 * label + REASON]
    trail[CYCLE] = row - trail[TOP]
    return INCONSISTENT if row < room else GROW


def enforce(
    labels: Buffer, arcs: Buffer, points: Buffer, pool: Buffer, trail: Buffer, edge: int, weight: int, fresh: bool
) -> int:
    """Bring one edge (the even arc of the pair) to `weight`, if that is tighter or the edge is fresh, and propagate."""
    old = arcs[2 * edge + 1]
    if old > INFINITY or weight >= INFINITY or (weight >= old and not fresh):
        return OK
    if trail[TOP] + 2 > len(trail) // 4:
        return GROW
    if not fresh:
        push(trail, WEIGHED, edge, old, 0)
        set_weight(arcs, pool, edge, weight)
    if fresh or old >= INFINITY:
        push(trail, LINKED, edge, 0, 0)
        for arc in range(edge, edge + 2):
            if link(labels, arcs, points, pool, trail, arc) != OK:
                return GROW_POOL
    for arc in range(edge, edge + 2):
        result = assert_arc(labels, arcs, pool, trail, arc)
        if result >= 0:
            return write_cycle(labels, arcs, points, trail, result, arc)
        if result != OK:
            return result
    return OK


def note_changes(labels: Buffer, points: Buffer, trail: Buffer, first: int, end: int) -> int:
    """Record the watched timepoints among the bounds set in records `first .. end` and not set back since."""
    if trail[WATCHES] == 0:
        return OK
    room = len(trail) // 4
    for row in range(first, end):
        if trail[4 * row] == SET and trail[4 * row + 2] != labels[4 * trail[4 * row + 1]]:
            point = trail[4 * row + 1] >> 1
            if points[8 * point + WATCHED] and not points[8 * point + NOTED]:
                if trail[TOP] >= room:
                    return GROW
                points[8 * point + NOTED] = 1
                push(trail, NOTE, point, trail[CHANGED], 0)
                trail[CHANGED] = trail[TOP] - 1
    return OK


def undo_record(labels: Buffer, arcs: Buffer, points: Buffer, pool: Buffer, trail: Buffer, row: int) -> None:
    """Undo one record that is not of kind SET."""
    kind = trail[4 * row]
    subject = trail[4 * row + 1]
    first = trail[4 * row + 2]
    if kind == LINKED:
        unlink_last(labels, arcs, points, subject + 1)
        unlink_last(labels, arcs, points, subject)
    elif kind == UNLINKED:
        relink(labels, arcs, points, pool, subject, first)
    elif kind == WEIGHED:
        set_weight(arcs, pool, subject, first)
    elif kind == POST:
        trail[CONSTRAINTS] -= 1
    elif kind == PROPAGATED:
        trail[DONE] = first
    elif kind == POINT:
        trail[POINTS] -= 1
        if trail[EMPTY] == subject:
            trail[EMPTY] = -1
    elif kind == WATCH:
        points[8 * subject + WATCHED] = 0
        trail[WATCHES] -= 1
    elif kind == NOTE:
        points[8 * subject + NOTED] = 0
        trail[CHANGED] = first
    elif kind == TAKE:
        trail[CHANGED] = first
        while first >= 0:
            points[8 * trail[4 * first + 1] + NOTED] = 1
            first = trail[4 * first + 2]


def undo_to(labels: Buffer, arcs: Buffer, points: Buffer, pool: Buffer, trail: Buffer, mark: int) -> int:
    """Undo every record from `mark` on, newest first."""
    row = trail[TOP]
    while row > mark:
        row -= 1
        if trail[4 * row] == SET:
            label = trail[4 * row + 1]
            labels[4 * label] = trail[4 * row + 2]
            labels[4 * label + REASON] = trail[4 * row + 3]
        else:
            undo_record(labels, arcs, points, pool, trail, row)
    trail[TOP] = row
    return OK


def propagate(labels: Buffer, arcs: Buffer, points: Buffer, pool: Buffer, trail: Buffer) -> int:
    """Bring the queued posts and tightenings into force, in order. OK; INCONSISTENT or GROW, and nothing has changed.

    After INCONSISTENT the walk of the conflict lies above the trail, until the next record is written.
    """
    start = trail[TOP]
    result = OK
    if trail[EMPTY] >= 0:
        trail[CYCLE] = 0
        trail[CYCLE_BACK] = 0
        return INCONSISTENT
    for row in range(trail[DONE], start):
        kind = trail[4 * row]
        if kind in (POST, TIGHTEN):
            edge = 4 * trail[4 * row + 1]
            fresh = kind == POST
            upper = arcs[2 * edge + 1] if fresh else trail[4 * row + 3]
            result = enforce(labels, arcs, points, pool, trail, edge, upper, fresh)
            if result == OK:
                lower = arcs[2 * edge + 5] if fresh else -trail[4 * row + 2]
                result = enforce(labels, arcs, points, pool, trail, edge + 2, lower, fresh)
            if result != OK:
                break
    if result == OK:
        result = note_changes(labels, points, trail, start, trail[TOP])
    if result == OK and trail[TOP] >= len(trail) // 4:
        result = GROW
    if result != OK:
        walk = trail[TOP]
        undo_to(labels, arcs, points, pool, trail, start)
        if result == INCONSISTENT:
            for word in range(4 * trail[CYCLE]):
                trail[4 * start + word] = trail[4 * walk + word]
        return result
    push(trail, PROPAGATED, 0, trail[DONE], 0)
    trail[DONE] = trail[TOP]
    return OK


def probe(
    labels: Buffer,
    arcs: Buffer,
    points: Buffer,
    pool: Buffer,
    trail: Buffer,
    from_: int,
    to: int,
    minimum: int,
    maximum: int,
    observed: int,
) -> int:
    """Post, propagate, read the labels of `observed`, and undo. The caller has made room for one constraint."""
    start = trail[TOP]
    if start >= len(trail) // 4:
        return GROW
    edge = 4 * trail[CONSTRAINTS]
    arcs[2 * edge] = APART | (2 * to)
    arcs[2 * edge + 1] = maximum
    arcs[2 * edge + 2] = APART | (2 * from_ + 1)
    arcs[2 * edge + 3] = maximum
    arcs[2 * edge + 4] = APART | (2 * from_)
    arcs[2 * edge + 5] = -minimum
    arcs[2 * edge + 6] = APART | (2 * to + 1)
    arcs[2 * edge + 7] = -minimum
    trail[CONSTRAINTS] += 1
    push(trail, POST, edge >> 2, 0, 0)
    result = propagate(labels, arcs, points, pool, trail)
    trail[PROBE_UPPER] = labels[8 * observed]
    trail[PROBE_LOWER] = -labels[8 * observed + 4]
    undo_to(labels, arcs, points, pool, trail, start)
    return result


def reset(labels: Buffer, points: Buffer, trail: Buffer, label: int) -> None:
    """Give a label its initial value back."""
    push(trail, SET, label, labels[4 * label], labels[4 * label + REASON])
    labels[4 * label] = points[8 * (label >> 1) + INITIAL + (label & 1)]
    labels[4 * label + REASON] = -1


def reset_dependents(labels: Buffer, arcs: Buffer, points: Buffer, pool: Buffer, trail: Buffer, ids: Buffer) -> int:
    """Reset every label whose chain of reasons holds an arc of a constraint in `ids`; they are the records appended."""
    room = len(trail) // 4
    row = trail[TOP]
    for place in range(len(ids)):
        for arc in range(4 * ids[place], 4 * ids[place] + 4):
            label = arcs[2 * arc] & TARGET
            if labels[4 * label + REASON] == arc:
                if trail[TOP] >= room:
                    return GROW
                reset(labels, points, trail, label)
    while row < trail[TOP]:
        span = labels[4 * trail[4 * row + 1] + SPAN]
        for place in range((span >> 32) + 1, (span >> 32) + (span & TARGET) + 1):
            label = pool[2 * place] & TARGET
            if labels[4 * label + REASON] == pool[2 * place] >> 32:
                if trail[TOP] >= room:
                    return GROW
                reset(labels, points, trail, label)
        row += 1
    return OK


def take_out(labels: Buffer, arcs: Buffer, points: Buffer, pool: Buffer, trail: Buffer, ids: Buffer) -> int:
    """Take the arcs of the constraints in `ids` out of the network, for good."""
    for place in range(len(ids)):
        for edge in range(4 * ids[place], 4 * ids[place] + 4, 2):
            if arcs[2 * edge + 1] == DEAD:
                continue
            if trail[TOP] + 3 > len(trail) // 4:
                return GROW
            unlink(labels, arcs, points, pool, trail, edge)
            unlink(labels, arcs, points, pool, trail, edge + 1)
            push(trail, WEIGHED, edge, arcs[2 * edge + 1], 0)
            set_weight(arcs, pool, edge, DEAD)
    return OK


def relax_into(labels: Buffer, pool: Buffer, label: int, span: int) -> None:
    """Lower a label by the arcs that enter it, found through their twins: a span of arcs out of label ^ 1.

    No record is needed: that of the label's reset holds the value to go back to.
    """
    for place in range((span >> 32) + 1, (span >> 32) + (span & TARGET) + 1):
        reached = labels[4 * ((pool[2 * place] & TARGET) ^ 1)] + pool[2 * place + 1]
        if reached < labels[4 * label]:
            labels[4 * label] = reached
            labels[4 * label + REASON] = (pool[2 * place] >> 32) ^ 1


def recompute(labels: Buffer, points: Buffer, pool: Buffer, trail: Buffer, start: int, end: int) -> int:
    """Propagate into and out of the labels of the records `start .. end`, whose values are too weak."""
    first = -1
    last = -1
    for row in range(start, end):
        label = trail[4 * row + 1]
        relax_into(labels, pool, label, points[8 * (label >> 1) + INWARD + (label & 1 ^ 1)])
        relax_into(labels, pool, label, labels[4 * (label ^ 1) + SPAN])
    for row in range(start, end):
        label = trail[4 * row + 1]
        labels[4 * label + LINK] = -1
        if first < 0:
            first = label
        else:
            labels[4 * last + LINK] = label
        last = label
    return settle(labels, pool, trail, first, last, -1)


def remove(labels: Buffer, arcs: Buffer, points: Buffer, pool: Buffer, trail: Buffer, ids: Buffer) -> int:
    """Take constraints out of the network, in force or still queued, and restore the exact bounds.

    Only the labels that rest on a removed arc are reset and recomputed. OK, or GROW with nothing changed.
    """
    start = trail[TOP]
    result = reset_dependents(labels, arcs, points, pool, trail, ids)
    end = trail[TOP]
    if result == OK:
        result = take_out(labels, arcs, points, pool, trail, ids)
    if result == OK:
        result = recompute(labels, points, pool, trail, start, end)
    if result == OK:
        result = note_changes(labels, points, trail, start, end)
    if result != OK:
        undo_to(labels, arcs, points, pool, trail, start)
    return result


def sift(heap: Buffer, place: int, label: int, size: int) -> None:
    """Put `label` where it belongs in the heap, starting from the free `place` (up, then down).

    `heap` holds three words for each position or timepoint: the label at this position of the heap; the position of
    this timepoint (-1: not reached, -2: final); the key of this timepoint.
    """
    key = heap[3 * (label >> 1) + 2]
    while place > 0:
        above = (place - 1) >> 1
        other = heap[3 * above]
        if heap[3 * (other >> 1) + 2] <= key:
            break
        heap[3 * place] = other
        heap[3 * (other >> 1) + 1] = place
        place = above
    while 2 * place + 1 < size:
        below = 2 * place + 1
        other = heap[3 * below]
        if below + 1 < size and heap[3 * (heap[3 * below + 3] >> 1) + 2] < heap[3 * (other >> 1) + 2]:
            below += 1
            other = heap[3 * below]
        if heap[3 * (other >> 1) + 2] >= key:
            break
        heap[3 * place] = other
        heap[3 * (other >> 1) + 1] = place
        place = below
    heap[3 * place] = label
    heap[3 * (label >> 1) + 1] = place


def shortest(labels: Buffer, pool: Buffer, heap: Buffer, source: int, goal: int, most: int) -> int:
    """Dijkstra from label `source` on reduced costs, its own value as potential; the origin's edges are the bounds.

    `heap` has three words a timepoint (see `sift`). Returns the distance to label `goal` (-1: to none). No more than
    `most` timepoints, those nearest by reduced costs, become final (-1: all that are nearer than through the origin).
    The key of one that is final is then its distance less the value of its label plus that of the source; to any other
    the shortest way known is through the origin, `labels[other] + labels[source ^ 1]`.
    """
    count = len(heap) // 3
    for point in range(count):
        heap[3 * point + 1] = -1
    through_origin = labels[4 * source] + labels[4 * (source ^ 1)]
    heap[3 * (source >> 1) + 2] = 0
    size = 0
    if source >= 2:
        sift(heap, 0, source, 0)
        size = 1
    while size > 0 and most != 0:
        most -= 1
        label = heap[0]
        key = heap[3 * (label >> 1) + 2]
        heap[3 * (label >> 1) + 1] = -2
        if label == goal:
            return key + labels[4 * label] - labels[4 * source]
        size -= 1
        if size > 0:
            sift(heap, 0, heap[3 * size], size)
        span = labels[4 * label + SPAN]
        for place in range((span >> 32) + 1, (span >> 32) + (span & TARGET) + 1):
            target = pool[2 * place] & TARGET
            state = heap[3 * (target >> 1) + 1]
            reached = key + labels[4 * label] + pool[2 * place + 1] - labels[4 * target]
            if state != -2 and reached < through_origin and (state < 0 or reached < heap[3 * (target >> 1) + 2]):
                heap[3 * (target >> 1) + 2] = reached
                if state < 0:
                    state = size
                    size += 1
                sift(heap, state, target, size)
    if goal == source:
        return 0
    return labels[4 * goal] + labels[4 * (source ^ 1)] if goal >= 0 else 0
