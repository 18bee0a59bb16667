"""The heaviest closed set against all subsets."""

from __future__ import annotations

import itertools

from hypothesis import given, settings
from hypothesis import strategies as st

from planner.tokens.resources.closure import elements, heaviest_closure


@st.composite
def orders(draw: st.DrawFn) -> tuple[list[float], list[int], int]:
    """Gains, a transitively closed order, and a closed set to choose from."""
    size = draw(st.integers(1, 9))
    gains = [float(g) for g in draw(st.lists(st.integers(-4, 4), min_size=size, max_size=size))]
    pairs = draw(st.lists(st.tuples(st.integers(0, size - 1), st.integers(0, size - 1)), max_size=14))
    requires = [0] * size
    for later, earlier in pairs:
        requires[later] |= 1 << earlier
    for middle, element in itertools.product(range(size), repeat=2):
        if requires[element] >> middle & 1:
            requires[element] |= requires[middle]
    among = sum(1 << i for i in draw(st.sets(st.integers(0, size - 1))))
    for element in elements(among):
        among |= requires[element]
    return gains, requires, among


def is_closed(bits: int, requires: list[int]) -> bool:
    return all(requires[i] & ~bits == 0 for i in elements(bits))


@settings(derandomize=True, max_examples=300, deadline=None)
@given(orders())
def test_no_closed_set_is_heavier(case: tuple[list[float], list[int], int]) -> None:
    gains, requires, among = case
    weights = {
        bits: sum(gains[i] for i in elements(bits))
        for bits in range(1 << len(gains))
        if bits & ~among == 0 and is_closed(bits, requires)
    }
    found = heaviest_closure(gains, requires, among)
    best = max(weights.values())
    assert weights[found] == best
    assert all(found & bits == found for bits, weight in weights.items() if weight == best)


def test_a_long_chain_of_detours() -> None:
    """Each element that gains pays its own cost or the next one's, the last one of the first two: all have to shift."""
    size = 200
    gains = [2.0] * size + [-2.0] * (size - 1) + [-1.0]
    requires = [3 << (size + i) for i in range(size - 1)] + [3 << size] + [0] * size
    found = heaviest_closure(gains, requires, (1 << (2 * size)) - 1)
    assert sum(gains[i] for i in elements(found)) == 1.0
    assert found == (1 << (2 * size)) - 1
    gains[-1] = -2.0
    assert heaviest_closure(gains, requires, (1 << (2 * size)) - 1) == 0
