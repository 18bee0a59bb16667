"""A plan beside its model: slots, declarations and values, looked up once for all judgements."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from planner.checker.network import PlanNetwork
from planner.domains import Domain, Interval, Universe, Values, singleton
from planner.model.classes import ModelObject, Predicate
from planner.model.manager import ModelManager
from planner.plan import FlexiblePlan, PlanToken


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


@dataclass(frozen=True)
class View:
    """A structurally sound plan. `slots`: by host, those of timelines first, then tokens of other attributes alone."""

    plan: FlexiblePlan
    model: ModelManager
    slots: dict[str, Slot]
    network: PlanNetwork
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


def closed(domain: Domain) -> Domain:
    """The same values as a domain to which nothing will be added: a plan is judged in the world as it stands."""
    if isinstance(domain, Values) and domain.is_open:
        return Universe(domain.universe.name, domain.values()).domain()
    return domain
