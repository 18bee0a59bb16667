"""Several depth-first searches in turn, each for a slice that grows: one is often quick where another thrashes.

How long a backtracking search takes depends heavily on its early choices; giving up and searching otherwise cuts the
tail off (Gomes, Selman and Kautz, "Boosting combinatorial search through randomization", AAAI 1998; algorithm
portfolios: Huberman, Lukose and Hogg, Science 275, 1997). Slices are counted in backtracks, so that a search which goes
straight on is not interrupted, and grow, so that whatever any of the searches finds or proves is found or proven.

What one search learns, the next begins with: a token for which no decision was left comes the earlier, the more often
that was so, in whichever search (as constraints are weighted in Boussemart et al., "Boosting systematic search by
weighting constraints", ECAI 2004). Within a slice the weights stand still.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from time import perf_counter

from planner.database import PlanDatabase
from planner.search.backjumping import Backjumping
from planner.search.chronological import Chronological
from planner.search.depth_first import DepthFirst
from planner.search.flaws import Ranking, nearest_first, soonest_first
from planner.search.outcome import Limits, Outcome, Request
from planner.tokens.path import TokenPath

MEMBERS: tuple[tuple[type[DepthFirst], Ranking], ...] = (
    (Chronological, soonest_first),
    (Chronological, nearest_first),
    (Backjumping, soonest_first),
    (Backjumping, nearest_first),
)
FIRST_SLICE = 250
"""Backtracks that each search has in the first round."""
GROWTH = 1.5
"""By how much longer a slice is in the next round."""


class Portfolio:
    """The engine: whose turn it is, and for how long."""

    def __init__(self, database: PlanDatabase, request: Request) -> None:
        self.database = database
        self.request = request
        self.deadline = perf_counter() + request.limits.max_seconds
        self.outcome = Outcome()
        self.dead_ends: Counter[TokenPath] = Counter()

    def run(self) -> Outcome:
        """Search until one member is done or the limits are reached. Without a plan the database is as before."""
        total, max_steps = self.outcome, self.request.limits.max_steps
        slice_ = FIRST_SLICE
        while True:
            for kind, order in MEMBERS:
                left = Limits(max_steps - total.steps, self.deadline - perf_counter())
                member = kind(self.database, replace(self.request, limits=left))
                member.order, member.max_backtracks = self.weighted(order), slice_
                _look_again(self.database)
                _add(total, member.run())
                self.dead_ends.update(member.dead_ends)
                if total.complete or total.exhausted:
                    return total
                if total.steps >= max_steps or perf_counter() > self.deadline:
                    return total
            slice_ = int(slice_ * GROWTH)

    def weighted(self, order: Ranking) -> Ranking:
        """An order of tokens, below that of how often each was a dead end up to now."""
        dead_ends = dict(self.dead_ends)
        return (lambda token, count: (-dead_ends.get(token.path, 0), *order(token, count))) if dead_ends else order


def _look_again(database: PlanDatabase) -> None:
    """Forget which token another order would take next."""
    for group in database.tokens.open.look():
        group.touch()
        for token in group.tokens.values():
            token.rank_key = ()


def _add(total: Outcome, part: Outcome) -> None:
    total.complete, total.exhausted = part.complete, part.exhausted
    total.steps += part.steps
    total.backtracks += part.backtracks
    total.refusal = part.refusal or total.refusal
    if part.conflict is not None and (total.conflict is None or part.conflict[0] < total.conflict[0]):
        total.conflict = part.conflict
