"""Charts of a report as inline SVG text: plan against execution, and telemetry. No scripts, no references."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from html import escape
from typing import Any

from scenarios.recording.reading import Plot
from scenarios.recording.style import DARK_RED, RED, Palette, token_label
from scenarios.run_story import Lane, RunStory, Stretch
from scenarios.times import clock

WIDTH = 1000
_PLOT_WIDTH = 560
_LEFT, _RIGHT = 8, 12
_LETTER, _BOLD = 5.7, 6.5  # mean widths of letters of 10 units height
_NAME, _THIN, _THICK, _GAP = 15, 8, 20, 9
_MARKS = 44.0  # height of the words above the lanes
_LINES = ("#2563a8", "#b34d12", "#187549", "#8a3fb0")
_HALF_WAY = 0.179  # the luminance on which black and white words stand out alike
_POINTS = 500
_STEPS_S = (60, 300, 600, 1800, 3600, 7200, 10_800, 21_600, 43_200, 86_400, 172_800, 604_800, 2_592_000)


class Axis:
    """From seconds to places on a chart that is `width` units wide, with `most` spaces between ticks."""

    def __init__(self, start: int, end: int, width: int = WIDTH, most: int = 13) -> None:
        self.start, self.end, self.width, self._most = start, max(end, start + 1), width, most

    def x(self, time: float) -> float:
        """Where a second is, in chart units."""
        share = (min(max(time, self.start), self.end) - self.start) / (self.end - self.start)
        return round(_LEFT + share * (self.width - _LEFT - _RIGHT), 1)

    def ticks(self) -> Iterator[int]:
        """Round times, `most` and one at most."""
        step = next((s for s in _STEPS_S if (self.end - self.start) / s <= self._most), _STEPS_S[-1])
        return iter(range(math.ceil(self.start / step) * step, self.end + 1, step))

    def grid(self, top: float, bottom: float) -> Iterator[str]:
        """Lines at the ticks, with their times below."""
        for tick in self.ticks():
            x = self.x(tick)
            anchor = "start" if x < 40 else "end" if x > self.width - 40 else "middle"
            yield f'<line class="grid" x1="{x}" y1="{top}" x2="{x}" y2="{bottom}"/>'
            yield f'<text class="tick" x="{x}" y="{bottom + 12}" text-anchor="{anchor}">{clock(tick)[:-3]}</text>'


def timeline(story: RunStory) -> str:
    """All lanes under the plans in force, with the faults and changes of plan across them."""
    axis, palette = Axis(*story.horizon), Palette()
    parts: list[str] = []
    names: list[str] = []  # above the marks that cross them
    y = _MARKS
    parts += _phases(story, axis, y)
    y += _THICK + _GAP
    for lane in story.lanes:
        names.append(f'<text class="lane" x="{_LEFT}" y="{y + 11}">{escape(lane.name)}</text>')
        parts += _lane(lane, axis, palette, y + _NAME)
        y += _NAME + 2 * _THIN + _THICK + _GAP
    name = f"plan against execution of {', '.join(lane.name for lane in story.lanes)}"
    return _svg(WIDTH, y + 18, [*axis.grid(_MARKS - 4, y), *parts, *_marks(story, axis, y), *names], name)


def _phases(story: RunStory, axis: Axis, y: float) -> Iterator[str]:
    for number, phase in enumerate(story.phases):
        colour = "#2b5c9e" if phase.plan and number % 4 < 2 else "#0f766e" if phase.plan else "#b07d1e"
        label = f"{phase.plan}: {phase.why}" if phase.plan else f"standby: {phase.why}"
        yield _bar(axis, phase.start, phase.end, y, _THICK, colour, label, f"{label}, from {clock(phase.start)}")


def _lane(lane: Lane, axis: Axis, palette: Palette, y: float) -> Iterator[str]:
    for stretches, words in ((lane.earliest, "planned, earliest"), (lane.latest, "planned, latest")):
        top = y if words.endswith("earliest") else y + _THIN + _THICK
        for stretch in stretches:
            label, colour = _look(stretch, palette)
            title = f"{words}: {label}, {_span(stretch)}"
            yield _bar(axis, stretch.start, stretch.end, top, _THIN - 1, colour, "", title, "planned")
    for stretch in lane.done:
        label, colour = _look(stretch, palette)
        word = {"failed": " failed", "aborted": " called off"}.get(stretch.state, "")
        title = f"{label}{word}, {_span(stretch)}" + (f": {stretch.note}" if stretch.note else "")
        yield _bar(axis, stretch.start, stretch.end, y + _THIN, _THICK - 1, colour, label, title)
        if word:
            x = axis.x(stretch.end)
            colour = _hex(RED if stretch.state == "failed" else DARK_RED)
            yield f'<rect x="{x - 2}" y="{y + _THIN}" width="4" height="{_THICK - 1}" fill="{colour}"/>'


def _marks(story: RunStory, axis: Axis, bottom: float) -> Iterator[str]:
    """Vertical lines: faults that occur, faults that are noticed, plans that take over."""
    kinds: dict[str, tuple[str, Callable[[Mapping[str, Any]], str]]] = {
        "fault.injected": ("fault", lambda e: f"{e['name']} occurs"),
        "fault.detected": ("seen", lambda e: f"noticed: {e.get('text') or e.get('diagnosis') or e.get('monitor')}"),
        "plan.adopted": ("plan", lambda e: f"{e['plan']} takes over"),
    }
    marks = [e for e in story.events(*kinds) if e["event"] != "plan.adopted" or e["reason"] != "initial"]
    for entry in marks:
        style, words = kinds[entry["event"]]
        x, text = axis.x(entry["t"]), words(entry)
        row = {"fault": 10, "seen": 22, "plan": 34}[style]
        anchor, offset = ("start", 3) if x < 0.6 * WIDTH else ("end", -3)
        # Half the way to the neighbour in the same row, if that one's words come towards these.
        others = [axis.x(e["t"]) for e in marks if e["event"] == entry["event"] and e is not entry]
        gaps = [abs(o - x) for o in others if (o > x) == (anchor == "start")]
        near = min(gaps, default=float(WIDTH))
        letters = int(near * (0.5 if anchor == "end" or x + near >= 0.6 * WIDTH else 1.0) / _BOLD)
        shown = text if len(text) <= letters else f"{text[: letters - 1]}…" if letters >= 4 else ""
        yield f'<line class="{style}" x1="{x}" y1="2" x2="{x}" y2="{bottom}"><title>{escape(text)}</title></line>'
        yield f'<text class="{style}" x="{x + offset}" y="{row}" text-anchor="{anchor}">{escape(shown)}</text>'


def plot(panel: Plot, title: str, story: RunStory) -> str:
    """One panel of telemetry."""
    axis, top, bottom = Axis(*story.horizon, _PLOT_WIDTH, most=6), 8.0, 118.0
    values = [v for _, row in panel.rows for v in row if math.isfinite(v)]
    if not values:
        return ""
    low, high = min(0.0, *values) if min(values) < 0.3 * max(values) else min(values), max(values)
    if high - low < 1e-9:
        low, high = low - 0.5, high + 0.5

    def y(value: float) -> float:
        return round(bottom - (value - low) / (high - low) * (bottom - top), 1)

    parts = [*axis.grid(top, bottom)]
    marks = [(value, y(value)) for value in _round_values(low, high)]
    right = _PLOT_WIDTH - _RIGHT
    parts += [f'<line class="grid" x1="{_LEFT}" y1="{at}" x2="{right}" y2="{at}"/>' for _, at in marks]
    for column in range(len(panel.rows[0][1])):
        colour = line_colour(column)
        points = " ".join(f"{axis.x(t)},{y(v)}" for t, v in _thinned([(t, row[column]) for t, row in panel.rows]))
        parts.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.5"/>')
    parts += [f'<text class="tick" x="{_LEFT + 2}" y="{at + 3}">{value:g}</text>' for value, at in marks]
    return _svg(_PLOT_WIDTH, bottom + 18, parts, f"{title}, {low:.4g} to {high:.4g}")


def _round_values(low: float, high: float) -> Iterator[float]:
    """Two to five round numbers in between."""
    decade = 10.0 ** math.floor(math.log10(high - low))
    step = next(s * decade for s in (0.2, 0.5, 1.0, 2.0, 5.0) if (high - low) / (s * decade) <= 4.5)
    for number in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1):
        yield round(number * step, 9)


def line_colour(column: int) -> str:
    """The colour of a plot's line."""
    return _LINES[column % len(_LINES)]


