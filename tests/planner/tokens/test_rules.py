"""Rule instances: guards fire when decided, undo withdraws them; alternatives, members, what merged tokens share."""

from __future__ import annotations

import pytest

from planner.constraints.network import Inconsistency
from planner.constraints.standard import STANDARD
from planner.database import PlanDatabase
from planner.domains import FALSE, TRUE, Domain, Interval
from planner.errors import ModelError
from planner.language.builder import ModelBuilder, RuleBuilder
from planner.model.manager import ModelManager
from planner.model.rules import Constant, Guard, Ref, Relate, Require, Rule, Statement, Subgoal
from planner.problem import TokenPattern
from planner.search.decisions import Codesignate, Insert
from planner.search.engines import ENGINES
from planner.search.outcome import Limits
from planner.tokens.token import Token, TokenState


def guarded(*body: Statement) -> ModelManager:
    """`A.a(mode, level)` with this rule, beside timelines B and C."""
    builder = ModelBuilder("guarded", STANDARD)
    builder.enumeration("Mode", ["slow", "fast", "off"])
    a, b, c = (builder.timeline(name) for name in "ABC")
    a.predicate("a", {"mode": "Mode", "level": Interval(0, 9)}, duration=(2, 6))
    b.predicate("b", {"mode": "Mode"})
    c.predicate("c")
    builder.manager.add_rule(Rule(("A", "a"), body, "the rule"))
    for name in "ABC":
        builder.object(name.lower(), name)
    return builder.finish()


def active(model: ModelManager) -> tuple[PlanDatabase, Token]:
    database = PlanDatabase(model, (0, 50))
    token = database.state(TokenPattern("A.a"), "goal", "goal")
    database.network.propagate()
    Insert(token, model.object_named("a"), 0).apply(database)
    return database, token


def decide(database: PlanDatabase, token: Token, parameter: str, *values: object) -> None:
    variable = token.parameters[parameter]
    domain: Domain = variable.domain
    if isinstance(domain, Interval):
        (value,) = values
        assert isinstance(value, int)
        database.network.restrict(variable, Interval(value, value), "test")
    else:
        database.network.restrict(variable, domain.keep(values), "test")
    database.network.propagate()


def names(database: PlanDatabase) -> list[str]:
    return [t.name for t in database.tokens.tokens]


FAST = (Ref(("mode",)), Constant("fast"))
NEED_B = Subgoal("contained_by", ("B", "b"), "held")
NEED_C = Subgoal("meets", ("C", "c"), "next")


def test_a_guard_fires_when_it_is_decided_and_not_before() -> None:
    database, token = active(guarded(Guard("eq", FAST, (NEED_B,), (NEED_C,))))
    assert names(database) == ["goal"]
    decide(database, token, "mode", "fast", "off")
    assert names(database) == ["goal"]
    decide(database, token, "mode", "fast")
    assert names(database) == ["goal", "goal/held"]


def test_the_other_branch_applies_as_soon_as_the_test_cannot_hold() -> None:
    database, token = active(guarded(Guard("eq", FAST, (NEED_B,), (NEED_C,))))
    decide(database, token, "mode", "slow", "off")
    assert names(database) == ["goal", "goal/next"]
    assert not token.parameters["mode"].domain.is_singleton


def test_undo_withdraws_a_guard_and_it_can_fire_the_other_way() -> None:
    database, token = active(guarded(Guard("eq", FAST, (NEED_B,), (NEED_C,))))
    for value, expected in (("fast", "goal/held"), ("slow", "goal/next"), ("fast", "goal/held")):
        depth = database.trail.push()
        decide(database, token, "mode", value)
        assert names(database) == ["goal", expected]
        database.trail.pop_to(depth)
        assert names(database) == ["goal"]
        assert list(database.tokens.open_tokens) == []


def test_guards_inside_guards() -> None:
    level = Guard("lt", (Ref(("level",)), Constant(5)), (NEED_C,))
    database, token = active(guarded(Guard("eq", FAST, (NEED_B, level))))
    decide(database, token, "level", 3)
    assert names(database) == ["goal"]
    decide(database, token, "mode", "fast")
    assert names(database) == ["goal", "goal/held", "goal/next"]


