"""A slow oracle: small domains as plain data, planned on whole times by exhaustive search, judged by schedules.

It shares nothing with the planner but the data: relations are formulas, tokens are tuples, a plan is a set of them.
"""

from __future__ import annotations

import itertools
import random
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from planner.plan import ORIGIN, FlexiblePlan
from tests.planner.relation_oracle import Bounds, holds

VALUES = (0, 1)
HORIZON = (0, 5)
REACH = 4
"""How far outside the horizon a token may begin or end: farther than any duration."""


@dataclass(frozen=True)
class Ask:
    """`relation(target)`; the target's x is `x`, or this token's own when `same`."""

    relation: str
    target: str
    bounds: tuple[Bounds, ...] = ()
    x: int | None = None
    same: bool = False


@dataclass(frozen=True)
class Keep:
    """Over an interval in the relation a line has only the allowed values: (kind, x), where None is any x and -1 this
    token's own."""

    relation: str
    line: str
    allowed: tuple[tuple[str, int | None], ...]


@dataclass(frozen=True)
class When:
    """The statements apply when this token's x is the value."""

    x: int
    body: tuple[Ask, ...]


@dataclass(frozen=True)
class Either:
    """One of the bodies applies."""

    bodies: tuple[tuple[Ask, ...], ...]


Statement = Ask | Keep | When | Either


@dataclass(frozen=True)
class Kind:
    """A predicate with one parameter x, on a timeline, with what it asks for."""

    name: str
    line: str
    duration: tuple[int, int]
    exogenous: bool = False
    rule: tuple[Statement, ...] = ()


@dataclass(frozen=True, order=True)
class Token:
    """A ground token."""

    kind: str
    x: int
    start: int
    end: int


@dataclass(frozen=True)
class Span:
    """A ground constraint token: a line, its times, the values that it allows."""

    line: str
    start: int
    end: int
    allowed: frozenset[tuple[str, int]]


@dataclass(frozen=True)
class Given:
    """A token of the problem: fixed times for what is true, a window for goals."""

    kind: str
    x: int | None
    start: tuple[int, int]
    end: tuple[int, int] = (HORIZON[0], HORIZON[1])
    role: str = "goal"


@dataclass
class Small:
    """A domain and a problem."""

    kinds: dict[str, Kind]
    given: list[Given] = field(default_factory=list)

    def tokens(self, kind: str) -> Iterator[Token]:
        shortest, longest = self.kinds[kind].duration
        for start in range(HORIZON[0] - REACH, HORIZON[1] + REACH):
            for duration in range(shortest, longest + 1):
                for x in VALUES:
                    yield Token(kind, x, start, start + duration)

    def asked(self, token: Token, ask: Ask) -> list[Token]:
        wanted = token.x if ask.same else ask.x
        return [
            t
            for t in self.tokens(ask.target)
            if holds(ask.relation, (token.start, token.end, t.start, t.end), ask.bounds) and wanted in (None, t.x)
        ]

    def spans(self, token: Token, keep: Keep) -> Iterator[Span]:
        """The intervals over which a line could be kept; a longer one than needed asks for more."""
        values = {(k, token.x if x == -1 else x) for k, x in keep.allowed}
        allowed = frozenset((k, x) for k in self.kinds for x in VALUES if {(k, x), (k, None)} & values)
        for start in range(HORIZON[0] - REACH, HORIZON[1] + REACH):
            for end in range(start, HORIZON[1] + REACH):
                if holds(keep.relation, (token.start, token.end, start, end), ()):
                    yield Span(keep.line, start, end, allowed)

    def spoils(self, token: Token, span: Span) -> bool:
        """Whether a token has a value that a constraint token does not allow."""
        overlaps = token.end > span.start and span.end > token.start
        return overlaps and self.kinds[token.kind].line == span.line and (token.kind, token.x) not in span.allowed

    def fits(self, plan: frozenset[Token], token: Token) -> bool:
        line = self.kinds[token.kind].line
        return all(
            t == token or t.end <= token.start or token.end <= t.start for t in plan if self.kinds[t.kind].line == line
        )


def outside(token: Token | Span) -> bool:
    """Whether the plan need not speak of the token."""
    return token.end <= HORIZON[0] or token.start >= HORIZON[1]


