"""A file without a horizon is planned for that of `new PlannerConfig()`, and for longer ones if that is too short."""

from __future__ import annotations

from pathlib import Path

import pytest

from scenarios.plan_verb import plan_file

LAMP = "class Lamp extends Timeline { predicate on { eq(duration, 30); } } Lamp lamp = new Lamp(); goal(lamp.on t); "


@pytest.mark.parametrize(
    ("text", "horizon"),
    [
        ("", (0, 100)),
        ("leq(200, t.start);", (0, 1000)),
        (
            "goal(lamp.on u); goal(lamp.on v); t before u; u before v; leq(v.start, 3000); leq(2000, v.start);",
            (0, 10_000),
        ),
        ("PlannerConfig c = new PlannerConfig(0, 70);", (0, 70)),
    ],
)
def test_the_first_horizon_that_has_a_plan(tmp_path: Path, text: str, horizon: tuple[int, int]) -> None:
    path = tmp_path / "lamp.nddl"
    path.write_text(LAMP + text)
    plan = plan_file(path).plan
    assert plan is not None
    assert plan.horizon == horizon


def test_a_horizon_that_the_file_gives_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "lamp.nddl"
    path.write_text(LAMP + "PlannerConfig c = new PlannerConfig(0, 70); leq(200, t.start);")
    answer = plan_file(path)
    assert answer.verdict == "unsolvable"
    assert "lies outside of the horizon [0, 70]" in str(answer.reason)
