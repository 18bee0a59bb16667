"""The plan file: there and back without loss, and a complaint that names the field for every malformed one."""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.errors import PlanFormatError
from planner.plan import FlexiblePlan, PlanConstraint, PlanTimeline, PlanToken

BOUND = st.none() | st.integers(-100, 100)
BOUNDS = st.tuples(BOUND, BOUND)
SCALAR = st.integers(-9, 9) | st.booleans() | st.text(max_size=3) | st.floats(-1, 1)
VALUE = SCALAR | st.lists(SCALAR, max_size=3).map(tuple) | st.fixed_dictionaries({"min": BOUND, "max": BOUND})


@st.composite
def plans(draw: st.DrawFn) -> FlexiblePlan:
    count = draw(st.integers(0, 4))
    tokens = tuple(
        PlanToken(
            f"t{n}",
            draw(st.text(max_size=3)),
            "state",
            "Class.predicate",
            draw(st.dictionaries(st.text(max_size=2), VALUE, max_size=2)),
            draw(BOUNDS),
            draw(BOUNDS),
            draw(BOUNDS),
            draw(st.booleans()),
            draw(st.none() | st.text(max_size=3)),
            draw(st.booleans()),
            draw(st.none() | st.sampled_from([f"t{m}" for m in range(count)])),
        )
        for n in range(count)
    )
    ids = [t.id for t in tokens]
    cut = draw(st.integers(0, count))
    slots = [tuple(part) for part in (ids[:cut], ids[cut:]) if part]
    points = st.sampled_from(["origin", *(f"{i}.{side}" for i in ids for side in ("start", "end"))])
    constraints = st.builds(PlanConstraint, points, points, BOUND, BOUND, st.text(max_size=5))
    start = draw(st.integers(-50, 50))
    return FlexiblePlan(
        draw(st.text(max_size=5)),
        (start, start + draw(st.integers(0, 50))),
        tuple(draw(st.lists(st.text(max_size=3), max_size=2))),
        (PlanTimeline("o", "state", tuple(slots)),),
        tokens,
        tuple(draw(st.lists(constraints, max_size=3))),
    )


@settings(max_examples=150, deadline=None, derandomize=True)
@given(plans())
def test_round_trip(plan: FlexiblePlan) -> None:
    text = json.dumps(plan.to_json())
    again = FlexiblePlan.from_json(json.loads(text))
    assert again == plan
    assert json.dumps(again.to_json()) == text


def example() -> dict[str, Any]:
    token = {
        "id": "t0",
        "object": "camera",
        "attribute": "state",
        "predicate": "Camera.picture",
        "parameters": {"asteroid": "Ida", "gain": {"min": 0, "max": 1.5}, "filter": ["red", "blue"]},
        "start": [0, 5],
        "end": [3, None],
        "duration": [3, 6],
        "contingent": False,
        "goal": None,
    }
    return {
        "format": 1,
        "model": "camera",
        "horizon": [0, 100],
        "objects": ["camera"],
        "timelines": [{"object": "camera", "attribute": "state", "slots": [["t0"]]}],
        "tokens": [token],
        "constraints": [{"from": "origin", "to": "t0.start", "min": 0, "max": 5, "why": "horizon"}],
    }


def test_files(tmp_path: Path) -> None:
    plan = FlexiblePlan.from_json(example())
    plan.save(tmp_path / "plan.json")
    assert FlexiblePlan.load(tmp_path / "plan.json") == plan
    assert plan.token("t0").parameters["filter"] == ("red", "blue")
    assert [t.id for t in plan.hosts()] == ["t0"]
    with pytest.raises(KeyError):
        plan.token("t1")


def replace(*path: str | int, by: object) -> Callable[[dict[str, Any]], None]:
    def change(content: dict[str, Any]) -> None:
        place: Any = content
        for step in path[:-1]:
            place = place[step]
        place[path[-1]] = by

    return change


def drop(*path: str | int) -> Callable[[dict[str, Any]], None]:
    def change(content: dict[str, Any]) -> None:
        place: Any = content
        for step in path[:-1]:
            place = place[step]
        del place[path[-1]]

    return change


