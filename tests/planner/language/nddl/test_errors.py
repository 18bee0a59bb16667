"""What the modeller is told: the place, what was expected, what was found, the nearest names."""

from __future__ import annotations

import pytest

from planner.constraints.standard import STANDARD
from planner.database import PlanDatabase
from planner.language.nddl.builder import load_text
from planner.language.nddl.errors import NddlError, UnsupportedError
from tests.planner.language.nddl.running import Run, complaints

DOMAIN = """enum Place {Hill, Rock}
class Rover extends Timeline {
  Place home;
  Rover(Place p) { home = p; }
  predicate at { Place place; }
}
"""


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("int x = [1 ];", "1:12 expected the upper bound: an interval is [lower upper], found ']'"),
        ("int x = [5 3];", "1:9 the interval [5 3] is empty: expected lower <= upper"),
        ("enum E {a b}", "1:11 expected ',' or '}' after a value of the enumeration, found 'b'"),
        ("goal Rover.at t;", "1:11 expected ';', found '.'"),
        ("eq(1, 2", "1:8 expected ',' or ')' in this list, found the end of the file"),
        ("predicate p {}", "1:1 a predicate is declared inside a class"),
        ("else {}", "1:1 'else' belongs to no 'if'"),
        ("}", "1:1 '}' closes nothing"),
        ("class A {", "1:9 the '{' of class A is never closed: expected '}', found the end of the file"),
        ("class A; A a = new A();", "1:1 class 'A' is announced here, but it is declared nowhere"),
        ("class A extends Timelin {}", "1:1 class A: there is no class named 'Timelin'; did you mean Timeline?"),
        ("class A extends B {} class B extends A {}", "1:1 class A inherits from itself"),
        ("int x; x = 2; int x;", "1:19 the name 'x' is already taken by another variable or token"),
        ("class Timeline {}", "1:1 class 'Timeline' is part of the language already"),
        ("Plaze p;", "1:1 there is no type named 'Plaze'"),
        ('#include "Missing.nddl"', "1:1 cannot find the file 'Missing.nddl'"),
        ("#define X", "1:1 expected '#include \"file\"', found '#define'"),
        ('string s = "abc', "1:12 this string is not closed on its line: expected '\"'"),
        ("int x; eq(x, 1); /* ...", "1:18 this comment is never closed: expected '*/'"),
        ("int x; x @ 3;", "1:10 '@' does not belong to the language"),
        ("int x; eq(x);", "1:8 constraint eq: expected 2 to any arguments, found 1"),
        (
            "int x; addeq(x, 1, 2);",
            "1:8 there is no constraint, relation or function named 'addeq'; did you mean addEq",
        ),
        ("int x; maxx(x, 1) == 2;", "1:8 there is no function named 'maxx'; did you mean max?"),
        ("int xylo; eq(xylp, 1);", "1:14 'xylp' means nothing here; did you mean xylo"),
        (DOMAIN + "Rover r = new Rover(Hull);", "7:21 'Hull' has no value here; did you mean Hill?"),
        (DOMAIN + "Rover r = new Rover(3);", "7:11 no constructor of class Rover takes (int): there is Rover(Place)"),
        (DOMAIN + "Rover r = new Rover();", "7:11 no constructor of class Rover takes (): there is Rover(Place)"),
        (DOMAIN + "Rover r = new Rver(Hill);", "7:11 there is no class named 'Rver'; did you mean Rover?"),
        (DOMAIN + "goal(Rover.att t);", "7:6 class Rover has no predicate named 'att'; did you mean at?"),
        (DOMAIN + "goal(Rovr.at t);", "7:6 there is no class or object named 'Rovr'; did you mean Rover?"),
        (
            DOMAIN + "goal(Rover.at t); t.plce.specify(Hill);",
            "7:19 a token of Rover.at has no variable 'plce'; did you",
        ),
        (DOMAIN + "Rover r = new Rover(Hill); r.hom.specify(Rock);", "7:28 class Rover has no member named 'hom'"),
        (DOMAIN + "Rover::att { }", "7:1 class Rover has no predicate named 'att'; did you mean at?"),
        (
            DOMAIN + "Rover::at { meats(at next); }",
            "7:13 there is no temporal relation named 'meats'; did you mean meets",
        ),
        (DOMAIN + "Rover::at { meets[1 2](at next); }", "7:13 relation meets: expected at most 0 bounds, found 1"),
        (DOMAIN + "goal(Rover.at t); goal(Rover.at u); t bifore u;", "7:39 expected a temporal relation between two"),
        (DOMAIN + "goal(Rover.at t); t.activat();", "7:19 there is no method named 'activat'; did you mean activate?"),
        (DOMAIN + "goal(Rover.at t); t.reject();", "7:19 't' is a goal: only a rejectable token can be rejected"),
        (
            "class B extends Resource { }",
            "1:1 class B: there is no class named 'Resource'; class Res",
        ),
        (
            "class R extends Reservoir { R() { super(0.0, MINUS_INFINITY, 3.0); } } R r = new R();",
            "1:46",
        ),
        ("enum E {a} E e = 'a';", "1:18 names of values in single quotes are of NDDL 1"),
        (
            DOMAIN + "Rover r = new Rover(Hill); int x; leq(x, r.home);",
            "7:42 expected a number, found r.home",
        ),
        (
            DOMAIN + "Rover r = new Rover(Hill); int x; x + r == 3;",
            "7:39 expected a number, found r, which",
        ),
        ("enum E {a} int x; x < a;", "1:23 expected a number, found a, a value of E"),
        ('int x; abs(x) == 3; max("three", x) == 3;', "1:25 expected a number, found the text"),
        (DOMAIN + "Rover::at { if (place < end) { } }", "7:17 expected a number, found place, which is of type Place"),
        (
            "class P extends Reusable { P() { super(1.0); } } P p = new P(); p.set_capacity(9, 3, 1.0);",
            "1:65 set_capacity",
        ),
        ("class P { } P p = new P(); p.set_limit(1.0, 2.0);", "1:28 set_limit: p is a P, expected a resource"),
        (DOMAIN + "Rover::at { foreach (x in place) {} }", "7:27 foreach: expected an object variable, found 'place'"),
    ],
)
def test_message(text: str, expected: str) -> None:
    assert any(found.startswith(expected) for found in complaints(text)), complaints(text)


