"""The table of temporal relations against formulas, over all small intervals."""

from __future__ import annotations

import itertools
import math

import pytest

from planner.errors import ModelError
from planner.model.relations import RELATIONS, Distance, distances
from tests.planner.relation_oracle import QUALITATIVE, QUANTITATIVE, holds

INTERVALS = [(s, e) for s in range(5) for e in range(s, 5)]
PAIRS = [(*a, *b) for a in INTERVALS for b in INTERVALS]
BOUNDS = [(0, 0), (1, 2), (0, 3), (2, math.inf), (-1, 1)]


def satisfied(table: tuple[Distance, ...], times: tuple[int, int, int, int]) -> bool:
    at = dict(zip(("o.start", "o.end", "t.start", "t.end"), times, strict=True))
    return all(d.minimum <= at[d.to] - at[d.from_] <= d.maximum for d in table)


def test_every_relation_is_tested() -> None:
    assert set(RELATIONS) == set(QUANTITATIVE) | set(QUALITATIVE)


@pytest.mark.parametrize("relation", RELATIONS)
def test_unwritten_bounds(relation: str) -> None:
    for times in PAIRS:
        assert satisfied(distances(relation), times) == holds(relation, times), times


@pytest.mark.parametrize("relation", QUANTITATIVE)
def test_quantitative_bounds(relation: str) -> None:
    count, _ = QUANTITATIVE[relation]
    for written in range(1, count + 1):
        for bounds in itertools.product(BOUNDS, repeat=written):
            table = distances(relation, bounds)
            for times in PAIRS:
                assert satisfied(table, times) == holds(relation, times, bounds), (bounds, times)


def test_before_10_20() -> None:
    # The paper: "before[10,20]" means that the first ends at least 10 and no more than 20 before the second starts.
    assert distances("before", [(10, 20)]) == (Distance("o.end", "t.start", 10, 20),)


INVERSES = [
    ("before", "after"),
    ("startsBefore", "startsAfter"),
    ("endsBefore", "endsAfter"),
    ("startsBeforeEnd", "endsAfterStart"),
    ("contains", "containedBy"),
    ("parallels", "paralleledBy"),
]


@pytest.mark.parametrize(("one", "other"), INVERSES)
def test_the_twelve_come_in_inverse_pairs(one: str, other: str) -> None:
    for bounds in ((), ((1, 2),), ((0, 0),)):
        for s, e, ts, te in PAIRS:
            forth = satisfied(distances(one, bounds), (s, e, ts, te))
            assert forth == satisfied(distances(other, bounds), (ts, te, s, e))


@pytest.mark.parametrize(
    ("relation", "bounds", "message"),
    [
        ("befor", (), "no temporal relation named 'befor'; did you mean before"),
        ("before", ((0, 1), (0, 1)), "before: expected at most 1 bounds, found 2"),
        ("meets", ((0, 1),), "meets: expected at most 0 bounds, found 1"),
        ("contains", ((3, 1),), r"contains: the bounds \[3 1\] are empty"),
    ],
)
def test_errors(relation: str, bounds: tuple[tuple[float, float], ...], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        distances(relation, bounds)
