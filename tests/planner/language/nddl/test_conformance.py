"""What models of other projects rely on: the library's classes and names, and finer points of the statements."""

from __future__ import annotations

from dataclasses import replace

import pytest

from planner.checker import check
from planner.constraints.standard import STANDARD
from planner.language.nddl.errors import UnsupportedError
from planner.language.nddl.operators import ALIASES
from planner.plan import FlexiblePlan
from tests.planner.language.nddl.running import Run

PUMP = """
class Pump extends Timeline {
  predicate idle {}
  predicate run { int speed; }
}
Pump pump = new Pump();
"""
TANK = "class Tank extends Reservoir { Tank(float l) { super(l, 0.0, 10.0); } } Tank tank = new Tank(4.0);"


# The library's classes


@pytest.mark.parametrize(
    ("config", "horizon", "steps"),
    [
        ("PlannerConfig c = new PlannerConfig();", (0, 100), 200),
        ("PlannerConfig c = new PlannerConfig(3, 40);", (3, 40), None),
        ("PlannerConfig c = new PlannerConfig(3, 40, 7);", (3, 40), 7),
        ("PlannerConfig c = new PlannerConfig(3, 40, 7, 5);", (3, 40), 7),
        (
            "class Mine extends PlannerConfig { Mine(int end) { super(0, end, 9); } } Mine c = new Mine(60);",
            (0, 60),
            9,
        ),
        ("", None, None),
    ],
)
def test_the_configuration_gives_horizon_and_limit(
    config: str, horizon: tuple[int, int] | None, steps: int | None
) -> None:
    program = Run(config).program
    assert (program.horizon, program.max_steps) == (horizon, steps)


def test_members_of_the_configuration_can_be_used() -> None:
    run = Run(
        "PlannerConfig c = new PlannerConfig(5, 30, 100, 50);"
        + PUMP
        + "goal(pump.idle t); eq(t.start, c.m_horizonStart); leq(c.m_horizonEnd, t.end);"
    )
    assert run.plan is not None
    assert run.plan.tokens[0].start == (5, 5)
    assert run.plan.tokens[0].end == (30, 30)


def test_texts_as_objects() -> None:
    run = Run('class Rock extends StringData {} Rock a = new Rock("a"); Rock b = new Rock("b"); Rock r; r.data == "b";')
    assert str(run.value("r")) == "b"


def test_members_of_resources_have_the_names_of_their_header() -> None:
    text = (
        "class Own extends Reservoir { Own(float l) { initialCapacity = l; levelLimitMin = 0.0; levelLimitMax = l; } }"
    )
    run = Run(text + "Own own = new Own(4.0); float x; x == own.levelLimitMax + own.initialCapacity;")
    assert run.value("x") == 8


def test_a_transaction_has_a_time() -> None:
    run = Run(
        TANK + PUMP + "Pump::run { any(Tank.consume c); eq(c.time, end); c.quantity == 3.0; }"
        "goal(pump.run t); eq(t.speed, 1); eq(t.start, 2); eq(t.end, 9);"
    )
    assert run.plan is not None
    (consume,) = [t for t in run.plan.tokens if t.predicate == "Reservoir.consume"]
    assert (consume.start, consume.end) == ((9, 9), (9, 9))


def test_a_level_that_begins_beyond_its_limits_is_judged_from_the_first_transaction_on() -> None:
    full = "class Tank extends Reservoir { Tank() { super(50.0, 0.0, 10.0); } } Tank tank = new Tank();"
    drain = "goal(tank.consume c); eq(c.time, 4); c.quantity == %d;"
    assert Run(full).solved
    assert Run(full + drain % 45).solved
    assert not Run(full + drain % 30).solved


def test_a_transaction_at_the_end_of_the_horizon_is_inside() -> None:
    assert Run(TANK + "goal(tank.consume c); eq(c.time, 0); goal(tank.consume d); eq(d.time, 100);").solved
    assert not Run(TANK + "goal(tank.consume c); eq(c.time, 101);").solved