class Oracle:
    """Whether a plan exists, by trying every ground token for everything that is asked for."""

    def __init__(self, small: Small) -> None:
        self.small = small
        self.budget = 20_000

    def feasible(self) -> bool | None:
        """None when the budget ran out."""
        first = sorted(self.small.given, key=lambda g: g.role == "goal")
        try:
            return self._place(frozenset(), first, frozenset())
        except TimeoutError:
            return None

    def _place(self, plan: frozenset[Token], given: list[Given], facts: frozenset[Token]) -> bool:
        if not given:
            agenda = [(t, s) for t in plan - facts for s in self.small.kinds[t.kind].rule]
            return self._satisfy(plan, agenda)
        one, *rest = given
        for token in self.small.tokens(one.kind):
            if one.x not in (None, token.x) or not one.start[0] <= token.start <= one.start[1]:
                continue
            if one.role == "goal" and not one.end[0] <= token.end <= one.end[1]:
                continue
            if self.small.kinds[one.kind].exogenous and one.role == "goal" and token not in plan:
                continue
            if self.small.fits(plan, token):
                true = facts | {token} if one.role == "fact" else facts
                if self._place(plan | {token}, rest, true):
                    return True
        return False

    def _satisfy(
        self, plan: frozenset[Token], agenda: list[tuple[Token, Statement]], kept: frozenset[Span] = frozenset()
    ) -> bool:
        self.budget -= 1
        if self.budget < 0:
            raise TimeoutError
        if not agenda:
            return True
        (token, statement), *rest = agenda
        if isinstance(statement, Keep):
            spans = list(self.small.spans(token, statement))
            if any(map(outside, spans)):
                return self._satisfy(plan, rest, kept)
            return any(
                self._satisfy(plan, rest, kept | {span})
                for span in spans
                if not any(self.small.spoils(t, span) for t in plan)
            )
        if isinstance(statement, When):
            return self._satisfy(plan, [*((token, a) for a in statement.body if token.x == statement.x), *rest], kept)
        if isinstance(statement, Either):
            return any(self._satisfy(plan, [*((token, a) for a in body), *rest], kept) for body in statement.bodies)
        candidates = self.small.asked(token, statement)
        if any(outside(c) for c in candidates):
            return self._satisfy(plan, rest, kept)
        kind = self.small.kinds[statement.target]
        for candidate in candidates:
            if candidate in plan:
                if self._satisfy(plan, rest, kept):
                    return True
            elif not kind.exogenous and self.small.fits(plan, candidate):
                added = [(candidate, s) for s in kind.rule]
                spoilt = any(self.small.spoils(candidate, span) for span in kept)
                if not spoilt and self._satisfy(plan | {candidate}, [*rest, *added], kept):
                    return True
        return False


def random_small(rng: random.Random, keeping: bool = False) -> Small:
    """A random domain of two timelines and a random problem. `keeping`: with constraint tokens."""
    names = {"a0": "A", "a1": "A", "b0": "B", "b1": "B"}
    kinds = {}
    for name, line in names.items():
        shortest = rng.randint(1, 2)
        others = [n for n in names if n != name and (names[n] != line or rng.random() < 0.3)]
        rule = tuple(_statement(rng, others) for _ in range(rng.choice((0, 1, 1, 2))))
        exogenous = name == "b1" and rng.random() < 0.5
        kinds[name] = Kind(name, line, (shortest, shortest + rng.randint(0, 2)), exogenous, rule)
    given = []
    if rng.random() < 0.6:
        kind = rng.choice(("b0", "b1"))
        start = rng.randint(0, 3)
        given.append(Given(kind, rng.choice((None, 0, 1)), (start, start), role=rng.choice(("fact", "state"))))
    for _ in range(rng.choice((1, 1, 2))):
        early, late = rng.randint(0, 2), rng.randint(3, 5)
        given.append(Given(rng.choice(list(names)), rng.choice((None, 0, 1)), (early, late), (0, HORIZON[1])))
    if keeping:
        kinds = {name: replace(k, rule=(*k.rule, *_keeps(rng, names, k.line))) for name, k in kinds.items()}
    return Small(kinds, given)


def _keeps(rng: random.Random, names: dict[str, str], line: str) -> Iterator[Keep]:
    if rng.random() < 0.6:
        over = rng.choice("AB")
        known = [n for n in names if names[n] == over and rng.random() < 0.6]
        relation = rng.choice(
            ("equals", "contained_by", "starts", "ends", "parallels") if over != line else ("meets", "met_by", "starts")
        )
        yield Keep(relation, over, tuple((n, rng.choice((None, 0, 1, -1))) for n in known))


