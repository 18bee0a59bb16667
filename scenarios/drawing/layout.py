"""Where everything of a plan's drawing goes.

Time runs to the right, and not to scale: every box is as wide as its words need. Boxes are drawn from earliest start to
earliest end; equal earliest times share a column, so what begins together stands together. Column positions are the
longest paths over "this box needs so much room", taken in order of time.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest

from planner.model.resources import LEVEL
from planner.plan import FlexiblePlan, PlanToken
from scenarios.drawing.text import LETTER, SMALL, bounds, cut, parameters, predicate, width

Column = tuple[float, int]
"""An earliest time, and how many instants at that time lie before."""
PAD, GAP = 6.0, 7.0
LINE = 13.0
ANY_DURATION = (1, None)
TOP, TICKS = 58.0, 42.0
LANE_GAP = 30.0
THIN = 18.0
ROW_GAP = 3.0
MARGIN = 14.0


@dataclass(slots=True)
class Box:
    """A host token as it is drawn. `slot`: it and what is codesignated with it. `edge_text`: bounds of start and end,
    empty where another box or a master says them. `columns`: of its start and its end."""

    token: PlanToken
    slot: tuple[PlanToken, ...]
    lines: tuple[str, ...]
    columns: tuple[Column, Column]
    edge_text: tuple[str, str] = ("", "")
    joined: bool = False
    x: float = 0.0
    y: float = 0.0
    wide: float = 0.0
    high: float = 0.0

    @property
    def right(self) -> float:
        """The right edge."""
        return self.x + self.wide

    @property
    def instant(self) -> bool:
        """Whether it takes no time: then only its left edge is one."""
        return self.token.duration == (0, 0)

    @property
    def transaction(self) -> bool:
        """Whether it takes from a resource, or gives."""
        return self.token.attribute == LEVEL

    @property
    def goals(self) -> list[str]:
        """The goals that it achieves."""
        return [t.goal for t in self.slot if t.goal is not None]

    def words_wide(self) -> float:
        """What its words need."""
        inside = max(width(line, LETTER if n == 0 else SMALL) for n, line in enumerate(self.lines)) + 2 * PAD
        return max(inside, sum(width(text, SMALL) for text in self.edge_text if text) + 2 * PAD)


@dataclass(slots=True)
class Lane:
    """A timeline, whose boxes lie in one row, or what has no order, where boxes take as many rows as overlap.

    `thin`: transactions on a resource, a line of words each.
    """

    name: str
    boxes: list[Box]
    ordered: bool
    thin: bool = False
    y: float = 0.0
    high: float = 0.0


@dataclass(slots=True)
class Layout:
    """A drawing's geometry, pixels from the upper left corner. `ticks`: columns with the times to write there."""

    lanes: list[Lane]
    by_token: dict[str, tuple[int, Box]] = field(default_factory=dict)
    ticks: list[tuple[float, str]] = field(default_factory=list)
    gutter: float = 0.0
    wide: float = 0.0
    high: float = 0.0


def lay_out(plan: FlexiblePlan) -> Layout:
    """The geometry of a plan's drawing."""
    lanes = [lane for lane in (*_timelines(plan), *_others(plan)) if lane.boxes]
    layout = Layout(lanes)
    layout.gutter = MARGIN + max((width(lane.name) for lane in lanes), default=0.0) + MARGIN
    places = _columns([box for lane in lanes for box in lane.boxes], layout.gutter)
    y = TOP
    for number, lane in enumerate(lanes):
        lane.y = y
        for box in lane.boxes:
            box.x = places[box.columns[0]]
            box.wide = places[box.columns[1]] - box.x
            layout.by_token.update((token.id, (number, box)) for token in box.slot)
        _stack(lane)
        y += lane.high + LANE_GAP
    layout.wide = max(places.values(), default=layout.gutter) + 3 * MARGIN
    layout.high = y
    layout.ticks = list(_ticks(places))
    return layout


def _timelines(plan: FlexiblePlan) -> Iterator[Lane]:
    for timeline in plan.timelines:
        boxes: list[Box] = []
        before: Box | None = None
        for slot in timeline.slots:
            tokens = tuple(plan.token(i) for i in slot)
            box = _box(plan, tokens, before)
            box.joined = before is not None and before.token.end == box.token.start
            boxes.append(box)
            before = box
        for box, after in zip_longest(boxes, boxes[1:]):
            ends_alone = after is None or not after.joined
            box.edge_text = bounds(box.token.start), bounds(box.token.end) if ends_alone else ""
        yield Lane(cut(f"{timeline.object}.{timeline.attribute}"), boxes, ordered=True)


