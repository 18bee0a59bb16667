"""Expressions of NDDL: precedence climbing over a Reader.

From loose to tight: `||`, `&&`, `==` and `!=`, order, `+ -`, `* /`, signs. Whether an expression means something is
the builder's question.
"""

from __future__ import annotations

import math

from planner.language.nddl.lexer import unquoted
from planner.language.nddl.reader import Reader
from planner.language.nddl.syntax import Binary, Call, Choice, Expression, Name, New, Number, Range, Text, Truth, Unary

_PRECEDENCE = {
    "||": 1,
    "&&": 2,
    "==": 3,
    "!=": 3,
    "<": 4,
    "<=": 4,
    ">": 4,
    ">=": 4,
    "+": 5,
    "-": 5,
    "*": 6,
    "/": 6,
}
_INFINITIES = {"inf": False, "inff": True}


def expression(reader: Reader, weakest: int = 1) -> Expression:
    """The expression at the cursor whose operators bind at least that tightly."""
    at = reader.at()
    left = _signed(reader)
    while True:
        lexeme = reader.lexeme
        strength = _PRECEDENCE.get(lexeme.text, 0) if lexeme.kind == "mark" else 0
        if strength < weakest or not strength:
            return left
        reader.count_operator()
        reader.advance()
        left = Binary(lexeme.text, left, expression(reader, strength + 1), at=at)


def _signed(reader: Reader) -> Expression:
    lexeme = reader.lexeme
    if lexeme.kind != "mark" or lexeme.text not in ("-", "+", "!"):
        return _primary(reader)
    at = reader.at()
    reader.count_operator()
    reader.advance()
    reader.enter()
    try:
        operand = _signed(reader)
    finally:
        reader.leave()
    if lexeme.text == "+":
        return operand
    if lexeme.text == "-" and isinstance(operand, Number):
        return Number(-operand.value, operand.real, at=at)
    return Unary(lexeme.text, operand, at=at)


def _primary(reader: Reader) -> Expression:
    kind = reader.lexeme.kind
    if kind == "name":
        return _named(reader)
    at = reader.at()
    if kind in ("whole", "real"):
        return _number(reader)
    if kind == "text":
        return Text(unquoted(reader.advance().text), at=at)
    reader.enter()
    try:
        if reader.accept("("):
            inside = expression(reader)
            reader.expect(")")
            return inside
        if reader.sees("["):
            return interval(reader)
        if reader.sees("{"):
            return choice(reader)
    finally:
        reader.leave()
    raise reader.unexpected("a value, a name or '('")


def _number(reader: Reader) -> Number:
    at = reader.at()
    kind, text, _ = reader.advance()
    if kind == "whole":
        digits = text.rstrip("lL")
        if len(digits) > 18:
            return Number(math.inf, at=at)  # beyond every bound that time and quantities know
        return Number(int(digits), at=at)
    return Number(float(text.rstrip("fFdD")), real=True, at=at)


def _named(reader: Reader) -> Expression:
    at = reader.at()
    text = reader.lexeme.text
    if text in _INFINITIES:
        reader.advance()
        return Number(math.inf, _INFINITIES[text], at=at)
    if text in ("true", "false"):
        reader.advance()
        return Truth(text == "true", at=at)
    if text == "new":
        reader.advance()
        cls = reader.name("the name of a class after 'new'")
        return New(cls, arguments(reader), at=at)
    path = reader.path("a name")
    if len(path) == 1 and reader.sees("("):
        return Call(path[0], arguments(reader), at=at)
    return Name(path, at=at)


def arguments(reader: Reader) -> tuple[Expression, ...]:
    """`(a, b)`."""
    reader.enter()
    try:
        reader.expect("(")
        found: list[Expression] = []
        while not reader.accept(")"):
            if found:
                reader.expect(",", " or ')' in this list")
            found.append(expression(reader))
        return tuple(found)
    finally:
        reader.leave()


def interval(reader: Reader) -> Range:
    """`[lower upper]` or `[lower, upper]`."""
    at = reader.at()
    reader.expect("[")
    lower = _bound(reader)
    reader.accept(",")
    if reader.sees("]"):
        raise reader.unexpected("the upper bound: an interval is [lower upper]")
    upper = _bound(reader)
    reader.expect("]", ": an interval is [lower upper]")
    return Range(lower, upper, at=at)


def _bound(reader: Reader) -> Expression:
    """A bound: a signed number or a name. No operators, since a space separates the bounds."""
    at = reader.at()
    if reader.lexeme.kind == "mark" and reader.lexeme.text in ("+", "-"):
        negative = reader.advance().text == "-"
        found = _bound_value(reader)
        if not isinstance(found, Number):
            raise reader.unexpected("a number after the sign")
        return Number(-found.value, found.real, at=at) if negative else found
    return _bound_value(reader)


def _bound_value(reader: Reader) -> Number | Name:
    if reader.lexeme.kind in ("whole", "real"):
        return _number(reader)
    if reader.lexeme.kind == "name":
        found = _named(reader)
        if isinstance(found, Number | Name):
            return found
    raise reader.unexpected("a number as the bound of an interval")


def choice(reader: Reader) -> Choice:
    """`{a, b}` or `{a b}`."""
    at = reader.at()
    reader.expect("{")
    values: list[Expression] = []
    while not reader.accept("}"):
        if values:
            reader.accept(",")
        kind = reader.lexeme.kind
        if kind not in ("name", "whole", "real", "text") and not (reader.sees("-") or reader.sees("+")):
            raise reader.unexpected("a value or '}' in this set")
        values.append(_signed(reader))
    return Choice(tuple(values), at=at)
