"""A campaign's folder: what was asked for, the rows as they come, and the Parquet file at the end.

`campaign.json` says what is flown; `rows.jsonl` gets a line a run, flushed, and is all that resuming needs;
`runs.parquet` holds the same rows in the order of their numbers once the campaign is over.
"""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from scenarios.campaign.flying import Row
from scenarios.campaign.variations import Faults
from scenarios.config import Scenario
from scenarios.errors import ScenarioError

SETTINGS, ROWS, PARQUET = "campaign.json", "rows.jsonl", "runs.parquet"

SCHEMA = pa.schema(
    [
        *[(name, pa.int64()) for name in ("run", "seed")],
        *[(name, pa.string()) for name in ("fault", "faults", "spacecraft", "outcome")],
        *[(name, pa.int32()) for name in ("goals", "achieved", "dropped", "missed", "plans", "replans")],
        *[(name, pa.int64()) for name in ("plan_steps", "detected", "rule_violations")],
        ("rules", pa.string()),
        *[(name, pa.int64()) for name in ("dispatch_violations", "makespan_s", "plans_invalid")],
        *[(name, pa.bool_()) for name in ("kept", "explained")],
        *[(name, pa.float64()) for name in ("planning_s", "wall_s")],
        ("error", pa.string()),
    ]
)


@dataclass(frozen=True, slots=True)
class Settings:
    """What a campaign flies; two with equal settings have equal runs. `text`: the scenario in full."""

    scenario: str
    runs: int
    faults: Faults
    seed: int
    text: str

    @classmethod
    def of(cls, scenario: Scenario, runs: int, faults: Faults, seed: int) -> Settings:
        """The settings of a campaign of this scenario."""
        return cls(scenario.name, runs, faults, seed, scenario.model_dump_json(exclude_defaults=True))


class Store:
    """The folder of one campaign, open for writing."""

    def __init__(self, folder: Path, settings: Settings, *, resume: bool) -> None:
        """Make the folder, or take up the one that is there. ScenarioError when it is not what was asked for."""
        self.folder = folder
        self.settings = settings
        try:
            if resume:
                self._check_same()
            else:
                self._make()
            self.rows = {row["run"]: row for row in _whole_lines(folder / ROWS)}
            self._file = (folder / ROWS).open("a", encoding="utf-8", newline="\n")
        except OSError as error:
            raise ScenarioError(f"{folder}: {error.strerror}") from error

    def missing(self) -> list[int]:
        """The numbers of the runs that are still to be flown."""
        return [number for number in range(self.settings.runs) if number not in self.rows]

    def add(self, row: Row) -> None:
        """Keep a row, once, whatever happens next."""
        if row["run"] not in self.rows:
            self.rows[row["run"]] = row
            self._file.write(json.dumps(row) + "\n")
            self._file.flush()
            os.fsync(self._file.fileno())

    def finish(self) -> list[Row]:
        """Write the Parquet file; returns all rows in the order of their numbers."""
        rows = [self.rows[number] for number in sorted(self.rows)]
        part = self.folder / f"{PARQUET}.part"
        pq.write_table(pa.Table.from_pylist(rows, SCHEMA), part)
        part.replace(self.folder / PARQUET)
        return rows

    def close(self) -> None:
        """No more rows."""
        self._file.close()

    def _make(self) -> None:
        if self.folder.exists() and (not self.folder.is_dir() or any(self.folder.iterdir())):
            raise ScenarioError(f"{self.folder}: there is something already; give another --out, or --resume it")
        self.folder.mkdir(parents=True, exist_ok=True)
        text = json.dumps(asdict(self.settings), indent=1) + "\n"
        (self.folder / SETTINGS).write_text(text, encoding="utf-8")
        (self.folder / ROWS).touch()

    def _check_same(self) -> None:
        there = settings_in(self.folder)
        if there != self.settings:
            fields = asdict(self.settings)
            other = [name for name, value in asdict(there).items() if fields[name] != value]
            raise ScenarioError(f"{self.folder}: the campaign there differs in {', '.join(other)}; resume it as it was")


def settings_in(folder: Path) -> Settings:
    """What the campaign of a folder flies; ScenarioError when there is none."""
    path = folder / SETTINGS
    try:
        content: Any = json.loads(path.read_text(encoding="utf-8"))
        return Settings(**content)
    except FileNotFoundError as error:
        raise ScenarioError(f"{folder}: expected a campaign's folder with {SETTINGS}, found none") from error
    except (OSError, ValueError, TypeError) as error:
        raise ScenarioError(f"{path}: not the settings of a campaign: {error}") from error


def rows_in(folder: Path) -> list[Row]:
    """The rows of a campaign that is over; ScenarioError when it is not, or the file is damaged."""
    settings_in(folder)
    path = folder / PARQUET
    if not path.is_file():
        raise ScenarioError(f"{folder}: the campaign is not over: expected {PARQUET}, found none")
    try:
        rows: list[Row] = pq.read_table(path, schema=SCHEMA).to_pylist()
    except (OSError, pa.ArrowException) as error:
        raise ScenarioError(f"{path}: not the rows of a campaign: {error}") from error
    return rows


def _whole_lines(path: Path) -> list[Row]:
    """The rows of a file whose last line may have been broken off; that one is cut away."""
    data = path.read_bytes()
    whole = data[: data.rfind(b"\n") + 1]
    if len(whole) < len(data):
        with path.open("r+b") as file:
            file.truncate(len(whole))
    return [json.loads(line) for line in whole.splitlines()]
