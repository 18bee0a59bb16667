"""What constraint tokens make of value tokens.

A constraint token lies over the timeline of its attribute, across any number of slots. To each value token there it is
on a side: the value token is before it, or after it, or *within*, which is to say that its value is one of those
allowed. The side is a variable of the pair: bounds and parameters take away what cannot be, guards post what the side
that is left means, and a search decides the rest. So sides are explained, undone and taken back like all else, and
two constraint tokens may overlap as they like: codesignation is for value tokens.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from planner.constraints.network import AnyVariable, Variable
from planner.constraints.procedure import ConstraintProcedure
from planner.domains import Domain, Universe
from planner.model.rules import Guard, Ref, Relate, Require, Statement
from planner.tokens.instance import GuardInstance, RuleInstance
from planner.tokens.limits import Allowed
from planner.tokens.token import Token

if TYPE_CHECKING:
    from planner.tokens.manager import TokenNetworkManager

WITHIN, BEFORE, AFTER = "within", "before", "after"
SIDES = Universe("side", (WITHIN, BEFORE, AFTER))
"""Where a value token is, the side that commits to least first."""


class Coverage:
    """A constraint token and a value token of its timeline. `allowed`: what of the first the second may be, or None."""

    __slots__ = ("allowed", "instance", "limit", "side", "token")

    def __init__(
        self, limit: Token, token: Token, side: Variable, allowed: Allowed | None, instance: RuleInstance
    ) -> None:
        self.limit = limit
        self.token = token
        self.side = side
        self.allowed = allowed
        self.instance = instance

    @property
    def is_settled(self) -> bool:
        """Whether the side is decided, or bounds or values tell that it makes no difference."""
        if self.side.domain.is_singleton or self.instance.withdrawn:
            return True
        temporal, limit, token = self.limit.start.temporal, self.limit, self.token
        for first, second in ((token.end, limit.start), (limit.end, token.start)):
            if temporal.upper(first.timepoint) <= temporal.lower(second.timepoint):
                return True
        return self.allowed is not None and all(
            _surely_in(token.parameters[name].domain, limit) for name, limit in self.allowed.limits.items()
        )

    def sides(self) -> Iterator[str]:
        """The sides that are left, one that the order of timepoints entails first."""
        temporal, limit, token = self.limit.start.temporal, self.limit, self.token
        entailed = [
            side
            for side, first, second in ((BEFORE, token.end, limit.start), (AFTER, limit.end, token.start))
            if temporal.distance(first.timepoint, second.timepoint)[0] >= 0
        ]
        left = list(self.side.domain.values())
        yield from sorted(left, key=lambda side: side not in entailed)


def cover(manager: TokenNetworkManager, limit: Token, token: Token) -> None:
    """Relate an active constraint token and an active value token of its timeline."""
    allowed = next((a for a in limit.allowed if a.predicate is token.predicate), None)
    instance = RuleInstance(_Confinement(limit), token, beside=limit)
    before = manager.measure()
    network, model = manager.network, manager.model
    sides = SIDES.domain() if allowed is not None else SIDES.domain((BEFORE, AFTER))
    side = network.variable(f"{limit.name} over {token.name}", sides, instance)
    manager.name_variable(side)
    instance.names.update(limit=limit, token=token)
    network.post(_MAY_BE, (token.start, token.end, limit.start, limit.end, side), instance)
    conditions: list[Statement] = []
    for name, bound in allowed.limits.items() if allowed is not None else ():
        variable = network.variable(f"{side.name}.{name}", bound, instance) if isinstance(bound, Domain) else bound
        network.post(_admits(model.procedures.get("eq")), (token.parameters[name], variable, side), instance)
        instance.names[f"allowed {name}"] = variable
        conditions.append(Require("eq", (Ref(("token", name)), Ref((f"allowed {name}",)))))
    meaning: dict[str, tuple[Statement, ...]] = {
        WITHIN: tuple(conditions),
        BEFORE: (Relate("before", "token", "limit"),),
        AFTER: (Relate("after", "token", "limit"),),
    }
    for one in sides.values():
        constant = network.variable(one, SIDES.domain((one,)), None)
        network.watch(GuardInstance(manager, Guard("eq", (), meaning[one]), (side, constant), instance))
    instance.extent = manager.extent_since(before)
    for end in (limit, token):
        manager.trail.append(end.rules, instance)
    manager.trail.append(manager.coverages, Coverage(limit, token, side, allowed, instance))


class _Confinement:
    """What a constraint token makes of a value token, as a label."""

    __slots__ = ("limit",)

    def __init__(self, limit: Token) -> None:
        self.limit = limit

    def __str__(self) -> str:
        return f"constraint token {self.limit!r}"


def _surely_in(domain: Domain, limit: AnyVariable | Domain) -> bool:
    """Whether whatever value of a domain is taken is one that the limit allows."""
    if isinstance(limit, Domain):
        return not domain.is_open and domain.intersect(limit) == domain
    return domain.is_singleton and limit.domain.is_singleton and not domain.intersect(limit.domain).is_empty


def _may_be(domains: Sequence[Domain]) -> Sequence[Domain] | None:
    """side = before implies end <= first; side = after implies last <= start."""
    start, end, first, last, side = domains
    left = side
    if end.lower > first.upper:
        left = left.without(BEFORE)
    if last.lower > start.upper:
        left = left.without(AFTER)
    return None if left.is_empty else (start, end, first, last, left)


_MAY_BE = ConstraintProcedure("side", _may_be, 5, 5)


def _admits(equal: ConstraintProcedure) -> ConstraintProcedure:
    """The relation between a parameter, what it has to equal within, and the side."""

    def narrow(domains: Sequence[Domain]) -> Sequence[Domain] | None:
        """side = within implies parameter = allowed."""
        value, allowed, side = domains
        if equal.narrow((value, allowed)) is not None:
            return domains
        left = side.without(WITHIN)
        return None if left.is_empty else (value, allowed, left)

    return ConstraintProcedure("admits", narrow, 3, 3)
