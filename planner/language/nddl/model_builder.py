"""From definitions to the model manager: types, classes, predicates, rules."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from planner.domains import Domain, Universe, singleton
from planner.errors import ModelError
from planner.language.nddl.causality import Supports
from planner.language.nddl.errors import Complaint, Report
from planner.language.nddl.library import LIBRARY_CLASSES
from planner.language.nddl.scope import Scope, StateMeaning
from planner.language.nddl.symbols import PredicateSymbol, Symbols
from planner.language.nddl.syntax import (
    Assignment,
    AttributeDefinition,
    Choice,
    Constraint,
    Contingent,
    Declaration,
    Declarator,
    Enumeration,
    Expression,
    Name,
    Number,
    PredicateDefinition,
    Range,
    RuleDefinition,
    Statement,
    Typedef,
)
from planner.language.nddl.translator import Translator
from planner.language.nddl.values import Literals
from planner.model.classes import Parameter, Predicate
from planner.model.manager import STATE, ModelManager
from planner.model.rules import Rule

Bounds = tuple[float, float]
ANY_DURATION: Bounds = (1, math.inf)


@dataclass(slots=True)
class _Predicate:
    """What the body of a predicate says so far."""

    parameters: list[Parameter]
    rest: list[Statement]
    duration: Bounds = ANY_DURATION
    contingent: bool = False
    solitary: bool = False


class ModelBuilder:
    """Fills a model manager from the statements of a program, in three steps that objects come between."""

    def __init__(self, model: ModelManager, symbols: Symbols, report: Report) -> None:
        self.model = model
        self.symbols = symbols
        self.report = report
        self.literals = Literals(symbols, model)

    def types(self, statements: Sequence[Statement]) -> None:
        """Enumerations and classes with their members; types follow where they stand, with the objects."""
        for enumeration in self.symbols.enumerations.values():
            self.enumeration(enumeration)
        for name, members in LIBRARY_CLASSES.items():
            self.model.add_class(name, "Object", dict(members))
        done = {found.name for found in self.model.classes()}
        for symbol in self.symbols.classes.values():
            self._class(symbol.name, done)

    def enumeration(self, node: Enumeration) -> None:
        """An enumeration."""
        doubled = [value for n, value in enumerate(node.values) if value in node.values[:n]]
        if doubled:
            self.report.complain(Complaint(node.at, f"enumeration {node.name}: value {doubled[0]!r} is listed twice"))
        self.model.add_enumeration(node.name, node.values)

    def _class(self, name: str, done: set[str]) -> None:
        """A class, its parents first."""
        chain = [symbol for symbol in self.symbols.lineage(name) if symbol.name not in done]
        for symbol in reversed(chain):
            self.model.add_class(symbol.name, symbol.parent or "Object")
            done.add(symbol.name)

    def members(self) -> None:
        """The members of classes, once all types are there."""
        for symbol in self.symbols.classes.values():
            if symbol.definition is None or symbol.definition.members is None:
                continue
            for member in symbol.definition.members:
                if isinstance(member, AttributeDefinition) and member.name not in self.model.attributes_of(symbol.name):
                    self.model.add_attribute(symbol.name, member.name)
                if not isinstance(member, Declaration):
                    continue
                try:
                    self.symbols.check_type(member.type, member.at)
                except Complaint as complaint:
                    self.report.complain(complaint)
                    continue
                for variable in member.variables:
                    self.model.class_named(symbol.name).members[variable.name] = member.type

    def typedef(self, node: Typedef) -> None:
        """A type over a basic type, an enumeration or objects."""
        self.symbols.check_type(node.type, node.at)
        base = self.literals.domain_of_type(node.type)
        if isinstance(node.domain, Range):
            interval = self.literals.interval(node.domain, self.literals.is_real(node.type))
            domain = base.intersect(interval) if base.is_numeric else None
            if domain is None:
                raise Complaint(node.domain.at, f"type {node.name}: an interval of {node.type} means nothing")
            self.model.add_type(node.name, domain)
            return
        choice = self.literals.choice(node.domain, node.type)
        strangers = [v for v in choice.values() if node.type != "string" and v not in base]
        if strangers:
            raise Complaint(node.domain.at, f"type {node.name}: {strangers[0]!r} is not a {node.type}")
        if base.is_numeric:
            choice = Universe(node.name, choice.values()).domain()
        self.model.add_type(node.name, choice)

    # Predicates

    def predicates(self) -> None:
        """The predicates of all classes, those of parents first."""
        done: set[tuple[str, str]] = set()
        for symbol in self.symbols.classes.values():
            for above in reversed(list(self.symbols.lineage(symbol.name))):
                for predicate in above.predicates.values():
                    key = (predicate.cls, predicate.name)
                    if key not in done and predicate.definition is not None:
                        self._add_predicate(predicate, predicate.definition)
                    done.add(key)

    def _add_predicate(self, symbol: PredicateSymbol, node: PredicateDefinition) -> None:
        found = _Predicate([], [])
        above = self._above(symbol)
        if above is not None:
            found.duration, found.contingent, found.solitary = above.duration, above.contingent, above.solitary
        for statement in node.body:
            try:
                self._predicate_statement(symbol, statement, found)
            except Complaint as complaint:
                self.report.complain(complaint)
        names = {p.name for p in found.parameters}
        inherited = [p for p in above.parameters if p.name not in names] if above is not None else []
        try:
            self.model.add_predicate(
                symbol.cls,
                symbol.name,
                [*inherited, *found.parameters],
                attribute=symbol.attribute or (above.attribute if above is not None else STATE),
                body=above.body if above is not None else (),
                duration=found.duration,
                contingent=found.contingent,
                exogenous=node.exogenous,
                solitary=found.solitary,
            )
        except ModelError as error:
            self.report.complain(Complaint(node.at, str(error)))
            return
        scope = Scope(self.symbols, (symbol.cls, symbol.name))
        body = Translator(self.symbols, self.model, self.report, scope).body(found.rest)
        if body:
            self.model.constrain_parameters(symbol.cls, symbol.name, body)

    def _above(self, symbol: PredicateSymbol) -> Predicate | None:
        """The predicate that this one declares again: what it says holds here too."""
        for above in list(self.symbols.lineage(symbol.cls))[1:]:
            found = self.model.class_named(above.name).predicates.get(symbol.name)
            if found is not None:
                return found
        return None

    def _predicate_statement(self, symbol: PredicateSymbol, node: Statement, found: _Predicate) -> None:
        if isinstance(node, Declaration):
            self.symbols.check_type(node.type, node.at)
            for variable in node.variables:
                self._parameter(node, variable, found)
        elif isinstance(node, Contingent):
            interval = self.literals.interval(node.domain, False)
            found.duration, found.contingent = (interval.lower, interval.upper), True
        elif not self._duration(node, found) and not self._state(symbol, node, found):
            found.rest.append(node)

    def _parameter(self, node: Declaration, variable: Declarator, found: _Predicate) -> None:
        value = variable.value
        if isinstance(value, Range | Choice):
            scope = Scope(self.symbols)
            domain = Translator(self.symbols, self.model, self.report, scope).initial_domain(node.type, value)
            if domain is None or domain.is_empty:
                raise Complaint(variable.at, f"parameter {variable.name!r}: no value of {node.type} is left")
            found.parameters.append(Parameter(variable.name, domain))
            return
        found.parameters.append(Parameter(variable.name, node.type))
        if value is not None:
            found.rest.append(Assignment(Name((variable.name,), at=variable.at), value, at=variable.at))

    def variable(self, type_: str, declarator: Declarator) -> None:
        """Let the model know a variable of the problem and the values that its declaration leaves."""
        given: Domain | None = None
        if declarator.value is not None:
            translator = Translator(self.symbols, self.model, self.report, Scope(self.symbols))
            given, value = translator.initial_domain(type_, declarator.value), self.literals.value(declarator.value)
            if given is None and value is not None:
                given = self.literals.domain_of_type(type_).intersect(singleton(value))
        base = self.symbols.base(type_)
        self.model.add_variable(declarator.name, base if given is None or given.is_empty else given)

    def _duration(self, node: Statement, found: _Predicate) -> bool:
        """Whether the statement bounds the duration by numbers; then it becomes the predicate's own bounds."""
        value: Expression | None = None
        if isinstance(node, Assignment) and node.target.path == ("duration",):
            value = node.value
        elif isinstance(node, Constraint) and node.call.function == "eq" and len(node.call.arguments) == 2:
            first, second = node.call.arguments
            if isinstance(first, Name) and first.path == ("duration",):
                value = second
            elif isinstance(second, Name) and second.path == ("duration",):
                value = first
        if not isinstance(value, Number | Range) or found.contingent:
            return False
        one = value if isinstance(value, Range) else Range(value, value, at=value.at)
        interval = self.literals.interval(one, False)
        lower, upper = max(found.duration[0], interval.lower), min(found.duration[1], interval.upper)
        if not interval.integer or lower > upper:
            return False
        found.duration = lower, upper
        return True

    def _state(self, symbol: PredicateSymbol, node: Statement, found: _Predicate) -> bool:
        """Whether the statement says `eq(state, ACTIVE)`: tokens of the predicate are never codesignated."""
        if not isinstance(node, Constraint) or node.call.function != "eq" or len(node.call.arguments) != 2:
            return False
        names = [a.path for a in node.call.arguments if isinstance(a, Name)]
        scope = Scope(self.symbols, (symbol.cls, symbol.name))
        if ("ACTIVE",) in names and len(names) == 2:
            other = next((p for p in names if p != ("ACTIVE",)), ())
            if other and isinstance(scope.meaning(other, node.at), StateMeaning):
                found.solitary = True
                return True
        return False

    # Rules

    def rules(self, statements: Sequence[Statement]) -> None:
        """The rules of all predicates, and what supports the effects of actions."""
        supports = Supports(self.symbols)
        for node in statements:
            if not isinstance(node, RuleDefinition):
                continue
            try:
                self._rule(node)
                supports.note(node)
            except Complaint as complaint:
                self.report.complain(complaint)
        for rule in supports.rules():
            self.model.add_rule(rule)

    def _rule(self, node: RuleDefinition) -> None:
        if node.cls not in self.symbols.classes:
            self.symbols.check_type(node.cls, node.at)
            raise Complaint(node.at, f"{node.cls!r} is not a class")
        owner = self.symbols.predicate(node.cls, node.predicate, node.at)
        scope = Scope(self.symbols, owner).inner()
        body = Translator(self.symbols, self.model, self.report, scope).body(node.body)
        where = f"{node.at}: rule {node.cls}::{node.predicate}"
        self.model.add_rule(Rule(owner, body, where))
