"""Why a token is there, and why there is no plan: held against the plan, and against smaller sets of statements."""

from __future__ import annotations

import json
from itertools import combinations
from pathlib import Path
from random import Random

import pytest
from typer.testing import CliRunner

from planner.cores import smallest_core
from scenarios.cli import app
from scenarios.explaining.conflict import Conflict
from scenarios.explaining.tokens import Rationale
from scenarios.plan_verb import plan_file

EXAMPLES = Path(__file__).parents[2] / "scenarios" / "examples"
LAMP = """class Lamp extends Timeline {
  predicate on { duration = 5; }
  predicate off { duration = [10 20]; }
}
Lamp::on { met_by(off before_); }
PlannerConfig w = new PlannerConfig(0, 30, 100);
Lamp lamp = new Lamp();
"""


def explained(path: Path, text: str, max_steps: int | None = None) -> Conflict:
    path.write_text(text)
    found = plan_file(path, max_seconds=10, max_steps=max_steps, explain=True).explanation
    assert isinstance(found, Conflict)
    return found


@pytest.mark.parametrize("name", sorted(path.stem for path in EXAMPLES.glob("*.nddl")))
def test_every_token_has_a_reason(name: str) -> None:
    answer = plan_file(EXAMPLES / f"{name}.nddl", explain=True)
    why = answer.explanation
    assert isinstance(why, Rationale)
    assert answer.plan is not None
    listed = {token.id: token for token in (*answer.plan.tokens, *answer.plan.boundary)}
    slots = {token: slot[0] for line in answer.plan.timelines for slot in line.slots for token in slot}
    assert [reason.token for reason in why.tokens] == list(listed)
    for reason in why.tokens:
        token = listed[reason.token]
        assert reason.required_by == token.master
        assert (reason.role == "fact") == token.fact
        assert (reason.role in ("goal", "rejectable")) == (token.goal is not None)
        assert (reason.host or reason.token) == slots.get(reason.token, reason.host or reason.token)
        if token.master is not None:
            master = listed[token.master]
            assert f"rule {master.predicate.replace('.', '::')}" in reason.because or "brings about" in reason.because
            if reason.placing != "outside":
                host = next(r for r in why.tokens if r.token == (reason.host or reason.token))
                assert slots.get(token.master, token.master) in host.supports
    text = "\n".join(why.lines())
    assert all(f"{i} " in text or f", {i}:" in text for i in listed)


def test_the_statements_in_conflict_are_named_with_their_place(tmp_path: Path) -> None:
    path = tmp_path / "lamp.nddl"
    told = explained(
        path, LAMP + "int x = 7;\nfact(lamp.off n); eq(n.start, 0);\ngoal(lamp.on a);\neq(a.start, 4); goal(lamp.on b);"
    )
    assert told.proven
    assert told.minimal
    assert [(s.line, s.column, s.text) for s in told.statements] == [
        (9, 1, "fact(lamp.off n);"),
        (9, 19, "eq(n.start, 0);"),
        (10, 1, "goal(lamp.on a);"),
        (11, 1, "eq(a.start, 4);"),
    ]
    assert any(f"{path}:11:1: eq(a.start, 4);" in line for line in told.lines())


def test_an_inconsistent_initial_state(tmp_path: Path) -> None:
    told = explained(tmp_path / "x.nddl", "int x; int y = 3;\neq(x, 1); leq(x, 5);\nleq(y, 4);\neq(x, 2);")
    assert [(s.line, s.text) for s in told.statements] == [(2, "eq(x, 1);"), (4, "eq(x, 2);")]
    assert told.minimal


def test_the_rules_by_which_statements_meet(tmp_path: Path) -> None:
    rule = "Lamp::on { leq(start, 8); }\n"
    told = explained(tmp_path / "x.nddl", LAMP + rule + "goal(lamp.on a); a.activate(); leq(9, a.start);")
    assert [s.text for s in told.statements] == ["goal(lamp.on a);", "leq(9, a.start);"]
    assert any("8:1: rule Lamp::on" in one for one in told.through) or told.dead_end is not None


def test_what_the_model_alone_leaves_no_plan_for(tmp_path: Path) -> None:
    told = explained(tmp_path / "x.nddl", LAMP + "goal(lamp.on a); eq(a.duration, 9);")
    assert [s.text for s in told.statements] == ["goal(lamp.on a);", "eq(a.duration, 9);"]
    late = explained(tmp_path / "x.nddl", LAMP + "goal(lamp.on a); leq(40, a.start);")
    assert [s.text for s in late.statements] == ["goal(lamp.on a);", "leq(40, a.start);"]
    assert "horizon [0 30]" in late.lines()[0]


SKY = """class Sky extends Timeline { exogenous predicate pass {} }
class Radio extends Timeline { predicate send { duration = 10; } }
Radio::send { contained_by(Sky.pass window); }
Sky sky = new Sky(); Radio radio = new Radio();
PlannerConfig w = new PlannerConfig(0, 100, 100);
"""


def test_facts_that_support_are_not_left_out(tmp_path: Path) -> None:
    facts = "fact(sky.pass a); eq(a.start, 50); eq(a.end, 70);\n"
    told = explained(tmp_path / "x.nddl", SKY + facts + "goal(radio.send s);\nleq(s.end, 30);")
    # Without the pass nothing could be sent at all; that it comes too late is what leaves no plan.
    assert [s.text for s in told.statements] == [
        "eq(a.start, 50);",
        "goal(radio.send s);",
        "leq(s.end, 30);",
    ]
    assert told.minimal
    assert told.proven


