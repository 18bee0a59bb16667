"""What was found in an image, as boxes over it: written to a recording, and read back."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import rerun as rr

from scenarios.recording.stream import Stream

Kind = Literal["target", "star"]
COLOURS: dict[Kind, tuple[int, int, int]] = {"target": (255, 150, 40), "star": (90, 160, 255)}
HALF_PX: dict[Kind, float] = {"target": 36.0, "star": 7.0}
_DRAW_ORDER: dict[Kind, float] = {"star": 20.0, "target": 30.0}
_FRAME = (70, 78, 90)
_WIDTH = 1.5  # of the outline, in points of the screen


@dataclass(frozen=True, slots=True)
class Mark:
    """Something found at a column and a row, in pixels; the middle of the first one is 0. `label`: its name, if any."""

    kind: Kind
    column: float
    row: float
    label: str = ""


def path_of(image: str, kind: Kind) -> str:
    """The entity of the marks of one kind: under the image, so that every view of it shows them."""
    return f"{image}/{kind}"


def draw_frame(stream: Stream, image: str, size_px: int) -> None:
    """Outline the images of this entity.

    Not for looks alone: the viewer (0.41) may hide what comes next above an image in the order of drawing, as if it
    were too near. The outline takes that place, and what comes after it is always seen.
    """
    half = size_px / 2
    outline = rr.Boxes2D(centers=[(half, half)], half_sizes=[(half, half)], colors=[_FRAME], draw_order=1.0)
    stream.static(f"{image}/frame", outline)


def draw(stream: Stream, time: int, image: str, marks: Sequence[Mark]) -> None:
    """Write the marks of the image of this second. Without any, those of the image before go all the same."""
    for kind, colour in COLOURS.items():
        found = [mark for mark in marks if mark.kind == kind]
        boxes = rr.Boxes2D(
            centers=[(mark.column + 0.5, mark.row + 0.5) for mark in found],
            half_sizes=[(HALF_PX[kind], HALF_PX[kind])] * len(found),
            colors=[colour] * len(found),
            radii=rr.Radius.ui_points([_WIDTH] * len(found)),
            labels=[mark.label for mark in found] if any(mark.label for mark in found) else [],
            draw_order=_DRAW_ORDER[kind],
        )
        stream.at(time, path_of(image, kind), boxes)


def read(batch: Any, kind: Kind) -> Iterator[list[Mark]]:
    """The marks of every row of a chunk of `path_of` a kind, without their labels."""
    for centres in batch.column("Boxes2D:centers").to_pylist():
        yield [Mark(kind, column - 0.5, row - 0.5) for column, row in centres or ()]
