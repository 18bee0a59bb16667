"""Variable domains against plain Python sets and the contracts that the constraint network relies on."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.domains import BOOLEAN, FALSE, REAL_RESOLUTION, TRUE, Domain, Interval, Universe, Values, singleton

INF = math.inf
UNIVERSE = Universe("u", (3, "a", -1, 7, "b", 0, 2.5))
OTHER = Universe("other", (7, "b", "c", 3, 2.5))
QUICK = settings(derandomize=True, max_examples=150, deadline=None)


@st.composite
def domains(draw: st.DrawFn) -> Domain:
    if draw(st.booleans()):
        low = draw(st.integers(-5, 8))
        return Interval(low, low + draw(st.integers(0, 6)))
    universe = draw(st.sampled_from([UNIVERSE, OTHER]))
    return universe.domain(draw(st.sets(st.sampled_from(universe.values), min_size=1)))


@given(domains(), domains())
@QUICK
def test_intersection_is_of_sets(a: Domain, b: Domain) -> None:
    both = a.intersect(b)
    common = set(a.values()) & set(b.values())
    if isinstance(a, Values):
        assert set(both.values()) == common
    elif common:
        assert (both.lower, both.upper) == (min(common), max(common))
    else:
        assert both.is_empty
    assert both is a or both != a


@given(domains(), st.one_of(st.integers(-6, 15), st.sampled_from(["a", "b", "zzz"])))
@QUICK
def test_removal_and_membership(a: Domain, value: object) -> None:
    inside = set(a.values())
    assert (value in a) == (value in inside)
    left = a.without(value)
    if isinstance(a, Values) or value in (a.lower, a.upper):
        assert set(left.values()) == inside - {value}
    else:
        assert left is a
    if value not in inside:
        assert left is a


@given(domains())
@QUICK
def test_size_and_singletons(a: Domain) -> None:
    values = list(a.values())
    assert a.size == len(values)
    assert a.is_singleton == (len(values) == 1)
    assert not a.is_empty
    if a.is_singleton:
        assert a.value == values[0]


@given(domains(), domains())
@QUICK
def test_equal_domains_hash_alike(a: Domain, b: Domain) -> None:
    assert a != b or hash(a) == hash(b)
    if isinstance(a, Values) and isinstance(b, Values):
        assert (a == b) == (set(a.values()) == set(b.values()))


@given(st.integers(-5, 5), st.integers(0, 6), st.floats(-8, 12), st.floats(-8, 12), st.booleans())
@QUICK
def test_bounds_of_intervals(low: int, width: int, lower: float, upper: float, integer: bool) -> None:
    interval = Interval(low, low + width, integer)
    kept = interval.bounded(lower, upper)
    assert (kept is interval) == (lower <= low and low + width <= upper)
    if integer:
        wanted = [v for v in range(low, low + width + 1) if lower <= v <= upper]
        assert kept.is_empty if not wanted else list(kept.values()) == wanted
    elif not kept.is_empty:
        assert (kept.lower, kept.upper) == (max(low, lower), min(low + width, upper))


def test_equal_empties_hash_alike() -> None:
    assert Interval(1, 0) == Interval(5, 2)
    assert hash(Interval(1, 0)) == hash(Interval(5, 2))


def test_equal_sets_of_two_universes_hash_alike() -> None:
    a, b = UNIVERSE.domain((7, "b")), OTHER.domain((7, "b"))
    assert a == b
    assert hash(a) == hash(b)


@pytest.mark.parametrize(
    "interval", [Interval(-INF, INF, False), Interval(-INF, 3, False), Interval(3, INF, False), Interval(0, INF)]
)
def test_unbounded_is_not_decided(interval: Interval) -> None:
    assert not interval.is_singleton
    assert interval.size == INF
    with pytest.raises(ValueError, match="cannot be enumerated"):
        interval.values()


def test_infinite_values() -> None:
    interval = Interval(0, INF)
    assert INF in interval
    assert -INF not in interval
    assert interval.without(INF) is interval
    assert Interval(INF, INF).without(INF).is_empty


def test_reals_to_the_resolution() -> None:
    point = Interval(2.0, 2.0 + REAL_RESOLUTION, False)
    assert point.is_singleton
    assert point.size == 1
    assert list(point.values()) == [point.value]
    assert 2.0 - REAL_RESOLUTION in point
    assert 2.1 not in point
    assert Interval(1, 4, False).without(1) == Interval(1, 4, False)
    assert Interval(1, 1, False).without(1).is_empty


def test_whole_ends() -> None:
    assert Interval(0.5, 3.7) == Interval(1, 3)
    assert Interval(0.2, 0.8).is_empty
    assert 2.5 not in Interval(0, 5)
    assert Interval(0.5, 3.7, False).intersect(Interval(0, 3)) == Interval(1, 3)


def test_universe_grows_until_closed() -> None:
    universe = Universe("open", ("a",), is_open=True)
    before = universe.domain()
    assert universe.add("b") == 1
    assert universe.add("a") == 0
    assert list(before.values()) == ["a"]
    assert list(universe.domain().values()) == ["a", "b"]
    assert before.is_open
    with pytest.raises(KeyError):
        universe.domain(("stranger",))


def test_numeric_values() -> None:
    numbers = Universe("numbers", (5, -2, 1.5)).domain()
    assert numbers.is_numeric
    assert (numbers.lower, numbers.upper) == (-2, 5)
    assert list(numbers.bounded(0, 5).values()) == [5, 1.5]
    assert numbers.bounded(-9, 9) is numbers
    assert not BOOLEAN.domain().is_numeric


def test_numeric_once_filled() -> None:
    universe = Universe("later", (), is_open=True)
    universe.add(4)
    assert universe.domain().is_numeric
    universe.add("four")
    assert not universe.domain().is_numeric


def test_singletons_of_values() -> None:
    assert singleton(True) is TRUE
    assert singleton(False) is FALSE
    assert singleton(3) == Interval(3, 3)
    assert singleton(0.5) == Interval(0.5, 0.5, False)
    assert list(singleton("x").values()) == ["x"]
