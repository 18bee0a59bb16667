"""The controllability check on flat arrays, compiled. `_controllability_python` is its plain twin and oracle.

Nodes: the n timepoints, then one node P a contingent link, in the links' order: P is the instant when the shortest
duration has passed. An edge `x -> y, w` means `t_y - t_x <= w`. Edges are rows of one growing table; a derived edge
remembers the two rows it was composed of, so every conclusion can be traced to the links it came from.
"""

# Compiled functions take their state as plain arguments: ruff: noqa: PLR0917
# Plain loops where numpy has a function or a slice assignment: those take numba tens of seconds to compile.

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

IntArray = NDArray[np.int64]
Function = TypeVar("Function", bound=Callable[..., object])

# Columns of the edge table. LEFT, RIGHT: the rows of a derived edge; of an original one -1 and its link.
# NEXT: the next row entering the same node in the list of negative or of other edges.
_FROM, _TO, _WEIGHT, _KIND, _LEFT, _RIGHT, _NEXT, _COLUMNS = range(8)
_ORDINARY, _LOWER, _LABELLED = range(3)
# Rows of a frame, the state of one node's propagation. FIRST: the edge by which the path to the source starts; REST:
# the row of what follows, -1 for nothing. The heap holds the nodes at a negative distance yet to be settled; PLACE: a
# node's position in it. MET: all nodes met, in order. SIZES: the length of the heap, and the number of nodes met.
_DISTANCE, _FIRST, _REST, _HEAP, _PLACE, _MET, _SIZES, _FRAME_ROWS = range(8)
# What is known of a node.
_PLAIN, _NEGATIVE, _OPEN, _FINISHED = range(4)
_INFINITE = 1 << 62
_UNBOUNDED = 1 << 62


def _compiled(function: Function) -> Function:
    """`numba.njit` that keeps the function's type. Its cache watches this file alone, and nothing is from another."""
    return cast(Function, njit(cache=True)(function))


def _compiled_for(signature: str) -> Callable[[Function], Function]:
    """The same for one signature, lest each call with a literal number be compiled anew."""

    def compiled(function: Function) -> Function:
        return cast(Function, njit(signature, cache=True)(function))

    return compiled


@_compiled_for("Tuple((i8[:, ::1], i8))(i8[:, ::1], i8, i8, i8, i8, i8, i8, i8)")
def _append(
    edges: IntArray, count: int, from_: int, to: int, weight: int, kind: int, left: int, right: int
) -> tuple[IntArray, int]:
    if count == edges.shape[0]:
        grown = np.empty((2 * count, _COLUMNS), np.int64)
        for e in range(count):
            for column in range(_COLUMNS):
                grown[e, column] = edges[e, column]
        edges = grown
    edges[count, _FROM] = from_
    edges[count, _TO] = to
    edges[count, _WEIGHT] = weight
    edges[count, _KIND] = kind
    edges[count, _LEFT] = left
    edges[count, _RIGHT] = right
    edges[count, _NEXT] = -1
    return edges, count + 1


@_compiled
def _original_edges(n: int, links: IntArray) -> tuple[IntArray, int, int]:
    """Edge table, its length and the number of nodes of a network in normal form."""
    # Room for most networks' derived edges: memory that is not touched costs nothing, growing does.
    edges = np.empty((64 * links.shape[0] + 64, _COLUMNS), np.int64)
    count, nodes = 0, n
    for i in range(links.shape[0]):
        a, c, lower, upper = links[i, 0], links[i, 1], links[i, 2], links[i, 3]
        if links[i, 4] != 0:
            p, spread = nodes, upper - lower
            nodes += 1
            edges, count = _append(edges, count, a, p, lower, _ORDINARY, -1, i)
            edges, count = _append(edges, count, p, a, -lower, _ORDINARY, -1, i)
            edges, count = _append(edges, count, p, c, spread, _ORDINARY, -1, i)
            edges, count = _append(edges, count, c, p, 0, _ORDINARY, -1, i)
            if spread > 0:
                edges, count = _append(edges, count, p, c, 0, _LOWER, -1, i)
                edges, count = _append(edges, count, c, p, -spread, _LABELLED, -1, i)
        else:
            if upper != _UNBOUNDED:
                edges, count = _append(edges, count, a, c, upper, _ORDINARY, -1, i)
            if lower != -_UNBOUNDED:
                edges, count = _append(edges, count, c, a, -lower, _ORDINARY, -1, i)
    return edges, count, nodes


