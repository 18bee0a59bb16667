"""Flaws: what keeps a partial plan from being complete (paper, section 3), found by looking, and which comes next.

Parameter variables must be assigned, tokens scheduled, resources kept. (Configuration constraints are satisfied as
tokens are inserted; the network's consistency is the database's own affair.) A token that may lie wholly outside the
horizon is no flaw: a plan speaks of its horizon only.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from itertools import chain, islice

from planner.constraints.heuristics import VARIABLE_HEURISTICS, fewest_values, in_order
from planner.constraints.network import DurationVariable, TimeVariable, Variable
from planner.database import PlanDatabase
from planner.domains import Interval
from planner.model.classes import ModelObject, objects_in
from planner.search.decisions import Activate, Assign, Codesignate, Decision, Insert, Limit, Order, Reject, Settle
from planner.search.hints import Hints
from planner.tokens.coverage import SIDES, Coverage
from planner.tokens.groups import OpenGroup, Rank
from planner.tokens.instance import GuardInstance
from planner.tokens.resources import Clash, Precede
from planner.tokens.token import GIVEN, Token


class OpenToken:
    """A token that is not yet on a timeline."""

    __slots__ = ("_openings", "hints", "token")

    def __init__(self, token: Token, hints: Hints | None = None) -> None:
        self.token = token
        self.hints = hints
        self._openings: tuple[Iterable[Token], Iterable[tuple[ModelObject, int]]] | None = None

    def decisions(self, database: PlanDatabase) -> Iterator[Decision]:
        """Codesignate where possible, then the empty slots in order, then rejection where it is allowed."""
        return (
            self._decisions(database)
            if self.hints is None
            else self.hints.arranged(self.token, self._decisions(database))
        )

    def _decisions(self, database: PlanDatabase) -> Iterator[Decision]:
        token, tokens = self.token, database.tokens
        hosts, places = self._openings or tokens.fitting(token)
        for host in hosts:
            yield Codesignate(token, host)
        if token.kind == "timeline":
            yield from self._inserts(places)
        elif not self._needs_host:
            for thing in objects_in(token.object.domain):
                yield Activate(token, thing)
        if token.role == "rejectable":
            yield Reject(token)

    def unfit(self, database: PlanDatabase) -> Iterator[Decision]:
        """What bounds allow and constraints with what is near do not: tried only to be told why it fails."""
        token, tokens = self.token, database.tokens
        if token.kind == "timeline":
            hosts, places = map(set, tokens.fitting(token))
            all_hosts, all_places = tokens.openings(token)
            yield from (Codesignate(token, host) for host in all_hosts if host not in hosts)
            yield from self._inserts([place for place in all_places if place not in places])

    def _inserts(self, places: Iterable[tuple[ModelObject, int]]) -> Iterator[Insert]:
        if not self._needs_host:
            yield from (Insert(self.token, thing, position) for thing, position in places)

    @property
    def _needs_host(self) -> bool:
        """Only what the problem says is true can be its host."""
        return self.token.predicate.exogenous and self.token.role not in GIVEN

    def count(self, database: PlanDatabase) -> int:
        """How many decisions there are. If they are few, they are those of the moment from now on."""
        token = self.token
        some_hosts, some_places = database.tokens.fitting(token)
        hosts, places = list(some_hosts), list(some_places)
        if len(hosts) + len(places) <= FEW:
            self._openings = hosts, places
        count = len(hosts) + (token.role == "rejectable")
        if self._needs_host:
            return count
        return count + (len(places) if token.kind == "timeline" else len(objects_in(token.object.domain)))

    def __repr__(self) -> str:
        return f"open {self.token!r}"


class Undecided:
    """A variable that has no value yet."""

    __slots__ = ("hints", "variable")

    def __init__(self, variable: Variable, hints: Hints | None = None) -> None:
        self.variable = variable
        self.hints = hints

    def decisions(self, database: PlanDatabase) -> Iterator[Decision]:
        """The values that are left, in the order in which the domain lists them, or as hinted."""
        domain = self.variable.domain
        for value in in_order(self.variable) if self.hints is None else self.hints.values_of(self.variable):
            one = Interval(value, value, domain.integer) if isinstance(domain, Interval) else domain.keep((value,))
            yield Assign(self.variable, value, one)

    def __repr__(self) -> str:
        return f"undecided {self.variable!r}"


class Astride:
    """A value token that may overlap a constraint token which, as far as is known, does not allow it."""

    __slots__ = ("coverage", "variable")

    def __init__(self, coverage: Coverage) -> None:
        self.coverage = coverage
        self.variable = coverage.side

    def decisions(self, database: PlanDatabase) -> Iterator[Decision]:
        """Let the value be an allowed one, or the token come before, or after; what holds anyway first."""
        for side in self.coverage.sides():
            yield Assign(self.variable, side, SIDES.domain((side,)))

    def __repr__(self) -> str:
        return f"astride {self.variable!r}"


class Contention:
    """Tokens that together overdraw a resource in some schedule that the plan allows."""

    __slots__ = ("clash",)

    def __init__(self, clash: Clash) -> None:
        self.clash = clash

    def decisions(self, database: PlanDatabase) -> Iterator[Decision]:
        """The remedies, the least restricting first."""
        for remedy in self.clash.remedies():
            if isinstance(remedy, Precede):
                yield Order(remedy.first, remedy.second, remedy.gap)
            else:
                yield Limit(remedy.variable, remedy.domain)

    def __repr__(self) -> str:
        return f"contention on {self.clash!r}"


class Unsettled:
    """A guard on times (or on numbers without end), which a flexible plan need not assign, that is not decided."""

    __slots__ = ("guard",)

    def __init__(self, guard: GuardInstance) -> None:
        self.guard = guard

    def decisions(self, database: PlanDatabase) -> Iterator[Decision]:
        """Let the test hold or fail, in each way in which it can."""
        a, b = self.guard.scope
        for procedure, swapped, holds in WAYS[self.guard.guard.test]:
            yield Settle(self.guard, procedure, (b, a) if swapped else (a, b), holds)

    def __repr__(self) -> str:
        return f"unsettled {self.guard.guard.test}({', '.join(v.name for v in self.guard.scope)})"


# How the test of a guard on numbers can come out: relation, arguments swapped, whether the test then holds.
WAYS: dict[str, tuple[tuple[str, bool, bool], ...]] = {
    "eq": (("eq", False, True), ("lt", False, False), ("lt", True, False)),
    "neq": (("lt", False, True), ("lt", True, True), ("eq", False, False)),
    "leq": (("leq", False, True), ("lt", True, False)),
    "lt": (("lt", False, True), ("leq", True, False)),
}

Flaw = OpenToken | Undecided | Astride | Unsettled | Contention

NOT_FORCED = (0,)
"""Below this is the rank of a token with a single decision or none."""
CROWD = 32
"""In a group of more tokens than this, how many decisions one has is counted again only when its own bounds moved: an
estimate, since what lies on the timeline moves too. The decisions themselves are always those of the moment."""
FEW = 16
"""So many openings of a token are kept from their being counted to their being decided on."""
DEEP = 4
"""From this depth on, tokens are equally far from the problem."""
WINDOW = 64
"""How many undecided variables are compared for the fewest values."""


Ranking = Callable[[Token, int], Rank]
"""The rank of a token with so many decisions, two or more; the lowest comes first."""


def next_flaw(
    database: PlanDatabase, order: Ranking | None = None, hints: Hints | None = None
) -> tuple[Flaw, Iterator[Decision]] | None:
    """The flaw to resolve next, with its decisions, none for a dead end. None: the plan is complete.

    The decisions are found as they are asked for, with the database as it is now.

    What the problem says is true comes first: exogenous tokens look there for a host. Then a token without a decision,
    then one with a single decision; then the alternatives that the problem's own tokens leave open, since they decide
    what else is needed; then tokens, those nearest to the problem first (depth), and among them the one with the fewest
    decisions; then values that constraint tokens may not allow; then variables with the fewest values; then guards on
    times; then contentions. Hints reorder those tokens and variables that are neither given, forced nor alternatives.
    """
    token = _given(database)
    if token is not None:
        given = OpenToken(token, hints)
        return given, given.decisions(database)
    order = order or nearest_first
    urgent = _most_urgent(database, order if hints is None else hints.ranking(order), hints)
    best: tuple[OpenToken, Iterator[Decision]] | None = None
    if urgent is not None:
        rank, flaw = urgent
        decisions = flaw.decisions(database)
        first = list(islice(decisions, 2))
        best = flaw, chain(first, decisions)
        if rank < NOT_FORCED or len(first) < 2:
            return best
    variable = next((v for v in database.tokens.alternatives if not v.domain.is_singleton), None)
    undecided = Undecided(variable, hints) if variable is not None else None
    if undecided is None and best is not None:
        undecided = _earlier(database, best[0].token, hints)
        if undecided is None:
            return best
    if undecided is None:
        astride = next((Astride(coverage) for coverage in database.tokens.open_coverages()), None)
        if astride is not None:
            return astride, astride.decisions(database)
        undecided = _smallest(database, hints)
    if undecided is not None:
        return undecided, undecided.decisions(database)
    return _unsettled(database) or _contention(database)


def _unsettled(database: PlanDatabase) -> tuple[Flaw, Iterator[Decision]] | None:
    for guard in database.tokens.waiting_guards():
        domains = [variable.domain for variable in guard.scope]
        # A finite variable that is still open here belongs to a token outside the horizon.
        is_time = [isinstance(v, TimeVariable | DurationVariable) for v in guard.scope]
        left = [d for d, time in zip(domains, is_time, strict=True) if not time and 1 < d.size < math.inf]
        if guard.guard.test in WAYS and not left and all(d.is_numeric for d in domains):
            unsettled = Unsettled(guard)
            return unsettled, unsettled.decisions(database)
    return None


def _contention(database: PlanDatabase) -> tuple[Flaw, Iterator[Decision]] | None:
    for resource in database.tokens.resources.values():
        clash = resource.clash()
        if clash is not None:
            contention = Contention(clash)
            return contention, contention.decisions(database)
    return None


def _earlier(database: PlanDatabase, token: Token, hints: Hints | None) -> Undecided | None:
    """The variable that hints want to be decided before a token, if there is one."""
    if hints is None or not hints.has_priorities:
        return None
    found = _smallest(database, hints)
    earlier = found is not None and hints.urgency_of_variable(found.variable) < hints.urgency(token)
    return found if earlier else None


def _smallest(database: PlanDatabase, hints: Hints | None) -> Undecided | None:
    """The variable with the fewest values, or as hinted, among the oldest that are undecided: a window, so that a step
    stays cheap. Where hints give priorities, among all with the highest."""
    sizes = ((v, v.domain.size) for v in database.tokens.still_undecided())
    finite = ((v, size) for v, size in sizes if size < math.inf)
    if hints is not None and hints.has_priorities:
        urgencies = [(hints.urgency_of_variable(variable), variable) for variable, _ in finite]
        most = min((urgency for urgency, _ in urgencies), default=0)
        among = iter([variable for urgency, variable in urgencies if urgency == most])
    else:
        among = islice((variable for variable, _ in finite), WINDOW)
    best = fewest_values(among) if hints is None else VARIABLE_HEURISTICS[hints.variables](among)
    return Undecided(best, hints) if best is not None else None


def _given(database: PlanDatabase) -> Token | None:
    """The first open token that the problem says is active."""
    return next((token for token in database.tokens.open.given() if not _is_no_flaw(database, token)), None)


def _is_no_flaw(database: PlanDatabase, token: Token) -> bool:
    """Whether a token may lie outside the horizon, of which a plan says nothing."""
    return token.role == "subgoal" and token.may_be_outside(database.horizon)


def _most_urgent(database: PlanDatabase, order: Ranking, hints: Hints | None) -> tuple[Rank, OpenToken] | None:
    """The other open token that comes first. Only groups in which something happened are looked at again."""
    best: tuple[Rank, OpenToken] | None = None
    for group in database.tokens.open.look():
        if group.stale or group.wide:
            found = _most_urgent_of(database, group, order, hints)
            group.best = None if found is None else (found[0], found[1].token)
            group.stale = False
        else:
            found = None if group.best is None else (group.best[0], OpenToken(group.best[1], hints))
        if found is not None and (best is None or found[0] < best[0]):
            best = found
    return best


def _most_urgent_of(
    database: PlanDatabase, group: OpenGroup, order: Ranking, hints: Hints | None
) -> tuple[Rank, OpenToken] | None:
    best: tuple[Rank, OpenToken] | None = None
    lower, upper = database.temporal.lower, database.temporal.upper
    crowded = len(group.tokens) > CROWD
    for token in group.tokens.values():
        if _is_no_flaw(database, token):
            continue
        flaw = OpenToken(token, hints)
        start, end = token.start.timepoint, token.end.timepoint
        key = lower(start), upper(start), lower(end), upper(end)
        if not crowded or key != token.rank_key:
            token.rank_key = key
            token.rank = _rank(token, flaw.count(database), key[0], order)
        if best is None or token.rank < best[0]:
            best = token.rank, flaw
    return best


def _rank(token: Token, decisions: int, earliest: int, order: Ranking) -> Rank:
    if decisions < 2:
        return (decisions - 2, 0, earliest, token.id)
    return order(token, decisions)


def nearest_first(token: Token, decisions: int) -> Rank:
    """Tokens nearest to the problem first: what is wanted is laid out before what it needs."""
    return (min(token.depth, DEEP), decisions, token.id)


def soonest_first(token: Token, decisions: int) -> Rank:
    """Tokens that must start soonest first: what goes wrong is near in time, hence near on the stack."""
    return (token.start.temporal.upper(token.start.timepoint), decisions, token.id)
