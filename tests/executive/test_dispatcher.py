"""Dispatch and simulation: known executions, and that nothing nature does breaks a controllable network."""

from __future__ import annotations

import itertools
import json
import random
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from executive.dispatcher import Choice, Decision, Dispatcher, Happened, Violation, Window
from executive.simulate import NATURES, broken_links, durations, execute, network_for, simulate, simulate_file
from planner.temporal.controllability import check
from planner.temporal.stnu import Stnu
from tests.strategies_stnu import TickRow, lanes_networks, tangles, tight_network


def dispatcher(count: int, *rows: TickRow) -> Dispatcher:
    network = check(Stnu.from_ticks([f"t{i}" for i in range(count)], rows)).network
    assert network is not None
    return Dispatcher(network)


def test_a_wait_ends_with_nature_or_with_time() -> None:
    """Timepoint 2 may come at most 1 before nature's end, in [1, 5] after 0."""
    for end in (2, None):
        run = dispatcher(3, (0, 1, 1, 5, True), (2, 1, None, 1, False))
        assert run.next_decision(10) == Decision(10, (0,), None)
        assert run.execute(0, 10) is None
        assert run.window(1) == Window(11, 15)
        assert run.window(2) == Window(14, None)
        assert run.narrowed == {1: Window(11, 15), 2: Window(14, None)}
        assert run.next_decision(10) == Decision(14, (2,), None)
        if end is None:
            assert run.execute(2, 14) is None
            assert run.happened(1, 15) is None
        else:
            assert run.happened(1, 10 + end) is None
            assert run.window(2) == Window(11, None)
            assert run.next_decision(12) == Decision(12, (2,), None)
            assert run.execute(2, 12) is None
        assert run.finished


def test_windows_narrow_as_neighbours_happen() -> None:
    run = dispatcher(4, (0, 1, 2, 9, False), (0, 2, 5, 8, False), (1, 2, 1, 4, False), (0, 3, None, 30, False))
    assert run.enabled() == (0, 3)
    assert run.window(1) == Window(None, None)
    run.execute(0, 0)
    assert run.window(1) == Window(2, 7)
    assert run.window(2) == Window(5, 8)
    run.execute(1, 6)
    assert run.window(2) == Window(7, 8)
    assert run.narrowed == {2: Window(7, 8)}
    assert run.window(1) == Window(6, 6)
    assert run.time(1) == 6
    assert run.time(2) is None


def test_choices_within_the_window() -> None:
    rows: list[TickRow] = [(0, 1, 2, 9, False), (0, 2, 4, None, False)]
    for choice, expected in (
        ("earliest", Decision(2, (1,), 9)),
        ("latest", Decision(4, (2,), 9)),  # 2 may be put off for ever, so it is not
        ({1: 6, 2: 6}, Decision(6, (1, 2), 9)),
        ({1: 1, 2: 50}, Decision(2, (1,), 9)),
        ({1: 99, 2: 99}, Decision(9, (1,), 9)),
    ):
        run = dispatcher(3, *rows)
        run.execute(0, 0)
        assert run.next_decision(0, choice) == expected


def test_late_is_a_value_and_still_propagates() -> None:
    run = dispatcher(3, (0, 1, 1, 5, True), (1, 2, 2, 3, False))
    run.execute(0, 0)
    assert run.happened(1, 7) == Violation(1, 7, Window(1, 5))
    assert run.window(2) == Window(9, 10)
    assert run.execute(2, 8) == Violation(2, 8, Window(9, 10))


def test_out_of_order_names_what_had_to_come_first() -> None:
    run = dispatcher(3, (0, 1, 1, 5, True), (1, 2, 2, 3, False))
    assert run.happened(2, 0) == Violation(2, 0, Window(None, None), (1,))
    waiting = dispatcher(3, (0, 1, 1, 5, True), (2, 1, None, 1, False))
    assert waiting.execute(2, 0) == Violation(2, 0, Window(None, None), (0,))


def test_misuse_is_an_error() -> None:
    run = dispatcher(2, (0, 1, 1, 5, True))
    with pytest.raises(ValueError, match="t1: is nature's to decide"):
        run.execute(1, 3)
    run.execute(0, 0)
    with pytest.raises(ValueError, match="t0: happened at 0, told again at 4"):
        run.execute(0, 4)
    assert run.is_natural(1)
    assert run.next_decision(0) is None
    assert not run.finished


