"""The search engines by name. On top of the same three operations, any engine is possible (paper, section 4)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from planner.database import PlanDatabase
from planner.search import backjumping, chronological, portfolio
from planner.search.outcome import Acceptance, Description, Limits, Outcome

Search = Callable[[PlanDatabase, Limits, Acceptance | None, Description | None], Outcome]


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
