"""The statements of a problem as requirements that can be left out, with what then cannot stand either."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any, Literal

from planner.language.nddl.errors import Position
from planner.language.nddl.methods import withdrawn
from planner.language.nddl.program import Program
from planner.language.nddl.syntax import (
    Assignment,
    Declaration,
    ForEach,
    Goal,
    Method,
    Name,
    New,
    Node,
    Relation,
    Statement,
    TokenReference,
)
from planner.model.manager import ModelManager
from planner.model.rules import Ref

_SILENT = ("close", "reset", "cancel", "free")
_LONGEST = 160


class Requirements:
    """What a problem asks for, by number in its order.

    What only says that things exist always stands, but for variables that nothing speaks of: a search would have to
    find values for them.
    """

    def __init__(self, program: Program, model: ModelManager) -> None:
        self.program = program
        self._spoken = set(_names_in_rules(model))
        gone = withdrawn(program.statements)
        self.all = [s for s in program.statements if id(s) not in gone]
        self.numbers = tuple(n for n, s in enumerate(self.all) if _asks(s))
        self._by_place = {_place(self.all[n].at): n for n in self.numbers}
        self._names = {n: frozenset(_names(self.all[n])) for n in self.numbers}
        self._needs = self._dependencies()

    def _dependencies(self) -> dict[int, set[int]]:
        """The statements that introduce the tokens which a statement speaks of."""
        introduced: dict[str, int] = {}
        for number in self.numbers:
            for name in _introduces(self.all[number]):
                introduced.setdefault(name, number)
        return {
            number: {introduced[name] for name in self._names[number] if name in introduced} - {number}
            for number in self.numbers
        }

    def closed(self, chosen: Collection[int]) -> list[int]:
        """Some requirements with those that introduce what they speak of."""
        found, todo = set(chosen), list(chosen)
        while todo:
            for needed in self._needs[todo.pop()] - found:
                found.add(needed)
                todo.append(needed)
        return sorted(found)

    def standing(self, chosen: Collection[int]) -> set[int]:
        """Those of some requirements that speak of nothing that is left out."""
        left = set(chosen)
        while True:
            fallen = {n for n in left if not self._needs[n] <= left}
            if not fallen:
                return left
            left -= fallen

    def program_of(self, chosen: Collection[int]) -> Program:
        """The program with these requirements only."""
        standing = self.standing(chosen)
        used = self._spoken.union(*(self._names[n] for n in standing))
        statements: list[Statement] = []
        for number, statement in enumerate(self.all):
            if number in standing:
                statements.append(statement)
            elif isinstance(statement, Declaration):
                statements += _without_values(statement, used)
            elif not _asks(statement):
                statements.append(statement)
        return replace(self.program, statements=statements)

    def number_at(self, at: Position) -> int | None:
        """The requirement that stands at a place."""
        return self._by_place.get(_place(at))

    def stated(self, kind: Literal["goal", "fact"]) -> list[int]:
        """The requirements that state tokens as goals or as facts."""
        statements = ((n, self.all[n]) for n in self.numbers)
        return [n for n, s in statements if isinstance(s, Goal) and s.kind == kind]


def _asks(statement: Statement) -> bool:
    """Whether a statement asks for something, beyond saying that something exists."""
    if isinstance(statement, Declaration):
        return any(v.value is not None and not isinstance(v.value, New) for v in statement.variables)
    if isinstance(statement, Assignment):
        return not isinstance(statement.value, New)
    return not (isinstance(statement, Method) and statement.method in _SILENT)


def _without_values(node: Declaration, used: Collection[str]) -> Iterator[Declaration]:
    """The objects of a declaration, and those of its variables that something speaks of, with any value."""
    variables = tuple(
        v if isinstance(v.value, New) else replace(v, value=None)
        for v in node.variables
        if isinstance(v.value, New) or v.name in used
    )
    if variables:
        yield replace(node, variables=variables)


def _names_in_rules(model: ModelManager) -> Iterator[str]:
    """The first names of all paths in the rules of a model."""
    for found in model.classes():
        for rule in (rule for rules in found.rules.values() for rule in rules):
            yield from _first_names(rule.body)
        for predicate in found.predicates.values():
            yield from _first_names(predicate.body)


def _first_names(node: Any) -> Iterator[str]:
    if isinstance(node, Ref):
        yield node.path[0]
    elif isinstance(node, tuple):
        for one in node:
            yield from _first_names(one)
    elif is_dataclass(node) and type(node).__module__ == Ref.__module__:
        for field in fields(node):
            yield from _first_names(getattr(node, field.name))


def _introduces(statement: Statement) -> Iterator[str]:
    """The tokens that a statement gives names to."""
    if isinstance(statement, Goal | Relation):
        yield from (target.name for target in statement.targets if target.path and target.name is not None)


def _names(node: Any) -> Iterator[str]:
    """The first names of all that a statement speaks of."""
    if isinstance(node, Name):
        yield node.path[0]
    elif isinstance(node, TokenReference):
        yield node.path[0] if node.path else node.name or ""
    else:
        if isinstance(node, Method) and node.path:
            yield node.path[0]
        elif isinstance(node, Relation) and node.origin is not None:
            yield node.origin
        elif isinstance(node, ForEach):
            yield from _names(node.over)
        for field in fields(node):
            yield from _names_within(getattr(node, field.name))


def _names_within(value: object) -> Iterator[str]:
    if isinstance(value, Node):
        yield from _names(value)
    elif isinstance(value, tuple) and not isinstance(value, Position):
        for one in value:
            yield from _names_within(one)


def _place(at: Position) -> tuple[int, int]:
    return id(at.source), at.offset


def written(statement: Statement) -> str:
    """A statement as the file writes it, up to its semicolon or the end of its line."""
    text, offset = statement.at.source.text, statement.at.offset
    line_end = text.find("\n", offset)
    line = text[offset:] if line_end < 0 else text[offset:line_end]
    semicolon = _semicolon(line)
    shown = line[: semicolon + 1] if semicolon >= 0 else line
    shown = " ".join(shown.split())
    return shown if len(shown) <= _LONGEST else shown[: _LONGEST - 1] + "…"


def _semicolon(line: str) -> int:
    """Where the statement ends in its line: not in a string, a comment or braces; -1 when further down."""
    quoted = False
    depth = 0
    for place, character in enumerate(line):
        if character == '"' and (place == 0 or line[place - 1] != "\\"):
            quoted = not quoted
        elif not quoted:
            depth += (character == "{") - (character == "}")
            if character == ";" and depth <= 0:
                return place
    return -1


def chosen_statements(requirements: Requirements, numbers: Sequence[int]) -> list[Statement]:
    """The statements of some requirements."""
    return [requirements.all[n] for n in numbers]
