"""Bad input: status 2, one complaint that says where, and nothing written."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenarios.config import parse
from scenarios.errors import ScenarioError
from tests.scenarios.commands import SMALL, remote_agent, small

GOAL = 'predicate = "Navigation.session"'
TARGET = 'parameters = { target = "asteroid_b" }'
WINDOW = 'window = ["40m", "2h"]'
HORIZON = 'horizon = "3h"'
FAULT = 'name = "micas-stuck-on"\nat = "30m"'

CHANGES = (
    (HORIZON, "horizon = -3", "horizon: input should be greater than"),
    (HORIZON, "horizon = 0", "horizon: input should be greater than"),
    (HORIZON, "horizon = 10000000000000000000000", "horizon: input should be less than"),
    (HORIZON, "horizon = 3.5", "horizon: expected seconds or a time such as 3h20m, found 3.5"),
    (HORIZON, "horizon = true", "horizon: expected seconds"),
    (HORIZON, 'horizon = "soon"', "found 'soon'"),
    (HORIZON, 'horizon = "99999999999h"', "horizon: expected seconds"),
    (HORIZON, "", "horizon: field required"),
    (HORIZON, HORIZON + "\nhorison = 3", "horison: unknown key"),
    (HORIZON, HORIZON + "\nepoch = 3", "epoch: expected a date and time"),
    (HORIZON, HORIZON + "\nepoch = 0001-01-01T00:00:00Z", "epoch: expected a year"),
    ('name = "small"', "name = 7", "name: input should be a valid string"),
    ('name = "small"', 'name = "small', "at line 2, column"),
    (GOAL, 'predicate = "Navigation.sesion"', "goals[0].predicate: class Navigation has no predicate named 'sesion'"),
    (GOAL, 'predicate = "session"', "goals[0].predicate: expected a predicate as Class.predicate"),
    (GOAL, 'predicate = "Navigator.session"', "did you mean Navigation?"),
    (
        TARGET,
        'parameters = { targt = "asteroid_b" }',
        "goals[0].parameters: Navigation.session has no parameter 'targt'",
    ),
    (TARGET, 'parameters = { target = "asteroid_e" }', "goals[0].parameters.target: expected one of"),
    (TARGET, "parameters = { target = [] }", "goals[0].parameters.target: expected a value"),
    (TARGET, "parameters = { target = { a = 1 } }", "goals[0].parameters"),
    ("priority = 5", "priority = 1.5", "goals[0].priority"),
    ("priority = 5", "priority = true", "goals[0].priority"),
    ("priority = 5", "priority = 10000000000000000000000", "goals[0].priority"),
    (WINDOW, 'window = ["2h", "40m"]', "goals[0].window: expected a start before the end"),
    (WINDOW, 'window = ["40m"]', "goals[0].window"),
    (WINDOW, 'window = ["3h", "4h"]', "goals[0].window: expected a start before the horizon"),
    (WINDOW, WINDOW + '\nlasting = "2h"', "goals[0].lasting: expected at most the window's 4800 s"),
    (WINDOW, WINDOW + "\nlasting = -1", "goals[0].lasting"),
    ('id = "session"', 'id = "downlink"', "goals[1].id: 'downlink' is already the id of goals[0]"),
    ('id = "session"', 'id = ""', "goals[0].id"),
    (FAULT, 'name = "micas-stuck"\nat = 1', "faults[0].name: there is no fault named 'micas-stuck'; did you mean"),
    (FAULT, 'name = "micas-stuck-on"\nat = "4h"', "faults[0].at: expected less than the horizon"),
    (FAULT, 'name = "micas-stuck-on"\nat = 9\nuntil = 9', "faults[0]: fault micas-stuck-on: expected an end after"),
    (FAULT, 'name = "slow-slew"\nat = 9\nparameters = { factor = 7 }', "factor: expected 0.01 to 1, found 7"),
    (FAULT, 'name = "slow-slew"\nat = 9\nparameters = { facter = 0.7 }', "found 'facter'"),
    (FAULT, 'name = "slow-slew"\nat = 9\nparameters = { factor = "x" }', "faults[0].parameters.factor"),
    (HORIZON, HORIZON + "\nspacecraft = { sun_distance = 1 }", "spacecraft: there is no field 'sun_distance'"),
    (HORIZON, HORIZON + '\nspacecraft = { sun_distance_au = "near" }', "spacecraft.sun_distance_au: expected a number"),
    (HORIZON, HORIZON + "\nspacecraft = { sun_distance_au = 0 }", "spacecraft.sun_distance_au: expected more than 0"),
    (HORIZON, HORIZON + "\nspacecraft = { sun_distance_au = nan }", "spacecraft.sun_distance_au"),
    (HORIZON, HORIZON + "\nspacecraft.orbit = 1", "spacecraft.orbit: expected a table"),
    (HORIZON, HORIZON + "\nspacecraft.orbit = { eccentricity = 0.1 }", "spacecraft.orbit.semimajor_axis_au: missing"),
    (HORIZON, HORIZON + "\nspacecraft.orbit = { semimajor_axis = 1 }", "spacecraft.orbit: there is no field"),
    (
        HORIZON,
        HORIZON + "\nspacecraft.targets.asteroid_a.orbit = { semimajor_axis_au = 2, eccentricity = 1.5 }",
        "spacecraft.targets.asteroid_a.orbit.eccentricity: expected 0 to under 1",
    ),
    (HORIZON, HORIZON + "\nspacecraft.targets.asteroid_e = {}", "spacecraft.targets.asteroid_e.kind: missing"),
    (HORIZON, HORIZON + '\nspacecraft.targets.moon.kind = "moon"', "spacecraft.targets, 'moon': expected a kind of"),
    (HORIZON, HORIZON + "\nspacecraft = { camera_warmup_s = [1] }", "spacecraft.camera_warmup_s: expected 2 numbers"),
    (HORIZON, HORIZON + "\nspacecraft = { settle_hold_s = 1.5 }", "spacecraft.settle_hold_s: expected a whole number"),
    (HORIZON, HORIZON + '\nspacecraft = { initial_target = "mars" }', "spacecraft.initial_target: expected one of"),
)


def refused(tmp_path: Path, complaint: str, *arguments: object) -> None:
    """The command complains in these words, and leaves the folder as it was."""
    before = sorted(tmp_path.rglob("*"))
    answer = remote_agent(*arguments)
    assert answer.status == 2, answer
    assert answer.out == ""
    assert complaint in answer.err
    assert "Traceback" not in answer.err
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize(("old", "new", "complaint"), CHANGES)
def test_a_wrong_field_is_named(tmp_path: Path, old: str, new: str, complaint: str) -> None:
    path = small(tmp_path, (old, new))
    refused(tmp_path, complaint, "run", path, "--out", tmp_path / "run")
    assert str(path) in remote_agent("run", path).err


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"", "name: field required"),
        (b"\xff\xfe\x00binary", "not UTF-8 text at byte 0"),
        (b"\x00\x01\x02", "not TOML"),
        (b"a = " + b"[" * 5000, "not TOML"),
        (b"a = " + b"9" * 5000, "not TOML"),
        (b"goals = 3", "goals"),
        (b"[[goals]]\n[goals]\n", "at line 2"),
    ],
)
def test_a_file_that_is_no_scenario(tmp_path: Path, content: bytes, complaint: str) -> None:
    (tmp_path / "bad.toml").write_bytes(content)
    refused(tmp_path, complaint, "run", tmp_path / "bad.toml", "--out", tmp_path / "run")


def test_scenarios_that_are_not_there(tmp_path: Path) -> None:
    (tmp_path / "folder.toml").mkdir()
    out = ("--out", tmp_path / "run")
    refused(tmp_path, "did you mean opnav-12h?", "run", "opnav-12", *out)
    refused(tmp_path, "there are", "run", "zzz", *out)
    refused(tmp_path, "No such file", "run", tmp_path / "none.toml", *out)
    refused(tmp_path, "directory", "run", tmp_path / "folder.toml", *out)


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (("--fault", "micas-stuk-on"), "did you mean micas-stuck-on"),
        (("--fault", "micas-stuck-on@bad"), "--fault micas-stuck-on@bad: expected seconds or a time"),
        (("--fault", "micas-stuck-on@"), "expected seconds or a time"),
        (("--fault", "micas-stuck-on@-5"), "expected seconds or a time"),
        (("--fault", "micas-stuck-on@99h"), "after the horizon"),
        (("--fault", "slow-slew"), "the scenario gives no time for it"),
        (("--fault", "slow-slew@1h", "--no-faults"), "contradict"),
        (("--seed", "-1"), "--seed: expected a whole number of at least 0, found -1"),
        (("--seed", "x"), "--seed"),
        (("--frob",), "--frob"),
    ],
)
def test_wrong_options(tmp_path: Path, options: tuple[str, ...], complaint: str) -> None:
    refused(tmp_path, complaint, "run", "opnav-12h", "--out", tmp_path / "run", *options)


def test_folders_that_cannot_be_taken(tmp_path: Path) -> None:
    full = tmp_path / "full"
    full.mkdir()
    (full / "something").touch()
    scenario = small(tmp_path)
    refused(tmp_path, "there is something already", "run", scenario, "--out", full)
    refused(tmp_path, "there is something already", "run", scenario, "--out", full / "something")
    refused(tmp_path, "Not a directory", "run", scenario, "--out", full / "something" / "run")
    answer = remote_agent("run", scenario, "--out", "/proc/nothing/run")
    assert (answer.status, answer.out) == (2, "")
    assert "/proc/nothing/run" in answer.err


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_without_permission(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    refused(tmp_path, "Permission denied", "run", "opnav-12h", "--out", tmp_path / "run")


@pytest.mark.parametrize("verb", [("review", "--html"), ("review", "--png")])
def test_reviewing_what_is_no_run(tmp_path: Path, verb: tuple[str, str]) -> None:
    (tmp_path / "empty").mkdir()
    refused(tmp_path, "expected", verb[0], tmp_path / "empty", verb[1], tmp_path / "out")
    refused(tmp_path, "expected", verb[0], tmp_path / "none", verb[1], tmp_path / "out")


@pytest.mark.parametrize(
    ("content", "complaint"),
    [("", "not JSON"), ("{}", "'format'"), ("[1]", "plan"), ('{"format": 9}', "plan.format: expected 1, found 9")],
)
def test_checking_what_is_no_plan(tmp_path: Path, content: str, complaint: str) -> None:
    (tmp_path / "plan.json").write_text(content)
    refused(tmp_path, complaint, "check", tmp_path / "plan.json", "opnav-12h")


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (("--procedures", "nothing.py"), "procedures nothing.py: expected a Python file, found none"),
        (("--procedures", "no.such.module"), "No module named 'no'"),
        (("--svg", "missing/plan.svg"), "--svg missing/plan.svg: No such file or directory"),
        (("--svg", "."), "--svg .: Is a directory"),
        (("--out", ""), "--out .: Is a directory"),
    ],
)
def test_planning_with_options_that_lead_nowhere(tmp_path: Path, options: tuple[str, str], complaint: str) -> None:
    (tmp_path / "x.nddl").write_text("int x;")
    refused(tmp_path, complaint, "plan", tmp_path / "x.nddl", *options)
    refused(tmp_path, "No such file", "check", tmp_path / "none.json", "opnav-12h")


@pytest.mark.parametrize("verb", ["check", "simulate"])
def test_networks_that_are_none(tmp_path: Path, verb: str) -> None:
    good, bad = tmp_path / "good.json", tmp_path / "bad.json"
    good.write_text('{"timepoints": ["a", "b"], "constraints": [{"from": "a", "to": "b", "min": 1, "max": 2}]}')
    bad.write_text('{"timepoints": ["a"], "constraints": [{"from": "a", "to": "c"}]}')
    refused(tmp_path, "constraints[0].to", "stnu", verb, good, bad)
    refused(tmp_path, "No such file", "stnu", verb, tmp_path / "none.json")
    if verb == "simulate":
        refused(tmp_path, "--runs", "stnu", verb, good, "--runs", "0")
        refused(tmp_path, "--strategy", "stnu", verb, good, "--strategy", "luck")
        refused(tmp_path, "--seed", "stnu", verb, good, "--seed", "-1")


LINES = SMALL.strip().splitlines()
VALUES = st.sampled_from(
    ["-1", "1e400", "nan", "true", '""', '"x"', "[]", "[[]]", "{}", "{ a = 1 }", "9" * 30, "1979-05-27", '"1h"', "0.5"]
)


@settings(max_examples=60, derandomize=True, deadline=None)
@given(st.integers(0, len(LINES) - 1), VALUES)
def test_any_value_in_any_field_is_taken_or_refused_with_its_place(line: int, value: str) -> None:
    key, equals, _ = LINES[line].partition(" = ")
    if not equals:
        return
    text = "\n".join([*LINES[:line], f"{key} = {value}", *LINES[line + 1 :]])
    complaint = complaint_about(text)
    assert all(line.startswith("small.toml: ") for line in complaint.splitlines())
    assert not complaint or key.strip() in complaint


def complaint_about(text: str) -> str:
    try:
        parse(text, "small.toml")
    except ScenarioError as error:
        return str(error)
    return ""
