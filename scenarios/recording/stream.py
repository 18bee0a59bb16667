"""The recording's file: one timeline, `sim_time`, with exact times, and the three ways to write to it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr

TIMELINE = "sim_time"
APPLICATION = "remote-agent"
EPOCH_PROPERTY = "mission"
_NS = 1_000_000_000


class Stream:
    """An open .rrd file with its layout inside. `epoch`: Unix seconds of simulation second 0.

    Times are kept in whole nanoseconds: the same simulation second is the same instant whichever way it was written.
    """

    def __init__(self, path: Path, epoch: float, layout: Any) -> None:
        self._epoch_ns = round(epoch * _NS)
        self._recording = rr.RecordingStream(APPLICATION)
        self._recording.save(path, default_blueprint=layout)
        self._recording.set_log_time_enabled(False)
        self._recording.set_log_tick_enabled(False)
        self._recording.send_property(EPOCH_PROPERTY, rr.AnyValues(epoch_ns=self._epoch_ns))

    def name(self, text: str) -> None:
        """What the viewer calls this recording."""
        self._recording.send_recording_name(text)

    def static(self, path: str, *content: Any) -> None:
        """Write what holds at all times; written again, the last one holds."""
        self._recording.log(path, *content, static=True)

    def at(self, time: int, path: str, *content: Any) -> None:
        """Write at one simulation second."""
        self._recording.set_time(TIMELINE, timestamp=np.datetime64(self._epoch_ns + time * _NS, "ns"))
        self._recording.log(path, *content)

    def columns(self, path: str, times: Sequence[int] | np.ndarray[Any, np.dtype[np.int64]], columns: Any) -> None:
        """Write many rows at once. `times`: simulation seconds, ascending, one a row."""
        instants = (np.asarray(times, np.int64) * _NS + self._epoch_ns).view("datetime64[ns]")
        column = rr.TimeColumn(TIMELINE, timestamp=instants)
        self._recording.send_columns(path, [column], columns)

    def flush(self) -> None:
        """Bring all that was written to the file, so that a kill after this loses none of it."""
        self._recording.flush()

    def close(self) -> None:
        """Write the file's index and close it."""
        self._recording.disconnect()
