"""Solver hints change which plan is found and how soon, never whether there is one; files that are none are refused."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.checker import check
from planner.constraints.heuristics import VARIABLE_HEURISTICS
from planner.constraints.standard import STANDARD
from planner.constraints.variables import Variable
from planner.database import PlanDatabase
from planner.domains import Interval
from planner.errors import HintsError
from planner.language.nddl.builder import load_text
from planner.plan import FlexiblePlan
from planner.planning import plan
from planner.search.flaws import OpenToken, Undecided, next_flaw
from planner.search.hint_files import load, parse
from planner.search.hints import LAST, Hint, Hints
from planner.search.outcome import Limits
from scenarios.plan_verb import plan_file
from tests.planner.search.ground import random_small
from tests.planner.search.ground_models import model_of, problem_of
from tests.scenarios.commands import remote_agent

LAMP = """
enum Colour {red, green, blue}
class Light extends Timeline {
  predicate on { int level; Colour colour; duration = 5; leq(0, level); leq(level, 4); }
  predicate off { duration = 5; }
}
class Lamp extends Light {}
class Bell extends Timeline { predicate ring { int level; duration = 5; leq(0, level); leq(level, 4); } }
Light::on { met_by(object.off before_); }
Lamp lamp = new Lamp();
Bell bell = new Bell();
close();
"""
TWICE = LAMP + "goal(lamp.on first); goal(lamp.on second);"
BOTH = LAMP + "rejectable(lamp.on first); rejectable(lamp.off second);"  # each with two decisions: none is forced


def planned(folder: Path, text: str, hints: str, seed: int = 0, engine: str = "portfolio") -> FlexiblePlan:
    """The plan of a text with hints beside it, judged."""
    problem = folder / "lamp.nddl"
    problem.write_text(text, encoding="utf-8")
    (folder / "lamp.hints.toml").write_text(hints, encoding="utf-8")
    answer = plan_file(problem, seed=seed, engine=engine)
    assert answer.plan is not None
    assert not check(answer.plan, answer.model)
    return answer.plan


def hint(line: str, predicate: str = "on") -> str:
    return f'[[hint]]\npredicate = "{predicate}"\n{line}\n'


# The order of values


@pytest.mark.parametrize(
    ("values", "level", "colour"),
    [
        ('"min"', 0, "red"),
        ('"max"', 4, "blue"),
        ("[7, 3, 1]", 3, "red"),
        ('["green", 2]', 2, "green"),
        ("[true, 1.0]", 1, "red"),
    ],
)
def test_values_are_tried_in_the_order_asked_for(tmp_path: Path, values: str, level: int, colour: str) -> None:
    plan = planned(tmp_path, LAMP + "goal(lamp.on light);", hint(f"values = {values}"))
    assert plan.tokens[0].parameters == {"level": level, "colour": colour}


def test_a_value_that_is_listed_but_impossible_gives_way_to_the_others(tmp_path: Path) -> None:
    text = LAMP + "goal(lamp.on light); neq(light.level, 3);"
    assert planned(tmp_path, text, hint("values = [3, 2]")).tokens[0].parameters["level"] == 2


def test_a_hint_is_for_its_class_predicate_and_variable_only(tmp_path: Path) -> None:
    text = LAMP + "goal(lamp.on light); goal(bell.ring sound);"

    def levels(hints: str) -> dict[str, object]:
        tokens = planned(tmp_path, text, hints).tokens
        return {t.predicate.split(".")[1]: t.parameters["level"] for t in tokens if "level" in t.parameters}

    assert levels('[[hint]]\nvariable = "level"\nvalues = "max"\n') == {"on": 4, "ring": 4}
    assert levels(hint('values = "max"', "ring")) == {"on": 0, "ring": 4}
    assert levels('[[hint]]\nclass = "Lamp"\nvalues = "max"\n') == {"on": 4, "ring": 0}
    assert levels('[[hint]]\nclass = "Light"\nvalues = "max"\n') == {"on": 4, "ring": 0}
    assert levels(hint('variable = "colour"\nvalues = "max"')) == {"on": 0, "ring": 0}


def test_the_first_hint_that_says_something_counts(tmp_path: Path) -> None:
    hints = hint('slot = "last"') + hint("values = [2]") + '[[hint]]\nvalues = "max"\n'
    text = LAMP + "goal(lamp.on light); goal(bell.ring sound);"
    found = {t.predicate: t.parameters for t in planned(tmp_path, text, hints).tokens}
    assert found["Bell.ring"]["level"] == 4
    assert [values["level"] for name, values in found.items() if name.endswith("on")] == [2]


def test_a_local_variable_of_a_rule_is_hinted_by_its_name(tmp_path: Path) -> None:
    rule = "Bell::ring { int strokes; leq(1, strokes); leq(strokes, 3); eq(level, strokes); }"
    text = LAMP.replace("Lamp lamp", rule + " Lamp lamp") + "goal(bell.ring sound);"
    strokes = hint('variable = "strokes"\npriority = 1\nvalues = [2]', "ring")
    assert planned(tmp_path, text, strokes).tokens[0].parameters["level"] == 2
    assert planned(tmp_path, text, "").tokens[0].parameters["level"] == 1


def test_a_random_order_is_that_of_its_seed(tmp_path: Path) -> None:
    text = LAMP + "goal(lamp.on light); goal(bell.ring sound);"
    plans = [[planned(tmp_path, text, '[[hint]]\nvalues = "random"\n', seed) for seed in range(12)] for _ in range(2)]
    assert plans[0] == plans[1]
    assert {p.tokens[0].parameters["level"] for p in plans[0]} == {0, 1, 2, 3, 4}
    assert any(p.tokens[0].parameters["level"] != p.tokens[1].parameters["level"] for p in plans[0])


@given(st.integers(0, 40), st.integers(0, 5), st.sampled_from(["min", "max", "random", (3, 1, 99, "x", True)]))
def test_every_order_has_every_value_once(width: int, seed: int, order: object) -> None:
    hints = Hints((Hint(variable="v", values=order),), seed)
    found = list(hints.values_of(Variable("v", Interval(-2, width), None)))
    assert sorted(found) == list(range(-2, width + 1))


def test_a_random_value_of_very_many_costs_no_list_of_them() -> None:
    variable = Variable("v", Interval(0, 10**15), None)
    few = Hints((Hint(variable="v", values="random"),)).values_of(variable)
    assert len({next(few) for _ in range(100)}) == 100


# Where tokens go


def test_a_token_is_inserted_before_codesignation_is_tried(tmp_path: Path) -> None:
    assert len(list(planned(tmp_path, TWICE, hint('prefer = "codesignate"')).hosts())) == 1
    assert len(list(planned(tmp_path, TWICE, "").hosts())) == 1
    assert len(list(planned(tmp_path, TWICE, hint('prefer = "insert"')).hosts())) == 3


@pytest.mark.parametrize(("slot", "order"), [("first", ["second", "first"]), ("last", ["first", "second"])])
def test_the_preferred_slot_is_taken(tmp_path: Path, slot: str, order: list[str]) -> None:
    found = planned(tmp_path, TWICE, hint(f'prefer = "insert"\nslot = "{slot}"'))
    on = sorted((t for t in found.hosts() if t.predicate.endswith(".on")), key=lambda t: t.start)
    assert [t.id for t in on] == [{"first": "t0", "second": "t1"}[name] for name in order]


# Which flaw comes next


def test_a_filter_or_a_priority_says_which_token_comes_first() -> None:
    assert first_flaw(BOTH, "") == "on"
    assert first_flaw(BOTH, hint("priority = 1", "off")) == "off"
    assert first_flaw(BOTH, hint("priority = 1", "off") + hint("priority = 2", "on")) == "on"
    assert first_flaw(BOTH, hint("priority = -1", "on")) == "off"
    assert first_flaw(BOTH, hint("filter = true", "on")) == "off"
    assert first_flaw(BOTH, hint("filter = true", "on") + hint("priority = -1000", "off")) == "off"


def first_flaw(text: str, hints: str) -> str:
    found = next_flaw(*database_of(text, hints))
    assert found is not None
    assert isinstance(found[0], OpenToken)
    return found[0].token.predicate.name


def database_of(text: str, hints: str) -> tuple[PlanDatabase, None, Hints]:
    model, program, report = load_text(text, STANDARD)
    database = PlanDatabase(model, (0, 100))
    program.carry_out(database, report)
    return database, None, parse(hints, "lamp.hints.toml").of_model(model)


def second_flaw(hints: str) -> str:
    """What comes after the lamp's token went where it goes first."""
    database, order, guide = database_of(LAMP + "goal(lamp.on light); rejectable(bell.ring sound);", hints)
    found = next_flaw(database, order, guide)
    assert found is not None
    database.trail.push()
    next(found[1]).apply(database)
    then = next_flaw(database, order, guide)
    assert then is not None
    flaw = then[0]
    assert isinstance(flaw, OpenToken | Undecided)
    return flaw.token.predicate.name if isinstance(flaw, OpenToken) else flaw.variable.part


