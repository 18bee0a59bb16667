"""Reading a recording back: the telemetry plots and the pictures, for a report. The rest is in the run folder."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from rerun.chunk import RrdReader

from scenarios.recording.blueprint import CAMERA_FALLBACK, CAMERA_LOG, CHASE
from scenarios.recording.scene import CAMERA_IMAGE
from scenarios.recording.stream import EPOCH_PROPERTY, TIMELINE

_PLOTS = "/telemetry/"
_NS = 1_000_000_000


@dataclass
class Plot:
    """One panel of telemetry: `rows` of (simulation second, a value for each of `names`), in order of time."""

    path: str
    names: tuple[str, ...] = ()
    rows: list[tuple[int, list[float]]] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture as it was recorded, encoded as `media_type` says."""

    time: int
    camera: Literal["micas", "chase"]
    media_type: str
    blob: bytes
    caption: str = ""


@dataclass
class Readings:
    """What a recording holds of telemetry and pictures."""

    plots: dict[str, Plot] = field(default_factory=dict)
    pictures: list[Picture] = field(default_factory=list)


def read(rrd: Path) -> Readings:
    """Plots and pictures of a recording, also of one whose run was killed; nothing where there is no recording."""
    readings = Readings()
    chunks = _chunks(rrd)
    epoch_ns = next((found for chunk in chunks if (found := _epoch(chunk)) is not None), None)
    if epoch_ns is None:
        return readings
    captions: dict[int, str] = {}
    for chunk in chunks:
        path, batch = str(chunk.entity_path), chunk.to_record_batch()
        if path.startswith(_PLOTS):
            _plot(readings.plots.setdefault(path, Plot(path)), batch, epoch_ns)
        elif chunk.is_static:
            continue
        elif path in (CAMERA_IMAGE, CAMERA_FALLBACK, CHASE):
            readings.pictures += _pictures(batch, "chase" if path == CHASE else "micas", epoch_ns)
        elif path == CAMERA_LOG:
            texts = batch.column("TextLog:text").to_pylist()
            captions |= {t: row[0].partition("  ")[2] for t, row in zip(_seconds(batch, epoch_ns), texts, strict=True)}
    readings.pictures = [
        Picture(p.time, p.camera, p.media_type, p.blob, captions.get(p.time, "") if p.camera == "micas" else "")
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


def _epoch(chunk: Any) -> int | None:
    if str(chunk.entity_path) != f"/__properties/{EPOCH_PROPERTY}":
        return None
    batch = chunk.to_record_batch()
    for name in batch.schema.names:
        if name.rpartition(":")[2] == "epoch_ns" and (values := batch.column(name).to_pylist()[0]):
            return int(values[0])
    return None


def _seconds(batch: Any, epoch_ns: int) -> list[int]:
    return [(t - epoch_ns) // _NS for t in batch.column(TIMELINE).cast("int64").to_pylist()]


def _plot(plot: Plot, batch: Any, epoch_ns: int) -> None:
    columns = batch.schema.names
    if "SeriesLines:names" in columns:
        plot.names = tuple(batch.column("SeriesLines:names").to_pylist()[0])
    elif "Scalars:scalars" in columns:
        values = batch.column("Scalars:scalars").to_pylist()
        plot.rows += zip(_seconds(batch, epoch_ns), values, strict=True)


def _pictures(batch: Any, camera: Literal["micas", "chase"], epoch_ns: int) -> Iterator[Picture]:
    if "EncodedImage:blob" not in batch.schema.names:
        return
    blobs, media = batch.column("EncodedImage:blob").to_pylist(), batch.column("EncodedImage:media_type").to_pylist()
    for time, blob, kind in zip(_seconds(batch, epoch_ns), blobs, media, strict=True):
        if blob:
            yield Picture(time, camera, kind[0], bytes(blob[0]))
