"""Campaigns: the same runs whatever happens to workers and scheduler, rows that say what came of them, comparisons."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import psutil
import pyarrow.parquet as pq
import pytest
from distributed import Client, LocalCluster

from scenarios.campaign import flying
from scenarios.campaign.campaign import campaign
from scenarios.campaign.comparison import compare, mcnemar
from scenarios.campaign.flying import CRASHED, fly
from scenarios.campaign.statistics import bootstrap, table, wilson, worst
from scenarios.campaign.store import Settings, Store, rows_in
from scenarios.campaign.variations import variation
from scenarios.campaign.workers import SchedulerLostError, client_of
from scenarios.config import Scenario, parse
from scenarios.errors import ScenarioError
from scenarios.run import Listener
from sim import FAULTS
from tests.scenarios.commands import SMALL, remote_agent

RUNS, SEED = 4, 7
CLOCK = ("planning_s", "wall_s")


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return parse(SMALL, "small.toml")


@pytest.fixture(scope="module")
def alone(scenario: Scenario) -> list[dict[str, Any]]:
    """The campaign's rows, flown one after another in this process."""
    return [fly(scenario, variation(scenario, SEED, "all", number)) for number in range(RUNS)]


def without_clock(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{name: value for name, value in row.items() if name not in CLOCK} for row in rows]


@contextmanager
def scheduler() -> Iterator[LocalCluster]:
    with LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0", silence_logs=50
    ) as cluster:
        yield cluster


def fly_in(folder: Path, scenario: Scenario, **how: Any) -> dict[str, Any]:
    return campaign(scenario, RUNS, "all", SEED, folder, recorded=0, **how)


def test_a_variation_is_its_number(scenario: Scenario) -> None:
    first = [variation(scenario, 1, "all", number) for number in range(len(FAULTS) + 1)]
    assert first == [variation(scenario, 1, "all", number) for number in range(len(FAULTS) + 1)]
    assert {own.label for own in first} == {*FAULTS, "none"}
    assert len({own.seed for own in first}) == len(first)
    assert all(fault.at < scenario.horizon for own in first for fault in own.faults)
    assert variation(scenario, 2, "all", 0) != first[0]
    assert variation(scenario, 1, "scenario", 3).faults == scenario.faults
    assert variation(scenario, 1, "none", 3).faults == ()
    drawn = [len(variation(scenario, 1, "random", number).faults) for number in range(400)]
    assert 0.8 < sum(drawn) / len(drawn) < 1.2


def test_two_campaigns_at_once() -> None:
    with scheduler(), client_of(1, None) as client:
        assert len(client.nthreads()) == 1


def test_a_killed_worker_loses_nothing(scenario: Scenario, alone: list[dict[str, Any]], tmp_path: Path) -> None:
    with scheduler() as cluster, Client(cluster) as client:
        pids = list(client.run(os.getpid).values())

        def kill(done: int, doing: str) -> None:
            if done == 1 and pids:
                os.kill(pids.pop(), signal.SIGKILL)

        found = fly_in(tmp_path / "c", scenario, scheduler=cluster.scheduler_address, listener=Listener(kill))
        assert len(pids) == 1
    rows = rows_in(tmp_path / "c")
    assert without_clock(rows) == without_clock(alone)
    assert found["table"] == table(alone)
    assert pq.read_table(tmp_path / "c" / "runs.parquet").num_rows == RUNS


def test_a_lost_scheduler_and_resume(scenario: Scenario, alone: list[dict[str, Any]], tmp_path: Path) -> None:
    folder = tmp_path / "c"
    with scheduler() as cluster:
        closing = threading.Thread(target=cluster.close)

        def lose(done: int, doing: str) -> None:
            if done == 1 and not closing.ident:
                closing.start()

        with pytest.raises(SchedulerLostError, match="--resume"):
            fly_in(folder, scenario, scheduler=cluster.scheduler_address, listener=Listener(lose))
        closing.join()
    kept = (folder / "rows.jsonl").read_text(encoding="utf-8")
    assert 1 <= kept.count("\n") < RUNS
    with (folder / "rows.jsonl").open("a", encoding="utf-8") as file:
        file.write('{"run": 3, "se')  # and killed while it wrote
    with pytest.raises(ScenarioError, match="not over"):
        rows_in(folder)
    resumed = fly_in(folder, scenario, workers=1, resume=True)
    assert without_clock(rows_in(folder)) == without_clock(alone)
    assert resumed["table"] == table(alone)
    assert (folder / "rows.jsonl").read_text(encoding="utf-8").startswith(kept)


