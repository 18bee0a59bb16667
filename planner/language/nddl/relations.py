"""Temporal relations of rules and problems: subgoals, and relations between tokens that have names."""

from __future__ import annotations

from typing import TYPE_CHECKING

from planner.errors import ModelError
from planner.language.nddl.errors import Complaint
from planner.language.nddl.keeping import translate as translate_keep
from planner.language.nddl.scope import TokenMeaning
from planner.language.nddl.syntax import Keep, Range, Relation, TokenReference
from planner.model import rules
from planner.model.relations import distances

if TYPE_CHECKING:
    from planner.language.nddl.translator import Translator

Bounds = tuple[tuple[float, float], ...]


def relate(translator: Translator, node: Relation) -> None:
    """Translate `[origin] relation[bounds](targets);`."""
    bounds = tuple(_bounds(translator, Range(one.lower, one.upper, at=one.lower.at)) for one in node.bounds)
    try:
        distances(node.relation, bounds)
    except ModelError as error:
        raise Complaint(node.at, str(error)) from None
    origin = node.origin or "this"
    if node.origin is not None:
        translator.token(node.origin, node.at)
    elif translator.scope.own is None:
        raise Complaint(
            node.at, f"outside of a rule, write which token {node.relation} is about: t1 {node.relation} t2;"
        )
    for target in node.targets:
        _relate_to(translator, node.relation, origin, bounds, target)


def keep(translator: Translator, node: Keep) -> None:
    """Translate `only relation[bounds] {values};`."""
    bounds = tuple(_bounds(translator, Range(one.lower, one.upper, at=one.lower.at)) for one in node.bounds)
    try:
        distances(node.relation, bounds)
    except ModelError as error:
        raise Complaint(node.at, str(error)) from None
    translate_keep(translator, node, bounds)


def _bounds(translator: Translator, node: Range) -> tuple[float, float]:
    interval = translator.literals.interval(node, False)
    return interval.lower, interval.upper


def _relate_to(translator: Translator, relation: str, origin: str, bounds: Bounds, target: TokenReference) -> None:
    scope, out = translator.scope, translator.out
    name = target.name if not target.path else target.path[0] if len(target.path) == 1 else None
    alone = name is not None and (not target.path or target.name is None)
    if name is not None and alone and isinstance(scope.first(name, target.at), TokenMeaning):
        out.append(rules.Relate(relation, origin, name, bounds))
        return
    if not target.path:
        translator.token(target.name or "", target.at)  # complains
    predicate, owner = scope.predicate_of(target.path, target.at)
    name = target.name or translator.fresh(predicate[1])
    scope.add(name, predicate)
    if origin == "this" and scope.own is not None:
        out.append(rules.Subgoal(relation, predicate, name, owner, bounds))
    else:
        out.append(rules.Subgoal("any", predicate, name, owner))
        out.append(rules.Relate(relation, origin, name, bounds))