def test_a_variable_with_a_priority_is_decided_before_tokens_without() -> None:
    tokens = {"ring", "off"}
    assert second_flaw("") in tokens
    assert second_flaw(hint("priority = 1")) in tokens
    assert second_flaw(hint('variable = "level"\npriority = 1')) == "level"
    assert second_flaw(hint('variable = "colour"\npriority = 1')) == "colour"
    both = hint('variable = "level"\npriority = 2') + hint('variable = "colour"\npriority = 1')
    assert second_flaw(both) == "level"


def test_hints_leave_what_can_be_planned_as_it_is() -> None:
    """Whatever they say, the same goals of random problems are kept, and the plans are right."""
    solved = dropped = 0
    for seed in range(120):
        small, draw = random_small(random.Random(seed)), random.Random(seed)
        model, problem = model_of(small), problem_of(small)
        predicates = sorted(small.kinds)
        hints = Hints(
            tuple(_random_hint(draw, predicates) for _ in range(4)),
            seed,
            variables=draw.choice(list(VARIABLE_HEURISTICS)),
        )
        limits = Limits(max_steps=2000, max_seconds=20)
        engine = draw.choice(["chronological", "backjumping", "portfolio"])
        plain, hinted = plan(model, problem, limits), plan(model, problem, limits, engine=engine, hints=hints)
        if any(d.kind == "undecided" for d in (*plain.dropped, *hinted.dropped)):
            continue
        assert (plain.plan is None) == (hinted.plan is None), seed
        assert [d.id for d in plain.dropped] == [d.id for d in hinted.dropped], seed
        if hinted.plan is not None:
            assert not check(hinted.plan, model), seed
        solved += hinted.plan is not None
        dropped += bool(hinted.dropped)
    assert solved > 40
    assert dropped > 20