# Names


def test_other_names_are_of_procedures_that_there_are() -> None:
    assert set(ALIASES.values()) <= set(STANDARD.names())
    assert not set(ALIASES) & set(STANDARD.names())


def test_other_names_of_constraints() -> None:
    run = Run("int x = [0 9]; lessThan(x, 3); bool b; testEQ(b, x, 2); eq(b, true);")
    assert run.value("x") == 2


# Statements


def test_a_token_that_a_rule_says_is_active_is_not_merged() -> None:
    text = PUMP + "Pump::run { meets(object.idle i); %s } goal(pump.run t); eq(t.speed, 1); leq(t.end, 9);"
    text += "goal(pump.idle u); u.activate();"
    assert Run(text % "").predicates() == ["Pump.idle", "Pump.run"]
    for said in ("eq(i.state, ACTIVE);", "i.state == ACTIVE;", "eq(ACTIVE, i.state);"):
        assert Run(text % said).predicates() == ["Pump.idle", "Pump.idle", "Pump.run"]
    assert Run(text % "eq(state, ACTIVE);").predicates() == ["Pump.idle", "Pump.run"]
    with pytest.raises(UnsupportedError, match="not for one that is MERGED"):
        Run(text % "eq(i.state, MERGED);")


def test_a_token_constrained_to_come_before_itself_is_only_assigned() -> None:
    run = Run(PUMP + "Pump other = new Pump(); goal(Pump.idle t); other.constrain(t, t);")
    assert run.plan is not None
    assert run.plan.tokens[0].object == "other"


def test_a_rejectable_token_outside_of_the_horizon_is_rejected() -> None:
    text = PUMP + "rejectable(pump.idle t); eq(t.start, 200);"
    run = Run(text)
    assert run.solved
    assert run.predicates() == []
    assert not Run(text + "t.activate();").solved


def test_a_variable_declared_with_another_starts_from_its_values() -> None:
    text = "enum E {a, b, c} E x; neq(x, c); E y = x; "
    assert Run(text + "neq(x, y);").solved
    assert not Run(text + "eq(y, c);").solved
    assert not Run(text.replace("neq(x, c)", "eq(x, b)") + "neq(x, y);").solved


@pytest.mark.parametrize(("closing", "solved"), [("", True), ("close();", False)])
def test_a_variable_of_a_class_without_objects(closing: str, solved: bool) -> None:
    assert Run("class Rock {} Rock any_rock; " + closing).solved == solved


# Inheritance


BASE = "class Base extends Timeline { predicate p { int x; eq(x, 5); eq(duration, 3); } predicate q {} }"


def test_a_predicate_declared_again_keeps_what_was_said_of_it() -> None:
    run = Run(
        BASE + "class Below extends Base { predicate p { int y; x < y; y < 7; } } Below b = new Below();"
        "goal(Below.p t);"
    )
    assert run.plan is not None
    (token,) = run.plan.tokens
    assert token.predicate == "Below.p"
    assert token.parameters == {"x": 5, "y": 6}
    assert token.duration == (3, 3)


@pytest.mark.parametrize("target", ["p", "object.p"])
@pytest.mark.parametrize("where", ["%s", "if (end == 4) { %s }"])
def test_an_inherited_rule_asks_for_the_predicate_of_the_object_itself(target: str, where: str) -> None:
    rule = "Base::q { " + where % f"meets({target} next);" + " }"
    below = "class Below extends Base { predicate p { int y; eq(y, 1); } } Below b = new Below();"
    run = Run(BASE + rule + below + "goal(b.q t); eq(t.end, 4);")
    assert run.predicates() == ["Base.q", "Below.p"]


def test_a_transaction_declared_again_is_still_an_instant() -> None:
    run = Run(
        "class Tank extends Reservoir { predicate consume { int why; eq(why, 3); } Tank() { super(4.0, 0.0, 9.0); } }"
        "Tank tank = new Tank(); goal(tank.consume c); eq(c.quantity, 2.0);"
    )
    assert run.plan is not None
    assert run.plan.tokens[0].duration == (0, 0)


