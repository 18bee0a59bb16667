"""Pairwise distances on the buffers of `kernel_python`, in the same compiled-or-plain style.

The exact bounds are a potential under which no arc is negative, so Dijkstra's algorithm applies (Johnson, "Efficient
algorithms for shortest paths in sparse networks", Journal of the ACM 24, 1977).
"""

from __future__ import annotations

from planner.temporal.kernel_python import SPAN, TARGET, Buffer


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


def shortest(labels: Buffer, pool: Buffer, heap: Buffer, source: int, goal: int) -> int:
    """Dijkstra from label `source` on reduced costs, its own value as potential; the origin's edges are the bounds.

    `heap` has three words a timepoint (see `sift`). Returns the distance to label `goal` (-1: to none). The key of a
    timepoint that is final is then its distance less the value of its label plus that of the source; to any other the
    shortest way is through the origin, `labels[other] + labels[source ^ 1]`.
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
    while size > 0:
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