def test_an_overdue_timepoint_is_due_now() -> None:
    run = dispatcher(2, (0, 1, 1, 5, False))
    run.execute(0, 0)
    assert run.next_decision(20) == Decision(20, (1,), 5)


def test_the_ends_of_fixed_durations_are_observed() -> None:
    run = dispatcher(2, (0, 1, 3, 3, True))
    run.execute(0, 0)
    assert run.next_decision(0) is None
    assert run.window(1) == Window(3, 3)


def _drawn(lengths: list[int], number: int, _: Dispatcher) -> int:
    return lengths[number]


def all_extremes(stnu: Stnu, choice: Choice) -> None:
    """Execute against every combination of shortest and longest durations."""
    network = check(stnu).network
    assert network is not None
    for ends in itertools.product((2, 3), repeat=len(network.contingents)):
        lengths = [int(row[end]) for row, end in zip(network.contingents, ends, strict=True)]
        times = execute(network, partial(_drawn, lengths), choice)
        assert broken_links(stnu, times) == ()


@settings(max_examples=150, derandomize=True, deadline=None)
@given(tangles(9, 12, 6), st.randoms(use_true_random=False))
def test_no_extreme_breaks_a_controllable_tangle(stnu: Stnu, rng: random.Random) -> None:
    assume(check(stnu).controllable)
    wishes = {node: rng.randint(0, 40) for node in range(len(stnu.timepoints))}
    for choice in ("earliest", "latest", wishes):
        all_extremes(stnu, choice)


@settings(max_examples=60, derandomize=True, deadline=None)
@given(lanes_networks(40), st.integers(0, 99))
def test_nothing_breaks_a_controllable_plan(stnu: Stnu, seed: int) -> None:
    assume(check(stnu).controllable)
    for choice in ("earliest", "latest", dict.fromkeys(range(len(stnu.timepoints)), seed)):
        result = simulate(stnu, 10, "rte", seed, choice=choice)
        assert (result.satisfied, dict(result.violations)) == (10, {})


@pytest.mark.parametrize("timepoints", [9, 25, 61, 161])
def test_tight_networks_hold_where_the_plain_network_breaks(timepoints: int) -> None:
    rte = stn = 0
    for seed in range(3):
        stnu = tight_network(seed, timepoints, 0.8)
        rte += simulate(stnu, 20, "rte", seed).satisfied
        stn += simulate(stnu, 20, "stn", seed).satisfied
    assert rte == 60
    assert stn < 60


def test_every_nature_stays_within_the_links_and_differs() -> None:
    stnu = tight_network(5, 41, 1.0)
    network = network_for(stnu, "rte")
    seen = {}
    for nature in NATURES:
        assert simulate(stnu, 3, nature=nature).satisfied == 3
        assert simulate(stnu, 5, seed=7, nature=nature) == simulate(stnu, 5, seed=7, nature=nature)
        times = execute(network, durations(network, nature, np.random.default_rng(3)))
        lasted = [times[end] - times[begin] for begin, end in network.contingents[:, :2]]
        assert all(low <= d <= high for d, (low, high) in zip(lasted, network.contingents[:, 2:4], strict=True))
        seen[nature] = tuple(lasted)
    assert seen["early"] == tuple(network.contingents[:, 2])
    assert seen["late"] == tuple(network.contingents[:, 3])
    assert len(set(seen.values())) == len(NATURES)


def test_a_network_that_is_not_controllable_breaks_and_says_where() -> None:
    stnu = Stnu.from_ticks("abc", [(0, 1, 1, 5, True), (0, 2, 0, 3, False), (1, 2, 0, None, False)])
    result = simulate(stnu, 50, "rte", 1)
    assert 0 < result.satisfied < 50
    assert set(result.violations) <= {1, 2}
    assert simulate(stnu, 4, nature="early").satisfied == 4


def test_what_can_never_happen_counts_as_broken() -> None:
    stnu = Stnu.from_ticks("ab", [(0, 1, 1, None, False), (1, 0, 1, None, False)])
    for strategy in ("rte", "stn"):
        result = simulate(stnu, 3, strategy)
        assert (result.satisfied, dict(result.violations)) == (0, {0: 3, 1: 3})


