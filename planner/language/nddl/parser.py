"""Statements of NDDL: recursive descent over a Reader, one function a construct.

A statement that cannot be read is complained about and skipped, so that one run says all that is wrong with a file.
Words have a meaning only where they stand: `contains` is a relation before `(`, and a name elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, cast

from planner.errors import nearest
from planner.language.nddl.definitions import class_definition, enumeration, signature, typedef
from planner.language.nddl.errors import Complaint, Position, Report, Source
from planner.language.nddl.expressions import arguments, expression, interval
from planner.language.nddl.keeping import keep
from planner.language.nddl.lexer import END, unquoted
from planner.language.nddl.reader import Reader
from planner.language.nddl.syntax import (
    Allocation,
    Assignment,
    Bounds,
    Call,
    Constraint,
    Contingent,
    Declaration,
    Declarator,
    Either,
    ForEach,
    Goal,
    If,
    Include,
    Method,
    Name,
    New,
    Relation,
    Requirement,
    RuleDefinition,
    Statement,
    Super,
    TokenReference,
)
from planner.model.relations import RELATIONS

OBSOLETE = {
    "subgoal": "'subgoal(...)' is of NDDL 1: write the temporal relation itself, or any(...) for none",
    "token": "'token' declarations are of NDDL 1: write goal(...), rejectable(...) or fact(...)",
    "numeric": "the type 'numeric' is of NDDL 1: write int or float",
    "association": "'association' is not part of the language",
    "private": "NDDL has no access control: leave 'private' out",
    "public": "NDDL has no access control: leave 'public' out",
    "void": "NDDL has no functions: leave 'void' out",
    "while": "NDDL has no 'while' loop: foreach (x in variable) is the only loop",
    "for": "NDDL has no 'for' loop: write foreach (x in variable)",
    "switch": "NDDL has no 'switch': write one if for each value",
    "return": "NDDL has no functions: there is nothing to return from",
}
OBSOLETE_FILTER = "filters of a variable, ': {...}', are of NDDL 1: write what they say as statements of their own"
METHODS: tuple[str, ...] = (
    *("specify", "reset", "restrict", "close"),
    *("activate", "merge", "reject", "cancel"),
    *("constrain", "free", "set_capacity", "set_limit", "setLimit"),
)


def parse(source: Source, report: Report, texts: set[str] | None = None) -> tuple[Statement, ...]:
    """The statements of a text; what is wrong goes to the report. `texts`: where to enter its strings."""
    reader = Reader(source, report)
    found: list[Statement] = []
    while reader.lexeme.kind != END:
        if reader.sees("}"):
            report.complain(Complaint(reader.at(), "'}' closes nothing"))
            reader.advance()
            continue
        one = _recovered(reader, _top_level)
        if one is not None:
            found.append(one)
    if texts is not None:
        texts.update(unquoted(token.text) for token in reader.tokens if token.kind == "text")
    return tuple(found)


def _recovered(reader: Reader, read: Callable[[Reader], Statement | None]) -> Statement | None:
    started, depth = reader.index, reader.depth
    reader.operators = 0
    try:
        return read(reader)
    except Complaint as complaint:
        reader.report.complain(complaint)
        reader.depth = depth
        reader.skip_statement(started)
        return None


def _top_level(reader: Reader) -> Statement | None:
    if reader.lexeme.kind == "include":
        at = reader.at()
        reader.advance()
        if reader.lexeme.kind != "text":
            raise reader.unexpected("a file name in quotes after '#include', as in #include \"Plasma.nddl\"")
        found = Include(unquoted(reader.advance().text), at=at)
        reader.accept(";")
        return found
    if reader.lexeme.kind == "name":
        read = _TOP_LEVEL.get(reader.lexeme.text)
        if read is not None:
            return read(reader)
        if reader.ahead().text == "::":
            return _rule(reader)
    return statement(reader)


def _rule(reader: Reader) -> RuleDefinition:
    at = reader.at()
    cls = reader.name("the name of a class")
    reader.expect("::")
    predicate = reader.name("the name of a predicate after '::'")
    return RuleDefinition(cls, predicate, block(reader), at=at)


def block(reader: Reader) -> tuple[Statement, ...]:
    """`{ statements }`, or one statement."""
    reader.enter()
    try:
        if not reader.sees("{"):
            one = statement(reader)
            return () if one is None else (one,)
        opened = reader.at()
        reader.advance()
        found: list[Statement] = []
        while not reader.accept("}"):
            if reader.lexeme.kind == END:
                raise Complaint(opened, "this '{' is never closed: expected '}', found the end of the file")
            one = _recovered(reader, statement)
            if one is not None:
                found.append(one)
        return tuple(found)
    finally:
        reader.leave()


def statement(reader: Reader) -> Statement | None:
    """One statement of a rule, a predicate, a constructor or of the problem; None for a lone `;`."""
    if reader.accept(";"):
        return None
    if reader.lexeme.kind != "name":
        return _requirement(reader)
    word, following = reader.lexeme.text, reader.ahead()
    if word == "either" and following.text == "{":
        return _either(reader)
    if word == "only" and following.text in RELATIONS:
        return keep(reader)
    read = _STATEMENTS.get(word)
    if read is not None and following.text not in (".", "=", "=="):
        return read(reader)
    if word in RELATIONS and following.text in ("(", "["):
        return _relation(reader, None)
    if word == "new":
        return _requirement(reader)
    if following.text == "(" and word not in OBSOLETE and _subgoal_follows(reader, 2):
        hint = nearest(word, RELATIONS)
        raise Complaint(reader.at(), f"there is no temporal relation named {word!r}{hint}")
    if following.kind == "name" and following.text != "in":
        return _two_names(reader)
    if word in OBSOLETE:
        raise Complaint(reader.at(), OBSOLETE[word], unsupported=True)
    return _path_statement(reader)


def _two_names(reader: Reader) -> Statement:
    """`t1 before t2;`, or the declaration `Type name ...;`."""
    word, after = reader.ahead().text, reader.ahead(2)
    if word in RELATIONS and (after.kind == "name" or after.text in ("(", "[")):
        return _relation(reader, reader.advance().text)
    if reader.lexeme.text in OBSOLETE:
        raise Complaint(reader.at(), OBSOLETE[reader.lexeme.text], unsupported=True)
    hint = nearest(word, RELATIONS)
    if hint and (after.kind == "name" or (after.text == "(" and _subgoal_follows(reader, 3))):
        reader.advance()
        raise Complaint(reader.at(), f"expected a temporal relation between two tokens, found {word!r}{hint}")
    return declaration(reader)


def _subgoal_follows(reader: Reader, index: int) -> bool:
    """Whether `c.d e` stands that many tokens on: a predicate and a token's name, which only a relation has."""
    while reader.ahead(index).kind == "name" and reader.ahead(index + 1).text == ".":
        index += 2
    if reader.ahead(index).text == "new":
        return False
    return reader.ahead(index).kind == reader.ahead(index + 1).kind == "name"


