"""The recording's file: one timeline, `sim_time`, with exact times, and the three ways to write to it.

Times are durations since second 0, as they are in the journal, the log and the report; the date of second 0 is a
property of the recording.
"""

from __future__ import annotations

import atexit
import os
import shutil
import sys
from collections.abc import Sequence
from errno import EIO, ENOSPC
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr

TIMELINE = "sim_time"
APPLICATION = "remote-agent"
EPOCH_PROPERTY = "mission"
RESERVE_BYTES = 8 << 20
"""Room on the disk under which nothing more is recorded, for the file's end and for the journal."""
PATIENCE_S = 60.0
_NS = 1_000_000_000


class Stream:
    """An open .rrd file with its layout inside. `epoch`: Unix seconds of simulation second 0.

    Times are kept in whole nanoseconds: the same simulation second is the same instant whichever way it was written.

    The library writes in a thread of its own. When a write fails there, it is never heard of again: to flush, to close
    and to leave the process would all wait for ever. So room is looked for before, and flushing has an end.
    OSError when the file cannot be made.
    """

    def __init__(self, path: Path, epoch: float, layout: Any, patience_s: float = PATIENCE_S) -> None:
        self._path = path
        self._patience_s = patience_s
        self._lost = False
        self._recording = rr.RecordingStream(APPLICATION)
        try:
            self._recording.save(path, default_blueprint=layout)
        except RuntimeError as error:
            raise OSError(EIO, str(error), str(path)) from error
        self._recording.set_log_time_enabled(False)
        self._recording.set_log_tick_enabled(False)
        self._recording.send_property(EPOCH_PROPERTY, rr.AnyValues(epoch_ns=round(epoch * _NS)))

    def name(self, text: str) -> None:
        """What the viewer calls this recording."""
        self._recording.send_recording_name(text)

    def static(self, path: str, *content: Any) -> None:
        """Write what holds at all times; written again, the last one holds."""
        self._recording.log(path, *content, static=True)

    def at(self, time: int, path: str, *content: Any) -> None:
        """Write at one simulation second."""
        self._recording.set_time(TIMELINE, duration=np.timedelta64(time * _NS, "ns"))
        self._recording.log(path, *content)

    def columns(self, path: str, times: Sequence[int] | np.ndarray[Any, np.dtype[np.int64]], columns: Any) -> None:
        """Write many rows at once. `times`: simulation seconds, ascending, one a row."""
        instants = (np.asarray(times, np.int64) * _NS).view("timedelta64[ns]")
        column = rr.TimeColumn(TIMELINE, duration=instants)
        self._recording.send_columns(path, [column], columns)

    def flush(self) -> None:
        """Bring all that was written to the file, so that a kill after this loses none of it.

        OSError when the disk is full or nearly, or did not take it.
        """
        self._bring()
        if shutil.disk_usage(self._path.parent).free < RESERVE_BYTES:
            raise OSError(ENOSPC, os.strerror(ENOSPC), str(self._path))

    def close(self) -> None:
        """Write the file's index and close it. OSError when the disk did not take it."""
        self._bring()
        self._recording.disconnect()

    def _bring(self) -> None:
        try:
            if not self._lost:
                self._recording.flush(timeout_sec=self._patience_s)
                return
        except RuntimeError:
            self._lost = True
            atexit.register(_leave, self._recording)
        raise OSError(EIO, "the recording could not be written (is the disk full?)", str(self._path))


def _leave(lost: rr.RecordingStream) -> None:
    """End the process without what waits for a lost recording: its destructor (it is kept until here) and the library.

    The status is that of a command that broke off.
    """
    del lost
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(1)
