"""From the syntax tree back to NDDL: parsing the result gives the same tree."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from planner.language.nddl.lexer import quoted
from planner.language.nddl.syntax import (
    Allocation,
    AllowedValue,
    Assignment,
    AttributeDefinition,
    Binary,
    Bounds,
    Call,
    Choice,
    ClassDefinition,
    Constraint,
    Constructor,
    Contingent,
    Declaration,
    Declarator,
    Either,
    Enumeration,
    Expression,
    ForEach,
    Goal,
    If,
    Include,
    Keep,
    Method,
    Name,
    New,
    Number,
    PredicateDefinition,
    Range,
    Relation,
    Requirement,
    RuleDefinition,
    Signature,
    Statement,
    Super,
    Text,
    TokenReference,
    Truth,
    Typedef,
    Unary,
)

INDENT = "  "


def render(statements: Sequence[Statement]) -> str:
    """The text of a file with these statements."""
    return "".join(line + "\n" for statement in statements for line in _lines(statement))


def render_expression(expression: Expression) -> str:
    """The text of an expression, every operation in parentheses of its own."""
    return _EXPRESSIONS[type(expression)](expression)


def render_statement(statement: Statement) -> str:
    """The text of one statement on one line, for messages."""
    return " ".join(line.strip() for line in _lines(statement))


def _lines(statement: Any) -> Iterator[str]:
    return _STATEMENTS[type(statement)](statement)


# Expressions


def _number(node: Number) -> str:
    if math.isinf(node.value):
        return ("" if node.value > 0 else "-") + ("inff" if node.real else "inf")
    if not node.real:
        return str(int(node.value))
    text = repr(float(node.value))
    return text if "." in text or "e" in text else text + ".0"


def _call(node: Call) -> str:
    return f"{node.function}({_comma(node.arguments)})"


def _comma(expressions: Iterable[Expression]) -> str:
    return ", ".join(map(render_expression, expressions))


def _operand(expression: Expression) -> str:
    text = render_expression(expression)
    # A sign next to a sign, or an operation within another, needs parentheses.
    return f"({text})" if isinstance(expression, Binary | Unary) else text


def _range(node: Range | Bounds) -> str:
    return f"[{render_expression(node.lower)} {render_expression(node.upper)}]"


_EXPRESSIONS: dict[type, Callable[[Any], str]] = {
    Number: _number,
    Text: lambda node: quoted(node.value),
    Truth: lambda node: "true" if node.value else "false",
    Name: str,
    Range: _range,
    Choice: lambda node: "{" + _comma(node.values) + "}",
    Call: _call,
    Binary: lambda node: f"{_operand(node.left)} {node.operator} {_operand(node.right)}",
    Unary: lambda node: f"{node.operator}{_parenthesised(node.operand)}",
    New: lambda node: f"new {node.cls}({_comma(node.arguments)})",
}


def _parenthesised(expression: Expression) -> str:
    text = render_expression(expression)
    return text if isinstance(expression, Name | Call) else f"({text})"


# Statements


def _block(head: str, body: Sequence[Any], separator: str = " ") -> Iterator[str]:
    if not body:
        yield f"{head}{separator}{{}}"
        return
    yield f"{head}{separator}{{"
    for statement in body:
        for line in _lines(statement):
            yield INDENT + line
    yield "}"


def _declaration(node: Declaration) -> Iterator[str]:
    prefix = "filter " if node.filter_only else ""
    yield f"{prefix}{node.type} {', '.join(map(_declarator, node.variables))};"


def _declarator(node: Declarator) -> str:
    return node.name if node.value is None else f"{node.name} = {render_expression(node.value)}"


def _message(message: str | None) -> str:
    return "" if message is None else f" : {quoted(message)}"


def _constraint(node: Constraint) -> Iterator[str]:
    yield f"{_call(node.call)}{_message(node.message)};"


def _requirement(node: Requirement) -> Iterator[str]:
    # `enforce` keeps a call apart from a constraint by name, and anything else from a statement that begins alike.
    yield f"enforce {render_expression(node.expression)}{_message(node.message)};"


def _reference(node: TokenReference) -> str:
    words = [node.role or "", ".".join(node.path), node.name or ""]
    return " ".join(word for word in words if word)


def _references(targets: Sequence[TokenReference]) -> str:
    if len(targets) == 1 and not targets[0].path:
        return f" {targets[0].name}"
    return f"({', '.join(map(_reference, targets))})"


def _relation(node: Relation) -> Iterator[str]:
    by_name = len(node.targets) == 1 and not node.targets[0].path
    origin = node.origin or ("this" if by_name else "")
    bounds = "".join(map(_range, node.bounds))
    yield f"{origin} {node.relation}{bounds}{_references(node.targets)};".lstrip()


def _goal(node: Goal) -> Iterator[str]:
    yield f"{node.kind}{_references(node.targets)};"


def _method(node: Method) -> Iterator[str]:
    yield f"{'.'.join((*node.path, node.method))}({_comma(node.arguments)});"


def _if(node: If) -> Iterator[str]:
    yield from _block(f"if ({render_expression(node.test)})", node.then)
    if node.otherwise:
        yield from _block("else", node.otherwise)


def _either(node: Either) -> Iterator[str]:
    for number, branch in enumerate(node.branches):
        yield from _block("or" if number else "either", branch)


def _keep(node: Keep) -> Iterator[str]:
    yield f"only {node.relation}{''.join(map(_range, node.bounds))} {{{', '.join(map(_allowed, node.values))}}};"


def _allowed(node: AllowedValue) -> str:
    limits = ", ".join(f"{name} == {render_expression(limit)}" for name, limit in node.parameters)
    return ".".join(node.path) + (f"({limits})" if limits else "")


def _class(node: ClassDefinition) -> Iterator[str]:
    if node.members is None:
        yield f"class {node.name};"
        return
    parent = f" extends {node.parent}" if node.parent else ""
    yield from _block(f"class {node.name}{parent}", node.members)


def _predicate(node: PredicateDefinition) -> Iterator[str]:
    prefix = "exogenous " if node.exogenous else ""
    yield from _block(f"{prefix}{'action' if node.action else 'predicate'} {node.name}", node.body)


def _constructor(node: Constructor) -> Iterator[str]:
    parameters = ", ".join(f"{type_} {name}" for type_, name in node.parameters)
    yield from _block(f"{node.name}({parameters})", node.body)


def _one(text: Callable[[Any], str]) -> Callable[[Any], Iterator[str]]:
    return lambda node: iter((text(node),))


_STATEMENTS: dict[type, Callable[[Any], Iterator[str]]] = {
    Include: _one(lambda node: f"#include {quoted(node.file)}"),
    Enumeration: _one(lambda node: f"enum {node.name} {{{', '.join(node.values)}}}"),
    Typedef: _one(lambda node: f"typedef {node.type} {render_expression(node.domain)} {node.name};"),
    Declaration: _declaration,
    Assignment: _one(lambda node: f"{node.target} = {render_expression(node.value)};"),
    Constraint: _constraint,
    Requirement: _requirement,
    Relation: _relation,
    Goal: _goal,
    Method: _method,
    Allocation: _one(lambda node: f"{render_expression(node.new)};"),
    Super: _one(lambda node: f"super({_comma(node.arguments)});"),
    Contingent: _one(lambda node: f"contingent duration = {_range(node.domain)};"),
    If: _if,
    Either: _either,
    Keep: _keep,
    ForEach: lambda node: _block(f"foreach ({node.name} in {node.over})", node.body),
    ClassDefinition: _class,
    PredicateDefinition: _predicate,
    AttributeDefinition: lambda node: _block(f"attribute {node.name}", node.predicates),
    Constructor: _constructor,
    RuleDefinition: lambda node: _block(f"{node.cls}::{node.predicate}", node.body),
    Signature: _one(lambda node: " ".join(node.words)),
}
