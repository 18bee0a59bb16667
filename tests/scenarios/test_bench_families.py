"""The benchmark's families of problems are what they say."""

from __future__ import annotations

import pytest

from scenarios.benchmarks import planner
from scenarios.benchmarks.families import FAMILIES


@pytest.mark.parametrize("family", FAMILIES)
def test_a_family_is_solved_or_proven_to_have_no_plan(family: str) -> None:
    size = {"order": 20, "queens": 6}.get(family, 8)
    found = planner.row(family, size)
    assert found["verdict"] == ("no plan" if family == "thrash" else "solved")
    # altern: N tokens, N subgoals that are one with them, and the second goal; thrash: 2^(K+2) - 2 decisions.
    expected = {"altern": ("tokens", 2 * size + 2), "thrash": ("steps", 2 ** (size + 2) - 2), "queens": ("tokens", 0)}
    name, value = expected.get(family, ("tokens", size))
    assert found[name] == value


def test_memory_is_flat_over_cycles_of_solving_and_undoing() -> None:
    assert planner.cycles(count=40)["flat"] < 1.05


def test_growth_is_the_exponent_between_the_last_two() -> None:
    rows: list[dict[str, object]] = [{"load_seconds": t, "solve_seconds": t * t} for t in (9.0, 1.0, 10.0)]
    assert planner.growth(rows, (1, 10, 100)) == {"load": 1.0, "solve": 2.0}
