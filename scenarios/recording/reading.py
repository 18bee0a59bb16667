"""Reading a recording back: the telemetry plots and the pictures, for a report. The rest is in the run folder."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from rerun.chunk import RrdReader

from scenarios.recording import marks
from scenarios.recording.blueprint import CAMERA_FALLBACK, CAMERA_LOG, CHASE, CHASE_CAPTION
from scenarios.recording.scene import CAMERA_IMAGE
from scenarios.recording.stream import TIMELINE

_PLOTS = "/telemetry/"
_MARKS = {marks.path_of(image, kind): kind for image in (CAMERA_IMAGE, CAMERA_FALLBACK) for kind in marks.COLOURS}
_NS = 1_000_000_000


@dataclass
class Plot:
    """One panel of telemetry: `rows` of (simulation second, a value for each of `names`), in order of time."""

    path: str
    names: tuple[str, ...] = ()
    rows: list[tuple[int, list[float]]] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture as it was recorded, encoded as `media_type` says. `marks`: what was found in it."""

    time: int
    camera: Literal["micas", "chase"]
    media_type: str
    blob: bytes
    caption: str = ""
    marks: tuple[marks.Mark, ...] = ()


@dataclass
class Readings:
    """What a recording holds of telemetry and pictures."""

    plots: dict[str, Plot] = field(default_factory=dict)
    pictures: list[Picture] = field(default_factory=list)


def read(rrd: Path) -> Readings:
    """Plots and pictures of a recording, also of one whose run was killed; nothing where there is no recording."""
    readings = Readings()
    captions: dict[tuple[str, int], str] = {}
    found: dict[int, list[marks.Mark]] = {}
    for chunk in _chunks(rrd):
        path, batch = str(chunk.entity_path), chunk.to_record_batch()
        if path.startswith(_PLOTS):
            _plot(readings.plots.setdefault(path, Plot(path)), batch)
        elif chunk.is_static:
            continue
        elif path in (CAMERA_IMAGE, CAMERA_FALLBACK, CHASE):
            readings.pictures += _pictures(batch, "chase" if path == CHASE else "micas")
        elif path in (CAMERA_LOG, CHASE_CAPTION):
            camera, texts = "micas" if path == CAMERA_LOG else "chase", batch.column("TextLog:text").to_pylist()
            rows = zip(_seconds(batch), texts, strict=True)
            captions |= {(camera, t): row[0].partition("  ")[2] for t, row in rows}
        elif path in _MARKS:
            for t, row in zip(_seconds(batch), marks.read(batch, _MARKS[path]), strict=True):
                found.setdefault(t, []).extend(row)
    readings.pictures = [
        replace(
            p,
            caption=captions.get((p.camera, p.time), ""),
            marks=tuple(found.get(p.time, ()) if p.camera == "micas" else ()),
        )
        for p in sorted(readings.pictures, key=lambda p: p.time)
    ]
    for plot in readings.plots.values():
        plot.rows.sort(key=lambda row: row[0])
    return readings


def _chunks(rrd: Path) -> list[Any]:
    if not rrd.is_file():
        return []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a run that was killed leaves a file without its index
        try:
            return list(RrdReader(rrd).stream())
        except (ValueError, OSError, RuntimeError):
            return []


def _seconds(batch: Any) -> list[int]:
    return [t // _NS for t in batch.column(TIMELINE).cast("int64").to_pylist()]


def _plot(plot: Plot, batch: Any) -> None:
    columns = batch.schema.names
    if "SeriesLines:names" in columns:
        plot.names = tuple(batch.column("SeriesLines:names").to_pylist()[0])
    elif "Scalars:scalars" in columns:
        values = batch.column("Scalars:scalars").to_pylist()
        plot.rows += zip(_seconds(batch), values, strict=True)


def _pictures(batch: Any, camera: Literal["micas", "chase"]) -> Iterator[Picture]:
    if "EncodedImage:blob" not in batch.schema.names:
        return
    blobs, media = batch.column("EncodedImage:blob").to_pylist(), batch.column("EncodedImage:media_type").to_pylist()
    for time, blob, kind in zip(_seconds(batch), blobs, media, strict=True):
        if blob:
            yield Picture(time, camera, kind[0], bytes(blob[0]))
