"""Chronological backtracking: depth first on an explicit stack, the newest decision undone first."""

from __future__ import annotations

from planner.constraints.network import Inconsistency
from planner.search.depth_first import DepthFirst


class Chronological(DepthFirst):
    """The engine: how it goes back."""

    def advance(self) -> bool:
        """The next decision of the newest flaw that has one left."""
        trail, outcome = self.database.trail, self.outcome
        while self.stack:
            frame = self.stack[-1]
            if trail.depth > frame.depth:
                trail.pop_to(frame.depth)
                outcome.backtracks += 1
            for decision in frame.decisions:
                if self.spent():
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
            self.exhausted(self.stack.pop())
        return False

    def explain(self, inconsistency: Inconsistency) -> None:
        """Note a dead end."""
        describe, network = self.describe, self.database.network
        if describe is not None:
            self.outcome.note(len(self.stack), lambda: describe(network.explain(inconsistency)))
