"""A campaign from settings to folder: fly what is missing, keep every row, say what the rows say."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

from scenarios.campaign import statistics
from scenarios.campaign.flying import Row
from scenarios.campaign.store import Settings, Store
from scenarios.campaign.variations import Faults, Variation, variation, varied
from scenarios.campaign.workers import client_of, fly_all
from scenarios.config import Scenario
from scenarios.report import write_report
from scenarios.run import Listener, RunOptions, run

STATISTICS, WORST = "statistics.json", "worst"


def campaign(
    scenario: Scenario,
    runs: int,
    faults: Faults,
    seed: int,
    folder: Path,
    *,
    workers: int = 2,
    scheduler: str | None = None,
    resume: bool = False,
    recorded: int = 3,
    listener: Listener | None = None,
) -> dict[str, Any]:
    """Fly a campaign into a folder; returns its statistics, which are also written there.

    `recorded`: how many of the worst runs are flown again with everything recorded, below `worst`. `listener`: its
    progress counts runs. ScenarioError for what cannot be, SchedulerLostError when it can be resumed.
    """
    listener = listener or Listener()
    store = Store(folder, Settings.of(scenario, runs, faults, seed), resume=resume)
    try:
        _fly_missing(store, scenario, workers, scheduler, listener)
        rows = store.finish()
    finally:
        store.close()
    found = {
        "scenario": scenario.name,
        "runs": len(rows),
        "faults": faults,
        "seed": seed,
        "table": statistics.table(rows),
        "timing": statistics.timing(rows),
        "worst": _record_worst(rows, scenario, store.settings, folder / WORST, recorded, listener),
    }
    (folder / STATISTICS).write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    return found


def _fly_missing(store: Store, scenario: Scenario, workers: int, scheduler: str | None, listener: Listener) -> None:
    missing = store.missing()
    if not missing:
        return

    def done(row: Row) -> None:
        store.add(row)
        listener.progress(len(store.rows), "flying")

    listener.progress(len(store.rows), "starting workers")
    with client_of(min(workers, len(missing)), scheduler) as client:
        fly_all(client, scenario, [_own(scenario, store.settings, number) for number in missing], done, listener.check)


def _own(scenario: Scenario, settings: Settings, number: int) -> Variation:
    return variation(scenario, settings.seed, settings.faults, number)


def _record_worst(
    rows: list[Row], scenario: Scenario, settings: Settings, parent: Path, count: int, listener: Listener
) -> list[dict[str, Any]]:
    """The worst runs flown again, into run folders of their own; those that are there already stay."""
    told = []
    for row in statistics.worst(rows, count):
        own = _own(scenario, settings, row["run"])
        folder = parent / f"run-{own.number:06d}"
        listener.progress(len(rows), f"recording run {own.number}")
        entry = {name: row[name] for name in ("run", "seed", "fault", "outcome", "dropped", "missed", "error")}
        told.append(entry | {"folder": str(folder)} | _recorded(varied(scenario, own), own, folder, listener))
    return told


def _recorded(scenario: Scenario, own: Variation, folder: Path, listener: Listener) -> dict[str, Any]:
    if (folder / "summary.json").is_file():
        return {}
    if folder.exists():  # broken off
        shutil.rmtree(folder)
    (folder / "plans").mkdir(parents=True, exist_ok=True)
    try:
        run(scenario, RunOptions(own.seed, own.faults, images=False), folder, Listener(check=listener.check))
        write_report(folder)
    except Exception as error:  # the run that crashed a worker may crash here too; its journal is what it leaves
        return {"recording_error": f"{type(error).__name__}: {error}"}
    return {}