def _random_hint(draw: random.Random, predicates: list[str]) -> Hint:
    predicate = draw.choice([None, *predicates])
    if draw.random() < 0.3:
        return Hint(predicate=predicate, variable="x", priority=draw.choice([5, -5, LAST]), values="random")
    return Hint(
        predicate=predicate,
        priority=draw.choice([None, 5, -5, LAST]),
        values=draw.choice([None, "min", "max", "least-constraining", "random", (1,)]),
        prefer=draw.choice([None, "insert", "codesignate"]),
        slot=draw.choice([None, "first", "last"]),
    )


# Files


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("[[hint]]\nprioritys = 3\n", "hint[0].prioritys: unknown key; did you mean priority?"),
        ("[[hints]]\npriority = 3\n", "hints: unknown key; did you mean hint?"),
        ("hint = 3\n", "hint: expected tables [[hint]], found 3"),
        ('[[hint]]\npriority = "high"\n', "hint[0].priority: expected a whole number from -1000 to 1000, found 'high'"),
        ("[[hint]]\npriority = true\n", "hint[0].priority: expected a whole number"),
        ("[[hint]]\npriority = 1001\n", "hint[0].priority: expected a whole number"),
        ('[[hint]]\nvalues = "up"\n', 'hint[0].values: expected "in-order", "min", "max", "least-constraining"'),
        (
            "variables = 3\n",
            "variables: expected one of first-stated, fewest-values, fewest-values-per-constraint, found",
        ),
        ("[[hint]]\nvalues = []\n", "hint[0].values: expected"),
        ("[[hint]]\nvalues = [nan]\n", "hint[0].values: expected"),
        ("[[hint]]\nslot = 1\n", 'hint[0].slot: expected "first" or "last", found 1'),
        ("[[hint]]\nfilter = false\n", "hint[0].filter: expected true, found False"),
        ("[[hint]]\nfilter = true\npriority = 1\n", "hint[0].filter: expected a filter or a priority, found both"),
        ('[[hint]]\nvariable = "v"\nslot = "last"\n', "hint[0].slot: is for tokens"),
        ('[[hint]]\nclass = "Lamp"\n', "hint[0]: expected one of priority, filter, values, prefer, slot, found none"),
        ("[[hint]\n", "not TOML"),
    ],
)
def test_what_is_wrong_is_said_with_file_and_key(text: str, complaint: str) -> None:
    with pytest.raises(HintsError) as error:
        parse(text, "lamp.hints.toml")
    assert str(error.value).startswith(f"lamp.hints.toml: {complaint}")


