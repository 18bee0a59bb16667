"""What the constructs of the language mean, on problems whose answers are known."""

from __future__ import annotations

from pathlib import Path

import pytest

from planner.domains import Interval
from planner.language.nddl.errors import NddlError
from planner.model.relations import RELATIONS
from tests.planner.language.nddl.running import Run

LAMP = """
enum Colour {Red, Green, Blue}
class Lamp extends Timeline {
  predicate off {}
  predicate on { Colour colour; int level = [1 9]; }
}
Lamp lamp = new Lamp();
"""


# Bare constraint problems


@pytest.mark.parametrize(
    ("text", "solved"),
    [
        ("typedef int [0 1] Bit; Bit x; Bit y; Bit z; neq(x, y); neq(y, z); neq(x, z);", False),
        ("typedef int [0 2] Bit; Bit x; Bit y; Bit z; neq(x, y); neq(y, z); neq(x, z);", True),
        ("int x = [0 5]; int y = [0 5]; x + y == 9; x < y;", True),
        ("int x = [0 5]; int y = [0 5]; x + y == 9; x == y;", False),
        ("int x = [0 5]; x * x == 16;", True),
        ("int x = [0 5]; x * x == 15;", False),
        ("int x = [-5 5]; abs(x) == 5; x < 0;", True),
        ("int x = [0 9]; mod(x, 5) == 3; x > 4; x != 8;", False),
        ("int x = [0 9]; x - 3 == 4; max(x, 9) == 9; min(x, 2) == 2;", True),
        ("bool a; bool b; a || b; !a; !b;", False),
        ("bool a; bool b; a || b; !a;", True),
        ("int x = [0 3]; x == 1 || x == 2; x != 1; x != 2;", False),
        ("enum E {a, b, c} E x; E y; E z; x != y; y != z; x != z; x != a; y != a;", True),
        ("enum E {a, b} E x; x.specify(a); x.reset(); x.specify(b);", True),
        ("enum E {a, b} E x; x.specify(a); x.specify(b);", False),
        ('string s; s == "one"; string t = "two"; s != t;', True),
        ('string s = "one"; string t = "two"; s == t;', False),
        ("false;", False),
        ("true && 1 < 2;", True),
        ("float x = [0.0 1.0]; x > 2.0;", False),
        ('enforce 1 + 1 == 3 : "cannot be";', False),
    ],
)
def test_bare_constraints(text: str, solved: bool) -> None:
    run = Run(text)
    assert run.solved == solved
    assert run.solved or run.exhausted


def test_real_and_endless_variables_stay_undecided() -> None:
    run = Run("float x = [0.0 1.0]; int y; int z = [3 9]; leq(8, z); y >= 2;")
    assert run.solved
    assert run.value("x") == Interval(0.0, 1.0, integer=False)
    assert run.value("y") == Interval(2, float("inf"))
    assert run.value("z") in (8, 9)


# Classes and objects


def test_constructors_inheritance_and_members() -> None:
    run = Run(
        """
        class Base { int a; Base next; Base(int x) { a = x; } Base(int x, Base n) { this.a = x + 1; next = n; } }
        class Derived extends Base { float b; Derived(int x) { super(x); b = a; } }
        Base first = new Base(5);
        Base second = new Base(6, first);
        Derived third = new Derived(7);
        close();
        """
    )
    members = {name: thing.members for name, thing in run.model.objects.items()}
    assert members["first"] == {"a": 5}
    assert members["second"] == {"a": 7, "next": run.model.objects["first"]}
    assert members["third"] == {"a": 7, "b": 7}


def test_objects_of_constructors_know_their_parent() -> None:
    run = Run("class Part {} class Whole { Part part; Whole() { part = new Part(); } } Whole w = new Whole();")
    part = run.model.objects["w.part"]
    assert part.parent is run.model.objects["w"]


def test_an_object_variable_ranges_over_all_instances_even_later_ones() -> None:
    text = LAMP + "goal(Lamp.on t); t.colour.specify(Red); Lamp other = new Lamp(); close(); t.object.specify(other);"
    run = Run(text)
    assert run.plan is not None
    assert [token.object for token in run.plan.tokens] == ["other"]