@_compiled
def _thread(edges: IntArray, count: int, nodes: int) -> tuple[IntArray, IntArray]:
    """For each node the first row of its entering edges, the negative ones and the others; and the nodes' states."""
    heads, state = np.empty((nodes, 2), np.int64), np.empty(nodes, np.int64)
    for node in range(nodes):
        heads[node, 0] = heads[node, 1] = -1
        state[node] = _PLAIN
    for e in range(count):
        to = edges[e, _TO]
        side = 0 if edges[e, _WEIGHT] < 0 else 1
        edges[e, _NEXT] = heads[to, side]
        heads[to, side] = e
        if side == 0:
            state[to] = _NEGATIVE
    return heads, state


@_compiled_for("void(i8[:, ::1], i8, i8, i8, i8)")
def _reach(frame: IntArray, node: int, distance: int, first: int, rest: int) -> None:
    """Lower a node's distance to the source. At a negative one it takes its place in the heap, to be extended."""
    known = frame[_DISTANCE, node]
    if distance >= known:
        return
    frame[_DISTANCE, node], frame[_FIRST, node], frame[_REST, node] = distance, first, rest
    if known == _INFINITE:
        frame[_MET, frame[_SIZES, 1]] = node
        frame[_SIZES, 1] += 1
    if distance >= 0:
        return
    if known >= 0:
        place = frame[_SIZES, 0]
        frame[_SIZES, 0] += 1
    else:
        place = frame[_PLACE, node]
    while place > 0:
        above = (place - 1) >> 1
        other = frame[_HEAP, above]
        if frame[_DISTANCE, other] <= distance:
            break
        frame[_HEAP, place] = other
        frame[_PLACE, other] = place
        place = above
    frame[_HEAP, place] = node
    frame[_PLACE, node] = place


@_compiled
def _take(frame: IntArray) -> int:
    """Remove the nearest node from the heap and return it."""
    nearest = frame[_HEAP, 0]
    frame[_SIZES, 0] -= 1
    size = frame[_SIZES, 0]
    node = frame[_HEAP, size]
    distance = frame[_DISTANCE, node]
    place = 0
    while True:
        below = 2 * place + 1
        if below >= size:
            break
        if below + 1 < size and frame[_DISTANCE, frame[_HEAP, below + 1]] < frame[_DISTANCE, frame[_HEAP, below]]:
            below += 1
        other = frame[_HEAP, below]
        if distance <= frame[_DISTANCE, other]:
            break
        frame[_HEAP, place] = other
        frame[_PLACE, other] = place
        place = below
    frame[_HEAP, place] = node
    frame[_PLACE, node] = place
    return int(nearest)


@_compiled
def _start(frame: IntArray, source: int, edges: IntArray, heads: IntArray) -> None:
    """Begin the propagation of a node from the edges that enter it, other than lower-case ones."""
    for node in range(frame.shape[1]):
        frame[_DISTANCE, node] = _INFINITE
    frame[_SIZES, 0] = frame[_SIZES, 1] = 0
    for side in range(2):
        e = heads[source, side]
        while e >= 0:
            if edges[e, _KIND] != _LOWER:
                _reach(frame, edges[e, _FROM], edges[e, _WEIGHT], e, -1)
            e = edges[e, _NEXT]


@_compiled
def _extend(frame: IntArray, node: int, row: int, source: int, edges: IntArray, heads: IntArray) -> None:
    """Continue backwards over the edges entering `node` that are not negative; `row`: the path from there.

    A lower-case edge must not be crossed by what carries the same label. Labels start at the node P of their link
    alone, so that is the lower-case edge that leaves the source.
    """
    distance = frame[_DISTANCE, node]
    e = heads[node, 1]
    while e >= 0:
        if edges[e, _KIND] != _LOWER or edges[e, _FROM] != source:
            _reach(frame, edges[e, _FROM], distance + edges[e, _WEIGHT], e, row)
        e = edges[e, _NEXT]


@_compiled
def _origins(edges: IntArray, rows: IntArray, links: int) -> IntArray:
    """The links, in order, from which the edges in `rows` were derived."""
    found, seen = np.zeros(links, np.int64), np.zeros(edges.shape[0], np.int64)
    stack = np.empty(edges.shape[0] + rows.size, np.int64)
    size = 0
    for e in rows:
        stack[size] = e
        size += 1
    total = 0
    while size > 0:
        size -= 1
        e = stack[size]
        if edges[e, _LEFT] < 0:
            total += 1 - found[edges[e, _RIGHT]]
            found[edges[e, _RIGHT]] = 1
            continue
        for side in range(_LEFT, _RIGHT + 1):
            part = edges[e, side]
            if seen[part] == 0:
                seen[part] = 1
                stack[size] = part
                size += 1
    result = np.empty(total, np.int64)
    for link in range(links - 1, -1, -1):
        if found[link] != 0:
            total -= 1
            result[total] = link
    return result


