"""The example models: each solved, judged, and saying what its comment promises."""

from __future__ import annotations

from pathlib import Path

import pytest

import scenarios
from planner.checker import check
from planner.errors import ProblemError
from planner.language.nddl.errors import NddlError
from scenarios.plan_verb import PlanAnswer, plan_file

FOLDER = Path(scenarios.__file__).parent / "examples"
SURVEY = "survey/survey"
TRAVEL = [str(FOLDER / "survey" / "travel.py")]
NAMES = [*sorted(path.stem for path in FOLDER.glob("*.nddl")), SURVEY]


def answer(name: str) -> PlanAnswer:
    own = TRAVEL if name == SURVEY else ()
    return plan_file(FOLDER / f"{name}.nddl", max_seconds=20, procedures=own)


def test_there_are_examples() -> None:
    assert set(NAMES) >= {"blocks", "light_switch", "project_scheduling", "rover_battery", "satellite"}


@pytest.mark.parametrize("name", NAMES)
def test_solved_and_valid(name: str) -> None:
    found = answer(name)
    assert found.solved, found.reason
    assert found.plan is not None
    wrong = [str(v) for v in check(found.plan, found.model)]
    assert not [v for v in wrong if "cannot judge" not in v]
    content = found.to_json()
    assert content["solved"] is True
    assert content["tokens"] == len(found.plan.tokens) > 0
    assert content["reason"] is None


def test_light_switch_invents_the_key_press() -> None:
    plan = answer("light_switch").plan
    assert plan is not None
    (press,) = [t for t in plan.tokens if t.predicate == "Switch.press"]
    (shining,) = [t for t in plan.tokens if t.predicate == "Lamp.shining"]
    assert press.goal is None
    assert press.end == shining.start
    assert shining.start == (10, 15)


def test_blocks_are_stacked_in_the_right_order() -> None:
    plan = answer("blocks").plan
    assert plan is not None
    moves = sorted(
        (t.start, t.parameters["block"], t.parameters["to"]) for t in plan.hosts() if t.predicate == "Hand.move"
    )
    assert [move[1:] for move in moves][-2:] == [("b", "c"), ("a", "b")]


def test_rover_takes_the_way_over_the_hill_and_charges_first() -> None:
    plan = answer("rover_battery").plan
    assert plan is not None
    drives = sorted((t.start, t.parameters["to"]) for t in plan.hosts() if t.predicate == "Rover.drive")
    assert [place for _, place in drives] == ["Hill", "Rock"]
    (charge,) = [t for t in plan.hosts() if t.predicate == "Panel.charge"]
    (sample,) = [t for t in plan.hosts() if t.predicate == "Arm.sample"]
    assert charge.end[1] is not None
    assert sample.start[1] is not None
    assert charge.end[1] <= sample.start[1]


def test_project_keeps_workers_and_cranes() -> None:
    plan = answer("project_scheduling").plan
    assert plan is not None
    for resource, capacity in (("workers", 5), ("cranes", 2)):
        uses = [t for t in plan.tokens if t.object == resource]
        assert uses
        for tick in range(60):
            used = sum(_number(t.parameters["quantity"]) for t in uses if _earliest(t.start) <= tick < _earliest(t.end))
            assert used <= capacity


def test_satellite_turns_the_wish_down() -> None:
    found = answer("satellite")
    assert found.rejected == ("glacier",)
    assert found.plan is not None
    assert [t.parameters["target"] for t in found.plan.hosts() if t.predicate == "Camera.picture"] == ["Volcano"]
    (slew,) = [t for t in found.plan.hosts() if t.predicate == "Attitude.slewing"]
    assert slew.contingent


def test_survey_drives_as_long_as_its_procedure_says_and_looks_by_day() -> None:
    plan = answer(SURVEY).plan
    assert plan is not None
    drives = {(t.parameters["origin"], t.parameters["target"]): t for t in plan.hosts() if t.predicate == "Rover.drive"}
    assert {way: drive.duration for way, drive in drives.items()} == {
        ("Home", "Near"): (12, 18),
        ("Near", "Far"): (20, 31),
        ("Far", "Home"): (30, 47),
    }
    assert all(drive.contingent for drive in drives.values())
    assert {f"{line.object}.{line.attribute}" for line in plan.timelines} >= {"rover.wheels", "rover.mast"}
    assert not [t for t in plan.tokens if t.predicate == "Reservoir.consume"]  # the first alternative, which is free


def test_survey_in_the_dark_takes_the_other_alternative(tmp_path: Path) -> None:
    path = tmp_path / "dark.nddl"
    path.write_text((FOLDER / f"{SURVEY}.nddl").read_text().replace("day.end == DUSK", "day.end == 25"))
    found = plan_file(path, max_seconds=20, procedures=TRAVEL)
    assert not found.solved  # the battery has the power of one panorama
    path.write_text(path.read_text().replace("CHARGE = 50.0", "CHARGE = 60.0"))
    found = plan_file(path, max_seconds=20, procedures=TRAVEL)
    assert found.plan is not None
    assert len([t for t in found.plan.tokens if t.predicate == "Reservoir.consume"]) == 2


def test_verdicts(tmp_path: Path) -> None:
    path = tmp_path / "problem.nddl"
    path.write_text("typedef int [0 1] Bit; Bit f; Bit x; Bit y; Bit z; neq(x, y); neq(y, z); neq(x, z);")
    assert plan_file(path).verdict == "unsolvable"
    assert plan_file(path, max_steps=2).verdict == "limit"
    path.write_text("int x; eq(x, 1); eq(x, 2);")
    found = plan_file(path)
    assert found.verdict == "unsolvable"
    assert found.reason is not None
    assert "initial state is inconsistent" in found.reason
    assert len(found.conflict) == 2


def test_bad_input(tmp_path: Path) -> None:
    with pytest.raises(NddlError, match="cannot read"):
        plan_file(tmp_path / "nothing.nddl")
    path = tmp_path / "problem.nddl"
    path.write_text("int x;")
    with pytest.raises(ProblemError, match="engine"):
        plan_file(path, engine="magic")
    with pytest.raises(ProblemError, match="horizon"):
        plan_file(path, horizon=(5, 5))


def _number(value: object) -> float:
    assert isinstance(value, int | float)
    return value


def _earliest(bounds: tuple[int | None, int | None]) -> int:
    assert bounds[0] is not None
    return bounds[0]