def _path_statement(reader: Reader) -> Statement:
    """A statement that begins with a path: a method, an assignment, a constraint by name, or an expression."""
    at, started = reader.at(), reader.index
    path = reader.path("a statement")
    if reader.sees("("):
        if path[-1] in METHODS:
            found = Method(path[:-1], path[-1], arguments(reader), at=at)
            reader.expect(";")
            return found
        if len(path) > 1:
            hint = nearest(path[-1], METHODS)
            raise Complaint(at, f"there is no method named {path[-1]!r}{hint}")
    elif reader.sees("=") or reader.sees("in"):
        reader.advance()
        value = expression(reader)
        reader.expect(";")
        return Assignment(Name(path, at=at), value, at=at)
    reader.index = started
    reader.lexeme = reader.tokens[started]
    return _requirement(reader)


def _requirement(reader: Reader) -> Statement:
    at = reader.at()
    enforced = reader.sees("enforce")
    if enforced:
        reader.advance()
    found = expression(reader)
    message = None
    if reader.accept(":"):
        if reader.lexeme.kind != "text":
            raise reader.unexpected("a message in quotes after ':'")
        message = unquoted(reader.advance().text)
    reader.expect(";")
    if isinstance(found, Call) and not enforced:
        return Constraint(found, message, at=at)
    if isinstance(found, New) and not enforced:
        return Allocation(found, at=at)
    return Requirement(found, message, at=at)


def declaration(reader: Reader) -> Declaration:
    """`[filter] Type a = 1, b(2), c;`."""
    at = reader.at()
    filter_only = reader.sees("filter") or reader.sees("filterOnly")
    if filter_only:
        reader.advance()
    type_ = reader.name("the type of a variable")
    found: list[Declarator] = []
    while True:
        place = reader.at()
        name = reader.name("the name of a variable")
        if reader.accept("="):
            found.append(Declarator(name, expression(reader), at=place))
        elif reader.accept("("):
            found.append(Declarator(name, expression(reader), at=place))
            reader.expect(")")
        elif reader.sees(":") and reader.ahead().text == "{":
            raise Complaint(reader.at(), OBSOLETE_FILTER, unsupported=True)
        else:
            found.append(Declarator(name, at=place))
        if not reader.accept(","):
            break
    reader.expect(";", f" after the variable '{found[-1].name}'")
    return Declaration(type_, tuple(found), filter_only, at=at)


