"""What this project adds to NDDL: attributes, alternatives, named numbers, texts for included files."""

from __future__ import annotations

from dataclasses import replace

import pytest

from planner.checker import check
from planner.constraints.standard import STANDARD
from planner.errors import ModelError
from planner.language.nddl.builder import load_text
from planner.language.nddl.errors import NddlError, Report, Source
from planner.language.nddl.parser import parse
from planner.language.nddl.printer import render
from scenarios.ds1.capability import capability_of
from scenarios.ds1.domain import header_of
from sim import SpacecraftConfig
from tests.planner.language.nddl.running import Run, complaints
from tests.planner.test_checker import ds1

CAMERA = """
class Camera {
  attribute mode { predicate off {} predicate ready {} }
  attribute switch { predicate on {} exogenous predicate stuck {} }
}
Camera::ready { contained_by(on o); }
class Better extends Camera { attribute mode { predicate best {} } }
Better camera = new Better();
"""


def test_an_object_has_a_timeline_for_each_attribute() -> None:
    run = Run(CAMERA + "goal(camera.ready r); goal(camera.off o); goal(camera.best b); r before o; o before b;")
    assert run.plan is not None
    lanes = {f"{t.object}.{t.attribute}": len(t.slots) for t in run.plan.timelines}
    assert lanes == {"camera.mode": 3, "camera.switch": 1}
    assert run.predicates() == ["Better.best", "Camera.off", "Camera.on", "Camera.ready"]


def test_alternatives_the_first_one_first() -> None:
    rules = "Camera::off { either { meets(ready r); } or { meets(best b); } }".replace("Camera", "Better")
    wanted = CAMERA + rules + "goal(camera.off o); eq(o.end, 50);"
    assert Run(wanted).predicates() == ["Camera.off", "Camera.on", "Camera.ready"]
    # A switch that never goes on leaves the second alternative only.
    assert Run(wanted + "fact(camera.stuck s); eq(s.start, 0); eq(s.end, 1000);").predicates() == [
        "Better.best",
        "Camera.off",
        "Camera.stuck",
    ]


def test_an_alternative_in_the_problem() -> None:
    assert Run("int x = [0 9]; either { x < 3; x > 5; } or { x == 7; }").value("x") == 7


def test_named_numbers_are_numbers() -> None:
    run = Run(
        """
        int SHORT = 3, LONG = 6; float DRAW = 2.5;
        class Attitude extends Timeline { predicate slew { contingent duration = [SHORT LONG]; } predicate rest {} }
        Attitude::slew { after[SHORT LONG](rest r); equals(power.uses u); u.quantity == DRAW; r.end + LONG <= start; }
        Attitude attitude = new Attitude();
        Reusable power = new Reusable(DRAW, 0.0);
        goal(attitude.slew s); s.start == 20;
        """
    )
    assert run.plan is not None
    by_predicate = {t.predicate: t for t in run.plan.tokens}
    assert by_predicate["Attitude.slew"].duration == (3, 6)
    assert by_predicate["Reusable.uses"].parameters == {"quantity": 2.5}
    assert by_predicate["Attitude.rest"].end == (14, 14)


def test_a_named_number_in_a_guard_is_specified() -> None:
    rule = "class A extends Timeline { predicate p {} predicate q {} } A::p { if (%s) { meets(q next); } }"
    rest = "int N = 5; A a = new A(); goal(a.p t); eq(t.end, 50);"
    for test, expected in (("N", 2), ("isSpecified(N)", 2), ("N == 5", 2), ("N == 4", 1)):
        assert len(Run(rule % test + rest).predicates()) == expected


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("int x; either { x == 1; }", "1:26 expected 'or {': an 'either' has two branches or more, found the end"),
        ("class A { attribute mode { int x; } }", "1:28 expected a predicate or '}' in the attribute 'mode'"),
        (
            "class A { attribute mode { predicate p {} } predicate p {} }",
            "1:45 class A: predicate 'p' is declared twice",
        ),
        (
            "int LOW = 5; class A extends Timeline { predicate p { contingent duration = [LOWW 9]; } }",
            "1:78 expected a number as the bound of an interval, found LOWW",
        ),
    ],
)
def test_what_is_wrong_with_them(text: str, complaint: str) -> None:
    assert any(found.startswith(complaint) for found in complaints(text)), complaints(text)


