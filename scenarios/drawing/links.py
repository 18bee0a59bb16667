"""The links of a plan's drawing: which temporal constraints are worth a line, and the line that each gets."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

from planner.plan import ORIGIN, Bounds, FlexiblePlan
from scenarios.drawing.layout import TICKS, Box, Layout
from scenarios.drawing.text import SMALL, bounds, width

Style = Literal["after", "same", "order", "asked"]
"""after: not before; same: at the same time; order: what the search decided; asked: required, without a constraint."""
Point = tuple[float, float]
Edge = tuple[int, bool]
"""A box by its identity, and whether it is its end."""
Rectangle = tuple[float, float, float, float]
"""Left, top, right, bottom."""
_TRIED = (0.5, 0.38, 0.62, 0.28, 0.72, 0.2, 0.8)


@dataclass(slots=True, eq=False)
class Link:
    """A line from one timepoint to another; `ends` are their edges.

    `label`: bounds that go beyond "not before", where there is room.
    """

    style: Style
    ends: tuple[Edge, Edge]
    start: Point
    end: Point
    controls: tuple[Point, Point]
    why: str
    label: str = ""
    label_at: Point | None = None


def links_of(plan: FlexiblePlan, layout: Layout) -> list[Link]:
    """The links, without those that the order of a timeline says already."""
    found = reduced(list(_constraints(plan, layout)), layout)
    _place_labels(found, layout)
    return found


def _constraints(plan: FlexiblePlan, layout: Layout) -> Iterator[Link]:
    linked: set[frozenset[int]] = set()
    for constraint in plan.constraints:
        if ORIGIN in (constraint.from_, constraint.to) or constraint.why == "codesignated":
            continue
        ends = (constraint.from_, constraint.to)
        low, high = constraint.min, constraint.max
        if high is not None and high <= 0 and (low is None or low < 0):  # read it the other way round
            ends, low, high = ends[::-1], -high, None if low is None else -low
        found = [layout.by_token[name] for end in ends if (name := end.partition(".")[0]) in layout.by_token]
        if len(found) < 2 or found[0][1] is found[1][1]:
            continue
        (lane, box), (other_lane, other) = found
        linked.add(frozenset((id(box), id(other))))
        if _goes_without_saying(lane == other_lane and layout.lanes[lane].ordered, box, other, ends, (low, high)):
            continue
        style: Style = "order" if constraint.why.startswith("order ") else "same" if low == high == 0 else "after"
        label = "" if (low, high) in ((0, None), (0, 0)) else bounds((low, high))
        text = f"{low if low is not None else '-inf'} <= {ends[1]} - {ends[0]} <= {high if high is not None else 'inf'}"
        yield _line(style, (box, ends[0]), (other, ends[1]), lane == other_lane, f"{text}: {constraint.why}", label)
    yield from _asked(plan, layout, linked)


def _goes_without_saying(same_timeline: bool, box: Box, other: Box, ends: tuple[str, str], distance: Bounds) -> bool:
    """Whether the drawing shows it by itself: the order of a timeline, boxes that touch, and a use of a resource that
    lasts as long as what asked for it."""
    if same_timeline:
        touching = distance == (0, 0) and other.joined and ends[0].endswith(".end")
        return touching or (distance == (0, None) and box.x <= other.x)
    equal = distance == (0, 0) and ends[0].rpartition(".")[2] == ends[1].rpartition(".")[2]
    return equal and (box.transaction or other.transaction) and box.columns == other.columns


def _asked(plan: FlexiblePlan, layout: Layout, linked: set[frozenset[int]]) -> Iterator[Link]:
    """What a rule asks for without saying when."""
    for token in plan.tokens:
        if token.master is None or token.id not in layout.by_token or token.master not in layout.by_token:
            continue
        (lane, box), (other_lane, other) = layout.by_token[token.master], layout.by_token[token.id]
        pair = frozenset((id(box), id(other)))
        if box is not other and pair not in linked:
            linked.add(pair)
            ends = (box, f"{token.master}.start"), (other, f"{token.id}.start")
            yield _line("asked", *ends, lane == other_lane, f"required by {box.token.predicate}", "")


def _line(style: Style, start: tuple[Box, str], end: tuple[Box, str], same_lane: bool, why: str, label: str) -> Link:
    (a, from_), (b, to) = start, end
    edges = (id(a), from_.endswith(".end")), (id(b), to.endswith(".end"))
    x1 = a.right if edges[0][1] and not a.instant else a.x
    x2 = b.right if edges[1][1] and not b.instant else b.x
    if same_lane and a.y == b.y:
        lift = 16.0
        return Link(style, edges, (x1, a.y), (x2, b.y), ((x1, a.y - lift), (x2, b.y - lift)), why, label)
    down = a.y < b.y
    y1 = a.y + a.high if down else a.y
    y2 = b.y if down else b.y + b.high
    reach = max(10.0, 0.45 * abs(y2 - y1)) * (1 if down else -1)
    return Link(style, edges, (x1, y1), (x2, y2), ((x1, y1 + reach), (x2, y2 - reach)), why, label)


def reduced(links: list[Link], layout: Layout) -> list[Link]:
    """The links without each plain "not before" that the others and the order of the timelines imply."""
    after: dict[Edge, set[Edge]] = defaultdict(set)
    for lane in layout.lanes:
        for box in lane.boxes:
            after[id(box), False].add((id(box), True))
        for box, following in pairwise(lane.boxes if lane.ordered else ()):
            after[id(box), True].add((id(following), False))
    plain = [link for link in links if link.style == "after" and not link.label]
    for link in links:
        if link.style == "same":
            after[link.ends[1]].add(link.ends[0])
        if link.style != "asked" and link not in plain:
            after[link.ends[0]].add(link.ends[1])
    count = Counter(link.ends for link in plain)
    for from_, to in count:
        after[from_].add(to)
    implied: set[tuple[Edge, Edge]] = set()
    for ends in count:
        after[ends[0]].discard(ends[1])
        if _leads(after, *ends):
            implied.add(ends)
        else:
            after[ends[0]].add(ends[1])
    return [link for link in links if link.ends not in implied or link not in plain]


def _leads(after: dict[Edge, set[Edge]], start: Edge, goal: Edge) -> bool:
    seen, todo = {start}, [start]
    while todo:
        for edge in after.get(todo.pop(), ()):
            if edge == goal:
                return True
            if edge not in seen:
                seen.add(edge)
                todo.append(edge)
    return False


def _place_labels(links: list[Link], layout: Layout) -> None:
    """Give each label a place on its line where it covers nothing; one without such a place is left to the title."""
    taken: list[Rectangle] = []
    for lane in layout.lanes:
        for box in lane.boxes:
            below = 0.0 if lane.thin else 13.0
            taken.append((box.x, box.y, box.right, box.y + box.high + below))
    for x, text in layout.ticks:
        half = width(text, SMALL) / 2
        taken.append((x - half, TICKS - SMALL, x + half, TICKS))
    for link in links:
        if not link.label:
            continue
        half = width(link.label, SMALL) / 2 + 1
        for share in _TRIED:
            x, y = _on_curve(link, share)
            place = (x - half, y - 6, x + half, y + 6)
            if place[0] > layout.gutter and not any(_overlap(place, other) for other in taken):
                link.label_at = (x, y + 3)
                taken.append(place)
                break


def _on_curve(link: Link, t: float) -> Point:
    s = 1 - t
    weights = (s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t)
    points = (link.start, *link.controls, link.end)
    return sum(w * p[0] for w, p in zip(weights, points, strict=True)), sum(
        w * p[1] for w, p in zip(weights, points, strict=True)
    )


def _overlap(a: Rectangle, b: Rectangle) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
