"""The search engines by name. On top of the same three operations, any engine is possible (paper, section 4)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol

from planner.database import PlanDatabase
from planner.search import backjumping, chronological, portfolio
from planner.search.hints import Hints
from planner.search.outcome import Acceptance, Description, Limits, Outcome


class Search(Protocol):
    """Completes the partial plan of a database within limits; `hints` say in which order to try."""

    def __call__(
        self,
        database: PlanDatabase,
        limits: Limits,
        accept: Acceptance | None = None,
        describe: Description | None = None,
        hints: Hints | None = None,
    ) -> Outcome:
        """Search; on success the database holds the plan, otherwise it is as before."""
        ...


@dataclass(frozen=True, slots=True)
class Engine:
    """A search engine: a name, what it does in a line, and the search itself."""

    name: str
    summary: str
    search: Search


ENGINES: Mapping[str, Engine] = MappingProxyType(
    {
        engine.name: engine
        for engine in (
            Engine("chronological", "depth first, the newest decision undone first", chronological.search),
            Engine(
                "backjumping",
                "depth first, back to the newest decision that had a part in a dead end",
                backjumping.search,
            ),
            Engine(
                "portfolio", "both of these in two orders of flaws, in turn, for longer and longer", portfolio.search
            ),
        )
    }
)
