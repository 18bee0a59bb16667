"""The run folder: where it goes, and the journal's stream that the recording listens to."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

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


class OverheardStream(io.TextIOWrapper):
    """A journal's new file that tells each entry to a listener once it is written and flushed."""

    def __init__(self, path: Path, listener: Callable[[dict[str, Any]], None]) -> None:
        super().__init__(path.open("xb"), encoding="utf-8", newline="\n")
        self._listener = listener

    def write(self, line: str, /) -> int:
        """Write one line, flush it, tell it."""
        count = super().write(line)
        self.flush()
        self._listener(json.loads(line))
        return count
