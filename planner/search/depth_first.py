"""What depth-first engines share: an explicit stack of flaws under resolution, going forward, and the limits."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from itertools import chain, islice
from time import perf_counter

from planner.database import PlanDatabase
from planner.search.collector import Collector
from planner.search.decisions import Decision
from planner.search.flaws import Flaw, OpenToken, Ranking, nearest_first, next_flaw
from planner.search.outcome import Outcome, Refusal, Request
from planner.tokens.path import TokenPath


@dataclass(slots=True)
class Frame:
    """A flaw under resolution at a level of the trail, and its decisions not yet tried.

    `conflict`: the places on the stack of the decisions that spoilt those tried so far, for engines that want to know;
    `is_last`: so do those left that cannot succeed.
    """

    flaw: Flaw
    decisions: Iterator[Decision]
    depth: int
    conflict: set[int] = field(default_factory=set)
    is_last: bool = False


class DepthFirst(ABC):
    """A depth-first search; its engine says how to go back. `order`: which token comes next, nearest to the problem
    first unless something else is set before `run`; `max_backtracks`: a further limit; `dead_ends`: the tokens for
    which no decision was left, and how often."""

    def __init__(self, database: PlanDatabase, request: Request) -> None:
        self.database = database
        self.hints = request.hints
        self.order: Ranking = nearest_first
        self.max_backtracks: float = math.inf
        self.max_steps = request.limits.max_steps
        self.deadline = perf_counter() + request.limits.max_seconds
        self.accept = request.accept
        self.describe = request.describe
        self.outcome = Outcome()
        self.collector = Collector(database.trail)
        self.stack: list[Frame] = []
        self.dead_ends: Counter[TokenPath] = Counter()

    @abstractmethod
    def advance(self) -> bool:
        """Take the next consistent decision, undoing as far as needed; False at the end of search or of limits."""

    def refused(self, refusal: Refusal) -> bool:
        """A complete plan was refused; False when that ends the search."""
        return True

    def run(self) -> Outcome:
        """Resolve flaw after flaw until there is none, or no way on. Without a plan the database is as before."""
        bottom = self.database.trail.push()
        while True:
            found = next_flaw(self.database, self.order, self.hints)
            going_on = True
            if found is None:
                refusal = None if self.accept is None else self.accept(self.database)
                if refusal is None:
                    self.outcome.complete = True
                    return self.outcome
                self.outcome.refusal = refusal.text
                going_on = self.refused(refusal)
            else:
                flaw, decisions = found
                first = list(islice(decisions, 1))
                if not first and isinstance(flaw, OpenToken) and self.outcome.is_news(len(self.stack)):
                    decisions = flaw.unfit(self.database)
                    first = list(islice(decisions, 1))
                if not first:
                    self.outcome.note(len(self.stack), partial("nothing resolves {!r}".format, flaw))
                self.stack.append(Frame(flaw, chain(first, decisions), self.database.trail.depth))
            if not going_on or not self.advance():
                self.outcome.exhausted = not self.stack
                self.database.trail.pop_to(bottom)
                return self.outcome

    def exhausted(self, frame: Frame) -> None:
        """Count a dead end of a token: no decision on it is left."""
        if isinstance(frame.flaw, OpenToken):
            self.dead_ends[frame.flaw.token.path] += 1

    def spent(self) -> bool:
        """Whether the limits are reached; asked before every decision."""
        self.collector.relieve()
        outcome = self.outcome
        if outcome.steps >= self.max_steps or outcome.backtracks >= self.max_backtracks:
            return True
        return perf_counter() > self.deadline
