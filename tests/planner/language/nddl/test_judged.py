"""The judge on plans of programs: rules that name variables of the problem and members that objects leave open."""

from __future__ import annotations

from dataclasses import replace

import pytest

from planner.checker import check
from planner.model.manager import ModelManager
from planner.plan import FlexiblePlan, ParameterValue
from tests.planner.language.nddl.running import Run

LAMPS = """
enum Mode { dim, bright };
enum Tint { red, green };
int limit = [0 5];
int spell = 4;
Mode mode;
class Lamp extends Timeline {
  Tint tint;
  predicate on { int level; }
  predicate off { }
}
Lamp lamp = new Lamp();
Lamp::on {
  leq(level, limit);
  eq(duration, spell);
  if (mode == bright) { meets(off o); }
  if (object.tint == green) { met_by(off p); }
}
close();
mode = bright;
eq(lamp.tint, green);
goal(Lamp.on a);
a.start.specify(3);
eq(a.level, 2);
eq(limit, a.level);
"""


@pytest.fixture
def planned() -> tuple[ModelManager, FlexiblePlan]:
    run = Run(LAMPS)
    assert run.plan is not None
    return run.model, run.plan


def test_the_plan_says_what_was_decided_besides_tokens(planned: tuple[ModelManager, FlexiblePlan]) -> None:
    model, plan = planned
    assert plan.variables == {"limit": 2, "spell": 4, "mode": "bright", "lamp.tint": "green"}
    assert FlexiblePlan.from_json(plan.to_json()) == plan
    assert check(plan, model) == ()


@pytest.mark.parametrize(
    ("name", "value", "kind", "said"),
    [
        ("limit", 1, "configuration", "leq(level = [2 2], limit = [1 1]) does not hold"),
        ("limit", 9, "parameter", "the plan gives limit as 9, expected some of [0 5]"),
        ("spell", 3, "parameter", "the plan gives spell as 3, expected some of [4 4]"),
        ("mode", "dark", "parameter", "the plan gives mode as 'dark', expected some of {dim, bright}"),
        ("lamp.tint", "blue", "parameter", "the plan gives lamp.tint as 'blue', expected some of {red, green}"),
        ("colour", "red", "parameter", "the plan gives colour as 'red', the model has no such variable"),
    ],
)
def test_other_values_are_refused(
    planned: tuple[ModelManager, FlexiblePlan], name: str, value: ParameterValue, kind: str, said: str
) -> None:
    model, plan = planned
    found = check(replace(plan, variables={**plan.variables, name: value}), model)
    assert kind in {v.kind for v in found}
    assert any(said in v.explanation for v in found)


@pytest.mark.parametrize(("name", "value"), [("mode", "bright"), ("lamp.tint", "green")])
def test_what_guards_on_variables_ask_for_must_be_there(
    planned: tuple[ModelManager, FlexiblePlan], name: str, value: str
) -> None:
    model, plan = planned
    off = next(t.id for t in plan.tokens if t.predicate == "Lamp.off" and (name == "mode") == ((t.start[0] or 0) > 3))
    kept = [c for c in plan.constraints if off not in (c.from_.partition(".")[0], c.to.partition(".")[0])]
    slots = replace(plan.timelines[0], slots=tuple(s for s in plan.timelines[0].slots if off not in s))
    left = tuple(t for t in plan.tokens if t.id != off)
    without = replace(plan, tokens=left, constraints=tuple(kept), timelines=(slots,))
    assert "configuration" in {v.kind for v in check(without, model)}
    other = {"bright": "dim", "green": "red"}[value]
    assert "configuration" not in {
        v.kind for v in check(replace(without, variables={**plan.variables, name: other}), model)
    }
