"""From a complete plan database to a FlexiblePlan: hosts, slots, bounds, every temporal constraint with its reason."""

from __future__ import annotations

from planner.constraints.network import Owner, Variable
from planner.database import PlanDatabase
from planner.domains import Domain, Interval
from planner.model.classes import ModelObject
from planner.plan import (
    CODESIGNATED,
    ORIGIN,
    Bound,
    Bounds,
    FlexiblePlan,
    ParameterValue,
    PlanConstraint,
    PlanTimeline,
    PlanToken,
    PlanValue,
    Value,
)
from planner.temporal.network import INFINITY
from planner.tokens.gap import Gap
from planner.tokens.token import Token, TokenState

_UNBOUNDED = 1 << 49
"""Bounds from here on are the temporal network's way of saying that there is none."""


def extract(database: PlanDatabase) -> FlexiblePlan:
    """The flexible plan that the database holds."""
    listed, open_ = numbered(database)
    tokens, outside = [t for _, t in listed], [t for _, t in open_]
    ids = {id(t): name for name, t in (*listed, *open_)}
    merged: dict[int, list[Token]] = {}
    for token in tokens:
        if token.host is not None:
            merged.setdefault(id(host_of(token)), []).append(token)
    timelines = []
    for timeline in database.tokens.timelines.values():
        slots = (tuple(ids[id(t)] for t in [host, *merged.get(id(host), ())]) for host in timeline.sequence)
        timelines.append(PlanTimeline(timeline.object.name, timeline.attribute, tuple(slots)))
    constraints, durations = _constraints(database, tokens, ids)
    return FlexiblePlan(
        model=database.model.name,
        horizon=database.horizon,
        objects=tuple(database.model.objects),
        timelines=tuple(timelines),
        tokens=tuple(_token(database, t, ids, durations) for t in tokens),
        constraints=constraints,
        boundary=tuple(_token(database, t, ids, durations) for t in outside),
        variables=_variables(database),
    )


def _variables(database: PlanDatabase) -> dict[str, ParameterValue]:
    """The problem's variables, and the members of objects of which something was decided."""
    model, tokens = database.model, database.tokens
    found = {name: v for name, v in tokens.names.items() if name in model.variables and isinstance(v, Variable)}
    values = {name: _value(variable.domain) for name, variable in found.items() if not variable.domain.is_empty}
    for thing, name, variable in tokens.open_members():
        if variable.domain != thing.members.get(name, model.domain_of(model.members_of(thing.cls)[name])):
            values[f"{thing}.{name}"] = _value(variable.domain)
    return values


def numbered(database: PlanDatabase) -> tuple[list[tuple[str, Token]], list[tuple[str, Token]]]:
    """The tokens of the plan and those that it leaves open, with the identifiers that the plan gives them."""
    tokens = [t for t in database.tokens.tokens if t.state in (TokenState.ACTIVE, TokenState.MERGED)]
    outside = [t for t in database.tokens.tokens if t.state is TokenState.INACTIVE]
    names = iter(range(len(tokens) + len(outside)))
    return [(f"t{next(names)}", t) for t in tokens], [(f"t{next(names)}", t) for t in outside]


def host_of(token: Token) -> Token:
    """The active token that this one is, in the end, codesignated with."""
    while token.host is not None:
        token = token.host
    return token


def _token(database: PlanDatabase, token: Token, ids: dict[int, str], durations: dict[int, Bounds]) -> PlanToken:
    temporal = database.temporal
    host = host_of(token)
    stated = host.duration.stated
    duration = _finite(stated.lower), _finite(stated.upper)
    if not host.contingent:
        duration = _tighter(duration, durations.get(host.start.timepoint, (None, None)))
    return PlanToken(
        id=ids[id(token)],
        object=token.thing.name if token.object.domain.is_singleton else "",
        attribute=token.predicate.attribute,
        predicate=token.predicate.full_name,
        parameters={name: _value(variable.domain) for name, variable in token.parameters.items()},
        start=(_finite(temporal.lower(token.start.timepoint)), _finite(temporal.upper(token.start.timepoint))),
        end=(_finite(temporal.lower(token.end.timepoint)), _finite(temporal.upper(token.end.timepoint))),
        duration=duration,
        contingent=host.contingent,
        goal=token.name if token.role in ("goal", "rejectable") else None,
        fact=token.role == "fact",
        master=ids.get(id(token.master)) if token.master is not None else None,
        allowed=_allowed(token),
    )


def _allowed(token: Token) -> tuple[PlanValue, ...] | None:
    """What a constraint token allows."""
    if token.kind != "constraint":
        return None
    return tuple(
        PlanValue(
            value.predicate.full_name,
            {n: _value(limit if isinstance(limit, Domain) else limit.domain) for n, limit in value.limits.items()},
        )
        for value in token.allowed
    )


