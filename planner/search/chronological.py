"""Chronological backtracking: depth first on an explicit stack, the newest decision undone first."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

from planner.constraints.network import Inconsistency
from planner.database import PlanDatabase
from planner.search.decisions import Decision
from planner.search.flaws import Flaw, next_flaw


@dataclass(frozen=True, slots=True)
class Limits:
    """When to give up: decisions tried, seconds of wall clock."""

    max_steps: int = 1_000_000
    max_seconds: float = 60.0


@dataclass(slots=True)
class Outcome:
    """What the search found. `complete`: the database holds a complete plan. `exhausted`: there is none.

    `conflicts` counts what stood in the way: the description of each dead end and how often it was met.
    """

    complete: bool = False
    exhausted: bool = False
    steps: int = 0
    backtracks: int = 0
    conflicts: dict[str, int] = field(default_factory=dict)


@dataclass(slots=True)
class _Frame:
    flaw: Flaw
    decisions: Iterator[Decision]
    depth: int


def search(
    database: PlanDatabase,
    limits: Limits,
    accept: Callable[[PlanDatabase], bool] | None = None,
    describe: Callable[[list[Any]], str] | None = None,
) -> Outcome:
    """Complete the partial plan in the database, which is at a propagated fixpoint.

    `accept` judges a complete plan; one that it refuses is a dead end. `describe` makes text of an explanation. On
    success the database holds the plan; otherwise it is as before.
    """
    outcome = Outcome()
    stack: list[_Frame] = []
    deadline = perf_counter() + limits.max_seconds
    bottom = database.trail.push()
    while True:
        found = next_flaw(database)
        if found is None:
            if accept is None or accept(database):
                outcome.complete = True
                return outcome
            _count(outcome, "a complete plan was refused")
        else:
            flaw, decisions = found
            if not decisions:
                _count(outcome, f"no place for {flaw.token!r}" if hasattr(flaw, "token") else repr(flaw))
            stack.append(_Frame(flaw, iter(decisions), database.trail.depth))
        if not _advance(database, stack, outcome, limits, deadline, describe):
            outcome.exhausted = not stack
            database.trail.pop_to(bottom)
            return outcome


def _advance(
    database: PlanDatabase,
    stack: list[_Frame],
    outcome: Outcome,
    limits: Limits,
    deadline: float,
    describe: Callable[[list[Any]], str] | None,
) -> bool:
    """Take the next decision that is consistent, undoing as far as needed; False at the end of search or of limits."""
    while stack:
        frame = stack[-1]
        if database.trail.depth > frame.depth:
            database.trail.pop_to(frame.depth)
            outcome.backtracks += 1
        for decision in frame.decisions:
            if outcome.steps >= limits.max_steps or perf_counter() > deadline:
                return False
            outcome.steps += 1
            database.trail.push()
            try:
                decision.apply(database)
            except Inconsistency as inconsistency:
                if describe is not None:
                    _count(outcome, describe(database.network.explain(inconsistency)))
                database.trail.pop_to(frame.depth)
                outcome.backtracks += 1
                continue
            return True
        stack.pop()
    return False


def _count(outcome: Outcome, what: str) -> None:
    outcome.conflicts[what] = outcome.conflicts.get(what, 0) + 1
