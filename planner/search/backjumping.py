"""Dependency-directed backtracking (Stallman and Sussman 1977) as conflict-directed backjumping (Prosser 1993).

When a flaw's decisions are exhausted, the search goes back to the newest decision that had a part in it, not to the
newest one. A problem without a solution is so often proven without trying the alternatives of what is beside the point.
"""

from __future__ import annotations

from planner.constraints.network import Inconsistency
from planner.database import PlanDatabase
from planner.search.culprits import Culprits
from planner.search.decisions import Decision
from planner.search.depth_first import DepthFirst, Frame
from planner.search.flaws import OpenToken
from planner.search.outcome import Refusal, Request


class Backjumping(DepthFirst):
    """The engine: how it goes back."""

    def __init__(self, database: PlanDatabase, request: Request) -> None:
        super().__init__(database, request)
        self.places: dict[int, int] = {}
        self.chosen: list[Decision] = []
        self.culprits = Culprits(database, self.places)

    def refused(self, refusal: Refusal) -> bool:
        """Go back to what the refusal blames."""
        owners = refusal.owners
        return self.jump(self.culprits.everything() if owners is None else self.culprits.of(owners))

    def advance(self) -> bool:
        """The next decision of the newest flaw, or of the one that the dead end goes back to."""
        while self.stack:
            frame = self.stack[-1]
            decision = next(frame.decisions, None)
            if decision is None and isinstance(frame.flaw, OpenToken) and not frame.is_last:
                frame.decisions, frame.is_last = frame.flaw.unfit(self.database), True
                continue
            if decision is None:
                self.exhausted(frame)
                if not self.jump(frame.conflict | self.culprits.of_flaw(frame.flaw), leave=frame):
                    return False
                continue
            if self.spent():
                return False
            self.outcome.steps += 1
            spoilt_by = self.attempt(decision, len(self.stack) - 1)
            if spoilt_by is None:
                return True
            if len(self.stack) - 1 not in spoilt_by:
                # It fails whatever is decided here.
                if not self.jump(spoilt_by, leave=frame):
                    return False
            else:
                frame.conflict |= spoilt_by - {len(self.stack) - 1}
        return False

    def attempt(self, decision: Decision, place: int) -> set[int] | None:
        """Apply a decision; None when it is consistent, else the places of the culprits, with the decision undone."""
        depth = self.database.trail.push()
        self.places[id(decision)] = place
        self.chosen.append(decision)
        try:
            decision.apply(self.database)
            return None
        except Inconsistency as inconsistency:
            owners = self.database.network.explain(inconsistency)
            describe = self.describe
            if describe is not None:
                self.outcome.note(len(self.stack), lambda: describe(owners))
            culprits = self.culprits.of(owners)
            self.forget(place)
            self.database.trail.pop_to(depth)
            self.outcome.backtracks += 1
            return culprits

    def jump(self, conflict: set[int], leave: Frame | None = None) -> bool:
        """Go back to the newest place in the conflict, undoing its decision; False when there is none: no solution."""
        if leave is not None:
            conflict = conflict - {len(self.stack) - 1}
        if not conflict:
            self.stack.clear()
            return False
        target = max(conflict)
        del self.stack[target + 1 :]
        frame = self.stack[target]
        self.forget(target)
        self.database.trail.pop_to(frame.depth)
        self.outcome.backtracks += 1
        frame.conflict |= conflict - {target}
        return True

    def forget(self, place: int) -> None:
        """The decisions from a place on are not in force any more."""
        for decision in self.chosen[place:]:
            del self.places[id(decision)]
        del self.chosen[place:]
