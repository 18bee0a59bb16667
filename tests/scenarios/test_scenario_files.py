"""The scenarios that come with the project: what each declares comes out, and what a file must not say is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from executive.network import PlanNetwork
from planner.problem import Problem
from planner.temporal.controllability import check
from scenarios.config import Scenario, built_in, load, parse, template_text
from scenarios.errors import ScenarioError
from scenarios.faults import own_faults
from scenarios.judging import violations_of
from scenarios.run import Flight, RunOptions
from scenarios.summary import fell_short, unmet
from sim.config import DEFAULT_TARGETS
from sim.environment import Environment
from sim.orbits import AU_M, Elements
from tests.scenarios.commands import SMALL

FLOWN_HERE = ("rax-12h", "rax-6h", "rax-hang")
"""Those that are flown in seconds; all are flown with many seeds by hand."""


@pytest.mark.parametrize("name", sorted(built_in()))
def test_a_scenario_file_says_what_it_is(name: str) -> None:
    scenario = load(name)
    assert scenario.name == name
    assert scenario.summary
    assert scenario.goals


@pytest.mark.parametrize("name", FLOWN_HERE)
def test_a_scenario_comes_out_as_declared(name: str) -> None:
    scenario = load(name)
    flight = Flight(scenario, RunOptions(1, own_faults(scenario, 1), images=False))
    summary = flight.fly_unrecorded()
    assert summary["unmet"] == []
    assert summary["flight_rules"]["violations"] == []
    assert not fell_short(summary)
    for adopted in flight.plans:
        assert violations_of(adopted.plan, scenario) == ()
        assert check(PlanNetwork.of(adopted.plan).stnu).controllable


def test_a_plan_from_the_ground_is_judged_before_it_flies() -> None:
    scenario = load("rax-12h")
    assert scenario.plan is not None
    Flight(scenario, RunOptions(0))
    cut = replace(scenario.plan, constraints=scenario.plan.constraints[:-20])
    with pytest.raises(ScenarioError, match="rax-12h: plan: "):
        Flight(scenario.model_copy(update={"plan": cut}), RunOptions(0))


def test_with_a_plan_from_the_ground_no_planner_is_aboard() -> None:
    scenario = load("rax-12h")
    flight = Flight(scenario, RunOptions(0))
    assert scenario.plan is not None
    assert flight.think(Problem(scenario.plan.horizon)).plan == scenario.plan
    answer = flight.think(Problem((7200, scenario.horizon)))
    assert answer.plan is None
    assert answer.reason == "no planner is aboard: the plan came from the ground"


def test_promises_that_are_not_kept_are_named() -> None:
    scenario = parse(SMALL + '\n[expect]\nreplans = 0\nrecoveries = 2\nachieved = ["session"]\n', "mine.toml")
    goals = [{"id": "session", "status": "dropped"}, {"id": "downlink", "status": "achieved"}]
    summary = {"outcome": "degraded", "expected": "completed", "replans": 1, "recoveries": 1, "goals": goals}
    assert unmet(summary, scenario, own_faults=False) == ["outcome: expected completed at least, found degraded"]
    assert unmet(summary, scenario, own_faults=True)[1:] == [
        "replans: expected 0 at most, found 1",
        "recoveries: expected 2 at least, found 1",
        "goal session: expected achieved, found dropped",
    ]


def test_faults_by_chance_are_the_seeds_own() -> None:
    scenario = parse(SMALL + '\n[[fault_rates]]\nname = "ips-recycle"\nmean_between = "15m"\n', "mine.toml")
    one, again, other = (own_faults(scenario, seed) for seed in (1, 1, 2))
    assert one == again != other
    assert one[0] == scenario.faults[0]
    assert {fault.name for fault in one[1:]} == {"ips-recycle"}
    assert all(fault.at < scenario.horizon for fault in one)


@pytest.mark.parametrize(
    ("more", "complaint"),
    [
        ("waypoints = ['4h']", r"waypoints\[0\]: expected ascending times before the horizon's end"),
        ("waypoints = ['2h', '1h']", r"waypoints\[1\]: expected ascending"),
        ("plan = 'nowhere.json'", "plan: .*nowhere.json: No such file"),
        ("plan = 3", "plan: "),
        ("[expect]\nachieved = ['sesion']", "expect.achieved: there is no goal 'sesion'; did you mean"),
        ("[expect]\nreplans = -1", "expect.replans: "),
    ],
)
def test_what_a_file_must_not_say(tmp_path: Path, more: str, complaint: str) -> None:
    head, _, tail = SMALL.partition("[[goals]]")
    text = f"{head}{more}\n[[goals]]{tail}" if not more.startswith("[") else f"{SMALL}\n{more}\n"
    with pytest.raises(ScenarioError, match=f"mine.toml: {complaint}"):
        parse(text, "mine.toml", tmp_path)


def test_a_file_is_a_scenario() -> None:
    assert isinstance(parse(SMALL, "mine.toml"), Scenario)


def test_the_template_is_a_scenario() -> None:
    assert parse(template_text(), "mine.toml").expect.achieved == ("photos", "thrust")


def test_orbits_of_spacecraft_and_targets_can_be_given() -> None:
    """In a line with the Sun on circles: distances by hand, and the run is flown where the file says."""
    text = (
        SMALL
        + """
[spacecraft.orbit]
semimajor_axis_au = 1.0
mean_anomaly_deg = 180.0
[spacecraft.targets.asteroid_b]
angular_diameter_rad = 0.0
orbit = { semimajor_axis_au = 1.5, mean_anomaly_deg = 180.0 }
[spacecraft.targets.asteroid_e]
kind = "asteroid"
orbit = { semimajor_axis_au = 2.0 }
"""
    )
    scenario = parse(text, "orbits.toml")
    config = scenario.spacecraft_config()
    assert config.orbit == Elements(1.0, mean_anomaly_deg=180.0)
    changed = {target.name: target for target in config.targets}
    assert {name for name in changed if changed[name] not in DEFAULT_TARGETS} == {"asteroid_b", "asteroid_e"}
    assert changed["asteroid_b"].magnitude == 9.0
    sky = Environment(config)
    assert sky.sun_distance_au(0.0) == pytest.approx(1.0, rel=1e-12)
    assert sky.distance_m("asteroid_b", 0.0) == pytest.approx(0.5 * AU_M, rel=1e-12)
    assert sky.distance_m("asteroid_e", 0.0) == pytest.approx(3.0 * AU_M, rel=1e-12)
    summary = Flight(scenario, RunOptions(0, images=False)).fly_unrecorded()
    assert (summary["outcome"], summary["flight_rules"]["violations"]) == ("completed", [])
