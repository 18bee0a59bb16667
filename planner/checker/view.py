"""A plan beside its model: slots, declarations and values, looked up once for all judgements."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from planner.checker.network import INF, PlanNetwork
from planner.domains import Domain, Interval, Universe, Values, singleton
from planner.model.classes import ModelObject, Predicate
from planner.model.manager import ModelManager
from planner.plan import FlexiblePlan, PlanToken, PlanValue


@dataclass(frozen=True, slots=True, eq=False)
class Slot:
    """One interval of the plan: codesignated tokens, the host first, with their declaration and object."""

    tokens: tuple[PlanToken, ...]
    predicate: Predicate
    object: ModelObject
    values: dict[str, Domain]

    @property
    def host(self) -> PlanToken:
        """The token that stands for the slot."""
        return self.tokens[0]

    @property
    def id(self) -> str:
        """The host's identifier."""
        return self.tokens[0].id

    @property
    def ids(self) -> tuple[str, ...]:
        """All identifiers."""
        return tuple(token.id for token in self.tokens)

    @property
    def is_fact(self) -> bool:
        """Whether it is true without support."""
        return any(token.fact for token in self.tokens)

    @property
    def stated(self) -> tuple[PlanToken, ...]:
        """The tokens that a problem states to be so: no other token's requirement, and nobody's goal."""
        return tuple(token for token in self.tokens if token.master is None and token.goal is None)


@dataclass(frozen=True, slots=True, eq=False)
class Limit:
    """A constraint token: its interval, as a slot of no timeline, and the values that it allows by predicate, each with
    what its parameters are within."""

    slot: Slot
    allowed: Mapping[str, Mapping[str, Domain]]

    def allows(self, slot: Slot) -> bool:
        """Whether the value of a slot is one of those allowed."""
        limits = self.allowed.get(slot.predicate.full_name)
        return limits is not None and all(_is_in(slot.values[name], limit) for name, limit in limits.items())


@dataclass(frozen=True)
class View:
    """A structurally sound plan. `slots`: by host, those of timelines first, then tokens of other attributes alone.
    `limits`: the constraint tokens. `variables`: what the plan decides besides tokens."""

    plan: FlexiblePlan
    model: ModelManager
    slots: dict[str, Slot]
    network: PlanNetwork
    limits: Mapping[str, Limit] = field(default_factory=dict)
    variables: Mapping[str, Domain] = field(default_factory=dict)
    _by_token: dict[str, Slot] = field(init=False, repr=False, default_factory=dict)

    def __post_init__(self) -> None:
        self._by_token.update((token.id, slot) for slot in self.slots.values() for token in slot.tokens)

    def slot_of(self, token_id: str) -> Slot:
        """The slot that a token is in."""
        return self._by_token[token_id]

    def sequences(self) -> Iterator[list[Slot]]:
        """The slots of each timeline in order."""
        for timeline in self.plan.timelines:
            yield [self.slots[slot[0]] for slot in timeline.slots]

    def range_of(self, slot: Slot, which: str) -> tuple[float, float]:
        """The least and greatest `start`, `end` or `duration` of a slot in any schedule."""
        start, end = self.network.point(slot.id, "start"), self.network.point(slot.id, "end")
        if which == "duration":
            return self.network.span(start, end)
        point = start if which == "start" else end
        return self.network.lower[point], self.network.upper[point]


def value_of(domain: Domain, value: object) -> Domain | None:
    """The domain that holds a plan's value of a parameter, objects by name; None when it is not decided or outside."""
    if isinstance(domain, Interval):
        if isinstance(value, bool) or not isinstance(value, int | float) or value not in domain:
            return None
        return Interval(value, value, domain.integer)
    for one in domain.values():
        known = one.name if isinstance(one, ModelObject) else one
        if known == value and isinstance(known, bool) == isinstance(value, bool):
            return closed(domain.keep((one,)))
    if domain.is_open and domain.universe.name == "string" and isinstance(value, str):
        return singleton(value)
    return None


def variables_of(plan: FlexiblePlan, model: ModelManager) -> tuple[dict[str, Domain], list[str]]:
    """The variables of the problem and the open members of objects with what the plan says of them, and what it says
    that cannot be."""
    declared = {name: closed(model.domain_of(type_)) for name, type_ in model.variables.items()}
    for thing in model.objects.values():
        for name, type_ in model.members_of(thing.cls).items():
            value = thing.members.get(name)
            if value is None or isinstance(value, Interval | Values):
                declared[f"{thing}.{name}"] = closed(model.domain_of(type_) if value is None else value)
    said = {name: f"the plan gives {name} as {value!r}" for name, value in plan.variables.items()}
    wrong = [f"{text}, the model has no such variable" for name, text in said.items() if name not in declared]
    found = {}
    for name, domain in declared.items():
        given = values_of(domain, plan.variables[name]) if name in plan.variables else domain
        found[name] = domain.intersect(given) if given is not None else domain
        if name in said and (given is None or found[name].is_empty):
            found[name] = domain
            wrong.append(f"{said[name]}, expected some of {domain!r}")
    return found, wrong


def allowed_by(model: ModelManager, values: Iterable[PlanValue]) -> dict[str, dict[str, Domain]]:
    """The values of a constraint token by predicate, each with what its parameters are within."""
    allowed: dict[str, dict[str, Domain]] = {}
    for value in values:
        declared = model.predicate_named(value.predicate)
        types = {p.name: model.domain_of(p.type) for p in declared.parameters}
        given = {name: values_of(types[name], part) for name, part in value.parameters.items()}
        allowed[declared.full_name] = {name: part for name, part in given.items() if part is not None}
    return allowed


def values_of(domain: Domain, values: object) -> Domain | None:
    """The part of a domain that a plan gives: a value, a list of values, or bounds; None when some is not there."""
    if isinstance(values, Mapping):
        lower, upper = values["min"], values["max"]
        given = Interval(-INF if lower is None else lower, INF if upper is None else upper, False)
        return given if isinstance(domain, Interval) else None
    if not isinstance(values, tuple | list):
        return value_of(domain, values)
    found = [value_of(domain, value) for value in values]
    known = [one.value for one in found if one is not None]
    return None if len(known) < len(found) else Universe("given", known).domain()


def _is_in(value: Domain, limit: Domain) -> bool:
    """Whether a decided value is in a domain, numbers by number."""
    return not limit.intersect(value).is_empty


def closed(domain: Domain) -> Domain:
    """The same values as a domain to which nothing will be added: a plan is judged in the world as it stands."""
    if isinstance(domain, Values) and domain.is_open:
        return Universe(domain.universe.name, domain.values()).domain()
    return domain
