"""Wall seconds of a run by phase: `opnav-12h` with its fault, with and without pictures.

`start_up_s` is from the start of the command to its first line of progress, in a process of its own. `spacecraft_s` is
inside `advance`, `planning_s` in the planner, `recording_s` in the observer; what is left of `flight_s` is the
executive's.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from scenarios.bridge import SpacecraftPlant
from scenarios.config import load
from scenarios.folder import new_folder
from scenarios.observer import Observer
from scenarios.report import write_report
from scenarios.run import Flight, Listener, RunOptions

SCENARIO = "opnav-12h"
_CLOCKED: tuple[tuple[str, type, str], ...] = (
    ("spacecraft_s", SpacecraftPlant, "advance"),
    ("planning_s", Flight, "think"),
    ("recording_s", Observer, "look"),
    ("recording_s", Observer, "event"),
    ("recording_s", Observer, "plan"),
    ("recording_s", Observer, "close"),
)


def measure() -> dict[str, object]:
    """All figures: a row with pictures and a row without, and how long the command takes to start."""
    wall_seconds(images=False)  # whatever is compiled or loaded at the first flight
    rows = [{"images": images, **wall_seconds(images=images)} for images in (True, False)]
    return {"scenario": SCENARIO, "start_up_s": start_up_s(), "rows": rows}


def wall_seconds(*, images: bool) -> dict[str, float]:
    """One flight of the scenario, in a folder that is thrown away."""
    scenario, spent = load(SCENARIO), dict.fromkeys((phase for phase, _, _ in _CLOCKED), 0.0)
    with tempfile.TemporaryDirectory() as parent, ExitStack() as clocks:
        for phase, owner, name in _CLOCKED:
            clocks.enter_context(_clocked(owner, name, spent, phase))
        begin = time.perf_counter()
        flight = Flight(scenario, RunOptions(0, scenario.faults, images))
        prepared = time.perf_counter()
        folder = new_folder(Path(parent, "run"), scenario.name)
        flight.fly(folder, Listener())
        flown = time.perf_counter()
        write_report(folder)
        reported = time.perf_counter()
    return {
        "prepare_s": prepared - begin,
        "flight_s": flown - prepared,
        **spent,
        "report_s": reported - flown,
        "wall_s": reported - begin,
    }


def start_up_s() -> float:
    """Seconds from starting the command to the first progress that it would show."""
    script = (
        "from scenarios.config import load; from scenarios.run import Flight, RunOptions;"
        f"Flight(load({SCENARIO!r}), RunOptions()); print('ready', flush=True)"
    )
    begin = time.perf_counter()
    subprocess.run([sys.executable, "-c", script], check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - begin


@contextmanager
def _clocked(owner: type, name: str, spent: dict[str, float], phase: str) -> Iterator[None]:
    """While open, the time inside a method is added to a phase."""
    original: Callable[..., Any] = getattr(owner, name)

    def timed(*arguments: Any, **named: Any) -> Any:
        begin = time.perf_counter()
        try:
            return original(*arguments, **named)
        finally:
            spent[phase] += time.perf_counter() - begin

    setattr(owner, name, timed)
    try:
        yield
    finally:
        setattr(owner, name, original)
