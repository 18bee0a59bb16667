"""The search engines by name. On top of the same three operations, any engine is possible (paper, section 4)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol

from planner.database import PlanDatabase
from planner.search.backjumping import Backjumping
from planner.search.chronological import Chronological
from planner.search.collector import patient_collector
from planner.search.hints import Hints
from planner.search.outcome import Acceptance, Description, Limits, Outcome, Request
from planner.search.portfolio import Portfolio


class Run(Protocol):
    """One search, ready to begin."""

    def run(self) -> Outcome:
        """Search, once."""
        ...


@dataclass(frozen=True, slots=True)
class Engine:
    """A search engine: a name, what it does in a line, and what a search of it is made by."""

    name: str
    summary: str
    kind: Callable[[PlanDatabase, Request], Run]

    def search(
        self,
        database: PlanDatabase,
        limits: Limits,
        accept: Acceptance | None = None,
        describe: Description | None = None,
        hints: Hints | None = None,
    ) -> Outcome:
        """Complete the partial plan in the database, which is at a propagated fixpoint.

        On success the database holds the plan; otherwise it is as before.
        """
        with patient_collector():
            return self.kind(database, Request(limits, accept, describe, hints)).run()


ENGINES: Mapping[str, Engine] = MappingProxyType(
    {
        engine.name: engine
        for engine in (
            Engine("chronological", "depth first, the newest decision undone first", Chronological),
            Engine(
                "backjumping", "depth first, back to the newest decision that had a part in a dead end", Backjumping
            ),
            Engine("portfolio", "both of these in two orders of flaws, in turn, for longer and longer", Portfolio),
        )
    }
)
