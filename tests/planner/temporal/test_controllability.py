"""The controllability check: known answers, two slow judges, the plain twin, and conflicts that are conflicts."""

from __future__ import annotations

import json
import random
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner import temporal
from planner.temporal import _controllability_python, controllability
from planner.temporal.controllability import Verdict, check, check_file, check_with
from planner.temporal.stnu import Stnu
from tests.planner.temporal.stnu_oracles import controllable_by_game, controllable_by_propagation
from tests.strategies_stnu import TickRow, lanes_networks, tangle, tangles


def stnu(count: int, *rows: TickRow) -> Stnu:
    return Stnu.from_ticks([f"t{i}" for i in range(count)], rows)


def plain_check(network: Stnu) -> Verdict:
    return check_with(_controllability_python.check_links, network)


KNOWN = {
    "a duration cannot be squeezed": (stnu(2, (0, 1, 1, 5, True), (0, 1, 1, 4, False)), (0, 1)),
    "a duration that fits": (stnu(2, (0, 1, 1, 5, True), (0, 1, 0, 5, False)), None),
    "following nature at once": (stnu(3, (0, 1, 1, 5, True), (1, 2, 0, 0, False)), None),
    "preceding nature by a fixed time": (stnu(3, (0, 1, 1, 5, True), (2, 1, 1, 1, False)), (0, 1)),
    "preceding nature with just enough room": (stnu(3, (0, 1, 1, 5, True), (2, 1, 1, 5, False)), None),
    "before nature with a tick too little room": (stnu(3, (0, 1, 1, 5, True), (2, 1, 1, 4, False)), (0, 1)),
    "a wait that a deadline forbids": (
        stnu(3, (0, 1, 0, 4, True), (1, 2, 0, 9, False), (0, 2, None, 3, False)),
        (0, 1, 2),
    ),
    "two durations in sequence": (stnu(3, (0, 1, 1, 3, True), (1, 2, 2, 4, True), (0, 2, 3, 7, False)), None),
    "two durations in sequence, late": (
        stnu(3, (0, 1, 1, 3, True), (1, 2, 2, 4, True), (0, 2, 3, 6, False)),
        (0, 1, 2),
    ),
    "two durations that must meet": (stnu(4, (0, 1, 1, 3, True), (2, 3, 1, 3, True), (1, 3, 0, 0, False)), (0, 1, 2)),
    "min above max": (stnu(3, (0, 1, 5, 3, False), (1, 2, 0, 0, False)), (0,)),
    "an inconsistent cycle": (
        stnu(4, (0, 1, 2, None, False), (1, 2, 2, None, False), (0, 2, None, 3, False)),
        (0, 1, 2),
    ),
    "one duration only constrains like any link": (stnu(2, (0, 1, 3, 3, True), (0, 1, 3, 3, False)), None),
    "one duration only, contradicted": (stnu(2, (0, 1, 3, 3, True), (0, 1, 4, 9, False)), (0, 1)),
    "fixed before a fixed duration ends": (stnu(3, (0, 1, 3, 3, True), (2, 1, 1, 1, False)), None),
    "a zero duration": (stnu(3, (0, 1, 0, 0, True), (1, 2, 0, 0, False), (0, 2, 0, 0, False)), None),
    "instants that begin one another": (stnu(2, (0, 1, 0, 0, True), (1, 0, 0, 0, True)), (0, 1)),
    "unrelated": (stnu(3), None),
    "nothing": (stnu(0), None),
}


@pytest.mark.parametrize("name", KNOWN)
@pytest.mark.parametrize("checker", [check, plain_check], ids=["compiled", "plain"])
def test_known_answers(name: str, checker: controllability.CheckLinks) -> None:
    network, conflict = KNOWN[name]
    verdict = checker(network)
    assert verdict.controllable == (conflict is None)
    assert verdict.conflict == (conflict or ())
    assert (verdict.network is None) == (conflict is not None)


def test_the_wait_of_the_classic_triangle() -> None:
    """x within 1 before or any time after nature's end in [1, 5]: it waits for the end, or until 4 after the start."""
    network = check(stnu(3, (0, 1, 1, 5, True), (2, 1, None, 1, False))).network
    assert network is not None
    assert network.waits.tolist() == [[0, 2, -4]]
    assert network.contingents.tolist() == [[0, 1, 1, 5, 0]]
    assert [0, 1, 5] in network.edges.tolist()
    assert [1, 0, -1] in network.edges.tolist()


