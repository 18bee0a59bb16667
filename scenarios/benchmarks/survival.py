"""Runs killed (SIGKILL) at 50 random instants and resumed: is what they leave what the uninterrupted run leaves?

Each kill is a `remote-agent run` in a process of its own, so that it strikes wherever the command happens to be: while
the first plan is sought (from the journal's first line to the first adopted plan), in flight, or after the journal's
last line, while recording, summary and report are being finished. Then `run --resume` flies it to its end. Journal and
plan files have to be the same bytes, the summary the same but for what was measured on a wall clock and the size of the
recording, which differs from run to run.
"""

from __future__ import annotations

import json
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scenarios.folder import JOURNAL, PLANS, SUMMARY

SCENARIOS = ("opnav-12h", "rax-12h")
"""Each with its own fault: one is replanned for, one is recovered from."""
KILLS = {"planning": 5, "flight": 15, "report": 5}
"""Of each scenario."""
_BEGINS = {"planning": b"", "flight": b'"event":"plan.adopted"', "report": b'"event":"run.finished"'}
"""What the journal holds once a phase has begun."""
_POLL_S = 0.002


@dataclass(frozen=True)
class Left:
    """What a run leaves, but for recording and report, which do not tell what was decided."""

    status: int
    journal: bytes
    plans: dict[str, bytes]
    summary: dict[str, Any]

    @classmethod
    def of(cls, status: int, folder: Path) -> Left:
        """Read a run folder."""
        summary = json.loads((folder / SUMMARY).read_bytes()) if (folder / SUMMARY).is_file() else {}
        plans = {path.name: path.read_bytes() for path in sorted((folder / PLANS).iterdir())}
        return cls(status, (folder / JOURNAL).read_bytes(), plans, _timeless(summary))

    def differs(self, other: Left) -> str:
        """The names of what differs."""
        return ", ".join(name for name in self.__dataclass_fields__ if getattr(self, name) != getattr(other, name))


def measure(seed: int = 1) -> dict[str, object]:
    """All figures; takes about ten minutes. `differing`: the kills after which something was not the same, and what."""
    rng = random.Random(seed)
    rows = [row for scenario in SCENARIOS for row in _of_scenario(scenario, rng)]
    strays = [row for row in rows if row["differs"]]
    table: list[dict[str, object]] = []
    for scenario in SCENARIOS:
        for phase in KILLS:
            those = [row for row in rows if (row["scenario"], row["phase"]) == (scenario, phase)]
            seconds = sorted(row["killed_at_s"] for row in those)
            span = f"{seconds[0]}-{seconds[-1]}"
            same = sum(not row["differs"] for row in those)
            table.append(
                {"scenario": scenario, "phase": phase, "kills": len(those), "at_simulated_s": span, "same": same}
            )
    told = {"differing": strays} if strays else {}
    return {"kills": len(rows), "same": len(rows) - len(strays), "rows": table, **told}


def _of_scenario(scenario: str, rng: random.Random) -> Iterator[dict[str, Any]]:
    with tempfile.TemporaryDirectory() as parent:
        whole, lasts = _uninterrupted(scenario, Path(parent, "whole"))
        for phase, kills in KILLS.items():
            for number in range(kills):
                folder = Path(parent, f"{phase}-{number}")
                _kill(scenario, folder, phase, lasts[phase], rng)
                at = _last_second(folder)
                status = subprocess.run(_command(scenario, folder, "--resume"), capture_output=True, check=False)
                left = Left.of(status.returncode, folder)
                yield {"scenario": scenario, "phase": phase, "killed_at_s": at, "differs": left.differs(whole)}


def _uninterrupted(scenario: str, folder: Path) -> tuple[Left, dict[str, float]]:
    """What is left by the run that nothing happens to, and how many wall seconds each phase of it lasts."""
    begun: dict[str, float] = {}
    with _started(scenario, folder) as process:
        for phase in KILLS:
            _await(process, folder, phase)
            begun[phase] = time.perf_counter()
        status = process.wait()
    ends = [*list(begun.values())[1:], time.perf_counter()]
    return Left.of(status, folder), {phase: end - begun[phase] for phase, end in zip(KILLS, ends, strict=True)}


def _kill(scenario: str, folder: Path, phase: str, lasts: float, rng: random.Random) -> None:
    """Begin a run, and kill it at some instant of the phase; one that was over before is begun anew."""
    for attempt in range(10):
        place = folder.with_name(f"{folder.name}.{attempt}")
        with _started(scenario, place) as process:
            _await(process, place, phase)
            time.sleep(rng.uniform(0.0, lasts))
            process.kill()
            if process.wait() < 0:
                place.rename(folder)
                return
    raise RuntimeError(f"{scenario}: ten runs were over before they could be killed in phase {phase}")


@contextmanager
def _started(scenario: str, folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    process = subprocess.Popen(_command(scenario, folder), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def _command(scenario: str, folder: Path, *more: str) -> list[str]:
    return [sys.executable, "-m", "scenarios", "run", scenario, "--no-images", "--json", "--out", str(folder), *more]


def _await(process: subprocess.Popen[bytes], folder: Path, phase: str) -> None:
    """Until the journal says that the phase has begun, or the run is over."""
    while process.poll() is None:
        if (folder / JOURNAL).is_file() and _BEGINS[phase] in (folder / JOURNAL).read_bytes():
            return
        time.sleep(_POLL_S)


def _last_second(folder: Path) -> int:
    """The simulated second of the last whole line; 0 before there is one."""
    lines = (folder / JOURNAL).read_bytes().split(b"\n")[:-1]
    return int(json.loads(lines[-1])["t"]) if lines else 0


def _timeless(summary: dict[str, Any]) -> dict[str, Any]:
    """A summary without what a wall clock measured, and the bytes of a recording, which are not the same twice."""
    measured = ("wall_seconds", "realtime_factor", "latency_us_p50", "latency_us_p99", "solve_seconds", "bytes")
    return {
        name: _timeless(value)
        if isinstance(value, dict)
        else [_timeless(item) if isinstance(item, dict) else item for item in value]
        if isinstance(value, list)
        else value
        for name, value in summary.items()
        if name not in measured
    }