def test_an_existential_variable_finds_the_object() -> None:
    run = Run(
        """
        class Path { int from_, to; Path(int a, int b) { from_ = a; to = b; } }
        Path p1 = new Path(1, 2); Path p2 = new Path(2, 3); Path p3 = new Path(3, 1);
        Path p; p.from_ == 2;
        """
    )
    assert run.value("p") is run.model.objects["p2"]


# Rules


@pytest.mark.parametrize("where", ["in the class", "below"])
def test_rules_are_inherited_and_several_apply(where: str) -> None:
    run = Run(
        """
        class A extends Timeline { predicate p {} predicate q {} predicate r {} predicate s {} }
        class B extends A { }
        A::p { contains_start(B.q x); }
        A::p { meets(object.r x); }
        B::p { met_by(object.s x); }
        """.replace("contains_start(B.q x)", "any(Other.o x)").replace(
            "class B", "class Other extends Timeline { predicate o {} } class B"
        )
        + "B b = new B(); Other o = new Other(); goal(b.p t); eq(t.start, 10); eq(t.end, 20);"
    )
    # `any` has no bounds, so that token may lie outside of the horizon; the other two touch this one inside.
    assert run.predicates() == ["A.p", "A.r", "A.s"]


@pytest.mark.parametrize(("level", "expected"), [(5, ["Lamp.off", "Lamp.on"]), (4, ["Lamp.on"])])
def test_a_guard_applies_when_its_variable_is_decided_so(level: int, expected: list[str]) -> None:
    run = Run(
        LAMP
        + f"Lamp::on {{ if (level == 5) {{ meets(off x); }} }} goal(lamp.on t); eq(t.level, {level}); "
        + "eq(t.start, 3); eq(t.end, 9); t.colour.specify(Red);"
    )
    assert run.predicates() == expected


@pytest.mark.parametrize(
    ("test", "applies"),
    [
        ("colour == Red", True),
        ("colour != Red", False),
        ("colour != Blue", True),
        ("colour == {Red, Blue}", True),
        ("colour == {Green, Blue}", False),
        ("isSingleton(colour)", True),
        ("level == [2 4]", True),
        ("level == [4 9]", False),
        ("level < 4", True),
        ("level + 1 == 4", True),
        ("level == 3 && colour == Red", True),
        ("level == 3 && colour == Blue", False),
        ("!(colour == Red)", False),
    ],
)
def test_guards(test: str, applies: bool) -> None:
    rule = f"Lamp::on {{ if ({test}) {{ meets(off a); }} else {{ met_by(off b); }} }}"
    run = Run(LAMP + rule + "goal(lamp.on t); eq(t.level, 3); t.colour.specify(Red); eq(t.start, 3); eq(t.end, 9);")
    assert run.plan is not None
    (off,) = [token for token in run.plan.tokens if token.predicate == "Lamp.off"]
    assert (
        (off.start[0], off.end[1]) == ((9, None) if applies else (None, 3)) or off.start == (9, 9) or off.end == (3, 3)
    )
    assert (off.start == (9, 9)) == applies


def test_a_loose_boolean_guard_is_a_disjunction() -> None:
    rule = "Lamp::on { bool OR; if (OR == true) { duration == 3; } else { duration == 5; } }"
    run = Run(LAMP + rule + "goal(lamp.on t); leq(4, t.duration);")
    assert run.plan is not None
    assert run.plan.tokens[0].duration == (5, 5)


def test_foreach_runs_over_what_is_left_of_the_variable() -> None:
    run = Run(
        """
        class Room { int floor; Room(int f) { floor = f; } }
        class Alarm extends Timeline { Room room; Alarm(Room r) { room = r; } predicate ring {} }
        class Guard extends Timeline { predicate round { int floor; } }
        Guard::round {
          Alarm alarms;
          eq(alarms.room.floor, floor);
          foreach (a in alarms) { contains(Alarm.ring r); eq(r.object, a); }
        }
        Room r1 = new Room(1); Room r2 = new Room(2); Room r3 = new Room(2);
        Alarm a1 = new Alarm(r1); Alarm a2 = new Alarm(r2); Alarm a3 = new Alarm(r3);
        Guard g = new Guard();
        goal(g.round t); eq(t.floor, 2); eq(t.start, 10); eq(t.end, 50);
        """
    )
    assert run.plan is not None
    assert sorted(t.object for t in run.plan.tokens if t.predicate == "Alarm.ring") == ["a2", "a3"]


