"""What configuration constraints use of resources: the constraint `uses(resource, quantity, start, end)`.

A plan does not say which alternative of a rule it took, nor which token it meant, and some ways to satisfy a rule may
use less than others. So each rule's application has a choice of ways, and the resources are kept if they are with one
way for each.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

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
    """The resources, with some way for each rule; the violations of the first ways when there is no such choice.

    Only another way for one of those who break a limit can mend it, since whatever else is used makes it no better: so
    from each choice that fails the search goes on with those alone.
    """
    first: list[Violation] = []
    waiting = [(0,) * len(choices)]
    seen = set(waiting)
    while waiting and len(seen) <= MOST_CHOICES:
        chosen = waiting.pop()
        ways = [choice.ways[number] for choice, number in zip(choices, chosen, strict=True)]
        found = list(check_resources(view, (t for way in ways for t in way)))
        if not found:
            return
        first = first or found
        for place in _blamed(ways, found[0]):
            for number in reversed(range(len(choices[place].ways))):
                other = (*chosen[:place], number, *chosen[place + 1 :])
                if other not in seen:
                    seen.add(other)
                    waiting.append(other)
    yield from first
    if waiting:
        text = f"none of {MOST_CHOICES} choices among the alternatives of rules keeps the resources; there are more"
        yield Violation("resource", text)


def _blamed(ways: Sequence[Way], violation: Violation) -> Iterator[int]:
    """The places of the ways that have a part in a violation."""
    for place, way in enumerate(ways):
        if any(t.slot.id in violation.tokens and t.resource in violation.objects for t in way):
            yield place
