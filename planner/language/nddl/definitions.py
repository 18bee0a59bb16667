"""Definitions of NDDL: classes with members, constructors and predicates, enumerations, types."""

from __future__ import annotations

from collections.abc import Callable

from planner.language.nddl.errors import Complaint
from planner.language.nddl.expressions import choice, interval
from planner.language.nddl.lexer import END
from planner.language.nddl.reader import Reader
from planner.language.nddl.syntax import (
    AttributeDefinition,
    ClassDefinition,
    Constructor,
    Declaration,
    Enumeration,
    PredicateDefinition,
    Signature,
    Statement,
    Typedef,
)

Block = Callable[[Reader], tuple[Statement, ...]]
Declare = Callable[[Reader], Declaration]
Recover = Callable[[Reader, Complaint, int, int], None]
Member = Declaration | Constructor | PredicateDefinition | AttributeDefinition


def class_definition(reader: Reader, block: Block, declare: Declare, recover: Recover) -> ClassDefinition:
    """`class C extends P {...}` or `class C;`."""
    at = reader.at()
    reader.advance()
    name = reader.name("the name of a class")
    if reader.accept(";"):
        return ClassDefinition(name, None, None, at=at)
    parent = reader.name("the name of the parent class") if reader.accept("extends") else None
    opened = reader.at()
    reader.expect("{", f", 'extends' or ';' after 'class {name}'" if parent is None else "")
    members: list[Member] = []
    while not reader.accept("}"):
        if reader.lexeme.kind == END:
            raise Complaint(
                opened, f"the '{{' of class {name} is never closed: expected '}}', found the end of the file"
            )
        if reader.accept(";"):
            continue
        started, depth = reader.index, reader.depth
        reader.operators = 0
        try:
            members.append(_member(reader, name, block, declare))
        except Complaint as complaint:
            recover(reader, complaint, started, depth)
    reader.accept(";")
    return ClassDefinition(name, parent, tuple(members), at=at)


def _member(reader: Reader, cls: str, block: Block, declare: Declare) -> Member:
    at = reader.at()
    if _predicate_follows(reader):
        return _predicate(reader, block)
    if reader.sees("attribute") and reader.ahead().kind == "name" and reader.ahead(2).text == "{":
        return _attribute(reader, block)
    if reader.lexeme.kind == "name" and reader.ahead().text == "(":
        return _constructor(reader, cls, block)
    if reader.lexeme.kind != "name":
        raise reader.unexpected("a member, a constructor or a predicate")
    if reader.ahead().text == "::":
        raise Complaint(at, "a rule is stated outside of the class")
    return declare(reader)


def _predicate_follows(reader: Reader) -> bool:
    if reader.sees("exogenous"):
        return reader.ahead().text == "predicate"
    return reader.sees("predicate") or reader.sees("action")


def _predicate(reader: Reader, block: Block) -> PredicateDefinition:
    at = reader.at()
    exogenous = reader.accept("exogenous")
    action = reader.advance().text == "action"
    name = reader.name("the name of a predicate")
    if not reader.sees("{"):
        raise reader.unexpected(f"'{{' after the predicate '{name}'")
    return PredicateDefinition(name, block(reader), action, exogenous, at=at)


def _attribute(reader: Reader, block: Block) -> AttributeDefinition:
    at = reader.at()
    reader.advance()
    name = reader.name("the name of an attribute")
    reader.expect("{")
    found: list[PredicateDefinition] = []
    while not reader.accept("}"):
        if not _predicate_follows(reader):
            raise reader.unexpected(f"a predicate or '}}' in the attribute '{name}'")
        found.append(_predicate(reader, block))
    return AttributeDefinition(name, tuple(found), at=at)


def _constructor(reader: Reader, cls: str, block: Block) -> Constructor:
    at = reader.at()
    name = reader.advance().text
    if name != cls:
        raise Complaint(at, f"expected a constructor of class {cls}, found {name!r}")
    reader.expect("(")
    parameters: list[tuple[str, str]] = []
    while not reader.accept(")"):
        if parameters:
            reader.expect(",", " or ')' after a parameter")
        type_ = reader.name("the type of a parameter")
        parameters.append((type_, reader.name("the name of a parameter")))
    if not reader.sees("{"):
        raise reader.unexpected(f"'{{' after the parameters of the constructor of {cls}")
    return Constructor(name, tuple(parameters), block(reader), at=at)


def enumeration(reader: Reader) -> Enumeration:
    """`enum E {a, b}`."""
    at = reader.at()
    reader.advance()
    name = reader.name("the name of an enumeration")
    reader.expect("{")
    values = [reader.name("a value of the enumeration")]
    while not reader.accept("}"):
        reader.expect(",", " or '}' after a value of the enumeration")
        if reader.sees("}"):
            continue
        values.append(reader.name("a value of the enumeration"))
    reader.accept(";")
    return Enumeration(name, tuple(values), at=at)


def typedef(reader: Reader) -> Typedef:
    """`typedef int [0 9] Digit;`."""
    at = reader.at()
    reader.advance()
    type_ = reader.name("a type")
    if reader.sees("["):
        found = Typedef(type_, interval(reader), reader.name("the name of the type"), at=at)
    elif reader.sees("{"):
        found = Typedef(type_, choice(reader), reader.name("the name of the type"), at=at)
    else:
        raise reader.unexpected(f"'[' or '{{': the values of the type, as in typedef {type_} [0 9] Name;")
    reader.expect(";")
    return found


def signature(reader: Reader) -> Signature:
    """`constraint name(types) ...`: kept as words, up to the `;` or the block's end."""
    at = reader.at()
    words: list[str] = []
    depth = 0
    while reader.lexeme.kind != END:
        text = reader.advance().text
        words.append(text)
        depth += (text == "{") - (text == "}")
        if depth <= 0 and text in (";", "}"):
            return Signature(tuple(words), at=at)
    raise Complaint(at, "this signature of a constraint is not closed: expected ';' or '}'")
