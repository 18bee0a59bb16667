"""What configuration constraints use of resources: the constraint `uses(resource, quantity, start, end)`.

A plan does not say which alternative of a rule it took, nor which token it meant, and some ways to satisfy a rule may
use less than others. So each rule's application has a choice of ways, and the resources are kept if they are with one
way for each.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice, product

from planner.checker.expressions import Expressions, Names, Path, Quantity
from planner.checker.resources import check_resources
from planner.checker.transactions import Transaction
from planner.checker.view import Slot, View
from planner.checker.violations import Violation
from planner.errors import ModelError
from planner.model.classes import objects_in
from planner.model.resources import USES
from planner.model.rules import ForEach, Guard, OneOf, Ref, Require, Statement

MOST_WAYS = 200
"""How many ways to satisfy one rule are looked at."""
MOST_CHOICES = 1000
"""How many choices of a way for each rule are looked at."""

Way = tuple[Transaction, ...]


@dataclass(frozen=True, slots=True)
class Choice:
    """The ways to satisfy one rule of one token, by what they use: none of them uses all that another does."""

    ways: tuple[Way, ...]


def mentions_uses(statements: Iterable[Statement]) -> bool:
    """Whether a body says anywhere that something is used."""
    for statement in statements:
        inside: tuple[Statement, ...] = ()
        if isinstance(statement, Guard):
            inside = (*statement.then, *statement.otherwise)
        elif isinstance(statement, ForEach):
            inside = statement.body
        elif isinstance(statement, OneOf):
            inside = tuple(s for branch in statement.branches for s in branch)
        if (isinstance(statement, Require) and statement.procedure == USES.name) or mentions_uses(inside):
            return True
    return False


def choice_of(ways: Iterator[Way]) -> Choice:
    """The ways that are worth a look."""
    kept: dict[frozenset[tuple[object, ...]], Way] = {}
    for way in islice(ways, MOST_WAYS):
        what = frozenset((t.resource, t.quantity, t.start, t.end) for t in way)
        if not any(known <= what for known in kept):
            kept = {known: other for known, other in kept.items() if not what <= known} | {what: way}
        if not what:
            break
    return Choice(tuple(kept.values()))


def transactions(
    expressions: Expressions, slot: Slot, statements: Iterable[tuple[Require, Path]], names: Names
) -> Iterator[Transaction]:
    """What `uses` statements of a satisfied rule come to. What is used outside of the horizon is not the plan's."""
    for statement, path in statements:
        resource, quantity, *ends = statement.arguments
        times = []
        for end in ends:
            found = expressions.resolve(end, names, path) if isinstance(end, Ref) else None
            if not isinstance(found, Quantity) or found.which == "duration":
                raise ModelError(
                    f"{slot.predicate.full_name}: uses: expected the start and the end of tokens, found {end!r}"
                )
            times.append(found)
        points = [expressions.view.network.point(t.token.id, t.which) for t in times if isinstance(t.token, Slot)]
        where = expressions.domain(resource, names, path, expressions.range_of)
        amount = expressions.domain(quantity, names, path, expressions.range_of)
        if len(points) == 2 and where is not None and amount is not None and amount.upper > 0:
            for thing in objects_in(where):
                yield Transaction(thing.name, "uses", float(amount.upper), slot, points[0], points[1])


def check_all_resources(view: View, choices: Sequence[Choice]) -> Iterator[Violation]:
    """The resources, with some choice of ways; the violations of the first choice when there is none."""
    first: list[Violation] | None = None
    for ways in islice(product(*(c.ways for c in choices)), MOST_CHOICES):
        found = list(check_resources(view, (t for way in ways for t in way)))
        if not found:
            return
        first = found if first is None else first
    yield from first or ()