def test_what_a_guard_adds_is_propagated_at_once() -> None:
    impossible = Require("lt", (Ref(("end",)), Ref(("start",))))
    database, token = active(guarded(Guard("eq", FAST, (impossible,))))
    decide(database, token, "mode", "fast", "slow")
    with pytest.raises(Inconsistency):
        decide(database, token, "mode", "fast")


def test_tokens_that_a_rule_names_are_related() -> None:
    relation = Relate("startsBefore", "held", "next", ((3, 5),))
    database, token = active(guarded(NEED_B, NEED_C, relation, Relate("starts", "this", "held")))
    held, following = database.tokens.tokens[1:]
    temporal = database.temporal
    assert temporal.distance(held.start.timepoint, following.start.timepoint) == (3, 5)
    assert temporal.distance(token.start.timepoint, held.start.timepoint) == (0, 0)
    assert temporal.distance(token.end.timepoint, following.start.timepoint) == (0, 0)


def test_a_parameter_of_a_subgoal_equals_this_ones() -> None:
    same = Require("eq", (Ref(("held", "mode")), Ref(("mode",))))
    database, token = active(guarded(NEED_B, same))
    decide(database, token, "mode", "off")
    held = database.tokens.tokens[1]
    assert held.parameters["mode"].domain.value == "off"


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        (Require("eq", (Ref(("nothing",)), Constant(1))), "the rule: 'nothing' means nothing here"),
        (Require("eq", (Ref(("start", "x")), Constant(1))), r"the rule: goal.start is a time, it has no member 'x'"),
        (Require("eq", (Ref(("mode", "x")), Constant(1))), "the rule: goal.mode is not an object, it has no member"),
        (Require("eq", (Ref(("object", "x")), Constant(1))), "object a of class A has no member 'x'"),
        (Require("eq", (Ref(("this",)), Constant(1))), "the rule: this is a token, expected a variable"),
        (Relate("before", "this", "mode"), "the rule: 'mode' is not a token"),
    ],
)
def test_a_rule_that_names_what_is_not_there(statement: Statement, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        active(guarded(statement))


SHORT = (Ref(("duration",)), Constant(3))


@pytest.mark.parametrize("test", ["eq", "neq", "leq", "lt"])
@pytest.mark.parametrize("blocked", ["b", "c"])
def test_a_guard_on_times_is_decided_by_the_search(test: str, blocked: str) -> None:
    """A flexible plan leaves the duration open, but all its schedules are on the side of the test planned for."""
    holds = {"eq": lambda d: d == 3, "neq": lambda d: d != 3, "leq": lambda d: d <= 3, "lt": lambda d: d < 3}[test]
    with_c = Subgoal("contained_by", ("C", "c"), "beside")
    database = PlanDatabase(guarded(Guard(test, SHORT, (NEED_B,), (with_c,))), (0, 50))
    token = database.state(TokenPattern("A.a"), "goal", "goal")
    # Only half of the horizon is free for what one of the branches needs.
    database.state(TokenPattern(f"{blocked.upper()}.{blocked}", start=(0, 0), end=(60, 60)), "fact", "fact")
    database.state(TokenPattern(f"{blocked.upper()}.{blocked}", start=(60, 60), end=(61, 61)), "later", "fact")
    database.network.propagate()
    assert ENGINES["chronological"].search(database, Limits()).complete
    asked = {t.predicate.name for t in database.tokens.tokens if t.role == "subgoal"}
    low, high = database.temporal.distance(token.start.timepoint, token.end.timepoint)
    assert {holds(d) for d in range(low, high + 1)} == {asked == {"b"}}
    assert asked in ({"b"}, {"c"})


def test_a_guard_between_times_of_two_tokens_is_decided_by_the_search() -> None:
    order = Guard("leq", (Ref(("held", "end")), Ref(("next", "end"))), (Require("eq", (Ref(("level",)), Constant(1))),))
    database = PlanDatabase(guarded(NEED_B, NEED_C, order), (0, 50))
    token = database.state(TokenPattern("A.a", parameters={"level": (2, 3)}, end=(10, 20)), "goal", "goal")
    database.network.propagate()
    assert ENGINES["chronological"].search(database, Limits()).complete
    held, following = (t for t in database.tokens.tokens if t.master is token)
    assert database.temporal.distance(following.end.timepoint, held.end.timepoint)[0] >= 1


# Alternatives


def either(*, first: str, second: str) -> ModelManager:
    builder = ModelBuilder("either", STANDARD)
    lines = {name: builder.timeline(name) for name in "ABC"}
    targets = {name: lines[name].predicate("hold", duration=(1, 9)) for name in "BC"}
    need = lines["A"].predicate("need", duration=(2, 2))
    with need.requires() as this, this.either() as alternatives:
        for name in (first, second):
            with alternatives.alternative() as alternative:
                alternative.contained_by(targets[name])
    for name in "ABC":
        builder.object(name.lower(), name)
    return builder.finish()


@pytest.mark.parametrize(("first", "second"), [("B", "C"), ("C", "B")])
def test_the_first_alternative_is_tried_first(first: str, second: str) -> None:
    model = either(first=first, second=second)
    database = PlanDatabase(model, (0, 9))
    database.state(TokenPattern("A.need"), "goal", "goal")
    database.network.propagate()
    assert ENGINES["chronological"].search(database, Limits()).complete
    assert {t.predicate.full_name for t in database.tokens.tokens} == {"A.need", f"{first}.hold"}


def test_the_other_alternative_is_taken_when_the_first_cannot_be() -> None:
    model = either(first="B", second="C")
    database = PlanDatabase(model, (0, 9))
    database.state(TokenPattern("A.need", start=(4, 4)), "goal", "goal")
    database.state(TokenPattern("B.hold", start=(5, 5), end=(8, 9)), "in the way", "fact")
    database.network.propagate()
    assert ENGINES["chronological"].search(database, Limits()).complete
    states = {t.predicate.full_name: t.state for t in database.tokens.tokens}
    assert states == {"A.need": TokenState.ACTIVE, "B.hold": TokenState.ACTIVE, "C.hold": TokenState.ACTIVE}


def test_no_alternative_can_be() -> None:
    model = either(first="B", second="C")
    database = PlanDatabase(model, (0, 9))
    database.state(TokenPattern("A.need", start=(4, 4)), "goal", "goal")
    for line in "BC":
        database.state(TokenPattern(f"{line}.hold", start=(5, 5), end=(8, 9)), f"{line} in the way", "fact")
    database.network.propagate()
    outcome = ENGINES["chronological"].search(database, Limits())
    assert (outcome.complete, outcome.exhausted) == (False, True)


# Objects and members


def fleet(rule: str) -> ModelManager:
    builder = ModelBuilder("fleet", STANDARD)
    builder.enumeration("Name", ["north", "south"])
    builder.manager.add_class("Dock", "Object", {"depth": "int", "open": "bool", "name": "Name"})
    docks = [
        builder.object("one", "Dock", {"depth": 3, "open": True, "name": "north"}),
        builder.object("two", "Dock", {"depth": 8, "open": False, "name": "south"}),
    ]
    ship = builder.timeline("Ship", {"home": "Dock", "draught": "int"})
    at = ship.predicate("at", {"dock": "Dock"}, duration=(1, 9))
    with at.requires() as this:
        _fleet_rule(this, rule)
    for dock, draught in zip(docks, (2, 5), strict=True):
        builder.object(f"ship{draught}", "Ship", {"home": dock, "draught": draught})
    return builder.finish()


def _fleet_rule(this: RuleBuilder, rule: str) -> None:
    dock_depth, draught = Ref(("dock", "depth")), Ref(("draught",))
    match rule:
        case "depth":
            this._statements.append(Require("leq", (draught, dock_depth)))
        case "home":
            this._statements.append(Require("eq", (Ref(("dock",)), Ref(("home",)))))
        case "open":
            this._statements.append(Require("eq", (Ref(("dock", "open")), Constant(True))))
        case "name":
            this._statements.append(Require("eq", (Ref(("dock", "name")), Constant("south"))))


@pytest.mark.parametrize(
    ("rule", "expected"),
    [
        ("depth", {("ship2", "one"), ("ship2", "two"), ("ship5", "two")}),
        ("home", {("ship2", "one"), ("ship5", "two")}),
        ("open", {("ship2", "one"), ("ship5", "one")}),
        ("name", {("ship2", "two"), ("ship5", "two")}),
    ],
)
def test_members_of_objects_that_are_not_decided_yet(rule: str, expected: set[tuple[str, str]]) -> None:
    model = fleet(rule)
    found = set()
    for ship in ("ship2", "ship5"):
        for dock in ("one", "two"):
            database = PlanDatabase(model, (0, 20))
            token = database.state(TokenPattern("Ship.at"), "goal", "goal")
            database.network.propagate()
            Insert(token, model.object_named(ship), 0).apply(database)
            try:
                decide(database, token, "dock", model.object_named(dock))
            except Inconsistency:
                continue
            found.add((ship, dock))
    assert found == expected


def test_constants_that_are_equal_to_a_dictionary_stay_apart() -> None:
    tokens = PlanDatabase(fleet("home"), (0, 20)).tokens
    constants = [tokens.constant(value) for value in (1, True, 0, False)]
    assert [repr(c.domain) for c in constants] == ["[1 1]", repr(TRUE), "[0 0]", repr(FALSE)]


# Codesignation and roles


def test_codesignated_tokens_share_every_variable() -> None:
    model = guarded()
    database, host = active(model)
    other = database.state(TokenPattern("A.a", parameters={"mode": ("fast", "off")}, start=(3, 9)), "other", "goal")
    database.network.propagate()
    Codesignate(other, host).apply(database)
    assert (other.state, other.host) == (TokenState.MERGED, host)
    for one, two in zip(host.parameters.values(), other.parameters.values(), strict=True):
        assert one.domain == two.domain
    assert host.start.domain == other.start.domain == Interval(3, 9)
    decide(database, host, "mode", "off")
    assert other.parameters["mode"].domain.value == "off"


def test_rejection_is_for_rejectable_tokens_and_the_last_resort() -> None:
    model = guarded()
    database = PlanDatabase(model, (0, 9))
    database.state(TokenPattern("A.a", start=(0, 0), duration=(6, 6)), "first", "rejectable")
    database.state(TokenPattern("A.a", start=(1, 1), duration=(6, 6)), "second", "rejectable")
    database.network.propagate()
    assert ENGINES["chronological"].search(database, Limits()).complete
    assert sorted(t.state for t in database.tokens.tokens) == [TokenState.ACTIVE, TokenState.REJECTED]


def test_inherited_rules_apply_to_objects_of_a_subclass() -> None:
    builder = ModelBuilder("inheritance", STANDARD)
    engine, gauge = builder.timeline("Engine"), builder.timeline("Gauge")
    thrust = engine.predicate("thrust", duration=(1, 5))
    watch = gauge.predicate("watch")
    with thrust.requires("general") as this:
        this.contained_by(watch)
    builder.manager.add_class("Booster", "Engine")
    special = Rule(("Booster", "thrust"), (Subgoal("meets", ("Gauge", "watch"), "after"),), "special")
    builder.manager.add_rule(special)
    for name in ("Engine", "Booster", "Gauge"):
        builder.object(name.lower(), name)
    model = builder.finish()
    for name, expected in (("engine", 1), ("booster", 2)):
        database = PlanDatabase(model, (0, 30))
        token = database.state(TokenPattern("Engine.thrust", name), "goal", "goal")
        database.network.propagate()
        Insert(token, model.object_named(name), 0).apply(database)
        assert len(database.tokens.open_tokens) == expected
