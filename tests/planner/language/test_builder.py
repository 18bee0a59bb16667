"""The builder: every construct gives the schema that it reads as, and errors come where they are made."""

from __future__ import annotations

import inspect
from typing import Any

import pytest

from planner.constraints.procedure import ConstraintProcedure
from planner.constraints.standard import STANDARD
from planner.domains import Interval
from planner.errors import ModelError
from planner.language import builder as builder_module
from planner.language.builder import ClassBuilder, ModelBuilder, PredicateBuilder, RuleBuilder
from planner.model.applicable import AttributeValue
from planner.model.manager import ModelManager
from planner.model.rules import Apply, Constant, Guard, Local, OneOf, Ref, Relate, Require, Rule, Subgoal
from planner.planning import plan
from planner.problem import Goal, Problem, TokenPattern


@pytest.fixture
def builder() -> ModelBuilder:
    return ModelBuilder("bench", STANDARD)


@pytest.fixture
def line(builder: ModelBuilder) -> ClassBuilder:
    return builder.timeline("Line", {"length": "int"})


@pytest.fixture
def walk(line: ClassBuilder) -> PredicateBuilder:
    return line.predicate("walk", {"x": Interval(0, 9), "y": Interval(0, 9)}, duration=(1, 9))


def rule_of(builder: ModelBuilder, name: str = "walk") -> Rule:
    (rule,) = builder.manager.rules_for("Line", name)
    return rule


X, Y = Ref(("x",)), Ref(("y",))


def test_relations(builder: ModelBuilder, line: ClassBuilder, walk: PredicateBuilder) -> None:
    rest = line.predicate("rest", {"x": Interval(0, 9)})
    with walk.requires("here") as this:
        this.meets(rest)
        this.met_by(rest)
        this.before(rest, bounds=(10, 20))
        this.after(rest)
        this.contains(rest, bounds=[(0, 1), (2, 3)])
        this.contained_by(rest)
        this.equals(rest)
        this.relation("startsBefore", rest, (1, 4))
    rule = rule_of(builder)
    assert (rule.owner, rule.where) == (("Line", "walk"), "here")
    found = [(s.relation, s.bounds, s.predicate, s.target) for s in rule.body if isinstance(s, Subgoal)]
    target = ("Line", "rest")
    assert found == [
        ("meets", (), target, None),
        ("met_by", (), target, None),
        ("before", ((10, 20),), target, None),
        ("after", (), target, None),
        ("contains", ((0, 1), (2, 3)), target, None),
        ("contained_by", (), target, None),
        ("equals", (), target, None),
        ("startsBefore", ((1, 4),), target, None),
    ]
    assert len({s.name for s in rule.body if isinstance(s, Subgoal)}) == len(rule.body)


def test_parameters_of_targets(builder: ModelBuilder, walk: PredicateBuilder) -> None:
    with walk.requires() as this:
        token = this.meets(walk, x=this.y, y=3)
        this.require(token.start <= this.end)
        this.relate("before", token, token, bounds=(0, 5))
    subgoal, *rest = rule_of(builder).body
    assert isinstance(subgoal, Subgoal)
    name = subgoal.name
    assert rest == [
        Require("eq", (Ref((name, "x")), Y)),
        Require("eq", (Ref((name, "y")), Constant(3))),
        Require("leq", (Ref((name, "start")), Ref(("end",)))),
        Relate("before", name, name, ((0, 5),)),
    ]


def test_terms(builder: ModelBuilder, walk: PredicateBuilder) -> None:
    with walk.requires() as this:
        this.require(this.x == this.y)
        this.require(this.x != 3)
        this.require(this.x <= 3)
        this.require(this.x < 3)
        this.require(this.x >= 3)
        this.require(this.x > 3)
        this.require(this.x + this.y * 2 == this.length)
        this.require(2 * this.x == 1 + this.y)
        this.constrain("absVal", this.x, this.y)
    three = Constant(3)
    assert [(s.procedure, *s.arguments) for s in rule_of(builder).body if isinstance(s, Require)] == [
        ("eq", X, Y),
        ("neq", X, three),
        ("leq", X, three),
        ("lt", X, three),
        ("leq", three, X),
        ("lt", three, X),
        ("eq", Apply("addEq", (X, Apply("mulEq", (Y, Constant(2))))), Ref(("length",))),
        ("eq", Apply("mulEq", (X, Constant(2))), Apply("addEq", (Y, Constant(1)))),
        ("absVal", X, Y),
    ]


def test_guards_alternatives_and_locals(builder: ModelBuilder, walk: PredicateBuilder) -> None:
    with walk.requires() as this:
        other = this.local("other", "Line")
        with this.when(this.x == 1) as inside:
            inside.require(inside.y == 2)
        with this.either() as either:
            with either.alternative() as one:
                one.meets(walk)
            with either.alternative() as two:
                two.require(other == this.object)
        this.relation_to_one_of("before", [walk, walk], bounds=(0, 3))
    local, guard, choice, shorthand = rule_of(builder).body
    assert local == Local("other", "Line")
    assert guard == Guard("eq", (X, Constant(1)), (Require("eq", (Y, Constant(2))),))
    assert isinstance(choice, OneOf)
    (meets,), (require,) = choice.branches
    assert isinstance(meets, Subgoal)
    assert require == Require("eq", (Ref(("other",)), Ref(("object",))))
    assert isinstance(shorthand, OneOf)
    names = {meets.name}
    for (subgoal,) in shorthand.branches:
        assert isinstance(subgoal, Subgoal)
        assert (subgoal.relation, subgoal.bounds) == ("before", ((0, 3),))
        names.add(subgoal.name)
    assert len(names) == 3


