"""The run folder: where it goes, and the journal's stream that the recording listens to."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from executive.journal import LineStream
from scenarios.errors import RunBrokenError, ScenarioError

SUMMARY = "summary.json"
JOURNAL = "journal.jsonl"
PLANS = "plans"
RECORDING = "run.rrd"
REPORT = "report.html"


def new_folder(wanted: Path | None, name: str) -> Path:
    """Make the folder of a run; without a wish `runs/NAME`, numbered when taken. ScenarioError when it cannot be."""
    folders = [wanted] if wanted is not None else [Path("runs", f"{name}-{n}" if n else name) for n in range(1000)]
    for folder in folders:
        try:
            if folder.is_dir() and not any(folder.iterdir()):
                pass
            else:
                folder.mkdir(parents=True)
            (folder / PLANS).mkdir()
            return folder
        except FileExistsError as error:
            if wanted is not None:
                raise ScenarioError(f"{folder}: there is something already; give another --out") from error
        except OSError as error:
            raise ScenarioError(f"{folder}: {error.strerror}") from error
    raise ScenarioError(f"runs/{name}: a thousand runs are there already; give --out")


def folder_to_resume(wanted: Path | None) -> Path:
    """The folder of a run that was broken off; ScenarioError when it holds none.

    One that was killed before its first entry gets an empty journal: nothing had happened.
    """
    if wanted is None:
        raise ScenarioError("--resume: give the folder of the run that was broken off with --out")
    if not (wanted / JOURNAL).is_file():
        if not _is_as_made(wanted):
            raise ScenarioError(f"{wanted}: expected a run folder with {JOURNAL}, found none")
        (wanted / JOURNAL).touch()
    (wanted / PLANS).mkdir(exist_ok=True)
    return wanted


def _is_as_made(folder: Path) -> bool:
    """Whether there is nothing but what `new_folder` makes, and perhaps a recording that was begun."""
    plans = folder / PLANS
    return (
        plans.is_dir() and not any(plans.iterdir()) and {path.name for path in folder.iterdir()} <= {PLANS, RECORDING}
    )


@contextmanager
def kept(path: Path, second: int | None = None) -> Iterator[None]:
    """Around what writes a file of a run: RunBrokenError when the machine cannot keep it.

    `second`: the simulation second that the run has come to; None when it is over.
    """
    try:
        yield
    except OSError as error:
        when = "after the run's end" if second is None else f"the run ended at {second} s"
        reason = error.strerror or str(error)
        raise RunBrokenError(f"{path}: {reason}; {when}, what was written until then is readable") from error


def new_stream(path: Path) -> LineStream:
    """A new journal file."""
    return path.open("x", encoding="utf-8", newline="\n")


class OverheardStream:
    """A journal's stream that tells each entry to a listener once it is written and flushed.

    `path`: the name that a RunBrokenError gives it.
    """

    def __init__(self, stream: LineStream, listener: Callable[[dict[str, Any]], None], path: Path) -> None:
        self._stream = stream
        self._listener = listener
        self._path = path

    def write(self, line: str, /) -> int:
        """Write one line, flush it, tell it. RunBrokenError when the disk does not take it."""
        entry = json.loads(line)
        with kept(self._path, entry["t"]):
            count = self._stream.write(line)
            self._stream.flush()
        self._listener(entry)
        return count

    def flush(self) -> None:
        """Nothing is left to flush."""

    def close(self) -> None:
        """Close the stream. RunBrokenError when the disk does not take what was left."""
        with kept(self._path):
            self._stream.close()