def _thinned(points: Sequence[tuple[int, float]]) -> Iterator[tuple[int, float]]:
    """Least and greatest value of each of a few hundred spans, so that no peak is lost."""
    size = max(1, math.ceil(2 * len(points) / _POINTS))
    for first in range(0, len(points), size):
        span = [p for p in points[first : first + size] if math.isfinite(p[1])]
        if span:
            ends = {min(span, key=lambda p: p[1]), max(span, key=lambda p: p[1])}
            yield from sorted(ends)


def _bar(
    axis: Axis, start: int, end: int, y: float, height: float, colour: str, label: str, title: str, style: str = "done"
) -> str:
    x, width = axis.x(start), round(max(0.6, axis.x(end) - axis.x(start)), 1)
    letters = int((width - 5) / _LETTER)
    shown = label if len(label) <= letters else label[: letters - 1] + "…" if letters >= 4 else ""
    ink = "label" if _luminance(colour) < _HALF_WAY else "label dark"
    text = f'<text class="{ink}" x="{x + 3}" y="{y + height - 6}">{escape(shown)}</text>' if shown else ""
    rect = f'<rect class="{style}" x="{x}" y="{y}" width="{width}" height="{height}" fill="{colour}"/>'
    return f"<g><title>{escape(title)}</title>{rect}{text}</g>"


def _luminance(colour: str) -> float:
    """Relative luminance of `#rrggbb`, as the contrast ratio of the Web Content Accessibility Guidelines has it."""
    shares = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    red, green, blue = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in shares)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def _look(stretch: Stretch, palette: Palette) -> tuple[str, str]:
    label = token_label(stretch.predicate, stretch.parameters)
    return label, _hex(palette.colour(stretch.predicate, stretch.parameters))


def _span(stretch: Stretch) -> str:
    return f"{clock(stretch.start)} to {clock(stretch.end)}"


def _hex(colour: int) -> str:
    return f"#{colour >> 8:06x}"


def _svg(width: int, height: float, parts: Iterable[str], name: str) -> str:
    head = f'<svg viewBox="0 0 {width} {height:g}" role="img" aria-label="{escape(name)}">'
    return head + "".join(parts) + "</svg>"
