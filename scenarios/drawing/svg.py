"""A flexible plan as an SVG document: no scripts, nothing loaded, its own background in light and in dark."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from planner.files import write_whole
from planner.plan import FlexiblePlan
from scenarios.drawing.layout import LINE, MARGIN, TICKS, Box, Lane, Layout, boxes_of, lay_out
from scenarios.drawing.links import Link, links_of
from scenarios.drawing.strips import OVERLAP, Strip, strips_of
from scenarios.drawing.style import HUES, STYLE
from scenarios.drawing.text import SMALL, bounds, parameters, width, xml

_LEGEND = (
    ("box", "from earliest start to earliest end, not to scale; below: [earliest latest]"),
    ("goal", "achieves a goal"),
    ("fact", "given"),
    ("nature", "nature decides how long"),
    ("after", "not before, where no other line says so"),
    ("same", "at the same time"),
    ("order", "ordered by the search"),
    ("asked", "required, at any time"),
)


_HEAD = 28.0
"""Height of the title above everything else."""


def draw(plan: FlexiblePlan) -> str:
    """The SVG text of a plan."""
    layout = lay_out(plan)
    links = links_of(plan, layout)
    shown = {link.style for link in links}
    legend = [entry for entry in _LEGEND if entry[0] in _kinds(layout) | shown]
    content = [
        *_grid(layout),
        *(part for link in links for part in _link(link)),
        *(part for lane in layout.lanes for part in _lane(lane, _hues(layout))),
        *(_link_label(link) for link in links if link.label_at is not None),
    ]
    strips = strips_of(layout)
    room = max(strip.right - strip.left for strip in strips) + 2 * OVERLAP
    wide = layout.wide if len(strips) == 1 else layout.gutter + room + MARGIN
    wide = max(wide, 560.0, MARGIN * 2 + width(_title(plan)))
    parts = [f'<text class="title" x="{MARGIN}" y="22">{xml(_title(plan))}</text>']
    if len(strips) == 1:
        parts += [*_bands(layout, wide, 0), *content]
    else:
        parts += ["<defs>", '<g id="plan">', *content, "</g>", "</defs>"]
        for number, strip in enumerate(strips):
            parts += _strip(layout, strip, wide, number, number == len(strips) - 1)
    rows, bottom = _legend(legend, wide, _HEAD + len(strips) * (layout.high - _HEAD))
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide:.0f}" height="{bottom:.0f}" '
        f'viewBox="0 0 {wide:.0f} {bottom:.0f}" role="img" aria-label="{xml(_title(plan))}">'
    )
    return "\n".join([head, f"<style>{STYLE}</style>", _DEFINITIONS, *parts, *rows, "</svg>", ""])


def save(plan: FlexiblePlan, path: Path) -> None:
    """Write the drawing, whole or not at all; OSError when it cannot be written."""
    write_whole(path, draw(plan))


_DEFINITIONS = (
    '<defs><pattern id="hatch" width="7" height="7" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">'
    '<line class="hatch" x1="0" y1="0" x2="0" y2="7"/></pattern>'
    + "".join(
        f'<marker id="tip-{style}" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" '
        f'orient="auto-start-reverse"><path class="tip-{style}" d="M0 0.8 L8 4 L0 7.2 Z"/></marker>'
        for style in ("after", "order", "asked")
    )
    + '</defs><rect class="back" width="100%" height="100%"/>'
)


def _title(plan: FlexiblePlan) -> str:
    return f"{plan.model}: {len(plan.tokens)} tokens, horizon {bounds(plan.horizon)}"


def _bands(layout: Layout, wide: float, down: float) -> Iterator[str]:
    """The bands behind the timelines, with their names."""
    for lane in layout.lanes:
        y = lane.y + down
        yield f'<rect class="band" x="0" y="{y - 7:.1f}" width="{wide:.0f}" height="{lane.high + 9:.1f}"/>'
        yield f'<text class="lane" x="{MARGIN}" y="{y + LINE:.1f}">{xml(lane.name)}</text>'


def _grid(layout: Layout) -> Iterator[str]:
    """Columns of times."""
    for x, text in layout.ticks:
        yield f'<line class="grid" x1="{x:.1f}" y1="{TICKS + 4}" x2="{x:.1f}" y2="{layout.high - 20:.1f}"/>'
        yield f'<text class="tick" x="{x:.1f}" y="{TICKS}">{text}</text>'


def _strip(layout: Layout, strip: Strip, wide: float, number: int, is_last: bool) -> Iterator[str]:
    """A piece of the drawing, what it shares with its neighbours faded, and the names of what began before it."""
    high = layout.high - _HEAD
    top, room = _HEAD + number * high, strip.right - strip.left + 2 * OVERLAP
    yield from _bands(layout, wide, number * high)
    yield (
        f'<svg x="{layout.gutter:.1f}" y="{top:.1f}" width="{room:.1f}" height="{high:.1f}" '
        f'viewBox="{strip.left - OVERLAP:.1f} {_HEAD} {room:.1f} {high:.1f}"><use href="#plan"/></svg>'
    )
    fade = f'class="back fade" y="{top:.1f}" width="{OVERLAP}" height="{high:.1f}"'
    if number:
        yield f'<rect {fade} x="{layout.gutter:.1f}"/>'
    if not is_last:
        yield f'<rect {fade} x="{layout.gutter + room - OVERLAP:.1f}"/>'
    for box in strip.continued:
        x, y = layout.gutter + OVERLAP + 5, box.y + LINE + number * high
        yield f'<text class="more" x="{x:.1f}" y="{y:.1f}">… {xml(box.lines[0])}</text>'


def _hues(layout: Layout) -> dict[str, int]:
    """A hue for each predicate, in the order in which they are drawn."""
    found: dict[str, int] = {}
    for box in boxes_of(layout):
        found.setdefault(box.token.predicate, len(found) % HUES)
    return found


def _kinds(layout: Layout) -> set[str]:
    boxes = list(boxes_of(layout))
    kinds = {"box"} if boxes else set()
    kinds |= {"goal"} if any(box.goals for box in boxes) else set()
    kinds |= {"fact"} if any(_is_given(box) for box in boxes) else set()
    return kinds | ({"nature"} if any(box.token.contingent for box in boxes) else set())


def _is_given(box: Box) -> bool:
    return any(token.fact for token in box.slot)


def _lane(lane: Lane, hues: dict[str, int]) -> Iterator[str]:
    for box in lane.boxes:
        classes = f"box h{hues[box.token.predicate]}" + (" goal" if box.goals else "")
        classes += " fact" if _is_given(box) else ""
        place = (
            f'x="{box.x + 0.5:.1f}" y="{box.y:.1f}" width="{max(box.wide - 1, 1):.1f}" height="{box.high:.1f}" rx="3"'
        )
        yield f"<g><title>{xml(_told(box))}</title>"
        yield f'<rect class="{classes}" {place}/>'
        if box.token.contingent:
            yield f'<rect fill="url(#hatch)" {place}/>'
        for number, line in enumerate(box.lines):
            style = "name" if number == 0 and not lane.thin else "goal" if line.startswith("goal ") else "more"
            y = box.y + (number + 1) * LINE
            yield f'<text class="{style}" x="{box.x + 6:.1f}" y="{y:.1f}">{xml(line)}</text>'
        yield from _edges(lane, box)
        yield "</g>"


def _edges(lane: Lane, box: Box) -> Iterator[str]:
    """Bounds of start and end below a box of a timeline; where two boxes touch, once and in the middle."""
    if lane.thin:
        return
    start, end = box.edge_text
    y = box.y + box.high + LINE - 1.5
    anchor, x = ("middle", box.x) if box.joined else ("start", box.x + 3)
    yield f'<text class="edge {anchor}" x="{x:.1f}" y="{y:.1f}">{start}</text>'
    if end:
        yield f'<text class="edge end" x="{box.right - 3:.1f}" y="{y:.1f}">{end}</text>'


def _told(box: Box) -> str:
    """All that there is to say about a box."""
    token = box.token
    lines = [
        f"{token.predicate}({parameters(token)})  {', '.join(t.id for t in box.slot)}",
        f"start {bounds(token.start)}, end {bounds(token.end)}, duration {bounds(token.duration)}",
        *(["its duration is nature's choice"] if token.contingent else []),
        *(f"goal {goal}" for goal in box.goals),
        *(["given"] if _is_given(box) else []),
        *([f"{len(box.slot)} tokens are one here"] if len(box.slot) > 1 else []),
    ]
    return "\n".join(lines)


def _link(link: Link) -> Iterator[str]:
    (x1, y1), (x2, y2) = link.start, link.end
    (cx1, cy1), (cx2, cy2) = link.controls
    tip = "" if link.style == "same" else f' marker-end="url(#tip-{link.style})"'
    path = f"M{x1:.1f} {y1:.1f} C{cx1:.1f} {cy1:.1f} {cx2:.1f} {cy2:.1f} {x2:.1f} {y2:.1f}"
    yield f'<path class="link {link.style}" d="{path}"{tip}><title>{xml(link.why)}</title></path>'


def _link_label(link: Link) -> str:
    assert link.label_at is not None
    x, y = link.label_at
    return f'<text class="bound" x="{x:.1f}" y="{y:.1f}">{link.label}</text>'


def _legend(entries: list[tuple[str, str]], wide: float, top: float) -> tuple[list[str], float]:
    """The key, in as many lines as it needs, and where the drawing ends."""
    parts: list[str] = []
    x, y = MARGIN, top + 4
    for kind, text in entries:
        room = 30 + width(text, SMALL) + 16
        if x + room > wide and x > MARGIN:
            x, y = MARGIN, y + 18
        parts += [_sign(kind, x, y), f'<text class="key" x="{x + 30:.1f}" y="{y + 9:.1f}">{text}</text>']
        x += room
    return parts, y + 18 + MARGIN


def _sign(kind: str, x: float, y: float) -> str:
    if kind in ("box", "goal", "fact", "nature"):
        place = f'x="{x:.1f}" y="{y:.1f}" width="24" height="11" rx="3"'
        hatch = f'<rect fill="url(#hatch)" {place}/>' if kind == "nature" else ""
        return f'<rect class="box h0 {kind if kind != "box" else ""}" {place}/>{hatch}'
    tip = "" if kind == "same" else f' marker-end="url(#tip-{kind})"'
    return f'<path class="link {kind}" d="M{x:.1f} {y + 6:.1f} H{x + 24:.1f}"{tip}/>'
