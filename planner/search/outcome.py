"""What every search engine is given and gives back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from planner.constraints.network import Owner
from planner.database import PlanDatabase
from planner.search.hints import Hints


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why a complete plan is not good enough, for people. `owners`: those of constraints that no plan which contains
    them all can be accepted with; None where that is not known."""

    text: str
    owners: tuple[Owner, ...] | None = None


Acceptance = Callable[[PlanDatabase], Refusal | None]
"""Judges a complete plan; one that it refuses is a dead end."""
Description = Callable[[list[Any]], str]
"""Makes text of an explanation: the owners of what is in conflict."""


@dataclass(frozen=True, slots=True)
class Limits:
    """When to give up: decisions tried, seconds of wall clock."""

    max_steps: int = 1_000_000
    max_seconds: float = 60.0


@dataclass(frozen=True, slots=True)
class Request:
    """What a search is asked for. `accept`: None takes every complete plan; `describe`: None tells no conflicts;
    `hints`: in which order to try."""

    limits: Limits
    accept: Acceptance | None = None
    describe: Description | None = None
    hints: Hints | None = None


@dataclass(slots=True)
class Outcome:
    """What the search found. `complete`: the database holds a complete plan. `exhausted`: there is none.

    `conflict`: what stood in the way nearest to the problem, and how many decisions deep that was. `refusal`: why the
    latest complete plan was refused.
    """

    complete: bool = False
    exhausted: bool = False
    steps: int = 0
    backtracks: int = 0
    conflict: tuple[int, str] | None = None
    refusal: str | None = None

    def is_news(self, depth: int) -> bool:
        """Whether a dead end so many decisions deep is nearer to the problem than the one kept so far."""
        return self.conflict is None or depth < self.conflict[0]

    def note(self, depth: int, describe: Callable[[], str]) -> None:
        """Keep a dead end if it is nearer to the problem than the one kept so far; only then is it described."""
        if self.is_news(depth):
            self.conflict = depth, describe()