@pytest.mark.parametrize("relation", sorted(set(RELATIONS) - {"any"}))
def test_every_relation_means_what_the_table_says(relation: str) -> None:
    """Tokens at fixed times: solved exactly if the distances of the table hold."""
    times = {"o.start": 10, "o.end": 20}
    for start, end in ((5, 10), (5, 15), (10, 20), (12, 18), (10, 15), (15, 20), (15, 25), (20, 25), (25, 30), (5, 25)):
        at = times | {"t.start": start, "t.end": end}
        holds = all(d.minimum <= at[d.to] - at[d.from_] <= d.maximum for d in RELATIONS[relation][0])
        run = Run(
            "class A { predicate p {} } A a = new A(); goal(a.p o); goal(a.p t); "
            f"eq(o.start, 10); eq(o.end, 20); eq(t.start, {start}); eq(t.end, {end}); o {relation} t;"
        )
        assert run.solved == holds, (start, end)


def test_bounds_of_a_relation() -> None:
    text = "class A { predicate p {} } A a = new A(); goal(a.p o); goal(a.p t); o before[10, 20] t; "
    assert Run(text + "eq(o.end, 30); eq(t.start, 50);").solved
    assert not Run(text + "eq(o.end, 30); eq(t.start, 51);").solved


@pytest.mark.parametrize(
    ("constraint", "gap", "solved"),
    [
        ("o.end + 5 <= t.start;", 5, True),
        ("o.end + 5 <= t.start;", 4, False),
        ("o.end + 5 < t.start;", 5, False),
        ("t.start - o.end == [3 6];", 6, True),
        ("t.start - o.end == [3 6];", 7, False),
        ("t.start >= o.end + 2;", 2, True),
        ("t.start > o.end + 2;", 2, False),
        ("temporalDistance(o.end, [3 4], t.start);", 5, False),
        ("addEq(o.end, 3, t.start);", 3, True),
        ("precedes(t.start, o.end);", 1, False),
        ("concurrent(t.start, o.end);", 0, True),
    ],
)
def test_distances_between_timepoints(constraint: str, gap: int, solved: bool) -> None:
    text = f"eq(o.end, 20); eq(t.start, {20 + gap});"
    base = "class A { predicate p {} } A a = new A(); goal(a.p o); goal(a.p t); "
    assert Run(base + constraint + text).solved == solved


# The problem


def test_goals_are_merged_or_stand_alone_and_activated_ones_stand_alone() -> None:
    text = LAMP + "goal(lamp.on t); goal(lamp.on u);"
    assert Run(text).predicates() == ["Lamp.on"]
    assert Run(text + "t.activate(); u.activate();").predicates() == ["Lamp.on", "Lamp.on"]
    assert Run(text + "t.activate(); u.activate(); u.cancel();").predicates() == ["Lamp.on"]
    assert not Run(text + "t.activate(); u.activate(); t equals u;").solved


def test_a_rejectable_token_that_cannot_be_is_rejected() -> None:
    text = LAMP + "fact(lamp.off night); eq(night.start, 0); leq(90, night.end); rejectable(lamp.on t); leq(t.end, 80);"
    run = Run(text)
    assert run.predicates() == ["Lamp.off"]
    assert not Run(text.replace("rejectable", "goal")).solved


def test_reject_and_merge_by_statement() -> None:
    assert Run(LAMP + "rejectable(lamp.on t); t.reject();").predicates() == []
    assert Run(LAMP + "goal(lamp.on t); goal(lamp.on u); t.merge(u); eq(u.start, 7);").predicates() == ["Lamp.on"]
    with pytest.raises(NddlError, match="cannot be merged"):
        Run(LAMP + "goal(lamp.on t); goal(lamp.off u); t.merge(u);")