def test_all_that_is_wrong_is_said_at_once() -> None:
    with pytest.raises(HintsError) as error:
        parse("seed = 3\n[[hint]]\nslot = 1\n[[hint]]\nvalue = 1\nslot = 'last'\n", "h")
    assert [line.split(": ")[1] for line in str(error.value).splitlines()] == ["seed", "hint[0].slot", "hint[1].value"]


@pytest.mark.parametrize(
    ("selector", "complaint"),
    [
        ('class = "Lmap"', "hint[1].class: there is no class named 'Lmap'; did you mean Lamp?"),
        ('predicate = "onn"', "hint[1].predicate: there is no predicate named 'onn'; did you mean on"),
        (
            'predicate = "on"\nvariable = "colourr"',
            "hint[1].variable: there is no variable named 'colourr'; did you mean colour?",
        ),
        ('class = "Bell"\nvariable = "colour"', "hint[1].variable: there is no variable named 'colour'"),
        ('class = "Bell"\npredicate = "on"', "hint[1].predicate: there is no predicate named 'on'"),
    ],
)
def test_names_that_the_model_does_not_have_are_refused(selector: str, complaint: str) -> None:
    model, _, _ = load_text(LAMP, STANDARD)
    hints = parse(f"[[hint]]\npriority = 1\n[[hint]]\n{selector}\npriority = 1\n", "lamp.hints.toml")
    with pytest.raises(HintsError) as error:
        hints.of_model(model)
    assert str(error.value).startswith(f"lamp.hints.toml: {complaint}")


def test_the_command_takes_the_hints_that_it_is_given(tmp_path: Path) -> None:
    problem, out = tmp_path / "lamp.nddl", tmp_path / "plan.json"
    problem.write_text(LAMP + "goal(lamp.on light);", encoding="utf-8")
    (tmp_path / "lamp.hints.toml").write_text(hint("values = [3]"), encoding="utf-8")
    other = tmp_path / "other.toml"
    other.write_text(hint("values = [2]"), encoding="utf-8")
    assert remote_agent("plan", problem, "--out", out).status == 0
    assert FlexiblePlan.load(out).tokens[0].parameters["level"] == 3
    assert remote_agent("plan", problem, "--out", out, "--hints", other, "--seed", 5).status == 0
    assert FlexiblePlan.load(out).tokens[0].parameters["level"] == 2
    out.unlink()
    other.write_text("[[hint]]\nvalues_ = 1\n", encoding="utf-8")
    answer = remote_agent("plan", problem, "--out", out, "--hints", other)
    assert (answer.status, answer.out) == (2, "")
    assert f"{other}: hint[0].values_: unknown key; did you mean values?" in answer.err
    assert not out.exists()


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    missing = tmp_path / "missing.toml"
    with pytest.raises(HintsError, match=r"missing\.toml: No such file"):
        load(missing)
    missing.write_bytes(b"\xff")
    with pytest.raises(HintsError, match="not UTF-8 text at byte 0"):
        load(missing)