# Variables of the problem in rules


def test_the_plan_says_what_its_rules_know_of_the_problem_and_is_judged_by_it() -> None:
    text = PUMP + "enum Mode {slow, fast} Mode mode; int least = [2 4]; neq(mode, slow);"
    text += "Pump::run { if (mode == fast) { meets(idle i); } eq(speed, least); }"
    run = Run(text + "goal(pump.run t); leq(t.end, 50);")
    assert run.plan is not None
    assert run.plan.variables == {"mode": "fast", "least": 2}
    assert check(FlexiblePlan.from_json(run.plan.to_json()), run.model) == ()
    other = replace(run.plan, variables={"mode": "fast", "least": 3})
    (violation,) = check(other, run.model)
    assert "eq(speed = [2 2], least = [3 3]) does not hold" in str(violation)


# Actions


@pytest.mark.parametrize(
    "local",
    ["Door it = object.door; meets(effect it.open o);", "Door it; eq(it, object.door); meets(effect it.open o);"],
)
def test_an_effect_on_an_object_that_a_local_variable_holds(local: str) -> None:
    run = Run(
        "class Door extends Timeline { predicate open {} predicate closed {} }"
        "class Robot extends Timeline { Door door; Robot(Door d) { door = d; } action push { duration = 2; } }"
        f"Robot::push {{ met_by(condition object.door.closed c); {local} }}"
        "Door door = new Door(); Robot robot = new Robot(door);"
        "fact(door.closed before_); eq(before_.start, 0); goal(door.open wanted); leq(10, wanted.start);"
    )
    assert run.predicates() == ["Door.closed", "Door.open", "Robot.push"]


def test_tokens_off_timelines_that_are_one_are_judged_as_one() -> None:
    run = Run(
        "class Clock { predicate tick { duration = 10; } } Clock clock = new Clock();"
        "Clock::tick { meets(object.tick n); met_by(object.tick p); }"
        "PlannerConfig c = new PlannerConfig(0, 60, 100);"
        "fact(clock.tick first); eq(first.start, 15); fact(clock.tick last); eq(last.start, 35);"
        "goal(clock.tick middle); eq(middle.start, 25);"
    )
    assert run.plan is not None
    assert len(run.plan.tokens) == 5
    assert check(run.plan, run.model) == ()
    apart = tuple(c for c in run.plan.constraints if c.why != "codesignated")
    assert check(replace(run.plan, constraints=apart), run.model) != ()


# Limits of resources

CRANE = """
class Crane extends Reusable { Crane(float c) { super(c, 0.0); } }
class Job extends Timeline { predicate lift { eq(duration, 5); } }
Job::lift { equals(Crane.uses u); eq(u.quantity, 2.0); }
Crane crane = new Crane(3.0); Job job = new Job();
"""


@pytest.mark.parametrize(
    ("limit", "starts", "solved"),
    [
        ("", 10, True),
        ("crane.set_capacity(1.0);", 10, False),
        ("crane.set_capacity(1.0); crane.set_capacity(2.0);", 10, True),
        ("crane.set_capacity(12, 1.0);", 10, False),
        ("crane.set_capacity(12, 1.0);", 7, True),
        ("crane.set_capacity(12, 20, 1.0);", 20, True),
        ("crane.set_capacity(12, 20, 1.0);", 19, False),
        ("crane.set_capacity(0, 50, 1.0); crane.set_capacity(10, 20, 2.0);", 15, True),
        ("crane.set_capacity(0, 50, 1.0); crane.set_capacity(10, 20, 2.0);", 16, False),
        ("crane.set_capacity(0, 50, 1.0); crane.set_capacity(10, 20, 2.0);", 50, True),
    ],
)
def test_the_capacity_of_a_resource_over_time(limit: str, starts: int, solved: bool) -> None:
    run = Run(CRANE + limit + f"goal(job.lift t); eq(t.start, {starts});")
    assert run.solved == solved
    assert run.plan is None or check(run.plan, run.model) == ()