def test_ctrl_c_keeps_the_rows_and_says_one_line(alone: list[dict[str, Any]], tmp_path: Path) -> None:
    """As a terminal gives it, to all processes of the command at once."""
    (tmp_path / "small.toml").write_text(SMALL, encoding="utf-8")
    folder = tmp_path / "c"
    asked = (
        "campaign",
        "small.toml",
        "--runs",
        RUNS,
        "--faults",
        "all",
        "--seed",
        SEED,
        "--workers",
        1,
        "--recorded",
        0,
    )
    command = [sys.executable, "-m", "scenarios", *map(str, asked), "--out", str(folder)]
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    process = subprocess.Popen(
        command, cwd=tmp_path, env=environment, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    deadline = time.monotonic() + 90
    while time.monotonic() < deadline and process.poll() is None:
        if (folder / "rows.jsonl").is_file() and (folder / "rows.jsonl").read_bytes().count(b"\n"):
            break
        time.sleep(0.02)
    workers = psutil.Process(process.pid).children(recursive=True)
    os.killpg(process.pid, signal.SIGINT)
    _, told = process.communicate(timeout=60)
    assert process.returncode == 130
    assert told == f"remote-agent: interrupted; what was flown is kept in {folder}: go on with --resume\n"
    while alive := [one for one in workers if one.is_running() and one.status() != psutil.STATUS_ZOMBIE]:
        assert time.monotonic() < deadline, alive
        time.sleep(0.02)
    kept = [json.loads(line) for line in (folder / "rows.jsonl").read_text(encoding="utf-8").splitlines()]
    assert 1 <= len(kept) < RUNS
    assert without_clock(kept) == without_clock([alone[row["run"]] for row in kept])


def test_a_recording_that_was_broken_off_is_made_anew(scenario: Scenario, tmp_path: Path) -> None:
    folder = tmp_path / "c"
    store = Store(folder, Settings.of(scenario, 1, "none", SEED), resume=False)
    store.add(flying.crashed(variation(scenario, SEED, "none", 0), "for the test"))
    store.close()
    broken = folder / "worst" / "run-000000"
    broken.mkdir(parents=True)
    (broken / "journal.jsonl").write_text("{}", encoding="utf-8")
    [worst_run] = campaign(scenario, 1, "none", SEED, folder, resume=True, recorded=1)["worst"]
    assert "recording_error" not in worst_run
    assert (broken / "summary.json").is_file()


def test_what_cannot_be_resumed_or_begun(scenario: Scenario, tmp_path: Path) -> None:
    folder = tmp_path / "c"
    Store(folder, Settings.of(scenario, 3, "none", 0), resume=False).close()
    for settings, resume, complaint in (
        (Settings.of(scenario, 3, "none", 0), False, "something already"),
        (Settings.of(scenario, 3, "none", 1), True, "differs in seed"),
        (Settings.of(scenario, 4, "all", 0), True, "differs in runs, faults"),
    ):
        with pytest.raises(ScenarioError, match=complaint):
            Store(folder, settings, resume=resume)
    with pytest.raises(ScenarioError, match="expected a campaign's folder"):
        Store(tmp_path / "other", Settings.of(scenario, 3, "none", 0), resume=True)
    assert not (tmp_path / "other").exists()


def test_one_bad_run_does_not_stop_the_rest(scenario: Scenario, monkeypatch: pytest.MonkeyPatch) -> None:
    def explode(*_: object) -> None:
        raise ZeroDivisionError("in the plant")

    monkeypatch.setattr(flying, "Flight", explode)
    row = fly(scenario, variation(scenario, SEED, "none", 0))
    assert (row["outcome"], row["error"]) == (CRASHED, "ZeroDivisionError: in the plant")
    [total, _] = table([row])
    assert (total["runs"], total["crashed"], total["kept"], total["achieved"]) == (1, 1, 0.0, None)
    assert worst([row], 3) == [row]


def test_intervals() -> None:
    low, high = wilson(8, 10)
    assert (round(low, 3), round(high, 3)) == (0.490, 0.943)  # E. B. Wilson's interval, by hand
    assert wilson(0, 0) == (0.0, 1.0)
    assert wilson(10, 10)[1] == 1.0
    assert bootstrap([3.0, 3.0]) == (3.0, 3.0)
    low, high = bootstrap([0.0, 1.0] * 50)
    assert low == pytest.approx(0.5 - 1.96 * 0.5 / math.sqrt(100), abs=0.02)
    assert high == pytest.approx(0.5 + 1.96 * 0.5 / math.sqrt(100), abs=0.02)
    assert mcnemar(0, 0) == 1.0
    assert mcnemar(9, 1) == pytest.approx(2 * 11 / 1024)


def test_comparison(scenario: Scenario, alone: list[dict[str, Any]], tmp_path: Path) -> None:
    folders = [tmp_path / name for name in ("before", "after", "other")]
    for folder, seed in zip(folders, (SEED, SEED, SEED + 1), strict=True):
        store = Store(folder, Settings.of(scenario, RUNS, "all", seed), resume=False)
        for row in alone:
            broken = {"outcome": "failed", "missed": 1, "kept": False, "rule_violations": 1, "rules": "battery-floor"}
            store.add(row | (broken if folder.name == "after" and row["run"] == 2 else {}))
        store.finish()
        store.close()
    before, after, other = folders
    assert not compare(before, before)["regression"]
    found = compare(before, after)
    assert found["regression"]
    assert [row["run"] for row in found["lost"]] == [row["run"] for row in found["newly_broken"]] == [2]
    assert not compare(after, before)["regression"]
    with pytest.raises(ScenarioError, match="seed is 7 and 8"):
        compare(before, other)
    ended = remote_agent("compare", before, after, "--json")
    assert ended.status == 1
    assert ended.json()["newly_broken"][0]["rules"] == "battery-floor"


def test_the_command(tmp_path: Path) -> None:
    small = tmp_path / "small.toml"
    small.write_text(SMALL, encoding="utf-8")
    folder = tmp_path / "c"
    ended = remote_agent("campaign", small, "--runs", 1, "--workers", 1, "--out", folder, "--recorded", 1, "--json")
    assert ended.status == 0, ended.err
    found = ended.json()
    assert found["table"][0]["runs"] == 1
    assert [Path(run["folder"], "report.html").is_file() for run in found["worst"]] == [True] * len(found["worst"])
    again = remote_agent("campaign", small, "--runs", 1, "--out", folder)
    assert again.status == 2
    assert "something already" in again.err
    refused = remote_agent("campaign", small, "--scheduler", "nonsense://x", "--out", tmp_path / "d")
    assert refused.status == 2
    assert "--scheduler nonsense://x" in refused.err
