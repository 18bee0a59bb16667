"""Configuration constraint schemata (paper, section 2) as frozen syntax: what a predicate requires of other attributes.

A schema's body is a sequence of statements over names: the token's parameters and `start`, `end`, `duration`,
`object`; tokens that the body names; local variables; members of objects along paths. The token network manager
instantiates a body when a token becomes active, and a guarded part of it when its guard is decided.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from planner.domains import Domain


@dataclass(frozen=True, slots=True)
class Ref:
    """A path of names: a variable (`next.place`), an object (`object.battery`) or a token (`next`)."""

    path: tuple[str, ...]

    def __repr__(self) -> str:
        return ".".join(self.path)


@dataclass(frozen=True, slots=True)
class Constant:
    """A value, or any of a domain's values when `domain` is given."""

    value: Any = None
    domain: Domain | None = None

    def __repr__(self) -> str:
        return repr(self.value if self.domain is None else self.domain)


@dataclass(frozen=True, slots=True)
class Apply:
    """The result of a function: the last argument of the constraint procedure of that name."""

    procedure: str
    arguments: tuple[Expression, ...]

    def __repr__(self) -> str:
        return f"{self.procedure}({', '.join(map(repr, self.arguments))})"


Expression = Ref | Constant | Apply


@dataclass(frozen=True, slots=True)
class Subgoal:
    """`relation(predicate)`: there is an interval with that predicate in that temporal relation to this token's.

    `predicate`: (class, predicate). `target`: the object that must have it; None: any object of the class. `name`:
    by which later statements know the token. `bounds`: quantitative bounds, one pair a distance of the relation.
    `solitary`: the interval is this token's own, which is codesignated with no other.
    """

    relation: str
    predicate: tuple[str, str]
    name: str
    target: Ref | None = None
    bounds: tuple[tuple[float, float], ...] = ()
    solitary: bool = False


@dataclass(frozen=True, slots=True)
class AllowedValue:
    """A value pattern: a predicate (class, name), and parameters each of which equals an expression; one that is a
    constant with a domain allows any of its values."""

    predicate: tuple[str, str]
    parameters: tuple[tuple[str, Expression], ...] = ()


@dataclass(frozen=True, slots=True)
class Confine:
    """`relation(attribute in values)`: there is an interval in that temporal relation to this token's over which the
    attribute, `(class, name)`, has only these values, and may change among them: a constraint token (paper, section 3).

    The rest is as for a `Subgoal`.
    """

    relation: str
    attribute: tuple[str, str]
    values: tuple[AllowedValue, ...]
    name: str
    target: Ref | None = None
    bounds: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Relate:
    """A temporal relation between two tokens that have names here."""

    relation: str
    origin: str
    target: str
    bounds: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Require:
    """A constraint procedure over these arguments must hold."""

    procedure: str
    arguments: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Local:
    """A local variable: of a named type or a domain. An object variable ranges over all instances of its class.

    `decide`: a complete plan must bind it; not so for the result of a function, which follows from its arguments.
    """

    name: str
    type: str | Domain
    decide: bool = True


@dataclass(frozen=True, slots=True)
class Guard:
    """`then` applies once the test is decided true, `otherwise` once it is decided false; nothing until then.

    `test` is a constraint procedure's name (`eq`, `neq`, ...) over `arguments`.
    """

    test: str
    arguments: tuple[Expression, ...]
    then: tuple[Statement, ...]
    otherwise: tuple[Statement, ...] = ()


@dataclass(frozen=True, slots=True)
class OneOf:
    """At least one of these branches applies; which one is a choice of the search (a set V_i of the paper)."""

    name: str
    branches: tuple[tuple[Statement, ...], ...]


@dataclass(frozen=True, slots=True)
class ForEach:
    """`body` applies once for each object that an object variable has left when the statement is carried out.

    `name`: by which the body knows the object.
    """

    name: str
    over: Ref
    body: tuple[Statement, ...]


Statement = Subgoal | Confine | Relate | Require | Local | Guard | OneOf | ForEach


@dataclass(frozen=True, slots=True)
class Rule:
    """A configuration constraint schema of one predicate. `where`: the place that states it, for messages."""

    owner: tuple[str, str]
    body: tuple[Statement, ...]
    where: str = ""