def test_texts_for_included_files() -> None:
    text = '#include "given.nddl"\n#include "given.nddl"\nint x = [0 N]; x > 2;'
    model, program, _ = load_text(text, STANDARD, headers={"given.nddl": "int N = 3;"}, model_name="mine")
    assert model.name == "mine"
    assert program.symbols.constants == {"N": 3}
    with pytest.raises(NddlError, match=r"^given.nddl:1:8: "):
        load_text(text, STANDARD, headers={"given.nddl": "int N ="})


def test_the_flown_domain_prints_and_says_what_nature_decides() -> None:
    model, _, plan = ds1()
    found = [p for c in model.classes() for p in c.predicates.values()]
    contingent = {p.full_name: p.duration for p in found if p.contingent}
    assert (contingent["Attitude.turn"], contingent["Camera.warmUp"]) == ((300, 900), (600, 902))
    assert "Camera.stuckOn" in [p.full_name for p in found if p.exogenous]
    used = {t.predicate for t in plan.tokens if t.contingent}
    assert {"Attitude.turn", "Camera.takeImage"} <= used <= set(contingent)


def test_a_target_without_a_name_of_the_language() -> None:
    capability = replace(capability_of(SpacecraftConfig()), targets=("earth", "asteroid-1"))
    with pytest.raises(ModelError, match="expected names of letters, digits and underscores, found 'asteroid-1'"):
        header_of(capability)


def test_words_of_the_extensions_are_names_elsewhere() -> None:
    text = "class A { attribute either; int attribute; predicate contingent { int exogenous; } } class attribute {}"
    report = Report()
    tree = parse(Source("t", text), report)
    assert not report.found
    again = parse(Source("t", render(tree)), report)
    assert again == tree


LAMPS = """
enum Tint { red, green, blue };
class Lamp extends Timeline {
  predicate dark {}
  predicate bright { int level; Tint tint; }
  predicate blink { int level; }
}
class Stage extends Timeline { Lamp lamp; Stage(Lamp l) { lamp = l; } predicate play { Tint tint; } }
Stage::play { duration == 10; only equals {lamp.dark, lamp.bright(level == [0 2], tint == tint)}; }
Lamp lamp = new Lamp(); Lamp other = new Lamp();
Stage stage = new Stage(lamp);
goal(stage.play p); p.start == 20; p.tint == green;
"""


def lit(problem: str) -> Run:
    return Run(LAMPS + problem)


def test_a_constraint_token_lets_only_some_values_be() -> None:
    assert lit("goal(lamp.bright b); b.start == 22; b.level == 2;").solved
    found = lit("goal(lamp.bright b); b.start == 22; b.level == 2;").plan
    assert found is not None
    assert next(t for t in found.tokens if t.goal == "b").parameters == {"level": 2, "tint": "green"}
    (kept,) = [t for t in found.tokens if t.allowed is not None]
    assert [value.predicate for value in kept.allowed or ()] == ["Lamp.dark", "Lamp.bright"]
    assert kept.object == "lamp"
    assert check(found, lit("").model) == ()
    for wrong in ("b.level == 3;", "b.tint == red; b.level == 1;"):
        assert lit(f"goal(lamp.bright b); b.start == 22; {wrong}").exhausted
        assert lit(f"goal(other.bright b); b.start == 22; {wrong}").solved
        assert lit(f"goal(lamp.bright b); b.start == 30; {wrong}").solved
    assert lit("goal(lamp.blink b); b.start == 22; b.level == 1;").exhausted
    assert lit("goal(lamp.dark a); goal(lamp.bright b); a.start == 21; a meets b; b.level == 1; b.end == 28;").solved


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Stage::play { only equals {lamp.dark, lamp.dim}; }", "has no predicate named 'dim'"),
        (
            "Stage::play { only equals {lamp.blink(levl == 1)}; }",
            "Lamp.blink has no parameter 'levl'; did you mean level",
        ),
        ("Stage::play { only equals {lamp.dark, lamp.dark}; }", "Lamp.dark is given twice"),
        ("Stage::play { only equals {lamp.dark, other.blink}; }", "expected a value of the object of the first one"),
        ("Stage::play { only equals[3 1] {lamp.dark}; }", "the interval [3 1] is empty"),
        ("Stage::play { only meets[3 4] {lamp.dark}; }", "relation meets: expected at most 0 bounds"),
        ("Stage::play { only equals {lamp.dark; }", "',' or '}' after an allowed value"),
        ("only equals {lamp.dark};", "only: a constraint token belongs to a rule"),
    ],
)
def test_a_constraint_token_that_means_nothing(text: str, message: str) -> None:
    assert any(message in found for found in complaints(LAMPS + text))