@pytest.mark.parametrize(
    ("limit", "solved"),
    [("", True), ("tank.set_limit(2.0, 10.0);", False), ("tank.set_limit(0, 9, 2.0, 10.0);", True),
     ("tank.setLimit(20, 2.0, 10.0);", False)],
)  # fmt: skip
def test_the_limits_of_a_level_over_time(limit: str, solved: bool) -> None:
    run = Run(TANK + limit + "goal(tank.consume c); eq(c.time, 10); eq(c.quantity, 3.0);")
    assert run.solved == solved
    assert run.plan is None or check(run.plan, run.model) == ()


def test_resources_without_arguments_are_endless() -> None:
    text = "class Pool extends Reusable { Pool() { super(); } } Pool pool = new Pool(); goal(pool.uses u);"
    assert Run(text + "eq(u.quantity, 1000000.0);").solved
    text = "class Pit extends Reservoir { Pit() { super(); } } Pit pit = new Pit(); goal(pit.consume c);"
    assert Run(text + "eq(c.quantity, 1000000.0);").solved


def test_a_grounded_profile_is_kept_in_the_schedule_of_earliest_times_only() -> None:
    text = """
        class Pump extends Reusable { string profileType; Pump(string p) { super(1.0, 0.0); profileType = p; } }
        Pump pump = new Pump("%s"); goal(pump.uses a); goal(pump.uses b);
        a.activate(); b.activate(); eq(a.quantity, 1.0); eq(b.quantity, 1.0); eq(a.duration, 5); eq(b.duration, 5);
        leq(5, b.start);
        """
    grounded, flexible = Run(text % "GroundedProfile"), Run(text % "IncrementalFlowProfile")
    assert grounded.plan is not None
    assert flexible.plan is not None
    assert grounded.plan.token("t0").start[1] > 90
    assert flexible.plan.token("t0").start[1] <= 90
    assert check(grounded.plan, grounded.model) == ()


def test_what_an_action_takes_from_a_resource_asks_for_no_action() -> None:
    run = Run(
        TANK
        + """
        class Valve extends Timeline { predicate Shut {} predicate Open {} }
        class Keeper {
          Valve valve; Tank tank;
          Keeper(Tank t) { valve = new Valve(); tank = t; }
          action Turn { eq(duration, 2); }
        }
        Keeper::Turn {
          met_by(condition object.valve.Shut);
          meets(effect object.valve.Open);
          starts(effect object.tank.consume c);
          eq(c.quantity, 1.0);
        }
        Keeper keeper = new Keeper(tank);
        fact(keeper.valve.Shut s); eq(s.start, 0);
        goal(tank.consume leak); leak.time.specify(30); leak.quantity.specify(1.0);
        goal(keeper.valve.Open o); leq(o.start, 20); leq(5, o.start);
        """
    )
    assert run.plan is not None
    predicates = [token.predicate for token in run.plan.tokens]
    assert (predicates.count("Keeper.Turn"), predicates.count("Reservoir.consume")) == (1, 2)
    assert check(run.plan, run.model) == ()


def test_numbers_of_a_rule_that_follow_from_each_other_are_found_by_the_checker() -> None:
    run = Run(
        PUMP
        + """
        class Survey extends Timeline { predicate leg { float east; float north; float speed; } }
        Survey::leg {
          float square, east_2, north_2;
          abs(east) == sqrt(east_2);
          abs(north) == sqrt(north_2);
          square == east_2 + north_2;
          speed == sqrt(square);
        }
        Survey survey = new Survey();
        goal(survey.leg l); l.east.specify(-3.0); l.north.specify(4.0);
        """
    )
    assert run.plan is not None
    assert run.plan.tokens[0].parameters["speed"] == 5.0
    assert check(run.plan, run.model) == ()
