"""Network files and values: what is read exactly, and what is refused with the place named."""

from __future__ import annotations

import json
from decimal import Decimal
from pathlib import Path

import pytest
from hypothesis import given, settings

from planner.errors import NetworkFormatError
from planner.temporal.stnu import UNBOUNDED, Link, Stnu
from tests.strategies_stnu import lanes_networks


def network(*constraints: object, timepoints: object = ("a", "b", "c")) -> object:
    return {
        "timepoints": list(timepoints) if isinstance(timepoints, tuple) else timepoints,
        "constraints": list(constraints),
    }


def link(**fields: object) -> dict[str, object]:
    return {"from": "a", "to": "b", "min": 1, "max": 2} | fields


def test_reads_what_the_format_says() -> None:
    stnu = Stnu.from_json(
        network(link(contingent=True), {"from": "b", "to": "c", "min": None}, {"from": "c", "to": "a", "max": 4})
    )
    assert stnu.timepoints == ("a", "b", "c")
    assert stnu.links == (Link(0, 1, 1, 2, True), Link(1, 2), Link(2, 0, None, 4))
    assert stnu.table.tolist() == [[0, 1, 1, 2, 1], [1, 2, -UNBOUNDED, UNBOUNDED, 0], [2, 0, -UNBOUNDED, 4, 0]]
    assert list(stnu.contingent_links()) == [0]


def test_scales_decimal_text_exactly() -> None:
    stnu = Stnu.from_json(network(link(min=0.1, max=0.3), link(min=-0.25, max=1)))
    assert stnu.ticks_per_unit == 20
    assert stnu.table[:, 2:4].tolist() == [[2, 6], [-5, 20]]


def test_a_file_keeps_digits_that_a_float_would_lose(tmp_path: Path) -> None:
    path = tmp_path / "network.json"
    text = (
        '{"timepoints": ["a", "b"], "constraints": [{"from": "a", "to": "b", "min": 1.00000000000000001, "max": 2e0}]}'
    )
    path.write_text(text)
    stnu = Stnu.load(path)
    assert stnu.links[0].min == Decimal("1.00000000000000001")
    assert stnu.ticks_per_unit == 10**17
    assert stnu.table[0, 2:4].tolist() == [10**17 + 1, 2 * 10**17]


def test_min_above_max_is_bad_input_on_a_contingent_link_alone() -> None:
    assert Stnu.from_json(network(link(min=3))).links == (Link(0, 1, 3, 2),)
    with pytest.raises(
        NetworkFormatError, match=r"constraints\[0\]: expected min <= max on a contingent link, found 3 > 2"
    ):
        Stnu.from_json(network(link(min=3, contingent=True)))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ([], "network: expected an object, found list"),
        ({"timepoints": []}, "network: the field 'constraints' is missing"),
        ({"constraints": []}, "network: the field 'timepoints' is missing"),
        (network(timepoints={"a": 1}), "timepoints: expected a list"),
        (network(timepoints=("a", 7)), "timepoints[1]: expected text, found 7"),
        (network(timepoints=("a", "b", "a")), "timepoints[2]: 'a' is already the name of timepoints[0]"),
        (network(link(), 3), "constraints[1]: expected an object, found 3"),
        (network({"from": "a"}), "constraints[0]: the field 'to' is missing"),
        (network(link(to="z")), "constraints[0].to: expected the name of a timepoint, found 'z'"),
        (network(link(to=["b"])), "constraints[0].to: expected the name of a timepoint"),
        (network(link(to="a")), "constraints[0]: expected two different timepoints"),
        (network(link(continent=True)), "constraints[0]: unknown field 'continent'"),
        (network(link(min="1")), "constraints[0].min: expected a number or null, found '1'"),
        (network(link(max=True)), "constraints[0].max: expected a number or null, found True"),
        (network(link(max=float("inf"))), "constraints[0].max: expected a finite number or null, found inf"),
        (network(link(min=float("nan"), contingent=True)), "constraints[0].min: expected a finite number"),
        (network(link(contingent=1)), "constraints[0].contingent: expected true or false, found 1"),
        (network(link(min=None, contingent=True)), "constraints[0].min: expected a finite number on a contingent link"),
        (
            network({"from": "a", "to": "b", "min": 1, "contingent": True}),
            "constraints[0].max: expected a finite number",
        ),
        (network(link(min=-0.5, contingent=True)), "constraints[0].min: expected at least 0 on a contingent link"),
        (
            network(link(contingent=True), link(**{"from": "c", "contingent": True})),
            "constraints[1].to: expected the only contingent link ending there, found constraints[0] before it",
        ),
        (network(link(max=2**62)), "constraints[0]: the bounds do not fit 64-bit integers"),
        (network(*[link(max=2**60)] * 5), "constraints[3]: the bounds do not fit 64-bit integers"),
        (network(link(min=1e-300)), "constraints[0].min: the bounds do not fit 64-bit integers"),
        (network(link(max=1e300)), "constraints[0].max: the bounds do not fit 64-bit integers"),
        (network(link(min=1e-12, max=1e12)), "constraints[0]: the bounds do not fit 64-bit integers"),
    ],
)
def test_refuses_with_the_place(content: object, message: str) -> None:
    with pytest.raises(NetworkFormatError) as caught:
        Stnu.from_json(content)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b'{"timepoints": [],\n "constraints": }', ":2:17: not JSON"),
        (b"\xff", ": not UTF-8 text at byte 0"),
        (b"[" * 100_000, ": nested too deeply"),
        (
            b'{"timepoints": ["a","b"], "constraints": [{"from":"a","to":"b","max":1,"max":9}]}',
            ": the field 'max' is there twice in {'from': 'a'",
        ),
        (b'{"timepoints": [], "constraints": [' + b"9" * 5000 + b"]}", ": a number is too long"),
        (
            b'{"timepoints": ["a","b"], "constraints": [{"from":"a","to":"b","min":NaN}]}',
            ": constraints[0].min: expected a",
        ),
        (
            b'{"timepoints": ["a","b"], "constraints": [{"from":"a","to":"b","min":1e999999999}]}',
            ": constraints[0].min: the",
        ),
    ],
)
def test_a_file_that_is_none_says_which_and_where(tmp_path: Path, text: bytes, message: str) -> None:
    path = tmp_path / "bad.json"
    path.write_bytes(text)
    with pytest.raises(NetworkFormatError) as caught:
        Stnu.load(path)
    assert str(caught.value).startswith(f"{path}{message}")


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(NetworkFormatError, match=r"none\.json: No such file"):
        Stnu.load(tmp_path / "none.json")


@pytest.mark.parametrize(
    "row", [(0, 2, 1, 2, False), (-1, 1, 1, 2, False), (0, 1, True, 2, False), (0, 0, 0, 0, False)]
)
def test_direct_construction_is_checked_too(row: tuple[int, int, int, int, bool]) -> None:
    with pytest.raises(NetworkFormatError, match=r"constraints\[0\]"):
        Stnu.from_ticks("ab", [row])


@settings(max_examples=50, derandomize=True, deadline=None)
@given(lanes_networks())
def test_survives_the_round_trip_through_a_file(stnu: Stnu) -> None:
    again = Stnu.from_json(json.loads(json.dumps(stnu.to_json())))
    assert again == stnu
    assert (again.table == stnu.table).all()
