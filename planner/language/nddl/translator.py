"""From statements of NDDL to statements of configuration constraints, names and arities checked on the way.

An expression becomes the variables and constraints that it needs: the result of a function whose procedure has it
first is a local variable that no search decides. A difference of two timepoints becomes a temporal distance, which the
temporal network knows exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from planner.domains import Interval
from planner.errors import ModelError, nearest
from planner.language.nddl.comparisons import Difference, difference
from planner.language.nddl.errors import Complaint, Position, Report
from planner.language.nddl.kinds import check_kinds
from planner.language.nddl.operators import (
    ALIASES,
    COMPARISONS,
    FUNCTIONS,
    MIRRORED,
    RESULT_LAST,
    SINGLETON_TESTS,
    TESTS,
)
from planner.language.nddl.relations import keep, relate
from planner.language.nddl.scope import Scope, StateMeaning, TokenMeaning, ValueMeaning, VariableMeaning
from planner.language.nddl.states import keep_active, state_said
from planner.language.nddl.symbols import Symbols
from planner.language.nddl.syntax import (
    Assignment,
    Binary,
    Call,
    Choice,
    Constraint,
    Declaration,
    Either,
    Expression,
    ForEach,
    If,
    Keep,
    Name,
    New,
    Number,
    Range,
    Relation,
    Requirement,
    Statement,
    Text,
    Truth,
    Unary,
)
from planner.language.nddl.values import Literals, is_number
from planner.model import rules
from planner.model.manager import ModelManager


class Translator:
    """Translates the statements of one body; `out` are the statements so far."""

    def __init__(self, symbols: Symbols, model: ModelManager, report: Report, scope: Scope) -> None:
        self.symbols = symbols
        self.model = model
        self.report = report
        self.scope = scope
        self.literals = Literals(symbols, model)
        self.out: list[rules.Statement] = []
        self._count = 0

    def body(self, statements: Sequence[Statement]) -> tuple[rules.Statement, ...]:
        """The statements of a body; those that are wrong are complained about and left out."""
        for statement in statements:
            self.statement(statement)
        return tuple(self.out)

    def statement(self, statement: Statement) -> None:
        """Translate one statement; what is wrong with it goes to the report."""
        try:
            translate = _TRANSLATE.get(type(statement))
            if translate is None:
                kind = type(statement).__name__.lower()
                raise Complaint(statement.at, f"a statement of this kind ({kind}) cannot stand here")
            translate(self, statement)
        except Complaint as complaint:
            self.report.complain(complaint)

    def inner(self, statements: Sequence[Statement], scope: Scope) -> tuple[rules.Statement, ...]:
        """The statements of a body inside this one."""
        return Translator(self.symbols, self.model, self.report, scope).body(statements)

    # Statements

    def _declaration(self, node: Declaration) -> None:
        self.symbols.check_type(node.type, node.at)
        for variable in node.variables:
            self.scope.add(variable.name, node.type)
            value = variable.value
            domain = self.initial_domain(node.type, value) if value is not None else None
            type_: Any = node.type if domain is None else domain
            self.out.append(rules.Local(variable.name, type_, not node.filter_only))
            if value is not None and domain is None:
                self.require("eq", (Name((variable.name,), at=variable.at), value), variable.at)

    def initial_domain(self, type_: str, value: Expression) -> Any | None:
        """The domain of a variable of a type with a literal as its initial value; None when it is none."""
        base = self.literals.domain_of_type(type_)
        if isinstance(value, Range):
            return base.intersect(self.literals.interval(value, self.literals.is_real(type_)))
        if isinstance(value, Choice):
            choice = self.literals.choice(value, type_)
            return choice.intersect(base) if isinstance(base, Interval) else base.intersect(choice)
        return None

    def _assignment(self, node: Assignment) -> None:
        self.require("eq", (node.target, node.value), node.at)

    def _constraint(self, node: Constraint) -> None:
        self.require(node.call.function, node.call.arguments, node.at)

    def require(self, name: str, arguments: Sequence[Expression], at: Position) -> None:
        """A constraint by name over arguments."""
        said = state_said(self.scope, arguments) if name == "eq" else None
        if said is not None:
            keep_active(self.out, said, at)
            return
        procedures = self.model.procedures
        name = name if name in procedures else ALIASES.get(name, name)
        if name not in procedures:
            known = procedures.names()
            raise Complaint(at, f"there is no constraint, relation or function named {name!r}{nearest(name, known)}")
        try:
            procedures.get(name).check_scope(len(arguments))
        except ModelError as error:
            raise Complaint(at, str(error)) from None
        check_kinds(self, procedures.get(name).kinds, arguments)
        real = any(self.is_real(argument) for argument in arguments)
        scope = tuple(self.expression(argument, real) for argument in arguments)
        self.out.append(rules.Require(name, scope))

    def _requirement(self, node: Requirement) -> None:
        self.holds(node.expression)

    def holds(self, node: Expression) -> None:
        """Require that an expression is true."""
        if isinstance(node, Binary):
            if node.operator == "&&":
                self.holds(node.left)
                self.holds(node.right)
                return
            if node.operator == "==" and state_said(self.scope, (node.left, node.right)):
                self.require("eq", (node.left, node.right), node.at)
                return
            if node.operator in COMPARISONS:
                self._compare(node)
                return
        elif isinstance(node, Call):
            if node.function not in SINGLETON_TESTS:
                self.require(node.function, node.arguments, node.at)
            else:
                self.truth(node)
            return
        self.out.append(rules.Require("eq", (self.truth(node), rules.Constant(True))))

    def _compare(self, node: Binary) -> None:
        self._check_order(node)
        real = self.is_real(node.left) or self.is_real(node.right)
        found = self.difference(node)
        if found is not None:
            between = rules.Constant(domain=Interval(found.lower, found.upper))
            self.out.append(rules.Require("temporalDistance", (found.from_, between, found.to)))
            return
        if node.operator == "==" and isinstance(node.left, Binary) and node.left.operator in RESULT_LAST:
            left = node.left
            check_kinds(self, ("numeric",), (left.left, left.right, node.right))
            scope = (self.expression(left.left, real), self.expression(left.right, real))
            result = self.expression(node.right, real)
            self.out.append(rules.Require(RESULT_LAST[left.operator], (*scope, result)))
            return
        pair = self.expression(node.left, real), self.expression(node.right, real)
        ordered = pair[::-1] if node.operator in MIRRORED else pair
        self.out.append(rules.Require(COMPARISONS[node.operator], ordered))

    def _check_order(self, node: Binary) -> None:
        if node.operator not in ("==", "!="):
            check_kinds(self, ("numeric",), (node.left, node.right))

    def difference(self, node: Binary) -> Difference | None:
        """The temporal distance that a comparison says, if it says one."""
        return difference(node, self._timepoint, self._number)

    def _timepoint(self, node: Name) -> rules.Ref | None:
        found = self.scope.meaning(node.path, node.at)
        return found.ref if isinstance(found, VariableMeaning) and found.is_timepoint else None

    def _number(self, node: Expression) -> tuple[float, float] | None:
        if isinstance(node, Name):
            found = self.scope.meaning(node.path, node.at)
            return (found.value, found.value) if isinstance(found, ValueMeaning) and is_number(found.value) else None
        if isinstance(node, Range):
            interval = self.literals.interval(node, False)
            return interval.lower, interval.upper
        value = self.literals.value(node)
        return (value, value) if is_number(value) else None

    def _relation(self, node: Relation) -> None:
        relate(self, node)

    def token(self, name: str, at: Position) -> TokenMeaning:
        """The token of a name; a complaint when it is none."""
        found = self.scope.first(name, at)
        if not isinstance(found, TokenMeaning):
            hint = nearest(name, self.scope.visible())
            raise Complaint(at, f"expected a token, found {name!r}, which is none{hint}")
        return found

    def fresh(self, base: str) -> str:
        """A name that nothing has."""
        self._count += 1
        depth, scope = 0, self.scope
        while scope.outer is not None:
            depth, scope = depth + 1, scope.outer
        return f"{base}_{depth}_{self._count}" if depth else f"{base}_{self._count}"

    def _if(self, node: If) -> None:
        then = self.inner(node.then, self.scope.inner())
        otherwise = self.inner(node.otherwise, self.scope.inner())
        test, positive = node.test, True
        while isinstance(test, Unary) and test.operator == "!":
            test, positive = test.operand, not positive
        procedure, scope = self.test(test)
        if not positive:
            then, otherwise = otherwise, then
        self.out.append(rules.Guard(procedure, scope, then, otherwise))

    def _either(self, node: Either) -> None:
        branches = tuple(self.inner(branch, self.scope.inner()) for branch in node.branches)
        self.out.append(rules.OneOf(self.fresh("either"), branches))

    def test(self, node: Expression) -> tuple[str, tuple[rules.Expression, ...]]:
        """The test of a guard as a procedure and its arguments."""
        if isinstance(node, Call) and node.function in SINGLETON_TESTS:
            one = self.expression(self._only_argument(node))
            return "eq", (one, one)
        if isinstance(node, Binary) and node.operator in COMPARISONS:
            self._check_order(node)
            real = self.is_real(node.left) or self.is_real(node.right)
            pair = self.expression(node.left, real), self.expression(node.right, real)
            return COMPARISONS[node.operator], pair[::-1] if node.operator in MIRRORED else pair
        if isinstance(node, Name):
            found = self.scope.meaning(node.path, node.at)
            if isinstance(found, VariableMeaning) and self.symbols.base(found.type) != "bool":
                return "eq", (found.ref, found.ref)
            if isinstance(found, ValueMeaning) and is_number(found.value):
                return "eq", (rules.Constant(found.value), rules.Constant(found.value))
        return "eq", (self.truth(node), rules.Constant(True))

    def _only_argument(self, node: Call) -> Expression:
        if len(node.arguments) != 1:
            raise Complaint(node.at, f"{node.function}: expected 1 argument, found {len(node.arguments)}")
        return node.arguments[0]

    def _for_each(self, node: ForEach) -> None:
        over = self.scope.meaning(node.over.path, node.over.at)
        cls = self.symbols.class_of(over.type) if isinstance(over, VariableMeaning) else None
        if cls is None or not isinstance(over, VariableMeaning):
            raise Complaint(node.over.at, f"foreach: expected an object variable, found {str(node.over)!r}")
        scope = self.scope.inner()
        scope.add(node.name, cls)
        self.out.append(rules.ForEach(node.name, over.ref, self.inner(node.body, scope)))

    # Expressions

    def is_real(self, node: Expression) -> bool:
        """Whether an expression is a variable of a real type."""
        if not isinstance(node, Name):
            return isinstance(node, Binary) and (self.is_real(node.left) or self.is_real(node.right))
        found = self.scope.meaning(node.path, node.at)
        return isinstance(found, VariableMeaning) and self.literals.is_real(found.type)

    def expression(self, node: Expression, real: bool = False) -> rules.Expression:
        """The variable or constant of an expression, made with the statements that it needs."""
        if isinstance(node, Name):
            return self._name(node)
        if isinstance(node, Number | Text | Truth):
            return rules.Constant(self.literals.value(node))
        if isinstance(node, Range):
            return rules.Constant(domain=self.literals.interval(node, real))
        if isinstance(node, Choice):
            return rules.Constant(domain=self.literals.choice(node))
        if isinstance(node, New):
            raise Complaint(node.at, "objects are created by declarations and constructors only")
        value = self.literals.value(node)
        if value is not None:
            return rules.Constant(value)
        if isinstance(node, Binary) and node.operator in ("+", "-", "*", "/"):
            return self._arithmetic(node, real)
        if isinstance(node, Unary) and node.operator == "-":
            return rules.Apply("neg", (self.expression(node.operand, real),))
        if isinstance(node, Call) and node.function not in SINGLETON_TESTS:
            return self._function(node)
        return self.truth(node)

    def _name(self, node: Name) -> rules.Expression:
        found = self.scope.meaning(node.path, node.at)
        if isinstance(found, VariableMeaning):
            return found.ref
        if isinstance(found, ValueMeaning):
            if found.enumeration is None:
                return rules.Constant(found.value)
            return rules.Constant(domain=self.literals.enumerated(str(found.value), found.enumeration))
        if isinstance(found, StateMeaning):
            message = "the state of a token is the planner's to decide; goal, rejectable, fact and activate() set it"
            raise Complaint(node.at, message, unsupported=True)
        raise Complaint(node.at, f"{str(node)!r} is a token, expected a variable of it")

    def _arithmetic(self, node: Binary, real: bool) -> rules.Expression:
        check_kinds(self, ("numeric",), (node.left, node.right))
        left, right = self.expression(node.left, real), self.expression(node.right, real)
        if node.operator != "-":
            return rules.Apply(RESULT_LAST[node.operator], (left, right))
        result = self._result("float", "difference")
        self.out.append(rules.Require("addEq", (result, right, left)))
        return result

    def _function(self, node: Call) -> rules.Expression:
        procedure = FUNCTIONS.get(node.function)
        if procedure is None:
            known = [*FUNCTIONS, *SINGLETON_TESTS]
            raise Complaint(node.at, f"there is no function named {node.function!r}{nearest(node.function, known)}")
        result = self._result("float", node.function)
        check_kinds(self, ("numeric",), node.arguments)
        scope = (result, *(self.expression(argument) for argument in node.arguments))
        try:
            self.model.procedures.get(procedure).check_scope(len(scope))
        except ModelError:
            found = len(node.arguments)
            raise Complaint(node.at, f"function {node.function}: {found} is a wrong number of arguments") from None
        self.out.append(rules.Require(procedure, scope))
        return result

    def truth(self, node: Expression) -> rules.Expression:
        """The boolean variable of an expression."""
        if isinstance(node, Truth | Name | Number):
            return self.expression(node)
        if isinstance(node, Unary) and node.operator == "!":
            return self._reified("testNot", (self.truth(node.operand),))
        if isinstance(node, Call) and node.function in SINGLETON_TESTS:
            return self._reified("testSingleton", (self.expression(self._only_argument(node)),))
        if isinstance(node, Binary) and node.operator in ("&&", "||"):
            pair = self.truth(node.left), self.truth(node.right)
            return self._reified("testAnd" if node.operator == "&&" else "testOr", pair)
        if isinstance(node, Binary) and node.operator in TESTS:
            self._check_order(node)
            real = self.is_real(node.left) or self.is_real(node.right)
            pair = self.expression(node.left, real), self.expression(node.right, real)
            return self._reified(TESTS[node.operator], pair[::-1] if node.operator in MIRRORED else pair)
        raise Complaint(node.at, "expected something that is true or false")

    def _reified(self, procedure: str, scope: tuple[rules.Expression, ...]) -> rules.Expression:
        result = self._result("bool", "truth")
        self.out.append(rules.Require(procedure, (result, *scope)))
        return result

    def _result(self, type_: str, what: str) -> rules.Ref:
        name = self.fresh(f"${what}")
        self.scope.add(name, type_)
        self.out.append(rules.Local(name, type_, decide=False))
        return rules.Ref((name,))


_TRANSLATE: dict[type, Callable[[Translator, Any], None]] = {
    Declaration: Translator._declaration,
    Assignment: Translator._assignment,
    Constraint: Translator._constraint,
    Requirement: Translator._requirement,
    Relation: Translator._relation,
    If: Translator._if,
    Either: Translator._either,
    Keep: keep,
    ForEach: Translator._for_each,
}
