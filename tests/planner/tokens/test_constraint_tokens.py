"""Constraint tokens: an attribute keeps to some values over an interval and changes among them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from planner.checker import check
from planner.constraints.standard import STANDARD
from planner.database import PlanDatabase
from planner.domains import Interval
from planner.errors import ModelError, ProblemError
from planner.language.builder import ModelBuilder, RuleBuilder
from planner.model.manager import ModelManager
from planner.operations import Operation, Operations, Refusal
from planner.plan import FlexiblePlan, PlanToken, PlanValue
from planner.planning import plan as make_plan
from planner.problem import ConstraintPattern, Goal, Problem, TokenPattern
from planner.tokens.token import Token, TokenState

HORIZON = (0, 100)


def spacecraft(requires: Callable[[RuleBuilder, dict[str, object]], None] | None = None) -> ModelManager:
    """An attitude that points and turns, and an engine with a rule on it."""
    model = ModelBuilder("spacecraft", STANDARD)
    target = model.enumeration("Target", ["earth", "Ida", "Gaspra"])
    attitude, engine = model.timeline("Attitude"), model.timeline("Engine")
    point = attitude.predicate("pointAt", {"target": target})
    turn = attitude.predicate("turn", {"from_": target, "to_": target}, duration=(5, 10))
    spin = attitude.predicate("spin", {"rate": Interval(0, 9)}, duration=(3, 30))
    thrust = engine.predicate("thrust", {"target": target}, duration=(20, 20))
    with point.requires() as this:
        this.met_by(turn, to_=this.target)
        this.meets(turn, from_=this.target)
    with turn.requires() as this:
        this.require(this.from_ != this.to_)
        this.met_by(point, target=this.from_)
        this.meets(point, target=this.to_)
    model.object("attitude", "Attitude")
    model.object("engine", "Engine")
    if requires is not None:
        with thrust.requires() as this:
            requires(this, {"point": point, "turn": turn, "spin": spin})
    return model.finish()


def keeps_pointing(this: RuleBuilder, values: dict[str, object]) -> None:
    """While it thrusts, the attitude points at the target or spins slowly."""
    point, spin = values["point"], values["spin"]
    this.throughout(point.where(target=this.target), spin.where(rate=[0, 2]))  # type: ignore[attr-defined]


def open_database(model: ModelManager, *patterns: ConstraintPattern) -> PlanDatabase:
    database = PlanDatabase(model, HORIZON)
    for number, pattern in enumerate(patterns):
        database.confine(pattern, f"limit{number}")
    database.network.propagate()
    return database


def limit(*values: TokenPattern, start: int = 20, end: int = 60) -> ConstraintPattern:
    return ConstraintPattern("Attitude.state", values, "attitude", (start, start), (end, end))


IDA = TokenPattern("Attitude.pointAt", parameters={"target": "Ida"})
ASTEROIDS = TokenPattern("Attitude.pointAt", parameters={"target": ("Ida", "Gaspra")})
SLOW = TokenPattern("Attitude.spin", parameters={"rate": (0, 2)})


def at(database: PlanDatabase, name: str, predicate: str, start: tuple[int, int], end: tuple[int, int]) -> None:
    database.state(TokenPattern(f"Attitude.{predicate}", "attitude", {}, start, end), name, "rejectable")
    database.network.propagate()


def named(database: PlanDatabase) -> dict[str, Token]:
    return {token.name: token for token in database.tokens.tokens}


def issued(found: Operation | Refusal) -> Operation:
    assert isinstance(found, Operation), found
    return found


# In the database, by the three operations.


def test_a_value_that_overlaps_is_an_allowed_one() -> None:
    database = open_database(spacecraft(), limit(ASTEROIDS, SLOW))
    at(database, "inside", "pointAt", (25, 25), (30, 30))
    at(database, "spinning", "spin", (30, 30), (40, 40))
    at(database, "outside", "pointAt", (60, 60), (70, 70))
    operations = Operations(database)
    limiting = issued(operations.insert("limit0", "attitude"))
    for position, name in enumerate(("inside", "spinning", "outside")):
        issued(operations.insert(name, "attitude", position))
    tokens = named(database)
    assert list(tokens["inside"].parameters["target"].domain.values()) == ["Ida", "Gaspra"]
    assert list(tokens["outside"].parameters["target"].domain.values()) == ["earth", "Ida", "Gaspra"]
    # Of an interval only the ends can go, and what is allowed is 0 or 2.
    assert tokens["spinning"].parameters["rate"].domain == Interval(0, 2)
    assert not operations.restrict(tokens["spinning"].parameters["rate"], Interval(1, 1))
    assert [t.name for t in database.tokens.slots_under(tokens["limit0"])] == ["inside", "spinning", "outside"]
    operations.undo(limiting)
    assert list(tokens["inside"].parameters["target"].domain.values()) == ["earth", "Ida", "Gaspra"]
    assert tokens["spinning"].parameters["rate"].domain == Interval(0, 9)
    assert tokens["limit0"].state is TokenState.INACTIVE


def test_a_value_that_is_not_allowed_is_before_or_after() -> None:
    database = open_database(spacecraft(), limit(IDA))
    at(database, "early", "turn", (10, 30), (15, 70))
    at(database, "late", "spin", (16, 90), (19, 95))
    operations = Operations(database)
    issued(operations.insert("limit0", "attitude"))
    issued(operations.insert("early", "attitude"))
    issued(operations.insert("late", "attitude", 1))
    tokens = named(database)
    assert tokens["early"].end.domain.upper == 20
    assert tokens["late"].start.domain.lower == 16
    side = database.tokens.variables["limit0 over late"]
    assert list(side.domain.values()) == ["before", "after"]
    after = issued(operations.restrict(side, side.domain.keep(("after",))))
    assert tokens["late"].start.domain.lower == 60
    operations.undo(after)
    assert tokens["late"].start.domain.lower == 16
    refused = operations.restrict(tokens["late"].start, Interval(30, 40))
    assert isinstance(refused, Refusal)
    assert any("limit0" in why for why in refused.explanation)


def test_two_constraint_tokens_may_overlap_and_both_hold() -> None:
    slow = TokenPattern("Attitude.spin", parameters={"rate": (0, 1, 2)})
    quick = TokenPattern("Attitude.spin", parameters={"rate": (2, 3)})
    database = open_database(spacecraft(), limit(slow, start=0, end=50), limit(quick, start=40, end=90))
    at(database, "spin", "spin", (42, 42), (45, 45))
    operations = Operations(database)
    for name in ("spin", "limit0", "limit1"):
        issued(operations.insert(name, "attitude"))
    assert named(database)["spin"].parameters["rate"].domain == Interval(2, 2)


def test_an_attribute_may_be_kept_without_a_value() -> None:
    database = open_database(spacecraft(), limit())
    at(database, "spin", "spin", (22, 62), (25, 65))
    operations = Operations(database)
    issued(operations.insert("limit0", "attitude"))
    issued(operations.insert("spin", "attitude"))
    assert named(database)["spin"].start.domain == Interval(60, 62)


# In search, the plan and its judge.


def thrusting(target: str = "Ida") -> Problem:
    goals = (
        Goal("thrust", TokenPattern("Engine.thrust", parameters={"target": target}, start=(30, 40))),
        Goal(
            "look", TokenPattern("Attitude.pointAt", parameters={"target": "Gaspra"}, start=(42, None), end=(None, 90))
        ),
    )
    return Problem(HORIZON, (TokenPattern("Attitude.pointAt", parameters={"target": "earth"}),), goals=goals)


@pytest.mark.parametrize("engine", ["chronological", "backjumping"])
def test_a_rule_keeps_an_attribute_to_values(engine: str) -> None:
    model, problem = spacecraft(keeps_pointing), thrusting()
    result = make_plan(model, problem, engine=engine)
    plan = result.plan
    assert plan is not None
    assert not result.dropped
    assert check(plan, model, problem) == ()
    (confined,) = [t for t in plan.tokens if t.allowed is not None]
    assert confined.allowed == (
        PlanValue("Attitude.pointAt", {"target": "Ida"}),
        PlanValue("Attitude.spin", {"rate": (0, 2)}),
    )
    thrust = next(t for t in plan.tokens if t.predicate == "Engine.thrust")
    assert confined.master == thrust.id
    assert (confined.start, confined.end) == (thrust.start, thrust.end)
    look = next(t for t in plan.tokens if t.goal == "look")
    assert look.start[0] is not None
    assert thrust.end[0] is not None
    assert look.start[0] >= thrust.end[0] + 5
    assert FlexiblePlan.from_json(plan.to_json()) == plan


def test_what_cannot_be_kept_is_explained() -> None:
    model = spacecraft(keeps_pointing)
    spin = Goal("spin", TokenPattern("Attitude.spin", parameters={"rate": 5}, start=(41, 41)))
    problem = Problem(HORIZON, goals=(thrusting().goals[0], spin))
    result = make_plan(model, problem)
    (dropped,) = result.dropped
    assert dropped.id == "spin"
    assert dropped.kind == "outbid"
    assert "thrust" in dropped.reason


@pytest.mark.parametrize("engine", ["chronological", "backjumping"])
def test_a_problem_keeps_an_attribute_to_values(engine: str) -> None:
    model = spacecraft()
    constraints = (limit(TokenPattern("Attitude.pointAt"), start=0, end=70),)
    problem = replace(thrusting(), constraints=constraints, goals=thrusting().goals[1:])
    result = make_plan(model, problem, engine=engine)
    assert result.plan is not None
    assert not result.dropped
    assert check(result.plan, model, problem) == ()
    assert not any(t.end[0] is not None and t.end[0] < 75 for t in result.plan.tokens if t.predicate == "Attitude.turn")
    without = make_plan(model, replace(problem, constraints=()), engine=engine).plan
    assert without is not None
    assert {v.kind for v in check(without, model, problem)} == {"constraint"}


def test_values_may_change_under_a_constraint_token() -> None:
    """Turning between asteroids is allowed, so that a plan changes its value three times under one constraint token."""
    model = spacecraft()
    turns = TokenPattern("Attitude.turn")
    goals = tuple(
        Goal(name, TokenPattern("Attitude.pointAt", parameters={"target": name}, start=start, end=(None, 70)))
        for name, start in (("Ida", (20, 20)), ("Gaspra", (40, 60)))
    )
    problem = Problem(HORIZON, goals=goals, constraints=(limit(ASTEROIDS, turns, start=25, end=65),))
    result = make_plan(model, problem)
    assert result.plan is not None
    assert not result.dropped
    assert check(result.plan, model, problem) == ()
    confined = next(t for t in result.plan.tokens if t.allowed is not None)
    under = [t.predicate for t in result.plan.hosts() if (t.end[0] or 0) > 25 and (t.start[1] or 0) < 65]
    assert len(under) >= 3
    assert confined.master is None


# The judge on planted violations.


def accepted() -> tuple[ModelManager, Problem, FlexiblePlan]:
    model, problem = spacecraft(keeps_pointing), thrusting()
    plan = make_plan(model, problem).plan
    assert plan is not None
    return model, problem, plan


def with_limit(plan: FlexiblePlan, change: Callable[[PlanToken], PlanToken]) -> FlexiblePlan:
    return replace(plan, tokens=tuple(change(t) if t.allowed is not None else t for t in plan.tokens))


def test_a_value_under_a_constraint_token_that_it_does_not_allow() -> None:
    model, problem, plan = accepted()
    other = with_limit(plan, lambda t: replace(t, allowed=(PlanValue("Attitude.pointAt", {"target": "earth"}),)))
    found = check(other, model, problem)
    assert {v.kind for v in found} == {"constraint", "configuration"}
    host = next(t for t in plan.hosts() if t.parameters.get("target") == "Ida" and t.attribute == "state")
    said = next(v for v in found if v.kind == "constraint")
    assert "target Ida may overlap" in said.explanation
    assert set(said.tokens) <= {t.id for t in plan.tokens}
    assert host is not None


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        (lambda t: replace(t, allowed=(*t.allowed, PlanValue("Attitude.turn"))), "configuration"),
        (lambda t: replace(t, allowed=(PlanValue("Attitude.pointAt"),)), "configuration"),
        (lambda t: replace(t, allowed=None), "structure"),
        (lambda t: replace(t, allowed=(PlanValue("Engine.thrust"),)), "structure"),
        (lambda t: replace(t, allowed=(PlanValue("Attitude.pointAt", {"aim": "Ida"}),)), "structure"),
        (lambda t: replace(t, allowed=(PlanValue("Attitude.pointAt", {"target": "Mars"}),)), "parameter"),
        (lambda t: replace(t, attribute="mode"), "structure"),
        (lambda t: replace(t, end=(0, 90)), "bounds"),
    ],
)
def test_a_changed_constraint_token_is_refused(change: Callable[[PlanToken], PlanToken], kind: str) -> None:
    model, problem, plan = accepted()
    assert kind in {v.kind for v in check(with_limit(plan, change), model, problem)}


def test_a_rule_without_its_constraint_token_lacks_support() -> None:
    model, problem, plan = accepted()
    gone = next(t.id for t in plan.tokens if t.allowed is not None)
    kept = [c for c in plan.constraints if gone not in (c.from_.partition(".")[0], c.to.partition(".")[0])]
    left = replace(plan, tokens=tuple(t for t in plan.tokens if t.id != gone), constraints=tuple(kept))
    (found,) = [v for v in check(left, model, problem) if v.kind == "configuration"]
    assert "keep to Attitude.pointAt or Attitude.spin by equals" in found.explanation


# What means nothing.


@pytest.mark.parametrize(
    ("pattern", "message"),
    [
        (ConstraintPattern("Attitude.mode", (IDA,)), "class Attitude has no timeline named 'mode'"),
        (ConstraintPattern("Attitude.state", (TokenPattern("Attitude.pointAtt"),)), "no predicate named .pointAtt."),
        (ConstraintPattern("Attitude.state", (TokenPattern("Engine.thrust"),)), "Engine.thrust is no value of"),
        (ConstraintPattern("Attitude.state", (IDA, ASTEROIDS)), "Attitude.pointAt is given twice"),
        (ConstraintPattern("Attitude.state", (IDA,), "engine"), "object engine has no"),
        (ConstraintPattern("Attitude.state", (IDA,), start=(5, 3)), "bounds .5 3. are empty"),
        (
            ConstraintPattern("Attitude.state", (TokenPattern("Attitude.pointAt", None, {"targetx": "Ida"}),)),
            "Attitude.pointAt has no parameter 'targetx'",
        ),
        (
            ConstraintPattern("Attitude.state", (TokenPattern("Attitude.pointAt", None, {"target": "Idax"}),)),
            "'Idax' is not one of",
        ),
    ],
)
def test_a_constraint_that_means_nothing_is_an_error(pattern: ConstraintPattern, message: str) -> None:
    with pytest.raises(ProblemError, match=message):
        make_plan(spacecraft(), Problem(HORIZON, constraints=(pattern,)))


def test_a_rule_that_allows_what_is_no_value_is_an_error() -> None:
    def wrong(this: RuleBuilder, values: dict[str, object]) -> None:
        this.throughout(values["point"], values["point"])  # type: ignore[arg-type]

    with pytest.raises(ModelError, match="given twice"):
        spacecraft(wrong)
