"""Actions and the fluents that they bring about.

A predicate that some action has as an effect holds only because an action with that effect did, or because a fact says
so. So every active token of it asks for one of those actions, in the inverse relation; an action that is already there
serves, and so does one outside of the horizon. Facts ask for nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from planner.language.nddl.errors import NOWHERE, Position
from planner.language.nddl.scope import Scope, VariableMeaning
from planner.language.nddl.symbols import PredicateKey, Symbols
from planner.language.nddl.syntax import Declaration, Either, ForEach, If, Name, Relation, RuleDefinition, Statement
from planner.model.rules import OneOf, Ref, Require, Rule, Subgoal

_INVERSES = (
    ("before", "after"),
    ("meets", "met_by"),
    ("contains", "contained_by"),
    ("parallels", "paralleled_by"),
    ("starts_before", "starts_after"),
    ("ends_before", "ends_after"),
    ("starts_before_end", "ends_after_start"),
    ("starts_during", "contains_start"),
    ("ends_during", "contains_end"),
    ("startsBefore", "startsAfter"),
    ("endsBefore", "endsAfter"),
    ("startsBeforeEnd", "endsAfterStart"),
)
INVERSE = dict(_INVERSES) | {b: a for a, b in _INVERSES}
INVERSE |= {name: name for name in ("any", "equals", "equal", "starts", "ends")}
INVERSE |= {"containedBy": "contains", "paralleledBy": "parallels"}

_RESOURCES = ("Reservoir", "Reusable", "CBReusable")


class Supports:
    """Which actions have which predicates as effects."""

    def __init__(self, symbols: Symbols) -> None:
        self.symbols = symbols
        self._effects: dict[PredicateKey, list[tuple[PredicateKey, str, Ref | None]]] = {}
        self._at: dict[PredicateKey, Position] = {}

    def note(self, rule: RuleDefinition) -> None:
        """Enter the effects that a rule of an action states."""
        action = (rule.cls, rule.predicate)
        declared = self.symbols.predicates_of(rule.cls)[rule.predicate].definition
        if declared is None or not declared.action:
            return
        scope, values = Scope(self.symbols, action), _Values()
        for relation in _relations(rule.body, scope, values):
            for target in relation.targets:
                if target.role != "effect" or relation.origin is not None:
                    continue
                (cls, name), owner = scope.predicate_of(values.meant(target.path), target.at)
                if owner is not None and owner.path[0] in scope.names:
                    owner = None  # a local variable of the action: what becomes of it cannot be said from outside
                if any(self.symbols.is_subclass(cls, resource) for resource in _RESOURCES):
                    continue  # a transaction says how much is taken or given: nothing has to bring it about
                declaring = self.symbols.predicates_of(cls)[name].cls
                self._effects.setdefault((declaring, name), []).append((action, relation.relation, owner))
                self._at.setdefault((declaring, name), rule.at)

    def rules(self) -> Iterator[Rule]:
        """For each such predicate the rule that asks for one of the actions."""
        for effect, actions in self._effects.items():
            branches = []
            for number, (action, relation, owner) in enumerate(actions):
                name = f"support_{number + 1}"
                branch: list[Subgoal | Require] = [Subgoal(INVERSE[relation], action, name)]
                if owner is not None:
                    branch.append(Require("eq", (Ref((name, *owner.path)), Ref(("object",)))))
                branches.append(tuple(branch))
            where = f"{self._at.get(effect, NOWHERE)}: what brings about {effect[0]}.{effect[1]}"
            yield Rule(effect, (OneOf("support", tuple(branches)),), where)


class _Values:
    """Local variables that are declared with a path as their value, so that they can be read as that path."""

    def __init__(self) -> None:
        self._paths: dict[str, tuple[str, ...]] = {}

    def declare(self, node: Declaration, scope: Scope) -> None:
        """Enter the variables of a declaration."""
        for variable in node.variables:
            if isinstance(variable.value, Name):
                self._paths[variable.name] = self.meant(variable.value.path)
            else:
                scope.add(variable.name, node.type)

    def meant(self, path: tuple[str, ...]) -> tuple[str, ...]:
        """The path with the value of its first name in that name's place."""
        return (*self._paths.get(path[0], path[:1]), *path[1:])


def _relations(statements: Sequence[Statement], scope: Scope, values: _Values) -> Iterator[Relation]:
    """The relations of a body in order; the local variables before each are entered."""
    for statement in statements:
        if isinstance(statement, Relation):
            yield statement
        elif isinstance(statement, Declaration):
            values.declare(statement, scope)
        elif isinstance(statement, If):
            yield from _relations((*statement.then, *statement.otherwise), scope, values)
        elif isinstance(statement, Either):
            yield from _relations([one for branch in statement.branches for one in branch], scope, values)
        elif isinstance(statement, ForEach):
            over = scope.meaning(values.meant(statement.over.path), statement.over.at)
            if isinstance(over, VariableMeaning):
                scope.add(statement.name, over.type)
            yield from _relations(statement.body, scope, values)
