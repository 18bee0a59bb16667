"""Configuration constraints as they apply to attribute values (paper, section 4).

A schema is a pattern; what it comes to for a value depends on the value's parameters, which decide its guards. A value
may say as much of its parameters as is known: a guard that this does not decide waits.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from planner.domains import Domain, Interval, Values, singleton
from planner.errors import ModelError, nearest
from planner.model.classes import ModelObject
from planner.model.rules import Constant, Expression, Guard, Ref, Rule, Statement

if TYPE_CHECKING:
    from planner.model.manager import ModelManager


@dataclass(frozen=True, slots=True)
class AttributeValue:
    """That an attribute has a value: a predicate `"Class.predicate"`, the object (None: any of the class), and what is
    known of its parameters: a value each, or a domain."""

    predicate: str
    object: str | None = None
    parameters: tuple[tuple[str, Any], ...] = ()

    @classmethod
    def of(cls, predicate: str, object_: str | None = None, **parameters: Any) -> AttributeValue:
        """The value with these parameters."""
        return cls(predicate, object_, tuple(sorted(parameters.items())))


@dataclass(frozen=True, slots=True)
class ConfigurationConstraint:
    """A schema as it applies to a value: its `statements` with decided guards replaced by the branch that they chose.
    `waiting`: the guards among them that the value does not decide."""

    rule: Rule
    value: AttributeValue
    statements: tuple[Statement, ...]

    @property
    def waiting(self) -> tuple[Guard, ...]:
        """The guards that more about the value, or its token's times and witnesses, would decide."""
        return tuple(s for s in self.statements if isinstance(s, Guard))


def constraints_on(model: ModelManager, values: Iterable[AttributeValue]) -> frozenset[ConfigurationConstraint]:
    """The configuration constraints that apply while attributes have these values; ModelError for a value that the
    model does not have."""
    found = set()
    for value in values:
        known, cls = _known(model, value)
        name = value.predicate.rpartition(".")[2]
        for rule in model.rules_for(cls, name):
            statements = tuple(_instantiated(model, rule.body, known))
            found.add(ConfigurationConstraint(rule, value, statements))
    return frozenset(found)


def _known(model: ModelManager, value: AttributeValue) -> tuple[dict[str, Domain], str]:
    """What is known of each parameter and of the object, and the class whose rules apply."""
    declared = model.predicate_named(value.predicate)
    known = {p.name: model.domain_of(p.type) for p in declared.parameters}
    for name, given in value.parameters:
        if name not in known:
            raise ModelError(f"{declared.full_name} has no parameter {name!r}{nearest(name, known)}")
        within = given if isinstance(given, Interval | Values) else singleton(given)
        part = known[name].intersect(within)
        if part.is_empty:
            raise ModelError(f"{declared.full_name}: {name} is {given!r}, expected one of {known[name]!r}")
        known[name] = part
    cls = value.predicate.partition(".")[0]
    if value.object is None:
        return known, cls
    thing = model.object_named(value.object)
    if not model.is_subclass(thing.cls, declared.cls):
        raise ModelError(f"object {thing} of class {thing.cls} has no predicate {declared.full_name}")
    return known | {"object": model.objects_of("Object").keep((thing,))}, thing.cls


def _instantiated(model: ModelManager, body: Sequence[Statement], known: dict[str, Domain]) -> Iterator[Statement]:
    for statement in body:
        holds = _outcome(model, statement, known) if isinstance(statement, Guard) else None
        if isinstance(statement, Guard) and holds is not None:
            yield from _instantiated(model, statement.then if holds else statement.otherwise, known)
        else:
            yield statement


def _outcome(model: ModelManager, guard: Guard, known: dict[str, Domain]) -> bool | None:
    """Whether a guard's test holds; None where what is known does not decide it."""
    domains = [_domain(model, argument, known) for argument in guard.arguments]
    there = [domain for domain in domains if domain is not None]
    if len(there) < len(domains):
        return None
    if model.procedures.get(guard.test).narrow(there) is None:
        return False
    sets = [isinstance(a, Constant) and a.domain is not None for a in guard.arguments]
    undecided = [d for d, given in zip(there, sets, strict=True) if not given and (d.is_open or not d.is_singleton)]
    return None if undecided else True


def _domain(model: ModelManager, expression: Expression, known: dict[str, Domain]) -> Domain | None:
    """The values of an expression; None for what speaks of times, of other tokens or of results."""
    if isinstance(expression, Constant):
        return singleton(expression.value) if expression.domain is None else expression.domain
    if not isinstance(expression, Ref):
        return None
    first, *rest = expression.path
    if first not in known:  # a bare name of a member is one of the value's own object
        first, rest = "object", [first, *rest]
    if first not in known:
        return None
    domain = known[first]
    for name in rest:
        thing = domain.value if domain.is_singleton else None
        if not isinstance(thing, ModelObject) or name not in model.members_of(thing.cls):
            return None
        member = thing.members.get(name, model.domain_of(model.members_of(thing.cls)[name]))
        domain = member if isinstance(member, Interval | Values) else singleton(member)
    return domain
