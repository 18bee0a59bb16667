"""What a model says of a predicate whose parameters are given: its shortest duration, and what may come next to it.

Statements are read without a plan: constraint procedures narrow the domains of the predicate's own variables and, for
what comes next to it, those of the neighbour. What cannot be read so (local variables, times, members of objects,
guards that are not decided) is left out: the answer may allow too much, never too little.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Literal

from planner.domains import Domain, Interval, singleton
from planner.model.classes import ModelObject, Predicate, objects_in
from planner.model.relations import OE, OS, TE, TS, distances
from planner.model.resources import USES
from planner.model.rules import Constant, Expression, Guard, OneOf, Ref, Require, Statement, Subgoal

if TYPE_CHECKING:
    from planner.model.manager import ModelManager

Side = Literal["after", "before"]
_TOUCHING: Mapping[Side, tuple[str, str]] = {"after": (OE, TS), "before": (TE, OS)}

Scope = Mapping[tuple[str, ...], Domain]
"""The domains that paths mean: `("target",)`, and for a neighbour that a rule calls `next`, `("next", "target")`."""


@dataclass(frozen=True, slots=True)
class Demand:
    """A neighbour that a token must have: one of these predicates, under constraints on the parameters of both."""

    subgoal: Subgoal
    requires: tuple[Require, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """A predicate as tokens of it may be. `scope`: the domains of its parameters and of its duration. `after`,
    `before`: of each group of demands one at least must be met by the token that directly follows or precedes.
    `inside`: what must last through all of it."""

    predicate: Predicate
    scope: Scope
    after: tuple[tuple[Demand, ...], ...]
    before: tuple[tuple[Demand, ...], ...]
    inside: tuple[Demand, ...]

    @property
    def shortest(self) -> float:
        """The shortest duration in ticks."""
        return self.scope["duration",].lower


class Grounding:
    """Makes the nodes of one attribute as objects of a class have it."""

    def __init__(self, model: ModelManager, cls: str, attribute: str) -> None:
        self.model = model
        self.cls = cls
        self.attribute = attribute
        self._own = {id(p) for p in model.predicates_of(cls).values() if p.attribute == attribute}

    def node(self, predicate: Predicate, parameters: Mapping[str, Domain]) -> Node | None:
        """The predicate with these domains of its parameters; None when no token can be like that."""
        scope: dict[tuple[str, ...], Domain] = {(p.name,): self.model.domain_of(p.type) for p in predicate.parameters}
        scope |= {(name,): domain for name, domain in parameters.items()}
        scope["duration",] = Interval(*predicate.duration)
        statements = list(predicate.body)
        for rule in self.model.rules_for(self.cls, predicate.name):
            statements += rule.body
        body = list(self._decided(statements, scope))
        changed = True
        while changed:
            changed = False
            for require in body:
                if isinstance(require, Require):
                    narrowed = self._narrow(require, scope)
                    if narrowed is None:
                        return None
                    changed = changed or any(domain is not scope[path] for path, domain in narrowed.items())
                    scope |= narrowed
        after, before = self._demands(body, scope, "after"), self._demands(body, scope, "before")
        return Node(predicate, scope, after, before, tuple(_demanded(body, self._lasts_through)))

    def accepts(self, demands: Sequence[Sequence[Demand]], node: Node, neighbour: Node) -> bool:
        """Whether the neighbour meets one demand of each group."""
        return all(any(self.met(demand, node, neighbour) for demand in group) for group in demands)

    def home_of(self, demand: Demand) -> tuple[ModelObject, str] | None:
        """The timeline on which what a demand asks for must be; None where there may be several."""
        declared = self.model.predicate(*demand.subgoal.predicate)
        things = objects_in(self.model.objects_of(declared.cls))
        return (things[0], declared.attribute) if len(things) == 1 else None

    def met(self, demand: Demand, node: Node, neighbour: Node) -> bool:
        """Whether the neighbour is what a demand of the node asks for."""
        if self.model.predicate(*demand.subgoal.predicate) is not neighbour.predicate:
            return False
        named = {(demand.subgoal.name, *path): domain for path, domain in neighbour.scope.items()}
        scope = {**node.scope, **named}
        return all(self._narrow(require, scope) is not None for require in demand.requires)

    def _demands(self, body: Sequence[Statement], scope: Scope, side: Side) -> tuple[tuple[Demand, ...], ...]:
        touches = partial(self._is_neighbour, side=side)
        groups: list[tuple[Demand, ...]] = [(demand,) for demand in _demanded(body, touches)]
        for choice in body:
            if isinstance(choice, OneOf):
                branches = [list(_demanded([*self._decided(b, scope)], touches)) for b in choice.branches]
                if all(branches):
                    groups.append(tuple(demands[0] for demands in branches))
        return tuple(groups)

    def _is_neighbour(self, subgoal: Subgoal, side: Side) -> bool:
        """Whether a subgoal lies on the token's own timeline and touches it on that side."""
        declared = self.model.predicate(*subgoal.predicate)
        if id(declared) not in self._own:
            return False
        its_own = subgoal.target is not None and _path(subgoal.target) == ("object",)
        if not its_own and self.model.objects_of(declared.cls).size > 1:
            return False
        touching = {_TOUCHING[side], _TOUCHING[side][::-1]}
        return any(
            (d.from_, d.to) in touching and d.minimum == d.maximum == 0
            for d in distances(subgoal.relation, subgoal.bounds)
        )

    def _lasts_through(self, subgoal: Subgoal) -> bool:
        """Whether a subgoal lasts from the token's start or before to its end or after, on a timeline."""
        if self.model.kind_of(self.model.predicate(*subgoal.predicate)) != "timeline":
            return False
        table = distances(subgoal.relation, subgoal.bounds)
        covered = {(d.from_, d.to) for d in table if d.minimum >= 0}
        covered |= {(d.to, d.from_) for d in table if d.maximum <= 0}
        return (TS, OS) in covered and (OE, TE) in covered

    def _decided(self, statements: Sequence[Statement], scope: Scope) -> Iterator[Statement]:
        """The statements, with the branch in place of each guard whose test is decided."""
        for statement in statements:
            if not isinstance(statement, Guard):
                yield statement
            elif (holds := self._holds(statement, scope)) is not None:
                yield from self._decided(statement.then if holds else statement.otherwise, scope)

    def _holds(self, guard: Guard, scope: Scope) -> bool | None:
        if any(isinstance(a, Constant) and a.domain is not None for a in guard.arguments):
            return None
        narrowed = self._narrow(Require(guard.test, guard.arguments), scope)
        if narrowed is None:
            return False
        paths = [_path(a) for a in guard.arguments if isinstance(a, Ref)]
        known = all(path in scope and scope[path].is_singleton and not scope[path].is_open for path in paths)
        return True if known and all(isinstance(a, Ref | Constant) for a in guard.arguments) else None

    def _narrow(self, require: Require, scope: Scope) -> dict[tuple[str, ...], Domain] | None:
        """What a constraint leaves of the domains of the paths that it names; None when it leaves nothing."""
        domains = [_domain(argument, scope) for argument in require.arguments]
        if require.procedure == USES.name or None in domains:
            return {}
        narrowed = self.model.procedures.get(require.procedure).narrow([d for d in domains if d is not None])
        if narrowed is None:
            return None
        return {_path(a): d for a, d in zip(require.arguments, narrowed, strict=True) if isinstance(a, Ref)}


def _demanded(body: Sequence[Statement], which: Callable[[Subgoal], bool]) -> Iterator[Demand]:
    """Those subgoals of a body, each with what the body requires."""
    for subgoal in body:
        if isinstance(subgoal, Subgoal) and which(subgoal):
            yield Demand(subgoal, tuple(s for s in body if isinstance(s, Require)))


def _path(ref: Ref) -> tuple[str, ...]:
    return ref.path[1:] if ref.path[0] == "this" else ref.path


def _domain(argument: Expression, scope: Scope) -> Domain | None:
    if isinstance(argument, Ref):
        return scope.get(_path(argument))
    if isinstance(argument, Constant) and not isinstance(argument.value, ModelObject):
        return singleton(argument.value) if argument.domain is None else argument.domain
    return None