def test_targets_of_one_object_or_of_a_member(
    builder: ModelBuilder, line: ClassBuilder, walk: PredicateBuilder
) -> None:
    thing = builder.object("one", "Line")
    with walk.requires() as this:
        this.meets(walk.of(thing))
        this.meets(walk.of("next"))
    one, two = rule_of(builder).body
    assert isinstance(one, Subgoal)
    assert isinstance(two, Subgoal)
    assert (one.target, two.target) == (Ref(("one",)), Ref(("object", "next")))


def test_parameter_constraints_hold_for_every_token(builder: ModelBuilder, walk: PredicateBuilder) -> None:
    with walk.parameters_satisfy() as this:
        this.require(this.x < this.y)
    declared = builder.manager.predicate("Line", "walk")
    assert declared.body == (Require("lt", (X, Y)),)
    assert builder.manager.rules_for("Line", "walk") == ()


def test_a_user_s_procedure() -> None:
    """A registered Python callable is a constraint like any other."""
    triple = ConstraintProcedure("triple", lambda d: (d[0], d[1].intersect(_times(d[0], 3))), 2, 2)
    builder = ModelBuilder("own", STANDARD.with_procedures(triple))
    line = builder.timeline("Line")
    step = line.predicate("step", {"x": Interval(0, 9), "y": Interval(0, 30)})
    with step.requires() as this:
        this.constrain("triple", this.x, this.y)
    builder.object("line", "Line")
    goal = Goal("g", TokenPattern("Line.step", parameters={"x": 4}))
    result = plan(builder.finish(), Problem((0, 9), goals=(goal,)))
    assert result.plan is not None
    assert result.plan.token("t0").parameters == {"x": 4, "y": 12}


def _times(domain: object, factor: int) -> Interval:
    assert isinstance(domain, Interval)
    return Interval(domain.lower * factor, domain.upper * factor)


def _unknown_variable(this: RuleBuilder, walk: PredicateBuilder) -> None:
    this.require(this.z == 1)


def _unknown_parameter(this: RuleBuilder, walk: PredicateBuilder) -> None:
    this.meets(walk, z=1)


def _unknown_procedure(this: RuleBuilder, walk: PredicateBuilder) -> None:
    this.constrain("absVel", this.x, this.y)


def _arity(this: RuleBuilder, walk: PredicateBuilder) -> None:
    this.constrain("absVal", this.x)


def _relation(this: RuleBuilder, walk: PredicateBuilder) -> None:
    this.relation("contaned_by", walk)


def _bounds(this: RuleBuilder, walk: PredicateBuilder) -> None:
    this.before(walk, bounds=(20, 10))


def _nothing(this: RuleBuilder, walk: PredicateBuilder) -> None:
    with this.either():
        pass


@pytest.mark.parametrize(
    ("state", "message"),
    [
        (_unknown_variable, "Line.walk has no variable 'z'"),
        (_unknown_parameter, "Line.walk has no variable 'z'"),
        (_unknown_procedure, "there is no constraint procedure named 'absVel'; did you mean absVal"),
        (_arity, "constraint absVal: expected 2 arguments, found 1"),
        (_relation, "there is no temporal relation named 'contaned_by'; did you mean contained_by"),
        (_bounds, r"relation before: the bounds \[20 10\] are empty"),
        (_nothing, "either of Line.walk: expected at least one alternative"),
    ],
)
def test_errors_come_where_they_are_made(walk: PredicateBuilder, state: object, message: str) -> None:
    assert callable(state)
    with pytest.raises(ModelError, match=message), walk.requires() as this:
        state(this, walk)


def test_what_is_named_must_exist_when_the_model_is_finished(line: ClassBuilder, walk: PredicateBuilder) -> None:
    with walk.requires("here") as this:
        this.meets(line.predicate_of("Line", "run"))
    with pytest.raises(ModelError, match="here: class Line has no predicate named 'run'"):
        line._builder.finish()


def test_finish_closes_the_model(builder: ModelBuilder) -> None:
    assert not builder.manager.is_closed
    model: ModelManager = builder.finish()
    assert model.is_closed


def test_the_documentation_runs() -> None:
    """The builder's docstring is the example by which the model manager's interface is told."""
    text = inspect.getdoc(builder_module)
    assert text is not None
    code = "\n".join(line[4:] for line in text.splitlines() if line.startswith("    ") or not line)
    names: dict[str, Any] = {"ModelBuilder": ModelBuilder, "STANDARD": STANDARD, "AttributeValue": AttributeValue}
    exec(code, names)
    assert isinstance(names["manager"], ModelManager)
    assert names["manager"].is_closed
    assert [c.value for c in names["come"]] == [names["gaspra"]]
    assert [c.value for c in names["go"]] == [names["ida"]]