class _Between:
    """What holds between two timepoints: bounds of the distance, and why, each reason once."""

    __slots__ = ("lower", "reasons", "upper")

    def __init__(self) -> None:
        self.lower, self.upper = -INFINITY, INFINITY
        self.reasons: dict[str, None] = {}

    def tighten(self, lower: int, upper: int) -> None:
        self.lower, self.upper = max(lower, self.lower), min(upper, self.upper)

    @property
    def bounds(self) -> Bounds:
        return _finite(self.lower), _finite(self.upper)


def _constraints(
    database: PlanDatabase, tokens: list[Token], ids: dict[int, str]
) -> tuple[tuple[PlanConstraint, ...], dict[int, Bounds]]:
    """The constraints between timepoints of hosts, one a pair, and the bounds of each host's own duration."""
    points = _Points(tokens)
    found: dict[tuple[int, int], _Between] = {}
    durations: dict[int, _Between] = {}
    why: dict[int, str] = {}
    for _, from_, to, lower, upper, owner in database.temporal.constraints():
        one, two = points.of_host.get(from_), points.of_host.get(to)
        reason = database.network.stakeholder_named(owner)
        # A gap follows from the tokens in between.
        if one is None or two is None or one == two or isinstance(reason, Gap):
            continue
        minimum, maximum = lower, upper
        if (two, one) in found or points.are_host(two, one):
            one, two, minimum, maximum = two, one, -upper, -lower
        if points.are_host(one, two):
            durations.setdefault(one, _Between()).tighten(minimum, maximum)
            stated = points.hosts[one].duration.stated
            # Nature's own choice is no constraint of the plan; what the plan wants of it is.
            if not points.hosts[one].contingent or (minimum <= stated.lower and stated.upper <= maximum):
                continue
        between = found.setdefault((one, two), _Between())
        between.tighten(minimum, maximum)
        between.reasons[why.get(id(reason)) or why.setdefault(id(reason), _why(reason))] = None
    names = points.names(ids)
    listed = _codesignations_off_timelines(tokens, ids) + tuple(
        PlanConstraint(names[one], names[two], *between.bounds, "; ".join(between.reasons))
        for (one, two), between in found.items()
        if between.bounds != (None, None)
    )
    return listed, {start: between.bounds for start, between in durations.items()}


class _Points:
    """The timepoints of tokens. `of_host`: of each, that of the host; `hosts`: the hosts by their starts."""

    def __init__(self, tokens: list[Token]) -> None:
        self.of_host = {0: 0}
        self.hosts: dict[int, Token] = {}
        for token in tokens:
            host = host_of(token)
            self.of_host[token.start.timepoint] = host.start.timepoint
            self.of_host[token.end.timepoint] = host.end.timepoint
            self.hosts[host.start.timepoint] = host

    def are_host(self, start: int, end: int) -> bool:
        """Whether these are the start and the end of one host."""
        return start in self.hosts and self.hosts[start].end.timepoint == end

    def names(self, ids: dict[int, str]) -> dict[int, str]:
        """The names of the hosts' timepoints."""
        names = {0: ORIGIN}
        for start, host in self.hosts.items():
            names[start] = f"{ids[id(host)]}.start"
            names[host.end.timepoint] = f"{ids[id(host)]}.end"
        return names


def _codesignations_off_timelines(tokens: list[Token], ids: dict[int, str]) -> tuple[PlanConstraint, ...]:
    """Slots tell which tokens of a timeline are one; of other tokens, constraints do."""
    return tuple(
        PlanConstraint(f"{ids[id(host_of(t))]}.{side}", f"{ids[id(t)]}.{side}", 0, 0, CODESIGNATED)
        for t in tokens
        if t.host is not None and t.kind != "timeline"
        for side in ("start", "end")
    )


def _why(owner: Owner) -> str:
    return owner if isinstance(owner, str) else repr(owner)


def _finite(value: float) -> Bound:
    return int(value) if -_UNBOUNDED < value < _UNBOUNDED else None


def _tighter(one: Bounds, two: Bounds) -> Bounds:
    lows = [b for b in (one[0], two[0]) if b is not None]
    highs = [b for b in (one[1], two[1]) if b is not None]
    return max(lows, default=None), min(highs, default=None)


def _value(domain: Domain) -> ParameterValue:
    if domain.is_singleton:
        return _plain(domain.value)
    if isinstance(domain, Interval):
        return {"min": _number(domain.lower), "max": _number(domain.upper)}
    return tuple(_plain(v) for v in domain.values())


def _plain(value: object) -> Value:
    if isinstance(value, ModelObject):
        return value.name
    assert isinstance(value, (bool, int, float, str))  # a union would be made anew for every value
    return value


def _number(value: float) -> float | None:
    return value if abs(value) < INFINITY else None
