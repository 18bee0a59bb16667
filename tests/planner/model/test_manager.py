"""The model manager: the input interface refuses what cannot be, the information interface knows inheritance."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from planner.constraints.standard import STANDARD
from planner.domains import Interval
from planner.errors import ModelError
from planner.model.classes import Parameter
from planner.model.manager import ModelManager
from planner.model.rules import Require, Rule, Subgoal


@pytest.fixture
def model() -> ModelManager:
    manager = ModelManager("engines", STANDARD)
    manager.add_enumeration("Level", ["low", "high"])
    manager.add_type("Fraction", Interval(0, 1, integer=False))
    manager.add_class("Engine", "Timeline", {"thrust": "float"})
    manager.add_class("Booster", "Engine", {"stages": "int"})
    manager.add_predicate("Engine", "off")
    manager.add_predicate("Engine", "burn", (Parameter("level", "Level"),), duration=(2, 9))
    manager.add_predicate("Booster", "drop", (Parameter("share", "Fraction"),), contingent=True, duration=(1, 2))
    manager.add_rule(Rule(("Engine", "burn"), (Subgoal("met_by", ("Engine", "off"), "before"),), "general"))
    manager.add_rule(Rule(("Booster", "burn"), (Subgoal("meets", ("Booster", "drop"), "after"),), "special"))
    manager.add_object("main", "Engine", {"thrust": 0.1})
    manager.add_object("left", "Booster", {"stages": 2})
    return manager


def test_hierarchy(model: ModelManager) -> None:
    assert [c.name for c in model.lineage("Booster")] == ["Booster", "Engine", "Timeline", "Object"]
    assert model.is_subclass("Booster", "Timeline")
    assert not model.is_subclass("Engine", "Booster")
    assert model.members_of("Booster") == {"thrust": "float", "stages": "int"}
    assert list(model.predicates_of("Booster")) == ["off", "burn", "drop"]
    assert list(model.attributes_of("Booster")) == ["state"]
    assert {"Object", "Timeline", "Reusable", "Engine", "Booster"} <= {c.name for c in model.classes()}


def test_predicates(model: ModelManager) -> None:
    burn = model.predicate("Booster", "burn")
    assert (burn.full_name, burn.attribute, burn.duration) == ("Engine.burn", "state", (2, 9))
    assert model.predicate_named("Booster.burn") is burn
    assert model.kind_of(burn) == "timeline"
    assert model.kind_of(model.predicate("Reusable", "uses")) == "reusable"


def test_objects_of_a_class_and_those_below_it(model: ModelManager) -> None:
    assert [o.name for o in model.objects_of("Engine").values()] == ["main", "left"]
    assert [o.name for o in model.objects_of("Booster").values()] == ["left"]
    third = model.add_object("right", "Booster")
    assert third in model.objects_of("Engine")
    assert model.objects_of("Engine").is_open
    model.close()
    assert not model.objects_of("Engine").is_open
    assert model.object_named("right") is third


def test_types(model: ModelManager) -> None:
    assert model.domain_of("Fraction") == Interval(0, 1, integer=False)
    assert list(model.domain_of("Level").values()) == ["low", "high"]
    assert list(model.domain_of("bool").values()) == [False, True]
    assert model.domain_of("Booster") == model.objects_of("Booster")
    written_out = Interval(3, 4)
    assert model.domain_of(written_out) is written_out


def test_configuration_constraints_that_apply(model: ModelManager) -> None:
    general, special = (r for r in (*model.rules_for("Engine", "burn"), model.rules_for("Booster", "burn")[0]))
    assert model.rules_for("Booster", "burn") == (special, general)
    assert model.applicable([("Engine", "burn"), ("Engine", "off")]) == {general}
    assert model.applicable([]) == frozenset()


def test_configuration_constraints_that_come_and_go(model: ModelManager) -> None:
    special, general = model.rules_for("Booster", "burn")
    assert model.changes([("Engine", "burn")], [("Booster", "burn")]) == ({special}, frozenset())
    assert model.changes([("Booster", "burn")], [("Engine", "off")]) == (frozenset(), {special, general})
    assert model.changes([("Booster", "burn")], [("Booster", "burn")]) == (frozenset(), frozenset())


def test_a_rule_added_later_applies(model: ModelManager) -> None:
    assert model.rules_for("Engine", "off") == ()
    rule = Rule(("Engine", "off"), ())
    model.add_rule(rule)
    assert model.rules_for("Booster", "off") == (rule,)


MISTAKES: list[tuple[Callable[[ModelManager], object], str]] = [
    (lambda m: m.add_class("Engine"), "class 'Engine': the name is already taken"),
    (lambda m: m.add_class("Level"), "class 'Level': the name is already taken"),
    (lambda m: m.add_class("Pump", "Engin"), "no class named 'Engin'; did you mean Engine"),
    (lambda m: m.add_enumeration("int", [1]), "type 'int': the name is already taken"),
    (lambda m: m.add_type("Fraction", Interval(0, 1)), "type 'Fraction': the name is already taken"),
    (lambda m: m.add_attribute("Timeline", "state"), "class Timeline: attribute 'state' is declared twice"),
    (lambda m: m.add_predicate("Engine", "off"), "class Engine: predicate 'off' is declared twice"),
    (lambda m: m.add_predicate("Engine", "x", (Parameter("p", "Levl"),)), "no type named 'Levl'; did you mean Level"),
    (lambda m: m.add_predicate("Engine", "x", duration=(3, 2)), r"Engine.x: expected a duration of 0 <= .* \(3, 2\)"),
    (lambda m: m.add_predicate("Engine", "x", duration=(-1, 2)), "Engine.x: expected a duration"),
    (lambda m: m.add_predicate("Engine", "x", contingent=True), "Engine.x: a contingent duration needs a finite max"),
    (lambda m: m.add_rule(Rule(("Engine", "brn"), ())), "class Engine has no predicate named 'brn'; did you mean burn"),
    (lambda m: m.add_object("main", "Engine"), "object 'main' is declared twice"),
    (lambda m: m.add_object("x", "Engine", {"thrst": 1}), "class Engine has no member 'thrst'; did you mean thrust"),
    (lambda m: m.object_named("mian"), "no object named 'mian'; did you mean main"),
    (lambda m: m.predicate_named("off"), "expected a predicate as Class.predicate, found 'off'"),
    (lambda m: m.predicate("Booster", "of"), "class Booster has no predicate named 'of'; did you mean off"),
    (lambda m: m.constrain_parameters("Booster", "off", ()), "class Booster declares no predicate named 'off'"),
]


@pytest.mark.parametrize(("mistake", "message"), MISTAKES, ids=[m for _, m in MISTAKES])
def test_mistakes(model: ModelManager, mistake: Callable[[ModelManager], object], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        mistake(model)


def test_closing_checks_what_rules_name(model: ModelManager) -> None:
    model.add_rule(Rule(("Engine", "off"), (Require("eq", ()),), "the rule"))
    with pytest.raises(ModelError, match="the rule: constraint eq: expected 2 to any arguments, found 0"):
        model.close()
    assert not model.is_closed
