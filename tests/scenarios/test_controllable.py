"""Plans that hold whatever nature decides: one that does not is repaired; where none does it is said why."""

from __future__ import annotations

from pathlib import Path

import pytest

from executive.network import conflict_of
from planner.search.engines import ENGINES
from scenarios.plan_verb import plan_file

MODEL = """
class Probe {
  attribute mode {
    predicate warm { contingent duration = [5 50]; }
    predicate quick { contingent duration = [5 6]; }
    predicate measure { duration = 3; }
  }
}
class Clock {
  attribute state { predicate tick { int n; duration = 2; 1 <= n; n <= 6; } }
}
Probe::measure {
  either { met_by(warm by_heater); by_heater.start == 10; } or { WAY }
}
Clock clock = new Clock();
Probe probe = new Probe();
PlannerConfig world = new PlannerConfig(0, 200, 2000);
"""
GOALS = """
goal(Probe.measure one);
one.start == [15 20];
goal(Clock.tick a);
goal(Clock.tick b);
goal(Clock.tick c);
close();
"""


def problem(folder: Path, way: str) -> Path:
    path = folder / "probe.nddl"
    path.write_text('#include "PlannerConfig.nddl"\n' + MODEL.replace("WAY", way) + GOALS)
    return path


@pytest.mark.parametrize("engine", ENGINES)
def test_a_first_plan_that_nature_could_break_is_repaired(engine: str, tmp_path: Path) -> None:
    answer = plan_file(problem(tmp_path, "met_by(quick by_hand);"), engine=engine)
    assert answer.plan is not None, answer.reason
    assert conflict_of(answer.plan) is None
    assert {"Probe.quick", "Probe.measure"} <= {token.predicate for token in answer.plan.tokens}


@pytest.mark.parametrize("engine", ENGINES)
def test_where_nature_can_break_every_plan_the_reason_is_in_the_words_of_the_domain(
    engine: str, tmp_path: Path
) -> None:
    answer = plan_file(problem(tmp_path, "met_by(warm late); late.start == 9;"), engine=engine, max_steps=3000)
    assert answer.plan is None
    assert answer.reason is not None
    assert "Probe.warm, decided by nature" in answer.reason
    if engine == "backjumping":
        assert answer.verdict == "unsolvable"
        assert answer.steps < 60  # what the clock does is beside the point