def test_rounding_does_not_decide() -> None:
    """0.1 + 0.2 <= 0.3 holds in decimals and fails in binary fractions."""

    def total(limit: float) -> Stnu:
        parts = [("a", "b", 0.1), ("b", "c", 0.2)]
        constraints = [{"from": a, "to": b, "min": d, "max": d} for a, b, d in parts]
        return Stnu.from_json(
            {"timepoints": list("abc"), "constraints": [*constraints, {"from": "a", "to": "c", "max": limit}]}
        )

    assert check(total(0.3)).controllable
    assert not check(total(0.2999999999999)).controllable


def assert_right(network: Stnu) -> None:
    verdict, plain = check(network), plain_check(network)
    expected = controllable_by_propagation(network)
    assert (verdict.controllable, plain.controllable) == (expected, expected)
    for conflict in {verdict.conflict, plain.conflict} - {()}:
        assert conflict == tuple(sorted(set(conflict)))
        alone = Stnu(network.timepoints, tuple(network.links[link] for link in conflict))
        assert not controllable_by_propagation(alone)
    if verdict.network and plain.network:
        np.testing.assert_array_equal(verdict.network.edges, plain.network.edges)
        np.testing.assert_array_equal(verdict.network.waits, plain.network.waits)


@settings(max_examples=400, derandomize=True, deadline=None)
@given(tangles(9, 14, 9))
def test_agrees_with_propagation_to_the_fixpoint(network: Stnu) -> None:
    assert_right(network)


@settings(max_examples=100, derandomize=True, deadline=None)
@given(lanes_networks(24))
def test_agrees_on_plans(network: Stnu) -> None:
    assert_right(network)


def test_agrees_on_a_thousand_tangles_both_ways() -> None:
    """Many of them controllable and many not, so that neither answer is right by chance."""
    rng = random.Random(20)
    answers = []
    for _ in range(1000):
        network = tangle(rng, rng.randint(2, 8), rng.randint(2, 10), rng.choice((1, 2, 5)))
        answers.append(controllable_by_propagation(network))
        assert check(network).controllable == answers[-1], network
    assert 200 < sum(answers) < 800


@settings(max_examples=300, derandomize=True, deadline=None)
@given(tangles(4, 6, 2))
def test_agrees_with_the_game_played_out(network: Stnu) -> None:
    assert check(network).controllable == controllable_by_game(network)


@settings(max_examples=100, derandomize=True, deadline=None)
@given(tangles(7, 10), st.integers(1, 1000))
def test_the_unit_of_time_does_not_matter(network: Stnu, factor: int) -> None:
    rows = [
        (a, c, None if lo is None else int(lo) * factor, None if hi is None else int(hi) * factor, k)
        for a, c, lo, hi, k in network.links
    ]
    verdict, scaled = check(network), check(Stnu.from_ticks(network.timepoints, rows))
    assert scaled.conflict == verdict.conflict
    if verdict.network and scaled.network:
        np.testing.assert_array_equal(scaled.network.edges[:, 2], verdict.network.edges[:, 2] * factor)
        np.testing.assert_array_equal(scaled.network.waits[:, 2], verdict.network.waits[:, 2] * factor)


def test_a_long_chain_of_negative_nodes_needs_no_recursion() -> None:
    n = 1500
    chain = [(i, i + 1, 1, None, False) for i in range(n - 1)]
    assert n > sys.getrecursionlimit()
    assert check(stnu(n, *chain)).controllable
    closed = stnu(n, *chain, (0, n - 1, None, n - 2, False))
    assert check(closed).conflict == tuple(range(n))


def test_the_plain_twin_stands_in_where_numba_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "planner.temporal._controllability_kernel", None)
    monkeypatch.delattr(temporal, "_controllability_kernel", raising=False)
    controllability._fastest.cache_clear()
    try:
        assert controllability._fastest() is _controllability_python.check_links
        assert not check(KNOWN["min above max"][0]).controllable
    finally:
        controllability._fastest.cache_clear()


def test_the_report_of_a_file(tmp_path: Path) -> None:
    path = tmp_path / "network.json"
    path.write_text(json.dumps(KNOWN["a duration cannot be squeezed"][0].to_json()))
    report = check_file(path)
    milliseconds = report.pop("milliseconds")
    assert isinstance(milliseconds, float)
    assert milliseconds >= 0
    assert report == {"file": str(path), "dynamically_controllable": False, "conflict": [0, 1]}


def test_a_fixed_duration_binds_the_moment_of_choice() -> None:
    """Once nature's only duration runs the executive has no say, so what follows from its end is said of its start."""
    network = check(stnu(4, (0, 1, 0, 9, False), (1, 2, 3, 3, True), (2, 3, None, 2, False))).network
    assert network is not None
    assert [1, 3, 5] in network.edges.tolist()