@_compiled
def _finish(frame: IntArray, source: int, edges: IntArray, count: int, heads: IntArray) -> tuple[IntArray, int]:
    """Add what was found at distances that are not negative: ordinary edges for others to extend over."""
    for i in range(frame[_SIZES, 1]):
        node = frame[_MET, i]
        if frame[_DISTANCE, node] >= 0 and frame[_REST, node] >= 0 and node != source:
            edges, count = _append(
                edges,
                count,
                node,
                source,
                frame[_DISTANCE, node],
                _ORDINARY,
                frame[_FIRST, node],
                frame[_REST, node],
            )
            edges[count - 1, _NEXT] = heads[source, 1]
            heads[source, 1] = count - 1
    return edges, count


@_compiled
def propagate(n: int, links: IntArray) -> tuple[IntArray, int, IntArray, bool]:
    """Back-propagate from every negative node (Morris 2014, section 4), with an explicit stack.

    `links`: as `Stnu.table`. Returns the edge table, its length, the conflict's links and whether there is a conflict.
    """
    edges, count, nodes = _original_edges(n, links)
    heads, state = _thread(edges, count, nodes)
    frames = np.empty((4, _FRAME_ROWS, nodes), np.int64)
    sources, waiting, row_of = np.empty(nodes, np.int64), np.empty(nodes, np.int64), np.empty(nodes, np.int64)
    for root in range(nodes):
        if state[root] != _NEGATIVE:
            continue
        depth, sources[0], waiting[0], state[root] = 0, root, -1, _OPEN
        _start(frames[0], root, edges, heads)
        while depth >= 0:
            frame, source, node = frames[depth], sources[depth], waiting[depth]
            if node < 0:
                if frame[_SIZES, 0] == 0:
                    edges, count = _finish(frame, source, edges, count, heads)
                    state[source] = _FINISHED
                    depth -= 1
                    continue
                node = _take(frame)
                row_of[depth] = frame[_FIRST, node]
                if frame[_REST, node] >= 0:
                    kind, row_of[depth] = _LABELLED if source >= n else _ORDINARY, count
                    distance, first, rest = frame[_DISTANCE, node], frame[_FIRST, node], frame[_REST, node]
                    edges, count = _append(edges, count, node, source, distance, kind, first, rest)
                if state[node] == _OPEN:
                    first = depth
                    while sources[first] != node:
                        first -= 1
                    return edges, count, _origins(edges, row_of[first : depth + 1], links.shape[0]), True
                if state[node] == _NEGATIVE:
                    waiting[depth] = node
                    depth += 1
                    if depth == frames.shape[0]:
                        frames = _doubled(frames)
                    sources[depth], waiting[depth], state[node] = node, -1, _OPEN
                    _start(frames[depth], node, edges, heads)
                    continue
            waiting[depth] = -1
            _extend(frame, node, row_of[depth], source, edges, heads)
    return edges, count, np.empty(0, np.int64), False


@_compiled
def _doubled(frames: IntArray) -> IntArray:
    grown = np.empty((2 * frames.shape[0], frames.shape[1], frames.shape[2]), np.int64)
    for depth in range(frames.shape[0]):
        for row in range(_FRAME_ROWS):
            for node in range(frames.shape[2]):
                grown[depth, row, node] = frames[depth, row, node]
    return grown


@_compiled_for("i8[::1](i8[:, ::1], i8, i8)")
def _sorted_pairs(rows: IntArray, count: int, n: int) -> IntArray:
    """The order of the first `count` rows by column 0, then 1: two passes of counting sort."""
    order, result = np.empty(count, np.int64), np.empty(count, np.int64)
    for i in range(count):
        order[i] = i
    for column in range(1, -1, -1):
        starts = np.zeros(n + 1, np.int64)
        for i in range(count):
            starts[rows[i, column] + 1] += 1
        for node in range(n):
            starts[node + 1] += starts[node]
        for i in range(count):
            key = rows[order[i], column]
            result[starts[key]] = order[i]
            starts[key] += 1
        order, result = result, order
    return order