def test_the_report_of_a_simulated_file(tmp_path: Path) -> None:
    path = tmp_path / "network.json"
    path.write_text(json.dumps(tight_network(3, 15).to_json()))
    report = simulate_file(path, 30, "rte", 5)
    counts = {"runs": 30, "satisfied": 30, "violations": 0, "violations_by_constraint": {}}
    assert report == {"file": str(path), "strategy": "rte", "seed": 5, **counts}
    stn = simulate_file(path, 30, "stn", 5)
    assert stn["runs"] == 30


@settings(max_examples=40, derandomize=True, deadline=None)
@given(lanes_networks(30), st.integers(0, 99))
def test_incremental_windows_equal_windows_from_scratch(stnu: Stnu, seed: int) -> None:
    """After every event, each window is what the neighbours and waits say when read off the whole network."""
    network = check(stnu).network
    assume(network is not None)
    assert network is not None
    run, rng = Dispatcher(network), random.Random(seed)
    order = rng.sample(range(len(stnu.timepoints)), len(stnu.timepoints))
    times: dict[int, int] = {}
    for now, node in enumerate(order):
        run.happened(node, 3 * now)
        times[node] = 3 * now
        for other in set(order) - set(times):
            low = [times[y] - w for x, y, w in network.edges.tolist() if x == other and y in times]
            high = [times[x] + w for x, y, w in network.edges.tolist() if y == other and x in times]
            for number, x, w in network.waits.tolist():
                begin, end = network.contingents[number, :2].tolist()
                if x == other and begin in times and end not in times:
                    low.append(times[begin] - w)
            assert run.window(other) == Window(max(low, default=None), min(high, default=None))
            before = {y for x, y, w in network.edges.tolist() if x == other and w < 0}
            before |= {int(network.contingents[number, 0]) for number, x, _ in network.waits.tolist() if x == other}
            if not run.is_natural(other):
                assert (other in run.enabled()) == (before <= set(times))


def one_by_one(
    run: Dispatcher, now: int, wishes: dict[int, int], spared: set[int]
) -> tuple[tuple[Happened, ...], int | None, dict[int, Window]]:
    """`perform_due` as `next_decision` and `execute` have it: what was performed, the next decision, what narrowed."""
    done: list[Happened] = []
    narrowed: dict[int, Window] = {}
    while True:
        decision = run.next_decision(now, wishes)
        if decision is None or decision.time > now:
            break
        due = [node for node in decision.timepoints if node not in spared]
        if not due:
            break
        for node in due:
            done.append(Happened(node, run.window(node), run.execute(node, now)))
            narrowed |= run.narrowed
    yet = {node: window for node, window in narrowed.items() if run.time(node) is None}
    return tuple(done), None if decision is None else decision.time, yet


@settings(max_examples=60, derandomize=True, deadline=None)
@given(lanes_networks(40), st.randoms(use_true_random=False))
def test_performing_an_instant_is_deciding_and_executing_one_by_one(stnu: Stnu, rng: random.Random) -> None:
    """Some activities end in time and some late, some instants are missed, and some timepoints are spared."""
    network = check(stnu).network
    assume(network is not None)
    assert network is not None
    at_once, stepwise = Dispatcher(network), Dispatcher(network)
    wishes = {node: 7 * node % 50 for node in range(len(stnu.timepoints))}
    spared = {node for node in range(len(stnu.timepoints)) if rng.random() < 0.1}
    ends: dict[int, int] = {}
    for now in range(0, 120, rng.choice((1, 3))):
        for node in [node for node, end in ends.items() if end <= now]:
            del ends[node]
            told = at_once.observe(node, now)
            assert (told.window, told.violation) == (stepwise.window(node), stepwise.happened(node, now))
            assert at_once.narrowed == stepwise.narrowed
        performed = at_once.perform_due(now, wishes, spared)
        assert (performed.happened, performed.next, at_once.narrowed) == one_by_one(stepwise, now, wishes, spared)
        for activation, end, least, most, _ in network.contingents.tolist():
            if at_once.time(activation) == now:
                ends[end] = now + rng.randint(least, most + 2)
    every = range(len(stnu.timepoints))
    assert [at_once.window(node) for node in every] == [stepwise.window(node) for node in every]
    assert at_once.enabled() == stepwise.enabled()