def _others(plan: FlexiblePlan) -> Iterator[Lane]:
    """Tokens of resources and of attributes without order, a lane for each object."""
    placed = {i for timeline in plan.timelines for slot in timeline.slots for i in slot}
    same: dict[str, str] = {}
    for constraint in plan.constraints:
        if constraint.why == "codesignated":
            same[constraint.to.partition(".")[0]] = constraint.from_.partition(".")[0]
    merged: dict[str, list[PlanToken]] = defaultdict(list)
    for token in plan.tokens:
        if token.id in same:
            merged[same[token.id]].append(token)
    lanes: dict[str, list[Box]] = defaultdict(list)
    for token in plan.tokens:
        if token.id in placed or token.id in same:
            continue
        box = _box(plan, (token, *merged[token.id]), None)
        if box.transaction:
            box.lines = (cut(f"{predicate(token)} {parameters(token)}".strip()),)
        else:
            box.edge_text = bounds(token.start), bounds(token.end)
        lanes[token.object or token.predicate.partition(".")[0]].append(box)
    for name, boxes in lanes.items():
        yield Lane(cut(name), boxes, ordered=False, thin=all(box.transaction for box in boxes))


def _box(plan: FlexiblePlan, slot: tuple[PlanToken, ...], before: Box | None) -> Box:
    token = slot[0]
    goals = ", ".join(t.goal for t in slot if t.goal is not None)
    lasting = f"{'nature: ' if token.contingent else 'lasts '}{bounds(token.duration)}"
    if token.duration == ANY_DURATION:
        lasting = ""
    lines = [predicate(token), parameters(token), lasting, f"goal {goals}" if goals else ""]
    start: Column = (plan.horizon[0] - 1 if token.start[0] is None else token.start[0], 0)
    if before is not None and start <= before.columns[1]:
        start = before.columns[1]
    lower = token.end[0]
    end: Column = (start[0] if lower is None else max(lower, start[0]), 0)
    if end <= start:
        end = (start[0], start[1] + 1)
    return Box(token, slot, tuple(cut(line) for line in lines if line), (start, end))


def _columns(boxes: Sequence[Box], left: float) -> dict[Column, float]:
    """The place of every column."""
    needs: dict[Column, list[tuple[Column, float]]] = defaultdict(list)
    for box in boxes:
        needs[box.columns[1]].append((box.columns[0], box.words_wide()))
    order = sorted({column for box in boxes for column in box.columns})
    places: dict[Column, float] = {}
    x = left
    for column in order:
        x = max([x, *(places[start] + room for start, room in needs[column])])
        places[column] = x
        x += GAP
    return places


def _stack(lane: Lane) -> None:
    """Heights of a lane's boxes: side by side on a timeline, in rows where they overlap elsewhere."""
    high = THIN if lane.thin else max(len(box.lines) for box in lane.boxes) * LINE + 8
    apart = high + (ROW_GAP if lane.thin else LINE + ROW_GAP)
    rows: list[float] = []
    for box in lane.boxes if lane.ordered else sorted(lane.boxes, key=lambda b: (b.x, b.token.id)):
        row = next((n for n, right in enumerate(rows) if lane.ordered or right <= box.x), len(rows))
        rows[row:] = [box.right, *rows[row + 1 :]]
        box.y, box.high = lane.y + row * apart, high
    lane.high = len(rows) * apart


def _ticks(places: dict[Column, float]) -> Iterator[tuple[float, str]]:
    """Times over as many columns as have room for them, every one on its own."""
    free = 0.0
    for (time, instant), x in places.items():
        text = f"{time:g}" if abs(time) < 1e6 else str(int(time))
        half = width(text, SMALL) / 2
        if not instant and x - half >= free:
            yield x, text
            free = x + half + PAD


def boxes_of(layout: Layout) -> Iterable[Box]:
    """All boxes, lane by lane."""
    return (box for lane in layout.lanes for box in lane.boxes)