def test_all_errors_of_a_file_in_one_go() -> None:
    text = DOMAIN + "Rover::at { meets(att a); eq(plce, Hill); met_by(at b) }\nint x = ;\ngoal(Rover.on t);\nint y;\n"
    assert [line.split()[0] for line in complaints(text)] == ["7:56", "8:9"]
    text = DOMAIN + "Rover::at { meets(att a); eq(plce, Hill); met_by(at b); }\ntypedef Plaze {Hill} Top;\n"
    assert [line.split()[0] for line in complaints(text)] == ["8:1"]
    text = DOMAIN + "Rover::at { meets(att a); eq(plce, Hill); met_by(at b); }\n"
    assert [line.split()[0] for line in complaints(text)] == ["7:19", "7:30"]


def test_the_source_line_is_shown_with_a_caret() -> None:
    with pytest.raises(NddlError) as caught:
        Run("int x;\n\teq(x, yy);\n")
    assert str(caught.value).splitlines()[-2:] == ["    \teq(x, yy);", "    \t      ^"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("class A extends Timeline { predicate p {} } A::p { subgoal(A.p x); }", "'subgoal(...)' is of NDDL 1"),
        ("numeric x;", "the type 'numeric' is of NDDL 1"),
        (
            "class A { } class B extends Timeline { predicate p {} } B::p { A a : { eq(a, a); }; }",
            "': {...}', are of NDDL 1",
        ),
    ],
)
def test_unsupported_is_an_error_of_its_own(text: str, expected: str) -> None:
    with pytest.raises(UnsupportedError) as caught:
        Run(text)
    assert expected in str(caught.value)


def test_an_inconsistent_problem_is_no_error_of_the_text() -> None:
    run = Run(DOMAIN + "Rover r = new Rover(Hill);\ngoal(r.at t);\nt.start.specify(5);\nleq(t.end, 4);\n")
    assert run.exhausted
    assert any("test.nddl:9:1: t.start.specify(5);" in line for line in run.conflict)
    assert any("test.nddl:10:1: leq(t.end, 4);" in line for line in run.conflict)


def test_a_goal_outside_the_horizon_says_so() -> None:
    text = DOMAIN + "PlannerConfig w = new PlannerConfig(0, 10, 100); Rover r = new Rover(Hill); goal(r.at t); "
    run = Run(text + "leq(20, t.start);")
    assert any("goal t" in line and "outside of the horizon [0, 10]" in line for line in run.conflict)


def test_a_database_is_left_alone_by_a_program_that_is_wrong() -> None:
    model, program, report = load_text(DOMAIN + "goal(Rover.at t); u.activate();", STANDARD)
    with pytest.raises(NddlError):
        program.carry_out(PlanDatabase(model, (0, 10)), report)
