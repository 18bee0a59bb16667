"""Helpers of the language's tests: a text loaded, and planned for."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest

from planner.constraints.network import Inconsistency
from planner.constraints.standard import STANDARD
from planner.database import PlanDatabase
from planner.extraction import extract
from planner.language.nddl.builder import load_text
from planner.language.nddl.errors import NddlError
from planner.plan import FlexiblePlan
from planner.search.engines import ENGINES
from planner.search.outcome import Limits

EXAMPLES = Path(__file__).parents[4] / "scenarios" / "examples"
HORIZON = (0, 100)


class Run:
    """What came of a text: solved or not, the plan, the reason of an inconsistency."""

    def __init__(self, text: str, max_steps: int = 2000, max_seconds: float = 10.0, folder: Path = Path()) -> None:
        self.model, self.program, report = load_text(text, STANDARD, "test.nddl", folder)
        self.database = PlanDatabase(self.model, self.program.horizon or HORIZON)
        self.conflict: list[str] = []
        self.plan: FlexiblePlan | None = None
        self.exhausted = False
        try:
            self.program.carry_out(self.database, report)
        except Inconsistency as inconsistency:
            self.conflict = [str(owner) for owner in self.database.network.explain(inconsistency)]
            self.exhausted = True
            return
        outcome = ENGINES["chronological"].search(self.database, Limits(max_steps, max_seconds))
        self.exhausted = outcome.exhausted
        if outcome.complete:
            self.plan = extract(self.database)

    @property
    def solved(self) -> bool:
        """There is a plan."""
        return self.plan is not None

    def predicates(self) -> list[str]:
        """The predicates of all hosts in the plan, sorted."""
        assert self.plan is not None
        hosts = {slot[0] for timeline in self.plan.timelines for slot in timeline.slots}
        merged = set(itertools.chain.from_iterable(s[1:] for t in self.plan.timelines for s in t.slots))
        return sorted(t.predicate for t in self.plan.tokens if t.id in hosts or t.id not in merged)

    def value(self, name: str) -> object:
        """The value of a global variable, or what is left of it."""
        variable = self.database.tokens.names[name]
        domain = variable.domain  # type: ignore[union-attr]
        return domain.value if domain.is_singleton else domain


def complaints(text: str) -> list[str]:
    """What is wrong with a text, each as `line:column message`."""
    with pytest.raises(NddlError) as caught:
        load_and_run(text)
    return [f"{d.at.line}:{d.at.column} {d.message}" for d in caught.value.diagnostics]


def load_and_run(text: str) -> None:
    """Load a text and carry out its problem."""
    model, program, report = load_text(text, STANDARD, "test.nddl")
    program.carry_out(PlanDatabase(model, program.horizon or HORIZON), report)