def test_facts_that_contradict_each_other(tmp_path: Path) -> None:
    told = explained(
        tmp_path / "x.nddl", SKY + "fact(sky.pass a); eq(a.start, 50); leq(a.end, 40);\ngoal(radio.send s);"
    )
    assert [s.text for s in told.statements] == ["fact(sky.pass a);", "eq(a.start, 50);", "leq(a.end, 40);"]
    assert told.minimal


def test_a_part_is_proven_where_the_search_of_all_is_not(tmp_path: Path) -> None:
    free = "".join(f"Bit f{n}; " for n in range(40))
    text = f"typedef int [0 1] Bit; {free} Bit x; Bit y; Bit z; neq(x, y); neq(y, z); neq(x, z); leq(f1, f2);"
    path = tmp_path / "x.nddl"
    path.write_text(text)
    assert plan_file(path, engine="chronological", max_steps=3000).verdict == "limit"
    answer = plan_file(path, engine="chronological", max_steps=3000, explain=True)
    assert answer.verdict == "unsolvable"
    assert isinstance(answer.explanation, Conflict)
    assert [s.text for s in answer.explanation.statements] == ["neq(x, y);", "neq(y, z);", "neq(x, z);"]


def test_limits_are_told(tmp_path: Path) -> None:
    names = [f"v{n}" for n in range(12)]
    pigeons = "typedef int [1 11] Hole; " + "".join(f"Hole {n}; " for n in names)
    pigeons += "".join(f"neq({a}, {b});" for a, b in combinations(names, 2))
    told = explained(tmp_path / "x.nddl", pigeons, max_steps=5)
    assert not told.proven
    assert "no part of the problem was proven" in told.lines()[0]


def test_a_plan_that_nature_could_break_is_none(tmp_path: Path) -> None:
    text = """class Attitude extends Timeline { predicate slew { contingent duration = [3 9]; } }
    Attitude attitude = new Attitude();
    PlannerConfig w = new PlannerConfig(0, 50, 100);
    goal(attitude.slew s);
    leq(5, s.start);
    eq(s.end, 20);
    leq(s.duration, 30);"""
    told = explained(tmp_path / "x.nddl", text)
    assert [s.text for s in told.statements] == ["goal(attitude.slew s);", "eq(s.end, 20);"]
    assert told.minimal
    assert told.dead_end is not None


def problem(random: Random) -> tuple[str, list[str]]:
    """A declaration of small variables and statements over them, too many to hold together."""
    names = [f"v{n}" for n in range(4)]
    head = "typedef int [0 3] Small; " + "".join(f"Small {name}; " for name in names)
    statements = []
    for _ in range(random.randint(5, 8)):
        a, b = random.sample(names, 2)
        forms = (f"neq({a}, {b});", f"lt({a}, {b});", f"eq({a}, {random.randint(0, 3)});", f"leq({b}, {a});")
        statements.append(random.choice(forms))
    return head, statements


@pytest.mark.parametrize("seed", range(40))
def test_minimal_by_brute_force(tmp_path: Path, seed: int) -> None:
    head, statements = problem(Random(seed))
    path = tmp_path / "x.nddl"

    def has_plan(chosen: list[str]) -> bool:
        path.write_text(head + "\n".join(chosen))
        return plan_file(path).solved

    if has_plan(statements):
        return
    told = explained(path, head + "\n".join(statements))
    core = [s.text for s in told.statements]
    assert told.minimal
    assert not has_plan(core)
    for left_out in range(len(core)):
        assert has_plan(core[:left_out] + core[left_out + 1 :])


@pytest.mark.parametrize("seed", range(60))
def test_cores_of_planted_conflicts(seed: int) -> None:
    random = Random(seed)
    members = list(range(random.randint(1, 40)))
    planted = [
        set(random.sample(members, random.randint(1, min(5, len(members))))) for _ in range(random.randint(1, 3))
    ]
    core = smallest_core(members, lambda chosen: any(one <= set(chosen) for one in planted))
    assert core.minimal
    assert set(core.members) in [one for one in planted if not any(other < one for other in planted)]
    unsure = smallest_core(members, lambda chosen: True if planted[0] <= set(chosen) else None)
    assert set(unsure.members) == planted[0]
    assert not unsure.minimal


def test_the_command_explains(tmp_path: Path) -> None:
    run = CliRunner().invoke(app, ["plan", str(EXAMPLES / "light_switch.nddl"), "--explain", "--json"])
    assert run.exit_code == 0
    tokens = json.loads(run.stdout)["explanation"]["tokens"]
    (press,) = [t for t in tokens if t["name"].endswith("/on")]
    assert press["required_by"] == next(t["id"] for t in tokens if t["name"] == "light")
    path = tmp_path / "x.nddl"
    path.write_text("int x; eq(x, 1);\neq(x, 2);")
    run = CliRunner().invoke(app, ["plan", str(path), "--explain"])
    assert run.exit_code == 1
    assert f"{path}:2:1: eq(x, 2);" in run.stdout