@_compiled_for("i8[:, ::1](i8[:, ::1], i8, i8)")
def _tightest(rows: IntArray, total: int, n: int) -> IntArray:
    """Of the first `total` rows (from, to, weight) the least weight of each pair, sorted by from and to."""
    order = _sorted_pairs(rows, total, n)
    distinct = 0
    for i in range(total):
        e, last = order[i], order[i - 1]
        if i == 0 or rows[e, 0] != rows[last, 0] or rows[e, 1] != rows[last, 1]:
            distinct += 1
    kept = np.empty((distinct, 3), np.int64)
    count = 0
    for i in range(total):
        e = order[i]
        if count > 0 and kept[count - 1, 0] == rows[e, 0] and kept[count - 1, 1] == rows[e, 1]:
            kept[count - 1, 2] = min(kept[count - 1, 2], rows[e, 2])
        else:
            kept[count, 0] = rows[e, 0]
            kept[count, 1] = rows[e, 1]
            kept[count, 2] = rows[e, 2]
            count += 1
    return kept


@_compiled
def _places(n: int, nodes: int, links: IntArray) -> IntArray:
    """For each node the timepoint that it follows after a fixed time, and the time; then the same as far as possible.

    First P by its activation. Then also the end of a contingent link that has but one duration, by its activation.
    """
    places = np.zeros((nodes, 4), np.int64)
    follows, delay = np.empty(n, np.int64), np.empty(n, np.int64)
    for node in range(n):
        places[node, 0], follows[node] = node, -1
    p, fixed = n, 0
    for i in range(links.shape[0]):
        if links[i, 4] != 0:
            places[p, 0], places[p, 1] = links[i, 0], links[i, 2]
            p += 1
            if links[i, 2] == links[i, 3]:
                follows[links[i, 1]], delay[links[i, 1]] = links[i, 0], links[i, 2]
                fixed += 1
    for node in range(nodes):
        first, after = places[node, 0], places[node, 1]
        for _ in range(fixed):  # no further, should the durations form a cycle
            if follows[first] < 0:
                break
            after += delay[first]
            first = follows[first]
        places[node, 2], places[node, 3] = first, after
    return places


@_compiled
def dispatch_form(n: int, links: IntArray, edges: IntArray, count: int) -> tuple[IntArray, IntArray]:
    """The edges and waits found, on the n timepoints alone: P is always the least duration after its activation.

    Returns rows (from, to, weight) and rows (contingent link counted among its kind, timepoint, -delay after the
    activation), each the tightest of its pair and sorted. Waits of timepoints that nature decides are left out. What
    concerns the end of a contingent link with one duration is said of its activation as well, the last moment at which
    the executive has a choice.
    """
    natural = np.zeros(n, np.int64)
    nodes = n
    for i in range(links.shape[0]):
        if links[i, 4] != 0:
            natural[links[i, 1]] = 1
            nodes += 1
    places = _places(n, nodes, links)
    rows, waits = np.empty((2 * count, 3), np.int64), np.empty((count, 3), np.int64)
    row_count = wait_count = 0
    for e in range(count):
        x, y, w, kind = edges[e, _FROM], edges[e, _TO], edges[e, _WEIGHT], edges[e, _KIND]
        if kind == _LABELLED and x < n and natural[x] == 0:
            waits[wait_count, 0] = y - n
            waits[wait_count, 1] = x
            waits[wait_count, 2] = w - places[y, 1]
            wait_count += 1
        elif kind == _ORDINARY:
            for side in range(0, 4, 2):
                again = side == 2 and places[x, 0] == places[x, 2] and places[y, 0] == places[y, 2]
                if places[x, side] != places[y, side] and not again:
                    rows[row_count, 0] = places[x, side]
                    rows[row_count, 1] = places[y, side]
                    rows[row_count, 2] = w + places[x, side + 1] - places[y, side + 1]
                    row_count += 1
    return _tightest(rows, row_count, n), _tightest(waits, wait_count, n)


@_compiled
def check_links(n: int, links: IntArray) -> tuple[IntArray, IntArray, IntArray, bool]:
    """Edges, waits, the conflict's links and whether there is a conflict (then no edges and waits)."""
    edges, count, conflict, found = propagate(n, links)
    if found:
        empty = np.empty((0, 3), np.int64)
        return empty, empty, conflict, True
    rows, waits = dispatch_form(n, links, edges, count)
    return rows, waits, conflict, False
