"""Methods on variables, tokens, objects and classes in the problem of a program."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from planner.language.nddl.errors import Complaint
from planner.language.nddl.syntax import Expression, Method, Name, Statement
from planner.model.classes import ModelObject
from planner.tokens.instance import RuleInstance

if TYPE_CHECKING:
    from planner.language.nddl.program import _Execution as Execution

_UNDONE_BY = {
    "reset": ("specify", "restrict"),
    "cancel": ("activate", "merge", "reject"),
    "free": ("constrain",),
}


def withdrawn(statements: Sequence[Statement]) -> set[int]:
    """The identities of statements that a later `reset`, `cancel` or `free` takes back, so that it is as if they had
    never been made."""
    gone: set[int] = set()
    standing: dict[tuple[str, ...], list[Method]] = {}
    for statement in statements:
        if not isinstance(statement, Method):
            continue
        key = _subject(statement)
        undone = _UNDONE_BY.get(statement.method)
        if undone is None:
            standing.setdefault(key, []).append(statement)
            continue
        kept = []
        for earlier in standing.get(key, []):
            if earlier.method in undone and _same_tokens(statement, earlier):
                gone.add(id(earlier))
            else:
                kept.append(earlier)
        standing[key] = kept
    return gone


def _subject(statement: Method) -> tuple[str, ...]:
    return statement.path


def _same_tokens(later: Method, earlier: Method) -> bool:
    """Whether `free(t1, t2)` is about what `constrain(t1, t2)` was: the tokens that it names."""
    return later.method != "free" or earlier.arguments[: len(later.arguments)] == later.arguments


def _arguments(node: Method, fewest: int, most: int) -> tuple[Expression, ...]:
    count = len(node.arguments)
    if not fewest <= count <= most:
        expected = str(fewest) if fewest == most else f"{fewest} to {most}"
        raise Complaint(node.at, f"{node.method}: expected {expected} arguments, found {count}")
    return node.arguments


def _tokens(execution: Execution, node: Method) -> list[Name]:
    names = [argument for argument in node.arguments if isinstance(argument, Name)]
    if len(names) < len(node.arguments):
        raise Complaint(node.at, f"{node.method}: expected tokens by their names")
    return names


def _specify(execution: Execution, node: Method, instance: RuleInstance) -> None:
    (value,) = _arguments(node, 1, 1)
    execution.specify(Name(node.path, at=node.at), value, instance)


def _nothing(execution: Execution, node: Method, instance: RuleInstance) -> None:
    """What it takes back was left out from the beginning."""
    execution.scope.meaning(node.path, node.at)


def _close(execution: Execution, node: Method, instance: RuleInstance) -> None:
    """Objects are all created before the plan begins, so that closing changes nothing; the name must be one."""
    _arguments(node, 0, 0)
    if node.path and not (len(node.path) == 1 and node.path[0] in execution.symbols.classes):
        execution.scope.meaning(node.path, node.at)


def _activate(execution: Execution, node: Method, instance: RuleInstance) -> None:
    _arguments(node, 0, 0)
    execution.activate(execution.token(node.path, node.at), instance)


def _reject(execution: Execution, node: Method, instance: RuleInstance) -> None:
    _arguments(node, 0, 0)
    execution.reject(execution.token(node.path, node.at), node.at)


def _merge(execution: Execution, node: Method, instance: RuleInstance) -> None:
    _arguments(node, 1, 1)
    (target,) = _tokens(execution, node)
    token, host = execution.token(node.path, node.at), execution.token(target.path, target.at)
    if token.predicate is not host.predicate or token is host:
        message = f"{token.name!r} of {token.predicate.full_name} cannot be merged with {host.name!r} of"
        raise Complaint(node.at, f"{message} {host.predicate.full_name}")
    execution.tokens.merge(token, host, instance)


def _constrain(execution: Execution, node: Method, instance: RuleInstance) -> None:
    """`object.constrain(t1, t2)`: both lie on the object's timeline, and t1 before t2, unless they are the same."""
    _arguments(node, 1, 2)
    tokens = [execution.token(name.path, name.at) for name in _tokens(execution, node)]
    thing = execution.database.model.objects.get(".".join(node.path))
    if not isinstance(thing, ModelObject):
        raise Complaint(node.at, f"expected an object, found {'.'.join(node.path)!r}, which is none")
    network = execution.database.network
    for token in tokens:
        network.restrict(token.object, execution.tokens.domain_of_object(thing), instance)
    if len(tokens) == 2 and tokens[0] is not tokens[1]:
        network.distance(tokens[0].end, tokens[1].start, 0, math.inf, instance)


def _done(execution: Execution, node: Method, instance: RuleInstance) -> None:
    """Limits of resources were set when objects were created."""


METHODS: dict[str, Callable[[Execution, Method, RuleInstance], None]] = {
    "specify": _specify,
    "restrict": _specify,
    "reset": _nothing,
    "cancel": _nothing,
    "free": _nothing,
    "close": _close,
    "activate": _activate,
    "reject": _reject,
    "merge": _merge,
    "constrain": _constrain,
    "set_capacity": _done,
    "set_limit": _done,
    "setLimit": _done,
}
