"""Chronological backtracking: depth first on an explicit stack, the newest decision undone first."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from time import perf_counter

from planner.constraints.network import Inconsistency
from planner.database import PlanDatabase
from planner.search.collector import patient_collector
from planner.search.decisions import Decision
from planner.search.flaws import Flaw, next_flaw
from planner.search.outcome import Acceptance, Description, Limits, Outcome

__all__ = ["Limits", "Outcome", "search"]


@dataclass(slots=True)
class _Frame:
    flaw: Flaw
    decisions: Iterator[Decision]
    depth: int


def search(
    database: PlanDatabase,
    limits: Limits,
    accept: Acceptance | None = None,
    describe: Description | None = None,
) -> Outcome:
    """Complete the partial plan in the database, which is at a propagated fixpoint.

    On success the database holds the plan; otherwise it is as before.
    """
    with patient_collector():
        return _Search(database, limits, accept, describe).run()


class _Search:
    def __init__(
        self,
        database: PlanDatabase,
        limits: Limits,
        accept: Acceptance | None,
        describe: Description | None,
    ) -> None:
        self.database = database
        self.max_steps = limits.max_steps
        self.deadline = perf_counter() + limits.max_seconds
        self.accept = accept
        self.describe = describe
        self.outcome = Outcome()
        self.stack: list[_Frame] = []

    def run(self) -> Outcome:
        bottom = self.database.trail.push()
        while True:
            found = next_flaw(self.database)
            if found is None:
                if self.accept is None or self.accept(self.database):
                    self.outcome.complete = True
                    return self.outcome
                self.outcome.note(len(self.stack), lambda: "a complete plan was refused")
            else:
                flaw, decisions = found
                if not decisions:
                    self.outcome.note(len(self.stack), partial("nothing resolves {!r}".format, flaw))
                self.stack.append(_Frame(flaw, iter(decisions), self.database.trail.depth))
            if not self.advance():
                self.outcome.exhausted = not self.stack
                self.database.trail.pop_to(bottom)
                return self.outcome

    def advance(self) -> bool:
        """Take the next consistent decision, undoing as far as needed; False at the end of search or of limits."""
        trail, outcome = self.database.trail, self.outcome
        while self.stack:
            frame = self.stack[-1]
            if trail.depth > frame.depth:
                trail.pop_to(frame.depth)
                outcome.backtracks += 1
            for decision in frame.decisions:
                if outcome.steps >= self.max_steps or perf_counter() > self.deadline:
                    return False
                outcome.steps += 1
                trail.push()
                try:
                    decision.apply(self.database)
                    return True
                except Inconsistency as inconsistency:
                    self.explain(inconsistency)
                    trail.pop_to(frame.depth)
                    outcome.backtracks += 1
            self.stack.pop()
        return False

    def explain(self, inconsistency: Inconsistency) -> None:
        describe, network = self.describe, self.database.network
        if describe is not None:
            self.outcome.note(len(self.stack), lambda: describe(network.explain(inconsistency)))