def test_a_fact_asks_for_nothing() -> None:
    rule = "Lamp::on { met_by(off x); }"
    assert Run(LAMP + rule + "fact(lamp.on t); eq(t.start, 5);").predicates() == ["Lamp.on"]
    assert Run(LAMP + rule + "goal(lamp.on t); eq(t.start, 5);").predicates() == ["Lamp.off", "Lamp.on"]


def test_constrain_orders_tokens_on_an_object() -> None:
    text = (
        LAMP + "Lamp second = new Lamp(); goal(Lamp.on t); goal(Lamp.off u); second.constrain(t, u); eq(u.start, 50);"
    )
    run = Run(text)
    assert run.plan is not None
    assert {token.object for token in run.plan.tokens} == {"second"}
    assert not Run(text + "leq(51, t.end);").solved
    assert Run(text + "leq(51, t.end); second.free(t, u); t.object.specify(lamp);").solved


@pytest.mark.parametrize(("start", "solved"), [(0, True), (99, True), (100, False), (-5, True), (-200, False)])
def test_a_goal_is_achieved_inside_the_horizon(start: int, solved: bool) -> None:
    run = Run(LAMP + f"goal(lamp.on t); eq(t.start, {start}); leq(t.duration, 50);")
    assert run.solved == solved


def test_a_goal_without_times_is_placed_inside_the_horizon() -> None:
    run = Run(LAMP + "PlannerConfig w = new PlannerConfig(20, 40, 100); goal(lamp.on t);")
    assert run.plan is not None
    (token,) = run.plan.tokens
    assert token.start[0] == 20
    assert token.end[1] == 40


def test_state_active_means_never_merged() -> None:
    text = "class A extends Timeline { predicate p { %s } } A a = new A(); goal(a.p t); goal(a.p u);"
    assert Run(text % "eq(state, ACTIVE);").predicates() == ["A.p", "A.p"]
    assert Run(text % "").predicates() == ["A.p"]


def test_an_effect_is_brought_about_by_an_action() -> None:
    domain = """
        class Door extends Timeline { predicate open {} predicate closed {} }
        class Robot extends Timeline { Door door; Robot(Door d) { door = d; } action push { duration = 2; } }
        Robot::push { met_by(condition object.door.closed c); meets(effect object.door.open o); }
        Door door = new Door(); Robot robot = new Robot(door);
        fact(door.closed before_); eq(before_.start, 0);
        """
    run = Run(domain + "goal(door.open wanted); leq(10, wanted.start);")
    assert run.predicates() == ["Door.closed", "Door.open", "Robot.push"]
    assert Run(domain + "fact(door.open given); leq(10, given.start);").predicates() == ["Door.closed", "Door.open"]


def test_durations_contingent_and_exogenous() -> None:
    run = Run(
        """
        class Sky extends Timeline { exogenous predicate pass { } }
        class Attitude extends Timeline { Sky sky; Attitude(Sky s) { sky = s; }
          predicate slew { contingent duration = [3 6]; } }
        Attitude::slew { contained_by(object.sky.pass p); }
        Sky sky = new Sky(); Attitude attitude = new Attitude(sky);
        fact(sky.pass window); eq(window.start, 10); eq(window.end, 30);
        goal(attitude.slew s);
        """
    )
    assert run.plan is not None
    (slew,) = [token for token in run.plan.tokens if token.predicate == "Attitude.slew"]
    assert slew.contingent
    assert slew.duration == (3, 6)
    (window,) = [t for t in run.plan.tokens if t.predicate == "Sky.pass" and t.fact]
    assert window.end == (30, 30)


def test_includes_once_and_relative_to_the_file(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "types.nddl").write_text('#include "more.nddl"\nenum E {a, b}')
    (tmp_path / "sub" / "more.nddl").write_text('#include "types.nddl"\ntypedef int [1 3] Small;')
    text = '#include "Plasma.nddl"\n#include "sub/types.nddl"\n#include "sub/more.nddl"\nE x = b; Small n; n > 2;'
    run = Run(text, folder=tmp_path)
    assert (run.value("x"), run.value("n")) == ("b", 3)
