"""The run folder: where it goes, and the journal's stream that the recording listens to."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from executive.journal import LineStream
from scenarios.errors import ScenarioError

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
    """The folder of a run that was broken off; ScenarioError when it holds none."""
    if wanted is None:
        raise ScenarioError("--resume: give the folder of the run that was broken off with --out")
    if not (wanted / JOURNAL).is_file():
        raise ScenarioError(f"{wanted}: expected a run folder with {JOURNAL}, found none")
    (wanted / PLANS).mkdir(exist_ok=True)
    return wanted


def new_stream(path: Path) -> LineStream:
    """A new journal file."""
    return path.open("x", encoding="utf-8", newline="\n")


class OverheardStream:
    """A journal's stream that tells each entry to a listener once it is written and flushed."""

    def __init__(self, stream: LineStream, listener: Callable[[dict[str, Any]], None]) -> None:
        self._stream = stream
        self._listener = listener

    def write(self, line: str, /) -> int:
        """Write one line, flush it, tell it."""
        count = self._stream.write(line)
        self._stream.flush()
        self._listener(json.loads(line))
        return count

    def flush(self) -> None:
        """Nothing is left to flush."""

    def close(self) -> None:
        """Close the stream."""
        self._stream.close()
