"""Flaws: what keeps a partial plan from being complete (paper, section 3), found by looking, and which comes next.

Parameter variables must be assigned, tokens scheduled, resources kept. (Configuration constraints are satisfied as
tokens are inserted; the network's consistency is the database's own affair.) A token that may lie wholly outside the
horizon is no flaw: a plan speaks of its horizon only.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import islice

from planner.constraints.network import Variable
from planner.database import PlanDatabase
from planner.domains import Interval
from planner.model.classes import objects_in
from planner.search.decisions import Activate, Assign, Codesignate, Decision, Insert, Order, Reject
from planner.tokens.resources import Clash
from planner.tokens.token import Token


class OpenToken:
    """A token that is not yet on a timeline."""

    __slots__ = ("token",)

    def __init__(self, token: Token) -> None:
        self.token = token

    def decisions(self, database: PlanDatabase) -> Iterator[Decision]:
        """Codesignate where possible, then the empty slots in order, then rejection where it is allowed."""
        token, tokens = self.token, database.tokens
        for host in tokens.hosts(token):
            yield Codesignate(token, host)
        if token.predicate.exogenous and token.role == "subgoal":
            return
        if token.kind == "timeline":
            for thing, position in tokens.places(token):
                yield Insert(token, thing, position)
        else:
            for thing in objects_in(token.object.domain):
                yield Activate(token, thing)
        if token.role == "rejectable":
            yield Reject(token)

    def __repr__(self) -> str:
        return f"open {self.token!r}"


class Undecided:
    """A variable that has no value yet."""

    __slots__ = ("variable",)

    def __init__(self, variable: Variable) -> None:
        self.variable = variable

    def decisions(self, database: PlanDatabase) -> Iterator[Decision]:
        """The values that are left, in the order in which the domain lists them."""
        domain = self.variable.domain
        for value in domain.values():
            one = Interval(value, value, domain.integer) if isinstance(domain, Interval) else domain.keep((value,))
            yield Assign(self.variable, value, one)

    def __repr__(self) -> str:
        return f"undecided {self.variable!r}"


class Contention:
    """Tokens that together exceed a resource in some schedule that the plan allows."""

    __slots__ = ("clash",)

    def __init__(self, clash: Clash) -> None:
        self.clash = clash

    def decisions(self, database: PlanDatabase) -> Iterator[Decision]:
        """Order two of them, the pair with the most room first."""
        for first, second in self.clash.profile.orders(self.clash):
            yield Order(first, second)

    def __repr__(self) -> str:
        return f"contention on {self.clash!r}"


Flaw = OpenToken | Undecided | Contention

FORCED = (-1, 1)
"""The rank of a token with a single decision."""
DEEP = 4
"""From this depth on, tokens are equally far from the problem."""
WINDOW = 64
"""How many undecided variables are compared for the fewest values."""


def next_flaw(database: PlanDatabase) -> tuple[Flaw, Sequence[Decision]] | None:
    """The flaw to resolve next, with its decisions. None: the plan is complete.

    A token without a decision comes first, then one with a single decision; then the alternatives that the problem's
    own tokens leave open, since they decide what else is needed; then tokens, those nearest to the problem first (depth),
    and among them the one with the fewest decisions; then variables with the fewest values; then contentions.
    """
    best: tuple[Flaw, Sequence[Decision]] | None = None
    least = (0, 0)
    for token in _in_order(database.tokens.open_tokens):
        if token.role == "subgoal" and token.may_be_outside(database.horizon):
            continue
        flaw = OpenToken(token)
        decisions = list(flaw.decisions(database))
        if not decisions:
            return flaw, decisions
        key = (min(token.depth, DEEP), len(decisions)) if len(decisions) > 1 else FORCED
        if best is None or key < least:
            best, least = (flaw, decisions), key
    if best is not None and least == FORCED:
        return best
    variable = next((v for v in database.tokens.alternatives if not v.domain.is_singleton), None)
    undecided = Undecided(variable) if variable is not None else None
    if undecided is None:
        if best is not None:
            return best
        undecided = _smallest(database)
    if undecided is not None:
        return undecided, list(undecided.decisions(database))
    return _contention(database)


def _contention(database: PlanDatabase) -> tuple[Flaw, Sequence[Decision]] | None:
    for profile in database.tokens.resources.values():
        clash = profile.clash()
        if clash is not None:
            contention = Contention(clash)
            return contention, list(contention.decisions(database))
    return None


def _smallest(database: PlanDatabase) -> Undecided | None:
    """The variable with the fewest values among the oldest that are undecided: a window, so that a step stays cheap."""
    best: Variable | None = None
    fewest = math.inf
    for variable in islice(database.tokens.still_undecided(), WINDOW):
        size = variable.domain.size
        if size < fewest:
            best, fewest = variable, size
            if size <= 2:
                break
    return Undecided(best) if best is not None else None


def _in_order(tokens: dict[int, Token]) -> list[Token]:
    return [tokens[number] for number in sorted(tokens)]
