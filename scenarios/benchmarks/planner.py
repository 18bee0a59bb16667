"""How planning grows with the problem: loading, search and extraction of each family, and the memory of a plan.

Processor time, the best of some runs. `growth`: the exponents of N, from the two largest sizes of a family. Memory is
what a database holds once it has been solved, plan, constraints and undo log, the model and the problem's own tokens
left out; `flat`: what is held after all solve-and-undo cycles by what was held after a tenth of them.
"""

from __future__ import annotations

import gc
import math
import tracemalloc
from collections.abc import Iterator
from dataclasses import dataclass
from time import process_time

from planner.constraints.network import Inconsistency
from planner.constraints.standard import STANDARD
from planner.database import PlanDatabase
from planner.extraction import extract
from planner.language.nddl.builder import load_text
from planner.search.collector import patient_collector
from planner.search.engines import ENGINES
from planner.search.outcome import Limits, Outcome
from scenarios.benchmarks.families import text

SIZES: dict[str, tuple[int, ...]] = {
    "altern": (300, 1000, 3000),
    "order": (300, 1000, 3000),
    "stn": (300, 1000, 3000),
    "job": (100, 300, 1000),
    "thrash": (4, 8),
    "queens": (6, 8, 10),
}
REPEATS = 3
CYCLES = 1000
LIMITS = Limits(1_000_000, 600.0)


@dataclass(frozen=True, slots=True)
class Timed:
    """One problem loaded and solved: seconds of processor time, and what the search did."""

    load_seconds: float
    solve_seconds: float
    extract_seconds: float
    outcome: Outcome
    tokens: int


def loaded(family: str, size: int) -> PlanDatabase:
    """A database in which a problem has been stated."""
    model, program, report = load_text(text(family, size), STANDARD, f"{family} {size}")
    database = PlanDatabase(model, program.horizon or (0, 1000))
    program.carry_out(database, report)
    return database


def timed(family: str, size: int) -> Timed:
    """Load, solve and extract one problem."""
    with patient_collector():
        started = process_time()
        try:
            database = loaded(family, size)
        except Inconsistency:
            raise ValueError(f"{family} {size}: expected a problem whose statements hold together") from None
        ready = process_time()
        outcome = ENGINES["chronological"].search(database, LIMITS)
        done = process_time()
        if outcome.complete:
            extract(database)
        return Timed(ready - started, done - ready, process_time() - done, outcome, len(database.tokens.tokens))


def row(family: str, size: int) -> dict[str, object]:
    """The best times of one problem."""
    runs = [timed(family, size) for _ in range(REPEATS)]
    outcome = runs[0].outcome
    return {
        "problem": f"{family} {size}",
        "load_seconds": round(min(run.load_seconds for run in runs), 4),
        "solve_seconds": round(min(run.solve_seconds for run in runs), 4),
        "extract_seconds": round(min(run.extract_seconds for run in runs), 4),
        "steps": outcome.steps,
        "backtracks": outcome.backtracks,
        "tokens": runs[0].tokens,
        "verdict": "solved" if outcome.complete else "no plan" if outcome.exhausted else "limit",
    }


def growth(rows: list[dict[str, object]], sizes: tuple[int, ...]) -> dict[str, float]:
    """The exponents of loading and of solving between the last two sizes."""
    ratio = math.log(sizes[-1] / sizes[-2])
    exponents = {}
    for name in ("load", "solve"):
        less, more = (max(float(str(r[f"{name}_seconds"])), 1e-4) for r in rows[-2:])
        exponents[name] = round(math.log(more / less) / ratio, 2)
    return exponents


def held_bytes() -> int:
    """What Python and numpy hold, garbage apart."""
    gc.collect()
    return tracemalloc.get_traced_memory()[0]


def memory(family: str = "altern", sizes: tuple[int, ...] = (1000, 3000)) -> Iterator[dict[str, object]]:
    """What a solved plan holds, by the token."""
    for size in sizes:
        database = loaded(family, size)
        tracemalloc.start()
        before = held_bytes()
        ENGINES["chronological"].search(database, LIMITS)
        tokens = len(database.tokens.tokens)
        yield {
            "problem": f"{family} {size}",
            "tokens": tokens,
            "kb_per_token": round((held_bytes() - before) / tokens / 1e3, 2),
        }
        tracemalloc.stop()


def cycles(family: str = "altern", size: int = 10, count: int = CYCLES) -> dict[str, object]:
    """Solve and undo over and over: what is held in the end by what was held early on."""
    database = loaded(family, size)
    tracemalloc.start()
    held = []
    for number in range(count):
        depth = database.trail.push()
        ENGINES["chronological"].search(database, LIMITS)
        database.trail.pop_to(depth)
        if number + 1 in (count // 10, count):
            held.append(held_bytes())
    tracemalloc.stop()
    return {"problem": f"{family} {size}", "cycles": count, "kb": round(held[-1] / 1e3, 1), "flat": held[-1] / held[0]}


def measure() -> dict[str, object]:
    """All figures of this benchmark: a row a problem, the growth of each family, and memory."""
    timed("altern", 30)
    rows: list[dict[str, object]] = []
    exponents: dict[str, dict[str, float]] = {}
    for family, sizes in SIZES.items():
        found = [row(family, size) for size in sizes]
        exponents[family] = growth(found, sizes)
        rows += found
    return {
        "rows": rows,
        "growth": [{"family": family, **exponent} for family, exponent in exponents.items()],
        "memory": list(memory()),
        "cycles": [cycles()],
    }
