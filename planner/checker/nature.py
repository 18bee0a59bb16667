"""The duration that nature may choose for a contingent token: what the domain declares for its parameter values.

The predicate declares bounds; relations over `duration` in its body and in its configuration constraints (how long a
turn from here to there takes) narrow them. What other tokens and the horizon leave of them is not nature's.
"""

from __future__ import annotations

from collections.abc import Sequence

from planner.checker.expressions import UNBOUNDED, Expressions, Path, Quantity, Wanted
from planner.checker.requirements import Requirements
from planner.checker.view import Slot, View, closed
from planner.domains import Domain, Interval
from planner.model.classes import Predicate
from planner.model.rules import Confine, Guard, Local, Require, Statement, Subgoal

ROUNDS = 8
"""How often the relations are applied to each other's results; two rounds settle what is seen in practice."""


def declared_duration(view: View, slot: Slot, stated: Interval) -> tuple[float, float]:
    """The bounds of nature's choice, beginning from those that the predicate and the problem state."""
    bodies = [slot.predicate.body]
    if not slot.is_fact:
        bodies += [rule.body for rule in view.model.rules_for(slot.object.cls, slot.predicate.name)]
    narrowing = _Narrowing(view, slot, stated)
    for _ in range(ROUNDS):
        before = narrowing.duration
        for body in bodies:
            narrowing.apply(body, {})
        if narrowing.duration == before:
            break
    return narrowing.duration.lower, narrowing.duration.upper


class _Narrowing:
    """Relations over one token's duration, with nothing known of other tokens and of times."""

    def __init__(self, view: View, slot: Slot, duration: Interval) -> None:
        self.model = view.model
        self.slot = slot
        self.duration = duration
        self.expressions = Expressions(view, slot)
        self.requirements = Requirements(self.expressions)

    def times(self, quantity: Quantity) -> Domain:
        """The token's own duration as it stands; any other time is open."""
        own = quantity.token is self.slot and quantity.which == "duration"
        return self.duration if own else UNBOUNDED

    def apply(self, body: Sequence[Statement], names: dict[tuple[Path, str], Slot | Wanted | Domain]) -> None:
        """Narrow by the relations of a body and by those of guards that the token's parameters decide."""
        for statement in body:
            if isinstance(statement, Subgoal):
                names[(), statement.name] = Wanted(statement.name, self.model.predicate(*statement.predicate))
            elif isinstance(statement, Confine):
                cls, attribute = statement.attribute
                names[(), statement.name] = Wanted(statement.name, Predicate(cls, attribute, attribute))
            elif isinstance(statement, Local):
                names[(), statement.name] = closed(self.model.domain_of(statement.type))
            elif isinstance(statement, Guard):
                verdict = self.requirements.decide(statement.test, statement.arguments, names, (), self.times)
                branch = statement.then if verdict is True else statement.otherwise if verdict is False else ()
                self.apply(branch, dict(names))
            elif isinstance(statement, Require):
                found = self.expressions.narrowed(statement.procedure, statement.arguments, names, (), self.times)
                for ref, part in found:
                    if ref.path in (("duration",), ("this", "duration")) and not part.is_empty:
                        self.duration = self.duration.intersect(part)
