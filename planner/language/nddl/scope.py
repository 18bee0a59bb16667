"""What a name means in a rule, a predicate or a problem statement, and of which type it is.

Names are looked up from the inside out: local variables and tokens, the variables of the token, members of the class,
global variables, objects and tokens, values of enumerations.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from planner.errors import nearest
from planner.language.nddl.errors import Complaint, Position
from planner.language.nddl.library import hint
from planner.language.nddl.symbols import PredicateKey, Symbols
from planner.model.rules import Ref

TIMES = ("start", "end", "duration")


@dataclass(frozen=True, slots=True)
class VariableMeaning:
    """A variable of a type. `token`: the predicate of the token whose time it is."""

    ref: Ref
    type: str
    is_timepoint: bool = False


@dataclass(frozen=True, slots=True)
class TokenMeaning:
    """A token of a predicate."""

    ref: Ref
    predicate: PredicateKey


@dataclass(frozen=True, slots=True)
class ValueMeaning:
    """A value of an enumeration, or a number that the program gives a name."""

    value: object
    enumeration: str | None


@dataclass(frozen=True, slots=True)
class StateMeaning:
    """The state of a token."""

    token: TokenMeaning


Meaning = VariableMeaning | TokenMeaning | ValueMeaning | StateMeaning


class Scope:
    """Names in a body, inside another scope or at the top. `own`: the predicate of the token that the body is about."""

    def __init__(self, symbols: Symbols, own: PredicateKey | None = None, outer: Scope | None = None) -> None:
        self.symbols = symbols
        self.own: PredicateKey | None = own if outer is None else outer.own
        self.outer = outer
        self.names: dict[str, str | PredicateKey] = {}

    def inner(self) -> Scope:
        """A scope inside this one."""
        return Scope(self.symbols, outer=self)

    def add(self, name: str, meaning: str | PredicateKey) -> None:
        """Declare a local variable by its type, or a token by its predicate."""
        self.names[name] = meaning

    def local(self, name: str) -> str | PredicateKey | None:
        """What a name was declared as here or further out."""
        scope: Scope | None = self
        while scope is not None:
            if name in scope.names:
                return scope.names[name]
            scope = scope.outer
        return None

    def meaning(self, path: tuple[str, ...], at: Position) -> Meaning:
        """What a path means; a complaint with the nearest names when it means nothing."""
        found = self.first(path[0], at)
        if found is None:
            found = self._value(path)
            if found is not None:
                return found
            raise Complaint(at, f"{path[0]!r} means nothing here{hint(path[0], self.visible())}")
        for name in path[1:]:
            found = self._part(found, name, at)
        return found

    def first(self, name: str, at: Position) -> Meaning | None:
        """What the first name of a path means; None when it may only be a class or a value."""
        declared = self.local(name)
        if declared is not None:
            return _declared(Ref((name,)), declared)
        if self.own is not None:
            cls, _ = self.own
            if name == "this":
                return TokenMeaning(Ref(("this",)), self.own)
            own = self._of_token(TokenMeaning(Ref(()), self.own), name)
            if own is not None:
                return own
            member = self.symbols.member(cls, name)
            if member is not None:
                return VariableMeaning(Ref(("object", member[0])), member[1])
        if self.own is not None and name in self.symbols.constants:
            return ValueMeaning(self.symbols.constants[name], None)
        if name in self.symbols.variables:
            return VariableMeaning(Ref((name,)), self.symbols.variables[name])
        if name in self.symbols.tokens:
            known = self.symbols.token_predicates
            if name not in known:
                known[name] = Scope(self.symbols).predicate_of(self.symbols.tokens[name], at)[0]
            return TokenMeaning(Ref((name,)), known[name])
        return None

    def predicate_of(self, path: tuple[str, ...], at: Position) -> tuple[PredicateKey, Ref | None]:
        """The predicate that a path names, and the object that must have it (None: any of the class).

        A bare name is a predicate of the same object.
        """
        symbols = self.symbols
        *owner, name = path
        if not owner:
            if self.own is None:
                raise Complaint(at, f"expected a predicate as object.{name} or Class.{name}, found {name!r}")
            return symbols.predicate(self.own[0], name, at), Ref(("object",))
        found = None if owner[0] in symbols.tokens and self.own is None else self.first(owner[0], at)
        if found is None and len(owner) == 1 and owner[0] in symbols.classes:
            return symbols.predicate(owner[0], name, at), None
        if found is None:
            known = [*self.visible(), *symbols.classes]
            raise Complaint(at, f"there is no class or object named {owner[0]!r}{hint(owner[0], known)}")
        for part in owner[1:]:
            found = self._part(found, part, at)
        cls = symbols.class_of(found.type) if isinstance(found, VariableMeaning) else None
        if cls is None:
            raise Complaint(at, f"{'.'.join(owner)!r} is not an object, so it has no predicate {name!r}")
        assert isinstance(found, VariableMeaning)
        return symbols.predicate(cls, name, at), found.ref

    def visible(self) -> Iterator[str]:
        """All names that mean something here."""
        scope: Scope | None = self
        while scope is not None:
            yield from scope.names
            scope = scope.outer
        if self.own is not None:
            yield from self.symbols.parameters_of(*self.own)
            yield from (*TIMES, "object", "this")
            yield from self.symbols.members_of(self.own[0])
        yield from self.symbols.variables
        yield from self.symbols.tokens
        yield from self.symbols.enumerations_of

    def _value(self, path: tuple[str, ...]) -> ValueMeaning | None:
        enumerations = self.symbols.enumerations_of
        if len(path) == 1 and path[0] in enumerations:
            of = enumerations[path[0]]
            return ValueMeaning(path[0], of[0] if len(of) == 1 else None)
        if len(path) == 2 and path[0] in enumerations.get(path[1], ()):
            return ValueMeaning(path[1], path[0])
        return None

    def _part(self, whole: Meaning, name: str, at: Position) -> Meaning:
        if isinstance(whole, TokenMeaning):
            found = self._of_token(whole, name)
            if found is not None:
                return found
            cls, predicate = whole.predicate
            member = self.symbols.member(cls, name)
            if member is not None:
                return VariableMeaning(Ref((*whole.ref.path, member[0])), member[1])
            known = [*self.symbols.parameters_of(cls, predicate), *TIMES, "object", "state"]
            known += self.symbols.members_of(cls)
            raise Complaint(at, f"a token of {cls}.{predicate} has no variable {name!r}{nearest(name, known)}")
        if not isinstance(whole, VariableMeaning):
            raise Complaint(at, f"{name!r} cannot be a part of a value")
        cls_or_none = self.symbols.class_of(whole.type)
        if cls_or_none is None:
            raise Complaint(at, f"{whole.ref!r} is of type {whole.type}, so it has no member {name!r}")
        own_name, type_ = self.symbols.member_named(cls_or_none, name, at)
        return VariableMeaning(Ref((*whole.ref.path, own_name)), type_)

    def _of_token(self, token: TokenMeaning, name: str) -> Meaning | None:
        """The variable of a token by its name; None when it has none."""
        ref = Ref((*token.ref.path, name))
        parameters = self.symbols.parameters_of(*token.predicate)
        if name in parameters:
            return VariableMeaning(ref, parameters[name])
        if name in TIMES:
            return VariableMeaning(ref, "int", name != "duration")
        if name == "time" and self.symbols.is_subclass(token.predicate[0], "Reservoir"):
            return VariableMeaning(Ref((*token.ref.path, "start")), "int", True)
        if name == "object":
            return VariableMeaning(ref, token.predicate[0])
        return StateMeaning(token) if name == "state" else None


def _declared(ref: Ref, meaning: str | PredicateKey) -> Meaning:
    return VariableMeaning(ref, meaning) if isinstance(meaning, str) else TokenMeaning(ref, meaning)