MALFORMED = [
    (replace("format", by=2), "plan.format: expected 1, found 2"),
    (drop("model"), "plan: the field 'model' is missing"),
    (replace("model", by=3), "plan.model: expected text, found 3"),
    (replace("horizon", by=[5, 1]), "plan.horizon: expected [start, end] with start <= end, found [5, 1]"),
    (replace("horizon", by=[5]), "plan.horizon: expected [lower, upper], found [5]"),
    (replace("horizon", by=[0, None]), "plan.horizon: expected [start, end] with start <= end"),
    (replace("objects", by="camera"), "plan.objects: expected a list, found 'camera'"),
    (replace("objects", by=[1]), "plan.objects[0]: expected text, found 1"),
    (replace("tokens", by={}), "plan.tokens: expected a list, found {}"),
    (replace("tokens", 0, by=7), "plan.tokens[0]: expected an object, found int"),
    (replace("tokens", 0, "start", by=[0.5, 1]), "plan.tokens[0].start[0]: expected a whole number of ticks or null"),
    (replace("tokens", 0, "end", by=[0, True]), "plan.tokens[0].end[1]: expected a whole number of ticks or null"),
    (replace("tokens", 0, "contingent", by=0), "plan.tokens[0].contingent: expected true or false, found 0"),
    (replace("tokens", 0, "fact", by="yes"), "plan.tokens[0].fact: expected true or false, found 'yes'"),
    (replace("tokens", 0, "goal", by=1), "plan.tokens[0].goal: expected text, found 1"),
    (replace("tokens", 0, "master", by="t9"), "plan.tokens[0].master: 't9' is not a token of the plan"),
    (drop("tokens", 0, "predicate"), "plan.tokens[0]: the field 'predicate' is missing"),
    (replace("tokens", 0, "parameters", by=[]), "plan.tokens[0].parameters: expected an object, found []"),
    (replace("tokens", 0, "parameters", by={"x": None}), "plan.tokens[0].parameters.x: expected a value"),
    (replace("tokens", 0, "parameters", by={"x": [[1]]}), "plan.tokens[0].parameters.x[0]: expected a value"),
    (replace("tokens", 0, "parameters", by={"x": {"min": 0}}), "plan.tokens[0].parameters.x: the field 'max' is miss"),
    (replace("tokens", 0, "parameters", by={"x": {"min": 0, "max": "a"}}), "plan.tokens[0].parameters.x.max: expected"),
    (lambda c: c["tokens"].append(c["tokens"][0]), "plan.tokens: two tokens have the same id"),
    (replace("timelines", 0, "slots", by=[["t1"]]), "plan.timelines[0].slots: ['t1'] is empty or names an unknown"),
    (replace("timelines", 0, "slots", by=[[]]), "plan.timelines[0].slots: [] is empty or names an unknown token"),
    (replace("timelines", 0, "slots", by=[3]), "plan.timelines[0].slots[0]: expected a list, found 3"),
    (replace("timelines", 0, "slots", by=[[["t0"]]]), "plan.timelines[0].slots[0][0]: expected text, found ['t0']"),
    (replace("constraints", 0, "to", by="t1.start"), "plan.constraints[0].to: 't1.start' is not a timepoint"),
    (replace("constraints", 0, "from", by="t0"), "plan.constraints[0].from: 't0' is not a timepoint of the plan"),
    (replace("constraints", 0, "min", by="0"), "plan.constraints[0].min: expected a whole number of ticks or null"),
    (drop("constraints", 0, "why"), "plan.constraints[0]: the field 'why' is missing"),
]


@pytest.mark.parametrize(("change", "message"), MALFORMED, ids=[m for _, m in MALFORMED])
def test_malformed(change: Callable[[dict[str, Any]], None], message: str) -> None:
    content = copy.deepcopy(example())
    change(content)
    with pytest.raises(PlanFormatError, match=re.escape(message)):
        FlexiblePlan.from_json(content)


@pytest.mark.parametrize("content", [None, 3, [], "plan", [[]]])
def test_not_an_object(content: object) -> None:
    with pytest.raises(PlanFormatError, match="plan: expected an object, found"):
        FlexiblePlan.from_json(content)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"{", r"plan.json:1:2: not JSON: "),
        (b'{\n "format": x', r"plan.json:2:12: not JSON: "),
        (b"\xff", r"plan.json: not UTF-8 text at byte 0"),
        (b"[" * 100_000, r"plan.json: nested too deeply to be a plan"),
        (b"{}", r"plan.json: plan: the field 'format' is missing"),
        (b"", r"plan.json:1:1: not JSON: "),
    ],
)
def test_files_that_are_no_plan(tmp_path: Path, data: bytes, message: str) -> None:
    path = tmp_path / "plan.json"
    path.write_bytes(data)
    with pytest.raises(PlanFormatError, match=message):
        FlexiblePlan.load(path)


def test_a_plan_file_is_written_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "plan.json"
    FlexiblePlan.from_json(example()).save(target)
    before = target.read_bytes()
    written = Path.write_text

    def disk_full(path: Path, text: str, encoding: str) -> int:
        written(path, text[:40], encoding=encoding)
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", disk_full)
    with pytest.raises(OSError, match="No space"):
        FlexiblePlan.from_json(example()).save(target)
    assert target.read_bytes() == before
    assert list(tmp_path.iterdir()) == [target]


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(PlanFormatError, match=r"missing.json: No such file or directory"):
        FlexiblePlan.load(tmp_path / "missing.json")


JSON = st.recursive(st.none() | st.booleans() | st.integers() | st.text(max_size=3), lambda c: st.lists(c, max_size=3))


@settings(max_examples=300, deadline=None, derandomize=True)
@given(st.sampled_from(["model", "horizon", "objects", "timelines", "tokens", "constraints", "format"]), JSON)
def test_any_other_content_is_refused_or_read(field: str, value: object) -> None:
    content = example()
    content[field] = value
    with suppress(PlanFormatError):  # and no other error
        FlexiblePlan.from_json(content)