def _ask(rng: random.Random, targets: list[str]) -> Ask:
    relation = rng.choice(
        ("meets", "met_by", "contained_by", "contains", "equals", "starts", "before", "after", "ends")
    )
    bounds: tuple[Bounds, ...] = ((0, rng.randint(0, 2)),) if relation in ("before", "after") else ()
    choice = rng.random()
    x = rng.choice(VALUES) if choice < 0.3 else None
    return Ask(relation, rng.choice(targets), bounds, x, same=choice > 0.7)


def _statement(rng: random.Random, targets: list[str]) -> Statement:
    kind = rng.random()
    if kind < 0.6:
        return _ask(rng, targets)
    if kind < 0.8:
        return When(rng.choice(VALUES), (_ask(rng, targets),))
    return Either(((_ask(rng, targets),), (_ask(rng, targets),)))


def schedules(plan: FlexiblePlan, limit: int = 40) -> Iterator[dict[str, int]]:
    """Whole-number schedules of a plan's hosts, from nothing but its bounds and constraints."""
    hosts = [*plan.hosts(), *(t for t in plan.tokens if t.allowed is not None)]
    points = [f"{t.id}.{side}" for t in hosts for side in ("start", "end")]
    window = (HORIZON[0] - REACH, HORIZON[1] + REACH)
    edges = [(c.from_, c.to, c.min, c.max) for c in plan.constraints]
    ranges = {}
    for token in hosts:
        edges.append((f"{token.id}.start", f"{token.id}.end", *token.duration))
        for side, (low, high) in (("start", token.start), ("end", token.end)):
            least = window[0] if low is None else max(low, window[0])
            most = window[1] if high is None else min(high, window[1])
            ranges[f"{token.id}.{side}"] = range(least, most + 1)

    def extend(at: dict[str, int], left: list[str]) -> Iterator[dict[str, int]]:
        if not left:
            yield dict(at)
            return
        for value in ranges[left[0]]:
            at[left[0]] = value
            if all(_kept(e, at) for e in edges if left[0] in e[:2]):
                yield from extend(at, left[1:])
        at.pop(left[0], None)

    yield from itertools.islice(extend({ORIGIN: 0}, points), limit)


def _kept(edge: tuple[str, str, int | None, int | None], at: dict[str, int]) -> bool:
    from_, to, low, high = edge
    if from_ not in at or to not in at:
        return True
    distance = at[to] - at[from_]
    return (low is None or low <= distance) and (high is None or distance <= high)


def violations(small: Small, plan: FlexiblePlan, at: dict[str, int], facts: set[str]) -> list[str]:
    """What a schedule of a plan breaks: overlap, a missing token, a rule."""
    ground = {}
    for host in plan.hosts():
        name = host.predicate.split(".")[1]
        value = host.parameters["x"]
        assert isinstance(value, int)
        ground[host.id] = Token(name, value, at[f"{host.id}.start"], at[f"{host.id}.end"])
    found = []
    whole = frozenset(ground.values())
    for line in plan.timelines:
        for (first, *_), (second, *_) in itertools.pairwise(line.slots):
            if ground[first].end > ground[second].start:
                found.append(f"{ground[first]} overlaps {ground[second]}")
    for id_, token in ground.items():
        kind = small.kinds[token.kind]
        if not kind.duration[0] <= token.end - token.start <= kind.duration[1]:
            found.append(f"{token} lasts too short or too long")
        if id_ not in facts:
            found += [f"{token}: {s}" for s in kind.rule if not _holds(small, whole, token, s)]
    for goal in (g for g in small.given if g.role == "goal"):
        if not any(
            t.kind == goal.kind
            and goal.x in (None, t.x)
            and goal.start[0] <= t.start <= goal.start[1]
            and goal.end[0] <= t.end <= goal.end[1]
            for t in whole
        ):
            found.append(f"{goal} is not achieved")
    return found


def _holds(small: Small, plan: frozenset[Token], token: Token, statement: Statement) -> bool:
    if isinstance(statement, Keep):
        spans = small.spans(token, statement)
        return any(outside(span) or not any(small.spoils(t, span) for t in plan) for span in spans)
    if isinstance(statement, When):
        return token.x != statement.x or all(_holds(small, plan, token, a) for a in statement.body)
    if isinstance(statement, Either):
        return any(all(_holds(small, plan, token, a) for a in body) for body in statement.bodies)
    candidates = small.asked(token, statement)
    return any(c in plan or outside(c) for c in candidates)
