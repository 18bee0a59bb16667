"""The verbs, their help, and what they print for people and for programs."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from scenarios.config import built_in
from sim import FAULTS
from tests.scenarios.commands import remote_agent
from tests.scenarios.conftest import Flown

VERBS = ("run", "scenarios", "faults", "engines", "check", "review", "stnu", "stnu check", "stnu simulate")
CONTROLLABLE = {
    "timepoints": ["a", "b", "c"],
    "constraints": [
        {"from": "a", "to": "b", "min": 1, "max": 5, "contingent": True},
        {"from": "b", "to": "c", "min": 0, "max": 3},
    ],
}
HOPELESS = {
    "timepoints": ["a", "b", "c"],
    "constraints": [
        {"from": "a", "to": "b", "min": 1, "max": 5, "contingent": True},
        {"from": "a", "to": "c", "min": 3, "max": 3},
        {"from": "b", "to": "c", "min": 0, "max": 1},
    ],
}


@pytest.mark.parametrize("verb", ["", *VERBS])
def test_every_verb_has_help(verb: str) -> None:
    answer = remote_agent(*verb.split(), "--help")
    assert answer.status == 0
    assert answer.out.startswith("Usage:")
    assert answer.err == ""
    if not verb:
        assert all(name.split()[0] in answer.out for name in VERBS)


@pytest.mark.parametrize(
    ("verb", "names"),
    [("scenarios", set(built_in())), ("faults", set(FAULTS)), ("engines", {"chronological"})],
)
def test_what_there_is(verb: str, names: set[str]) -> None:
    plain = remote_agent(verb).out.splitlines()
    rows = [json.loads(line) for line in remote_agent(verb, "--json").out.splitlines()]
    assert {row["name"] for row in rows} >= names
    assert {line.split()[0] for line in plain} == {row["name"] for row in rows}
    assert all(row["summary"] for row in rows)


def test_a_plan_of_a_run_is_judged_against_its_scenario(faulted: Flown) -> None:
    for path in sorted((faulted.folder / "plans").iterdir()):
        answer = remote_agent("check", path, "opnav-12h")
        assert (answer.status, answer.out) == (0, f"{path}: valid\n")
        assert remote_agent("check", path, "opnav-12h", "--json").json() == {"valid": True, "violations": []}


def test_a_corrupted_plan_is_told_apart(nominal: Flown, tmp_path: Path) -> None:
    plan = json.loads((nominal.folder / "plans/plan-01.json").read_text())
    goal = next(token for token in plan["tokens"] if token["goal"] == "opnav-1-a")
    goal["parameters"]["target"] = "asteroid_d"
    corrupted = tmp_path / "plan.json"
    corrupted.write_text(json.dumps(plan))
    answer = remote_agent("check", corrupted, "opnav-12h", "--json")
    assert answer.status == 1
    assert not answer.json()["valid"]
    assert any(goal["id"] in row["tokens"] for row in answer.json()["violations"])
    told = remote_agent("check", corrupted, "opnav-12h")
    assert told.status == 1
    assert "opnav-1-a" in told.out


def test_checking_networks(tmp_path: Path) -> None:
    good, bad = tmp_path / "good.json", tmp_path / "bad.json"
    good.write_text(json.dumps(CONTROLLABLE))
    bad.write_text(json.dumps(HOPELESS))
    answer = remote_agent("stnu", "check", good, bad)
    assert answer.status == 0
    first, second = map(json.loads, answer.out.splitlines())
    assert first.keys() == {"file", "dynamically_controllable", "milliseconds", "conflict"}
    assert (first["file"], first["dynamically_controllable"], first["conflict"]) == (str(good), True, [])
    assert not second["dynamically_controllable"]
    assert set(second["conflict"]) == {0, 1, 2}


def test_simulating_networks(tmp_path: Path) -> None:
    good, bad = tmp_path / "good.json", tmp_path / "bad.json"
    good.write_text(json.dumps(CONTROLLABLE))
    bad.write_text(json.dumps(HOPELESS))
    answer = remote_agent("stnu", "simulate", good, "--runs", 40)
    assert answer.status == 0
    row = answer.json()
    assert (row["runs"], row["satisfied"], row["violations"], row["strategy"]) == (40, 40, 0, "rte")
    answer = remote_agent("stnu", "simulate", bad, "--runs", 40, "--strategy", "stn", "--seed", 1)
    assert answer.status == 0
    assert answer.json()["satisfied"] < 40
    assert answer.json()["violations"]
    assert answer.out == remote_agent("stnu", "simulate", bad, "--runs", 40, "--strategy", "stn", "--seed", 1).out


def test_the_terminal_lines_are_broken_between_words(faulted: Flown, monkeypatch: pytest.MonkeyPatch) -> None:
    from contextlib import redirect_stdout
    from io import StringIO

    from scenarios.console import print_summary

    monkeypatch.setenv("COLUMNS", "60")
    out = StringIO()
    with redirect_stdout(out):
        print_summary(faulted.summary, Path("runs/x"))
    words = out.getvalue().split()
    for goal in faulted.summary["goals"]:
        assert goal["id"] in words
    for text in (faulted.summary["plans"][1]["reason"], "unreachable: no plan exists"):
        assert text in " ".join(words)
    assert "unconfirmed" not in out.getvalue()


def test_reviewing_makes_a_page(faulted: Flown, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    answer = remote_agent("review", faulted.folder, "--html", page)
    assert (answer.status, answer.out) == (0, f"{page}\n")
    assert page.read_text() == (faulted.folder / "report.html").read_text()
    assert remote_agent("review", faulted.folder, "--html", page, "--json").json() == {"report": str(page)}
