"""The syntax tree of NDDL: frozen, with the place of every node. Two trees are equal when they say the same."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from planner.language.nddl.errors import NOWHERE, Position


@dataclass(frozen=True, slots=True)
class Node:
    """Anything that stands in a text."""

    at: Position = field(default=NOWHERE, compare=False, repr=False, kw_only=True)


# Expressions


@dataclass(frozen=True, slots=True)
class Number(Node):
    """A number. `real`: written as one, so that 3.0 is not 3."""

    value: float
    real: bool = False


@dataclass(frozen=True, slots=True)
class Text(Node):
    """A string."""

    value: str


@dataclass(frozen=True, slots=True)
class Truth(Node):
    """`true` or `false`."""

    value: bool


@dataclass(frozen=True, slots=True)
class Name(Node):
    """`a.b.c`: a variable, token, object, class or enumeration value along a path."""

    path: tuple[str, ...]

    def __str__(self) -> str:
        return ".".join(self.path)


@dataclass(frozen=True, slots=True)
class Range(Node):
    """`[lower upper]`."""

    lower: Expression
    upper: Expression


@dataclass(frozen=True, slots=True)
class Choice(Node):
    """`{a, b, c}`."""

    values: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Call(Node):
    """`f(arguments)`: a function in an expression; as a statement, a constraint by name."""

    function: str
    arguments: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Binary(Node):
    """`left operator right`."""

    operator: str
    left: Expression
    right: Expression


@dataclass(frozen=True, slots=True)
class Unary(Node):
    """`-operand` or `!operand`."""

    operator: str
    operand: Expression


@dataclass(frozen=True, slots=True)
class New(Node):
    """`new C(arguments)`."""

    cls: str
    arguments: tuple[Expression, ...]


Expression = Number | Text | Truth | Name | Range | Choice | Call | Binary | Unary | New

# Statements


@dataclass(frozen=True, slots=True)
class Include(Node):
    """`#include "file"`."""

    file: str


@dataclass(frozen=True, slots=True)
class Enumeration(Node):
    """`enum name {values}`."""

    name: str
    values: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Typedef(Node):
    """`typedef type domain name;`."""

    type: str
    domain: Range | Choice
    name: str


@dataclass(frozen=True, slots=True)
class Declarator(Node):
    """A declared variable with its initial value, or None."""

    name: str
    value: Expression | None = None


@dataclass(frozen=True, slots=True)
class Declaration(Node):
    """`[filter] type a = 1, b;`. `filter_only`: never a decision of the search."""

    type: str
    variables: tuple[Declarator, ...]
    filter_only: bool = False


@dataclass(frozen=True, slots=True)
class Assignment(Node):
    """`target = value;`: initialises in a constructor, specifies elsewhere."""

    target: Name
    value: Expression


@dataclass(frozen=True, slots=True)
class Constraint(Node):
    """`name(arguments);` with the message to show when it is violated."""

    call: Call
    message: str | None = None


@dataclass(frozen=True, slots=True)
class Requirement(Node):
    """`expression;` or `enforce expression;`: it holds."""

    expression: Expression
    message: str | None = None


@dataclass(frozen=True, slots=True)
class Bounds(Node):
    """`[lower upper]` of a temporal relation."""

    lower: Expression
    upper: Expression


@dataclass(frozen=True, slots=True)
class TokenReference(Node):
    """`object.path.predicate name` or, with an empty path, a token by its name. `role`: condition or effect."""

    path: tuple[str, ...]
    name: str | None = None
    role: Literal["condition", "effect"] | None = None


@dataclass(frozen=True, slots=True)
class Relation(Node):
    """`[origin] relation[bounds](targets);` or `origin relation target;`."""

    origin: str | None
    relation: str
    bounds: tuple[Bounds, ...]
    targets: tuple[TokenReference, ...]


@dataclass(frozen=True, slots=True)
class Goal(Node):
    """`goal(...)`, `rejectable(...)` or `fact(...)`."""

    kind: Literal["goal", "rejectable", "fact"]
    targets: tuple[TokenReference, ...]


@dataclass(frozen=True, slots=True)
class Method(Node):
    """`path.method(arguments);`."""

    path: tuple[str, ...]
    method: str
    arguments: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Allocation(Node):
    """`new C(...);` as a statement."""

    new: New


@dataclass(frozen=True, slots=True)
class Super(Node):
    """`super(arguments);`."""

    arguments: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Contingent(Node):
    """`contingent duration = [lower upper];`: nature decides the duration, within the bounds. An extension."""

    domain: Range


@dataclass(frozen=True, slots=True)
class If(Node):
    """`if (test) {...} else {...}`."""

    test: Expression
    then: tuple[Statement, ...]
    otherwise: tuple[Statement, ...] = ()


@dataclass(frozen=True, slots=True)
class Either(Node):
    """`either {...} or {...}`: at least one of the branches holds, the first one preferred. An extension."""

    branches: tuple[tuple[Statement, ...], ...]


@dataclass(frozen=True, slots=True)
class AllowedValue(Node):
    """`object.path.predicate(parameter == expression, ...)`: a value that a constraint token allows."""

    path: tuple[str, ...]
    parameters: tuple[tuple[str, Expression], ...] = ()


@dataclass(frozen=True, slots=True)
class Keep(Node):
    """`only relation[bounds] {value, ...};`: a constraint token. An extension."""

    relation: str
    bounds: tuple[Bounds, ...]
    values: tuple[AllowedValue, ...]


@dataclass(frozen=True, slots=True)
class ForEach(Node):
    """`foreach (name in over) {...}`."""

    name: str
    over: Name
    body: tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class Constructor(Node):
    """`C(type name, ...) {...}`."""

    name: str
    parameters: tuple[tuple[str, str], ...]
    body: tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class PredicateDefinition(Node):
    """`predicate p {...}`, `action a {...}`. `exogenous`: no plan brings it about. An extension."""

    name: str
    body: tuple[Statement, ...]
    action: bool = False
    exogenous: bool = False


@dataclass(frozen=True, slots=True)
class AttributeDefinition(Node):
    """`attribute name { predicates }`: a timeline of its own for these values. An extension."""

    name: str
    predicates: tuple[PredicateDefinition, ...]


@dataclass(frozen=True, slots=True)
class ClassDefinition(Node):
    """`class C extends P {...}`; `members` is None in a forward declaration `class C;`."""

    name: str
    parent: str | None
    members: tuple[Declaration | Constructor | PredicateDefinition | AttributeDefinition, ...] | None


@dataclass(frozen=True, slots=True)
class RuleDefinition(Node):
    """`C::p {...}`."""

    cls: str
    predicate: str
    body: tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class Signature(Node):
    """`constraint name(types) ...`: the signature of a constraint procedure, as text; it declares nothing new."""

    words: tuple[str, ...]


Statement = (
    Include
    | Enumeration
    | Typedef
    | Declaration
    | Assignment
    | Constraint
    | Requirement
    | Relation
    | Goal
    | Method
    | Allocation
    | Super
    | Contingent
    | If
    | Either
    | Keep
    | ForEach
    | ClassDefinition
    | RuleDefinition
    | Signature
)
