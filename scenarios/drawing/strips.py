"""A long plan in several strips, one below the other, as music is set: where it is cut, and what goes on across a cut.

A strip shows a little of its neighbours, so that what stands at a cut can be read in one of the two at least.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from scenarios.drawing.layout import Box, Layout, boxes_of
from scenarios.drawing.text import LETTER, width

WIDEST = 1700.0
"""A drawing up to this wide, in pixels, is not cut."""
OVERLAP = 36.0
_LONGEST = 1500.0
_SHORTEST = 0.6
"""The shortest that a strip may be, as a share of the longest."""


@dataclass(frozen=True, slots=True)
class Strip:
    """A piece of a drawing from column to column, and the boxes that began before it."""

    left: float
    right: float
    continued: tuple[Box, ...]


def strips_of(layout: Layout) -> list[Strip]:
    """The strips of a drawing; a single one where it is not too wide."""
    columns = sorted({x for box in boxes_of(layout) for x in (box.x, box.right)})
    if layout.wide <= WIDEST:
        return [Strip(layout.gutter, layout.wide, ())]
    cuts = [columns[0]]
    while columns[-1] - cuts[-1] > _LONGEST:
        within = [x for x in columns if _SHORTEST * _LONGEST <= x - cuts[-1] <= _LONGEST]
        beyond = next(x for x in columns if x > cuts[-1])
        cuts.append(min(within, key=lambda x: (_spoilt(layout, x), -x)) if within else beyond)
    cuts.append(columns[-1])
    return [
        Strip(left, right, tuple(b for b in boxes_of(layout) if b.x < left - OVERLAP and b.right > left + OVERLAP))
        for left, right in pairwise(cuts)
    ]


def _spoilt(layout: Layout, cut: float) -> int:
    """How many boxes have words on both sides of a cut."""
    crossed = (box for box in boxes_of(layout) if box.x < cut < box.right)
    return sum(box.x + 6 + max(_words(box)) > cut + OVERLAP for box in crossed)


def _words(box: Box) -> Iterator[float]:
    return (width(line, LETTER) for line in box.lines)
