"""What the names of a program stand for, before anything is built: classes, predicates, enumerations, global variables.

Collected in one pass over all statements, so that rules may speak of what is declared further down.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from planner.errors import nearest
from planner.language.nddl.errors import NOWHERE, Complaint, Position, Report
from planner.language.nddl.library import LIBRARY_CLASSES, MEMBER_NAMES, hint
from planner.language.nddl.syntax import (
    AttributeDefinition,
    ClassDefinition,
    Constructor,
    Declaration,
    Enumeration,
    Goal,
    PredicateDefinition,
    Statement,
    TokenReference,
    Typedef,
)
from planner.model.manager import ModelManager

BASIC_TYPES = ("int", "float", "bool", "string")
PredicateKey = tuple[str, str]
"""A predicate by its class and its name."""


@dataclass(slots=True)
class PredicateSymbol:
    """A predicate: the types of its parameters, its definition (None: built in) and the attribute that it names."""

    cls: str
    name: str
    parameters: dict[str, str] = field(default_factory=dict)
    definition: PredicateDefinition | None = None
    attribute: str | None = None


@dataclass(slots=True)
class ClassSymbol:
    """A class: the types of its own members, its own predicates and constructors."""

    name: str
    parent: str | None
    at: Position = NOWHERE
    members: dict[str, str] = field(default_factory=dict)
    predicates: dict[str, PredicateSymbol] = field(default_factory=dict)
    constructors: list[Constructor] = field(default_factory=list)
    definition: ClassDefinition | None = None


class Symbols:
    """The symbol table of a program."""

    def __init__(self, report: Report) -> None:
        self.report = report
        self.classes: dict[str, ClassSymbol] = {}
        self.enumerations: dict[str, Enumeration] = {}
        self.enumerations_of: dict[str, list[str]] = {}
        self.aliases: dict[str, str] = {}
        self.variables: dict[str, str] = {}
        self.constants: dict[str, float] = {}
        """Global variables that are declared with a number: rules and bounds may use them as one."""
        self.tokens: dict[str, tuple[str, ...]] = {}
        self.forward: dict[str, Position] = {}
        self.token_predicates: dict[str, PredicateKey] = {}
        # Answers that are asked for at every name; nothing is declared any more by then.
        self._members: dict[str, dict[str, str]] = {}
        self._predicates: dict[str, dict[str, PredicateSymbol]] = {}
        self._parameters: dict[PredicateKey, dict[str, str]] = {}

    def add_built_in(self, model: ModelManager) -> None:
        """The classes that every model has."""
        for found in model.classes():
            symbol = ClassSymbol(found.name, found.parent)
            symbol.members.update((m, t if isinstance(t, str) else "float") for m, t in found.members.items())
            for predicate in found.predicates.values():
                types = {p.name: p.type if isinstance(p.type, str) else "float" for p in predicate.parameters}
                symbol.predicates[predicate.name] = PredicateSymbol(found.name, predicate.name, types)
            self.classes[found.name] = symbol
        for name, members in LIBRARY_CLASSES.items():
            self.classes[name] = ClassSymbol(name, "Object", members=dict(members))

    def collect(self, statements: Sequence[Statement]) -> None:
        """Enter all that is declared; complaints about names that are taken."""
        for statement in statements:
            try:
                if isinstance(statement, ClassDefinition):
                    self._class(statement)
                elif isinstance(statement, Enumeration):
                    self._enumeration(statement)
                elif isinstance(statement, Typedef):
                    self._check_free(statement.name, statement.at)
                    self.aliases[statement.name] = statement.type
                elif isinstance(statement, Declaration):
                    for variable in statement.variables:
                        self._variable(variable.name, statement.type, variable.at)
                elif isinstance(statement, Goal):
                    for target in statement.targets:
                        self._token(target)
            except Complaint as complaint:
                self.report.complain(complaint)
        self._check_forward()

    def _class(self, statement: ClassDefinition) -> None:
        if statement.members is None:
            self.forward.setdefault(statement.name, statement.at)
            return
        known = self.classes.get(statement.name)
        if known is not None and known.definition is None:
            raise Complaint(statement.at, f"class {statement.name!r} is part of the language already")
        self._check_free(statement.name, statement.at)
        symbol = ClassSymbol(statement.name, statement.parent or "Object", statement.at, definition=statement)
        self.classes[statement.name] = symbol
        for member in statement.members:
            if isinstance(member, Constructor):
                symbol.constructors.append(member)
            elif isinstance(member, PredicateDefinition):
                self._predicate(symbol, member)
            elif isinstance(member, AttributeDefinition):
                for predicate in member.predicates:
                    self._predicate(symbol, predicate, member.name)
            else:
                for variable in member.variables:
                    if variable.name in symbol.members:
                        self._complain(variable.at, f"class {symbol.name}: member {variable.name!r} is declared twice")
                    symbol.members[variable.name] = member.type

    def _predicate(self, symbol: ClassSymbol, member: PredicateDefinition, attribute: str | None = None) -> None:
        if member.name in symbol.predicates:
            self._complain(member.at, f"class {symbol.name}: predicate {member.name!r} is declared twice")
            return
        found = PredicateSymbol(symbol.name, member.name, definition=member, attribute=attribute)
        for statement in member.body:
            if isinstance(statement, Declaration):
                found.parameters.update((variable.name, statement.type) for variable in statement.variables)
        symbol.predicates[member.name] = found

    def _enumeration(self, statement: Enumeration) -> None:
        self._check_free(statement.name, statement.at)
        self.enumerations[statement.name] = statement
        for value in statement.values:
            self.enumerations_of.setdefault(value, []).append(statement.name)

    def _variable(self, name: str, type_: str, at: Position) -> None:
        if name in self.variables or name in self.tokens:
            raise Complaint(at, f"the name {name!r} is already taken by another variable or token")
        self.variables[name] = type_

    def _token(self, target: TokenReference) -> None:
        if target.name is None:
            return
        if target.name in self.variables or target.name in self.tokens:
            raise Complaint(target.at, f"the name {target.name!r} is already taken by another variable or token")
        self.tokens[target.name] = target.path

    def _check_free(self, name: str, at: Position) -> None:
        if name in self.classes or name in self.enumerations or name in self.aliases or name in BASIC_TYPES:
            raise Complaint(at, f"the name {name!r} is already taken by another type")

    def _check_forward(self) -> None:
        for name, at in self.forward.items():
            if name not in self.classes:
                instead = hint(name, self.classes)
                self._complain(at, f"class {name!r} is announced here, but it is declared nowhere{instead}")
        for symbol in self.classes.values():
            if symbol.parent is not None and symbol.parent not in self.classes:
                instead = hint(symbol.parent, self.classes)
                self._complain(symbol.at, f"class {symbol.name}: there is no class named {symbol.parent!r}{instead}")
                symbol.parent = "Object"
        for symbol in self.classes.values():
            if self._is_cyclic(symbol):
                self._complain(symbol.at, f"class {symbol.name} inherits from itself")
                symbol.parent = "Object"

    def _is_cyclic(self, symbol: ClassSymbol) -> bool:
        seen: set[str] = set()
        name: str | None = symbol.name
        while name is not None:
            if name in seen:
                return True
            seen.add(name)
            name = self.classes[name].parent
        return False

    def _complain(self, at: Position, message: str) -> None:
        self.report.complain(Complaint(at, message))

    # Questions

    def lineage(self, cls: str) -> Iterator[ClassSymbol]:
        """The class, its parent, and so on up."""
        name: str | None = cls
        while name is not None and name in self.classes:
            yield self.classes[name]
            name = self.classes[name].parent

    def is_subclass(self, cls: str, ancestor: str) -> bool:
        """Whether the class is the ancestor or below it."""
        return any(symbol.name == ancestor for symbol in self.lineage(cls))

    def members_of(self, cls: str) -> dict[str, str]:
        """The types of all members, inherited ones included."""
        if cls not in self._members:
            found: dict[str, str] = {}
            for symbol in self.lineage(cls):
                found = symbol.members | found
            self._members[cls] = found
        return self._members[cls]

    def predicates_of(self, cls: str) -> dict[str, PredicateSymbol]:
        """All predicates, inherited ones included."""
        if cls not in self._predicates:
            found: dict[str, PredicateSymbol] = {}
            for symbol in self.lineage(cls):
                found = symbol.predicates | found
            self._predicates[cls] = found
        return self._predicates[cls]

    def parameters_of(self, cls: str, predicate: str) -> dict[str, str]:
        """The types of a predicate's parameters; a predicate declared again in a subclass adds to them."""
        key = (cls, predicate)
        if key not in self._parameters:
            found: dict[str, str] = {}
            for symbol in self.lineage(cls):
                if predicate in symbol.predicates:
                    found = symbol.predicates[predicate].parameters | found
            self._parameters[key] = found
        return self._parameters[key]

    def predicate(self, cls: str, name: str, at: Position) -> PredicateKey:
        """The predicate of a class; a complaint when it has none of that name."""
        known = self.predicates_of(cls)
        if name not in known:
            raise Complaint(at, f"class {cls} has no predicate named {name!r}{nearest(name, known)}")
        return cls, name

    def member(self, cls: str, name: str) -> tuple[str, str] | None:
        """The name that the model has for a member, and its type; None when the class has none of that name."""
        known = self.members_of(cls)
        if name not in known:
            name = MEMBER_NAMES.get(name, name)
        return (name, known[name]) if name in known else None

    def member_named(self, cls: str, name: str, at: Position) -> tuple[str, str]:
        """The same; a complaint when the class has none of that name."""
        found = self.member(cls, name)
        if found is None:
            known = self.members_of(cls)
            raise Complaint(at, f"class {cls} has no member named {name!r}{nearest(name, known)}")
        return found

    def class_of(self, type_: str) -> str | None:
        """The class that a type names, itself or as the base of a typedef; None for any other type."""
        while type_ in self.aliases:
            type_ = self.aliases[type_]
        return type_ if type_ in self.classes else None

    def base(self, type_: str) -> str:
        """The type that a typedef is made of, in the end."""
        for _ in self.aliases:
            if type_ not in self.aliases:
                break
            type_ = self.aliases[type_]
        return type_

    def check_type(self, type_: str, at: Position) -> str:
        """The type itself; a complaint when there is none of that name."""
        known = (*BASIC_TYPES, *self.enumerations, *self.aliases, *self.classes)
        if type_ not in known:
            raise Complaint(at, f"there is no type named {type_!r}{hint(type_, known)}")
        return type_
