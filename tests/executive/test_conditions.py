"""Conditions, watches and locks against plain definitions of the same."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from executive.bindings import Maintained
from executive.conditions import Condition, Operator, Telemetry, Watch
from executive.errors import BindingsError
from executive.locks import LockTable, compatible

SIZES: tuple[Operator, ...] = ("==", "!=", "<", "<=", ">", ">=")


@pytest.mark.parametrize(
    ("condition", "telemetry", "holds"),
    [
        (Condition("a", "==", "on"), {"a": "on"}, True),
        (Condition("a", "==", "on"), {"a": "off"}, False),
        (Condition("a", "!=", "on"), {"a": "off"}, True),
        (Condition("a", "!=", "on"), {}, False),
        (Condition("a", "<", 3), {"a": 2.5}, True),
        (Condition("a", "<", 3), {"a": 3}, False),
        (Condition("a", "<=", 3), {"a": 3}, True),
        (Condition("a", ">", 3), {"a": "4"}, False),
        (Condition("a", ">=", 3), {"a": 3}, True),
        (Condition("a", "==", "@b"), {"a": 3, "b": 3}, True),
        (Condition("a", "==", "@b"), {"a": 3}, False),
        (Condition("a", ">", "@b"), {"a": 3, "b": 2}, True),
    ],
)
def test_conditions(condition: Condition, telemetry: Telemetry, holds: bool) -> None:
    assert condition.holds(telemetry) is holds


@pytest.mark.parametrize(
    ("op", "value", "before", "after", "holds"),
    [
        ("changed_by", 2, 5, 3, True),
        ("changed_by", 2, 5, 6, False),
        ("changed_by", 2, 5, 7, True),
        ("changed_by", 1, "off", "on", True),
        ("changed_by", 1, "off", "off", False),
        ("increased_by", 2, 5, 7, True),
        ("increased_by", 2, 5, 3, False),
        ("increased_by", 1, None, 3, False),
    ],
)
def test_relative_conditions_compare_with_when_the_watch_was_set(
    op: Operator, value: int, before: float | str | None, after: float | str, holds: bool
) -> None:
    start: Telemetry = {} if before is None else {"a": before}
    watch = Watch((Condition("a", op, value),), 0, start)
    assert watch.update({"a": after}, 1) is holds


def test_a_condition_says_what_is_wrong_with_it() -> None:
    with pytest.raises(BindingsError, match=r"expected an operator of ==, !=, <.*found '~'"):
        Condition("a", "~", 1)
    with pytest.raises(BindingsError, match=r"condition on 'a': '<' expects a number, .* found 'three'"):
        Condition("a", "<", "three")
    with pytest.raises(BindingsError, match="expected the name of a channel"):
        Condition("", "==", 1)


def test_parameters_are_put_in_place() -> None:
    assert Condition("a", "==", "$x").bound_to({"x": 3}) == Condition("a", "==", 3)
    assert Condition("a", "==", "@x").channels() == ("a", "x")
    assert Condition("a", "==", "$x").channels() == ("a",)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(st.lists(st.booleans(), max_size=25), st.integers(0, 4), st.booleans())
def test_a_watch_is_true_after_holding_for_its_persistence(held: list[bool], persistence: int, broken: bool) -> None:
    watch = Watch((Condition("a", "==", True),), persistence, {}, broken=broken)
    for now in range(len(held)):
        recent = held[max(0, now - persistence) : now + 1]
        wanted = len(recent) == persistence + 1 and all(value is not broken for value in recent)
        assert watch.update({"a": held[now]}, now) is wanted
        due = watch.due(now)
        if due is not None:
            assert now < due <= now + persistence
            assert not wanted


values = st.integers(-2, 2)
conditions = st.builds(Condition, st.just("a"), st.sampled_from(SIZES), values)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(conditions, conditions)
def test_compatible_means_that_some_value_satisfies_both(first: Condition, second: Condition) -> None:
    grid = [number / 4 for number in range(-16, 17)]
    some = any(first.holds({"a": value}) and second.holds({"a": value}) for value in grid)
    assert compatible(first, second) is some


def test_texts_channels_and_references() -> None:
    assert not compatible(Condition("a", "==", "on"), Condition("a", "==", "off"))
    assert compatible(Condition("a", "==", "on"), Condition("a", "==", "on"))
    assert compatible(Condition("a", "==", "on"), Condition("b", "==", "off"))
    assert compatible(Condition("a", "==", "@b"), Condition("a", "==", "off"))
    assert compatible(Condition("a", "increased_by", 1), Condition("a", "==", 3))


def test_locks_are_taken_broken_and_released() -> None:
    table = LockTable()
    pointing = Maintained("pointing", (Condition("target", "==", "$target"),), persistence=2)
    telemetry: dict[str, str] = {"target": "vesta"}
    assert table.take("t1", pointing, {"target": "vesta"}, telemetry) is None
    conflict = table.take("t2", pointing, {"target": "ceres"}, telemetry)
    assert conflict == "'pointing' needs target == ceres, but 'pointing' of t1 needs target == vesta"
    assert table.broken(telemetry, 5) == ()
    telemetry["target"] = "moon"
    assert table.broken(telemetry, 6) == ()
    assert list(table.dues(6)) == [8]
    assert table.broken(telemetry, 7) == ()
    (broken,) = table.broken(telemetry, 8)
    assert (broken.token, broken.detail) == ("t1", "'pointing': expected target == vesta, found moon")
    table.release("t1")
    assert table.broken(telemetry, 9) == ()
    assert table.take("t2", pointing, {"target": "ceres"}, telemetry) is None
