"""The problem of a program: its statements carried out, in order, on a plan database."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from planner.constraints.network import Inconsistency
from planner.database import PlanDatabase
from planner.domains import Domain, Interval
from planner.errors import ModelError
from planner.language.nddl.errors import Complaint, Position, Report
from planner.language.nddl.library import CONFIG
from planner.language.nddl.methods import METHODS, withdrawn
from planner.language.nddl.printer import render_statement
from planner.language.nddl.scope import Scope, StateMeaning, TokenMeaning, VariableMeaning
from planner.language.nddl.symbols import Symbols
from planner.language.nddl.syntax import (
    Assignment,
    Binary,
    Constraint,
    Declaration,
    Declarator,
    Either,
    Expression,
    ForEach,
    Goal,
    If,
    Keep,
    Method,
    Name,
    New,
    Relation,
    Requirement,
    Statement,
)
from planner.language.nddl.translator import Translator
from planner.language.nddl.values import Literals
from planner.model import rules
from planner.model.classes import ModelObject, objects_in
from planner.tokens.instance import RuleInstance, evaluate, resolve
from planner.tokens.path import TokenPath
from planner.tokens.token import Role, Token

PROBLEM = (Assignment, Constraint, Declaration, Either, ForEach, Goal, If, Keep, Method, Relation, Requirement)
"""The kinds of statements that say something about the plan."""
_BOUND_BY_NUMBER = ("eq", "leq", "lt")


class Stated:
    """A statement as the owner of what it posts: its place and its text, made when somebody asks."""

    __slots__ = ("statement",)

    def __init__(self, statement: Statement) -> None:
        self.statement = statement

    @property
    def at(self) -> Position:
        """Where it stands."""
        return self.statement.at

    def __str__(self) -> str:
        message = getattr(self.statement, "message", None)
        text = render_statement(self.statement)
        return f"{self.statement.at}: {text}" + (f" ({message})" if message else "")


def is_plain_declaration(owner: object) -> bool:
    """Whether the owner of something in a plan database is a declaration that gives no value to its variables."""
    label = owner.label if isinstance(owner, RuleInstance) else None
    statement = label.statement if isinstance(label, Stated) else None
    return isinstance(statement, Declaration) and all(v.value is None for v in statement.variables)


@dataclass
class Program:
    """A problem, checked and ready to be carried out on a database of its model.

    `horizon`: what the program's PlannerConfig says, or None; `max_steps` likewise.
    """

    symbols: Symbols
    statements: Sequence[Statement]
    horizon: tuple[int, int] | None = None
    max_steps: int | None = None
    constants: dict[str, object] = field(default_factory=dict)

    def carry_out(self, database: PlanDatabase, report: Report) -> None:
        """Post all statements and propagate. Inconsistency when they cannot hold together."""
        _Execution(self, database, report).run()


class _Execution:
    def __init__(self, program: Program, database: PlanDatabase, report: Report) -> None:
        self.program = program
        self.symbols = program.symbols
        self.database = database
        self.tokens = database.tokens
        self.report = report
        self.scope = Scope(self.symbols)
        self.literals = Literals(self.symbols, database.model)
        self.translator = Translator(self.symbols, database.model, report, self.scope)
        self.goals: list[tuple[Token, RuleInstance]] = []

    def run(self) -> None:
        gone = withdrawn(self.program.statements)
        # After every statement: in one go at the end, bounds would move back and forth far more often.
        propagate = self.database.network.propagate
        for statement in self.program.statements:
            if id(statement) in gone:
                continue
            try:
                self.statement(statement)
                propagate()
            except Complaint as complaint:
                self.report.complain(complaint)
            except ModelError as error:
                self.report.complain(Complaint(statement.at, str(error)))
        self.report.raise_if_failed()
        self._members()
        for token, instance in self.goals:
            self._inside(token, instance)
        self.database.network.propagate()

    def statement(self, statement: Statement) -> None:
        carry_out = _CARRY_OUT.get(type(statement))
        if carry_out is None:
            self._general(statement)
            return
        carry_out(self, statement, RuleInstance(Stated(statement), None))

    def _members(self) -> None:
        """Members that the constructors left open are decided with everything else."""
        for thing in self.database.model.objects.values():
            if self.symbols.is_subclass(thing.cls, CONFIG):
                continue
            for name, type_ in self.database.model.members_of(thing.cls).items():
                if name not in thing.members and isinstance(type_, str) and type_ in self.symbols.enumerations:
                    self._decide(self.tokens.member_of(thing, name))

    def _decide(self, found: object) -> None:
        variable: Any = found
        self.tokens.must_be_decided(variable)

    # Statements

    def _general(self, statement: Statement) -> None:
        """A statement that means here what it means in a rule."""
        self.translator.out = []
        self.translator.statement(statement)
        instance = RuleInstance(Stated(statement), None)
        for one in self.translator.out:
            if not (isinstance(one, rules.Require) and self._by_number(one, instance)):
                self.tokens.carry_out((one,), instance)
        for name, found in instance.names.items():
            self._name(name, found)

    def _name(self, name: str, found: Any) -> None:
        self.database.trail.add(self.tokens.names, name, found)

    def _by_number(self, node: rules.Require, instance: RuleInstance) -> bool:
        """Post `eq`, `leq` or `lt` between a variable and a number as what it is: a smaller domain."""
        if node.procedure not in _BOUND_BY_NUMBER or len(node.arguments) != 2:
            return False
        first, second = node.arguments
        if isinstance(second, rules.Constant) and isinstance(first, rules.Ref):
            ref, constant, below = first, second, True
        elif isinstance(first, rules.Constant) and isinstance(second, rules.Ref):
            ref, constant, below = second, first, False
        else:
            return False
        domain = _bound(node.procedure, constant, below)
        if domain is None:
            return False
        variable = evaluate(self.tokens, ref, instance)
        if not isinstance(variable.domain, Interval):
            return False
        self.database.network.restrict(variable, domain, instance)
        return True

    def _declaration(self, node: Declaration, instance: RuleInstance) -> None:
        for variable in node.variables:
            if variable.name in self.database.model.objects:
                continue
            if isinstance(variable.value, New):
                raise Complaint(variable.at, f"object {variable.name!r} could not be created")
            source = self._source(variable)
            plain = Declarator(variable.name, at=variable.at) if source is not None else variable
            one = Declaration(node.type, (plain,), node.filter_only or self._is_empty(node.type), at=node.at)
            self._general(one)
            self.scope.names.pop(variable.name, None)
            if source is not None:
                declared: Any = self.tokens.names[variable.name]
                self.database.network.restrict(declared, source, instance)

    def _source(self, variable: Declarator) -> Domain | None:
        """The domain that a variable starts from if it is declared with another one that has several values left.

        It starts from that domain; they need not stay equal.
        """
        if not isinstance(variable.value, Name):
            return None
        found = self.scope.meaning(variable.value.path, variable.value.at)
        if not isinstance(found, VariableMeaning):
            return None
        source = resolve(self.tokens, found.ref, RuleInstance("", None))
        if isinstance(source, ModelObject | Token) or source.domain.is_singleton:
            return None
        return source.domain

    def _is_empty(self, type_: str) -> bool:
        """Whether a type is a class that has no object yet, and may have some later."""
        cls = self.symbols.class_of(type_)
        closed = any(isinstance(s, Method) and s.method == "close" for s in self.program.statements)
        return cls is not None and not closed and not objects_in(self.database.model.objects_of(cls))

    def _goal(self, node: Goal, instance: RuleInstance) -> None:
        for target in node.targets:
            if not target.path:
                raise Complaint(node.at, f"{node.kind}: expected a predicate, as in {node.kind}(Class.predicate name)")
            predicate, owner = self.scope.predicate_of(target.path, target.at)
            name = target.name or f"{node.kind}_{len(self.tokens.tokens) + 1}"
            role: Role = node.kind
            token = self.tokens.create(predicate, TokenPath.of(name), role, instance)
            self._name(name, token)
            if owner is not None:
                thing = resolve(self.tokens, owner, instance)
                if isinstance(thing, ModelObject):
                    self.database.network.restrict(token.object, self.tokens.domain_of_object(thing), instance)
                elif not isinstance(thing, Token):
                    self.tokens.require("eq", (token.object, thing), instance)
            if role != "fact":
                self.goals.append((token, instance))

    def _inside(self, token: Token, instance: RuleInstance) -> None:
        """A goal is achieved inside the horizon; one that its own times keep from that must still overlap it.

        A rejectable token that cannot is rejected.
        """
        network, (first, last) = self.database.network, self.database.horizon
        start, end = token.start.domain, token.end.domain
        if token.host is not None:
            return
        least = min(1, token.duration.domain.upper)  # of the token within the horizon: an instant may be at its ends
        if start.lower + least > last or end.upper - least < first:
            if token.role == "goal" or token.must_host:
                raise Inconsistency(HorizonMissed(token, (first, last)), token.start)
            self.tokens.reject(token)
            return
        inside = start.upper >= first and start.lower + token.duration.domain.lower <= last
        earliest = first if start.upper >= first else -math.inf
        latest = last if inside and end.lower <= last else math.inf
        network.restrict(token.start, Interval(earliest, last - least), instance)
        network.restrict(token.end, Interval(first + least, latest), instance)

    def _relation(self, node: Relation, instance: RuleInstance) -> None:
        self._general(node)

    def _assignment(self, node: Assignment, instance: RuleInstance) -> None:
        if isinstance(node.value, New):
            return
        self.specify(node.target, node.value, instance)

    def _requirement(self, node: Requirement, instance: RuleInstance) -> None:
        expression = node.expression
        if isinstance(expression, Binary) and expression.operator == "==" and self._state(expression.left):
            self.set_state(expression.left, expression.right, instance)
            return
        self._general(node)

    def _constraint(self, node: Constraint, instance: RuleInstance) -> None:
        arguments = node.call.arguments
        if node.call.function == "eq" and len(arguments) == 2 and self._state(arguments[0]):
            self.set_state(arguments[0], arguments[1], instance)
            return
        self._general(node)

    def _state(self, node: Expression) -> bool:
        if not isinstance(node, Name) or node.path[-1] != "state":
            return False
        return isinstance(self.scope.meaning(node.path, node.at), StateMeaning)

    def _method(self, node: Method, instance: RuleInstance) -> None:
        METHODS[node.method](self, node, instance)

    # Services to methods

    def specify(self, target: Name, value: Expression, instance: RuleInstance) -> None:
        """Restrict a variable to a value."""
        if self._state(target):
            self.set_state(target, value, instance)
            return
        found = self.scope.meaning(target.path, target.at)
        if not isinstance(found, VariableMeaning):
            raise Complaint(target.at, f"expected a variable, found {str(target)!r}, which is none")
        self.translator.out = []
        self.translator.require("eq", (target, value), target.at)
        for one in self.translator.out:
            if isinstance(one, rules.Require) and self._by_value(one, instance):
                continue
            self.tokens.carry_out((one,), instance)

    def _by_value(self, node: rules.Require, instance: RuleInstance) -> bool:
        if self._by_number(node, instance):
            return True
        first, second = node.arguments
        if not isinstance(first, rules.Ref) or isinstance(second, rules.Apply):
            return False
        value = evaluate(self.tokens, second, instance).domain
        variable = evaluate(self.tokens, first, instance)
        if value.is_open or (not value.is_singleton and not isinstance(second, rules.Constant)):
            return False
        self.database.network.restrict(variable, value, instance)
        return True

    def set_state(self, target: Expression, value: Expression, instance: RuleInstance) -> None:
        """Set the state of a token by the name of the state."""
        assert isinstance(target, Name)
        token = self.token(target.path[:-1], target.at)
        state = value.path[-1] if isinstance(value, Name) else ""
        if state == "ACTIVE":
            self.activate(token, instance)
        elif state == "REJECTED":
            self.reject(token, target.at)
        elif state != "INACTIVE":
            message = f"the state of a token can be set to ACTIVE or REJECTED, found {state or 'an expression'!r}"
            raise Complaint(value.at, message, unsupported=state == "MERGED")

    def token(self, path: tuple[str, ...], at: Position) -> Token:
        """The token of a path."""
        found = self.scope.meaning(path, at) if path else None
        if not isinstance(found, TokenMeaning):
            raise Complaint(at, f"expected a token, found {'.'.join(path)!r}, which is none")
        token = resolve(self.tokens, found.ref, RuleInstance("", None))
        assert isinstance(token, Token)
        return token

    def activate(self, token: Token, instance: RuleInstance) -> None:
        """Say that a token is active: where it goes, if that is open, the search decides before anything else."""
        if not token.must_host:
            self.tokens.open.put_first(token)
        if token.kind == "timeline" or not token.object.domain.is_singleton or token.placed:
            return
        self.tokens.activate(token, instance)

    def reject(self, token: Token, at: Position) -> None:
        """Leave a token out."""
        if token.role != "rejectable":
            raise Complaint(at, f"{token.name!r} is a {token.role}: only a rejectable token can be rejected")
        self.goals = [(t, i) for t, i in self.goals if t is not token]
        self.tokens.reject(token)


_CARRY_OUT: dict[type, Callable[[_Execution, Any, RuleInstance], None]] = {
    Declaration: _Execution._declaration,
    Goal: _Execution._goal,
    Assignment: _Execution._assignment,
    Requirement: _Execution._requirement,
    Constraint: _Execution._constraint,
    Method: _Execution._method,
}


class HorizonMissed:
    """A goal whose own times keep it outside of the horizon, as the reason of an inconsistency."""

    __slots__ = ("horizon", "token")

    def __init__(self, token: Token, horizon: tuple[int, int]) -> None:
        self.token = token
        self.horizon = horizon

    def __repr__(self) -> str:
        start, end = self.token.start.domain, self.token.end.domain
        return f"goal {self.token.name} (start {start!r}, end {end!r}) lies outside of the horizon {list(self.horizon)}"


def _bound(procedure: str, constant: rules.Constant, below: bool) -> Domain | None:
    """What `procedure(variable, constant)`, or with the arguments the other way round, leaves of a numeric domain."""
    domain = constant.domain
    if domain is None:
        value = constant.value
        if not isinstance(value, int | float) or isinstance(value, bool):
            return None
        lower = upper = value
    elif isinstance(domain, Interval):
        lower, upper = domain.lower, domain.upper
    else:
        return None
    if procedure == "eq":
        return Interval(lower, upper, False)
    if procedure == "lt":
        return None
    return Interval(-math.inf, upper, False) if below else Interval(lower, math.inf, False)
