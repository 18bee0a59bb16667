"""Procedures of a model's own: found by name, used by planner and checker, and their mistakes told as bad input."""

from __future__ import annotations

from pathlib import Path

import pytest

from planner.checker import check
from planner.constraints.user import procedures_of, registry_with
from planner.database import PlanDatabase
from planner.domains import Interval
from planner.errors import ModelError
from planner.extraction import extract
from planner.language.nddl.builder import load_text
from planner.language.nddl.errors import NddlError
from planner.search.engines import ENGINES
from planner.search.outcome import Limits

TRAVEL = '''
from dataclasses import dataclass
from math import inf


@dataclass
class _Unused:
    number: int


def travelTime(distance, speed, duration):
    """duration >= distance / speed"""
    return distance, speed, duration.bounded(distance.lower / speed.upper, inf)


def anySum(*terms):
    """nothing"""
    return terms


def _helper(a):
    return a
'''
MODEL = """
class Rover extends Timeline { predicate drive { int metres; travelTime(metres, 3, duration); } }
Rover rover = new Rover();
goal(rover.drive d); eq(d.metres, 10); eq(d.start, 0);
"""


def written(folder: Path, text: str) -> str:
    path = folder / "travel.py"
    path.write_text(text)
    return str(path)


def test_public_functions_of_a_file_by_their_names(tmp_path: Path) -> None:
    found = {p.name: p for p in procedures_of(written(tmp_path, TRAVEL))}
    assert set(found) == {"travelTime", "anySum"}
    assert (found["travelTime"].minimum, found["travelTime"].maximum) == (3, 3)
    assert (found["anySum"].minimum, found["anySum"].maximum) == (0, None)
    assert found["travelTime"].formula == "duration >= distance / speed"


def test_planner_and_checker_use_them(tmp_path: Path) -> None:
    registry = registry_with([written(tmp_path, TRAVEL)])
    model, program, report = load_text(MODEL, registry)
    database = PlanDatabase(model, (0, 100))
    program.carry_out(database, report)
    assert ENGINES["chronological"].search(database, Limits(100, 10)).complete
    plan = extract(database)
    assert plan.tokens[0].duration[0] == 4
    assert not check(plan, model)
    stricter, _, _ = load_text(MODEL.replace("(metres, 3,", "(metres, 2,"), registry)
    assert [v.kind for v in check(plan, stricter)]


def test_a_module_by_its_name() -> None:
    assert {"turnDuration"} <= {p.name for p in procedures_of("tests.planner.constraints.own_procedures")}


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("def f(a):\n    return 1 / 0\n", r"constraint f .*ZeroDivisionError in line 2 for \(\[5 5\]\)"),
        ("def f(a):\n    return a\n", "expected None or 1 domains"),
        ("def f(a):\n    return [a, a]\n", "expected None or 1 domains"),
        ("def f(a):\n    return [3]\n", "expected None or 1 domains"),
    ],
)
def test_what_a_procedure_does_wrong(tmp_path: Path, text: str, complaint: str) -> None:
    (procedure,) = procedures_of(written(tmp_path, text))
    with pytest.raises(ModelError, match=complaint):
        procedure.narrow([Interval(5, 5)])
    model, program, report = load_text("int x = 5; f(x);", registry_with([str(tmp_path / "travel.py")]))
    with pytest.raises(NddlError, match=r"<text>:1:12: .*constraint f"):
        program.carry_out(PlanDatabase(model, (0, 10)), report)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("def f(:\n", "SyntaxError in line 1"),
        ("import nothing_like_this\n", "ModuleNotFoundError"),
        ("x = 1\n", "expected public functions, found none"),
        ("def f(a, *, b):\n    return [a]\n", "expected positional parameters, found b"),
    ],
)
def test_files_that_are_none(tmp_path: Path, text: str, complaint: str) -> None:
    with pytest.raises(ModelError, match=complaint):
        registry_with([written(tmp_path, text)])


def test_nothing_there(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="expected a Python file, found none"):
        registry_with([str(tmp_path / "missing.py")])
    with pytest.raises(ModelError, match=r"No module named 'travel'.*with its \.py"):
        registry_with(["travel"])