def _relation(reader: Reader, origin: str | None) -> Relation:
    at = reader.at() if origin is None else Position(reader.source, reader.tokens[reader.index - 1].offset)
    name = reader.advance().text
    bounds: list[Bounds] = []
    while reader.sees("["):
        one = interval(reader)
        bounds.append(Bounds(one.lower, one.upper, at=one.at))
        if reader.sees(",") and reader.ahead().text == "[":
            reader.advance()
    targets = token_references(reader)
    reader.expect(";")
    return Relation(None if origin == "this" else origin, name, tuple(bounds), targets, at=at)


def token_references(reader: Reader) -> tuple[TokenReference, ...]:
    """`(object.path.predicate name, ...)`, or the name of a token."""
    at = reader.at()
    if not reader.sees("("):
        return (TokenReference((), reader.name("a token or '('"), at=at),)
    reader.advance()
    found: list[TokenReference] = []
    while not reader.accept(")"):
        if found:
            reader.expect(",", " or ')' after a token")
        found.append(_token_reference(reader))
    return tuple(found)


def _token_reference(reader: Reader) -> TokenReference:
    at = reader.at()
    role: Literal["condition", "effect"] | None = None
    if reader.lexeme.text in ("condition", "effect") and reader.ahead().kind == "name":
        role = cast("Literal['condition', 'effect']", reader.advance().text)
    path = reader.path("a predicate, as in object.predicate")
    name = reader.advance().text if reader.lexeme.kind == "name" else None
    if name is None and len(path) == 1 and role is None:
        # A token by its name, or a predicate of the same class: which of the two, the names in scope tell.
        return TokenReference(path, at=at)
    return TokenReference(path, name, role, at=at)


def _goal(reader: Reader) -> Goal:
    at = reader.at()
    kind = cast("Literal['goal', 'rejectable', 'fact']", reader.advance().text)
    targets = token_references(reader)
    reader.expect(";")
    return Goal(kind, targets, at=at)


def _if(reader: Reader) -> If:
    at = reader.at()
    reader.advance()
    reader.expect("(")
    test = expression(reader)
    reader.expect(")")
    then = block(reader)
    otherwise = block(reader) if reader.accept("else") else ()
    return If(test, then, otherwise, at=at)


def _either(reader: Reader) -> Either:
    at = reader.at()
    reader.advance()
    branches = [block(reader)]
    while reader.sees("or") and reader.ahead().text == "{":
        reader.advance()
        branches.append(block(reader))
    if len(branches) == 1:
        raise reader.unexpected("'or {': an 'either' has two branches or more")
    return Either(tuple(branches), at=at)


def _foreach(reader: Reader) -> ForEach:
    at = reader.at()
    reader.advance()
    reader.expect("(")
    name = reader.name("the name of the loop's variable")
    reader.expect("in")
    place = reader.at()
    over = Name(reader.path("an object variable"), at=place)
    reader.expect(")")
    return ForEach(name, over, block(reader), at=at)


def _super(reader: Reader) -> Super:
    at = reader.at()
    reader.advance()
    found = Super(arguments(reader), at=at)
    reader.expect(";")
    return found


def _contingent(reader: Reader) -> Contingent:
    at = reader.at()
    reader.advance()
    reader.expect("duration", ": only a duration can be contingent")
    reader.expect("=")
    if not reader.sees("["):
        raise reader.unexpected("the bounds of the contingent duration, as in [5 9]")
    found = Contingent(interval(reader), at=at)
    reader.expect(";")
    return found


def _misplaced(reader: Reader) -> Statement:
    raise Complaint(reader.at(), _MISPLACED[reader.lexeme.text])


_MISPLACED = {
    "else": "'else' belongs to no 'if'",
    "predicate": "a predicate is declared inside a class",
    "action": "an action is declared inside a class",
    "class": "a class is declared at the top level of a file, not inside a block",
    "enum": "an enumeration is declared at the top level of a file, not inside a block",
    "typedef": "a type is declared at the top level of a file, not inside a block",
}
_TOP_LEVEL: dict[str, Callable[[Reader], Statement]] = {
    "class": lambda reader: class_definition(reader, block, declaration, _recover_member),
    "enum": enumeration,
    "typedef": typedef,
    "constraint": signature,
}
_STATEMENTS: dict[str, Callable[[Reader], Statement]] = {
    "goal": _goal,
    "rejectable": _goal,
    "fact": _goal,
    "if": _if,
    "foreach": _foreach,
    "super": _super,
    "contingent": _contingent,
    "enforce": _requirement,
    "filter": declaration,
    "filterOnly": declaration,
    **dict.fromkeys(_MISPLACED, _misplaced),
}


def _recover_member(reader: Reader, complaint: Complaint, started: int, depth: int) -> None:
    reader.report.complain(complaint)
    reader.depth = depth
    reader.skip_statement(started)
