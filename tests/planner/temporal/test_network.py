"""The temporal network manager: contract and known answers, for the compiled kernel and its plain twin."""

from __future__ import annotations

import sys
import tracemalloc

import pytest

from planner.temporal.kernel import load_kernel
from planner.temporal.network import INFINITY, TemporalNetworkManager
from scenarios.benchmarks.temporal import build, call_by_call, one_call


@pytest.fixture(params=[True, False], ids=["compiled", "plain"])
def compiled(request: pytest.FixtureRequest) -> bool:
    return bool(request.param)


@pytest.fixture
def network(compiled: bool) -> TemporalNetworkManager:
    return TemporalNetworkManager((0, 100), compiled=compiled)


def bounds(network: TemporalNetworkManager, *points: int) -> list[tuple[int, int]]:
    return [(network.lower(t), network.upper(t)) for t in points]


def chain(network: TemporalNetworkManager) -> tuple[list[int], list[int]]:
    """a + 5..10 = b, b + 3..4 = c."""
    points = [network.add_timepoint(0, 100) for _ in range(3)]
    posted = [network.post(points[0], points[1], 5, 10), network.post(points[1], points[2], 3, 4)]
    assert network.propagate()
    return points, posted


def test_origin_is_fixed(network: TemporalNetworkManager) -> None:
    assert network.ORIGIN == 0
    assert bounds(network, 0) == [(0, 0)]
    network.restrict(0, 1, 2)
    assert not network.propagate()
    assert network.conflict() == (0,)


def test_bounds_distances_and_reasons_of_a_chain(network: TemporalNetworkManager) -> None:
    (a, b, c), (first, second) = chain(network)
    assert bounds(network, a, b, c) == [(0, 92), (5, 97), (8, 100)]
    assert network.distance(a, c) == (8, 14)
    assert network.distance(c, a) == (-14, -8)
    assert network.distances_from(b) == [(-97, -5), (-10, -5), (0, 0), (3, 4)]
    assert network.explain(c, "lower") == (second, first)
    assert network.explain(a, "upper") == (first, second)
    assert network.explain(a, "lower") == ()


def test_initial_bounds_are_clamped(compiled: bool) -> None:
    bounded = TemporalNetworkManager((10, 20), compiled=compiled)
    assert bounds(bounded, bounded.add_timepoint(-INFINITY, 15)) == [(10, 15)]
    free = TemporalNetworkManager(compiled=compiled)
    a, b = (free.add_timepoint(-INFINITY, INFINITY) for _ in range(2))
    lower, upper = bounds(free, a)[0]
    assert lower == -upper < -(10**12)
    free.post(a, b, -INFINITY * 10, INFINITY * 10)
    assert free.propagate()
    assert free.explain(b, "upper") == ()
    free.post(a, b, INFINITY * 10, INFINITY * 10)
    assert not free.propagate()


def test_empty_initial_bounds_fail_until_undone(network: TemporalNetworkManager) -> None:
    mark = network.mark()
    network.add_timepoint(200, 300)
    network.add_timepoint(7, 3)
    assert not network.propagate()
    assert network.conflict() == ()
    network.undo_to(mark)
    assert network.propagate()


def test_cycle_away_from_the_origin(network: TemporalNetworkManager) -> None:
    (a, _, c), posted = chain(network)
    mark = network.mark()
    culprit = network.post(c, a, -7, INFINITY)
    assert not network.propagate()
    assert sorted(network.conflict()) == [*posted, culprit]
    assert sum(edge[2] for edge in network.conflict_cycle()) == -1
    network.undo_to(mark)
    assert network.propagate()


def test_failure_keeps_the_queue_and_removal_of_a_culprit_cures_it(network: TemporalNetworkManager) -> None:
    (a, b, c), (first, second) = chain(network)
    before = bounds(network, a, b, c)
    late, soon = network.restrict(a, 50, INFINITY), network.restrict(c, 0, 40)
    assert not network.propagate()
    assert not network.propagate()
    assert bounds(network, a, b, c) == before
    assert set(network.conflict()) == {first, second, late, soon}
    network.remove([late])
    assert network.propagate()
    assert bounds(network, a, b, c) == [(0, 32), (5, 37), (8, 40)]


def test_removal_is_exact_and_undone(network: TemporalNetworkManager) -> None:
    (a, b, c), (first, _) = chain(network)
    network.watch(b)
    mark = network.mark()
    network.remove([first, first])
    assert bounds(network, a, b, c) == [(0, 100), (0, 97), (3, 100)]
    assert network.changed() == [b]
    assert [row[0] for row in network.constraints()] == [1]
    with pytest.raises(IndexError, match="constraint 0: expected one that is posted and not removed"):
        network.tighten(first, 6, 7)
    network.undo_to(mark)
    assert bounds(network, a, b, c) == [(0, 92), (5, 97), (8, 100)]
    assert network.changed() == []


def test_tightening_removed_before_it_takes_effect(network: TemporalNetworkManager) -> None:
    (a, b, c), (first, _) = chain(network)
    network.tighten(first, 9, 9)
    network.remove([first])
    assert network.propagate()
    assert bounds(network, a, b, c) == [(0, 100), (0, 97), (3, 100)]


def test_undo_restores_unread_changes(network: TemporalNetworkManager) -> None:
    (a, b, c), (first, _) = chain(network)
    for point in (a, c):
        network.watch(point)
    network.tighten(first, 8, 10)
    assert network.propagate()
    mark = network.mark()
    assert sorted(network.changed()) == [a, c]
    assert network.changed() == []
    network.undo_to(mark)
    assert sorted(network.changed()) == [a, c]
    assert next(iter(network.constraints())) == (first, a, b, 8, 10, -1)


def test_owners_are_kept(network: TemporalNetworkManager) -> None:
    a = network.add_timepoint(0, 10)
    network.post(0, a, 1, 2, owner=42)
    assert list(network.constraints()) == [(0, 0, a, 1, 2, 42)]


def test_probe_changes_nothing(network: TemporalNetworkManager) -> None:
    (a, _, c), _ = chain(network)
    assert network.probe(a, c, 12, INFINITY, c) == (12, 100)
    assert network.probe(a, c, 15, INFINITY) is None
    assert bounds(network, a, c) == [(0, 92), (8, 100)]
    assert len(list(network.constraints())) == 2


def test_numbers_out_of_range_are_errors(network: TemporalNetworkManager) -> None:
    for call in (
        lambda: network.post(0, 1, 0, 0),
        lambda: network.restrict(-1, 0, 0),
        lambda: network.remove([0]),
        lambda: network.probe(0, 0, 0, 0, 5),
        lambda: network.tighten(0, 0, 0),
        lambda: network.watch(1),
        lambda: network.distance(0, 1),
        lambda: network.distances_from(-1),
    ):
        with pytest.raises(IndexError, match="expected"):
            call()
    with pytest.raises(ValueError, match="expected one from"):
        network.undo_to(network.mark() + 1)


def test_star_of_many_constraints(network: TemporalNetworkManager) -> None:
    """Spans move to larger blocks while earlier ones are in use."""
    end = network.add_timepoint(0, 100)
    marks = []
    for k in range(200):
        marks.append(network.mark())
        network.post(network.add_timepoint(0, 100), end, k % 50, INFINITY)
        assert network.propagate()
    assert bounds(network, end) == [(49, 100)]
    assert network.distance(50, end) == (48, 100)
    network.remove([k for k in range(200) if k % 50 >= 20])
    assert bounds(network, end) == [(19, 100)]
    network.undo_to(marks[10])
    assert network.propagate()
    assert bounds(network, end) == [(9, 100)]


def test_memory_is_flat_over_repeated_solving_and_undoing(compiled: bool) -> None:
    workload = build(200, operations=1, compiled=compiled)
    network = workload.network
    mark = network.mark()

    def cycle() -> None:
        for _ in range(20):
            point = network.add_timepoint(0, 100_000)
            for other in range(1, 10):
                network.post(other, point, 0, INFINITY)
            assert network.propagate()
        network.undo_to(mark)

    cycle()
    sizes = [len(buffer) for buffer in network._buffers]
    pooled = network._header[11]
    tracemalloc.start()
    cycle()
    before = tracemalloc.get_traced_memory()[0]
    for _ in range(10):
        cycle()
    grown = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    assert [len(buffer) for buffer in network._buffers] == sizes
    assert network._header[11] == pooled
    assert grown < 5_000


def test_workload_leaves_the_network_as_it_was(compiled: bool) -> None:
    workload = build(200, operations=200, compiled=compiled)
    network = workload.network
    before = bounds(network, *range(len(workload.times)))
    one_call(network, workload.operations)
    call_by_call(network, workload.operations)
    assert bounds(network, *range(len(workload.times))) == before
    assert all(lower <= time <= upper for (lower, upper), time in zip(before, workload.times, strict=True))


def test_both_kernels_agree_on_a_large_network() -> None:
    first, second = (build(1000, operations=300, compiled=compiled) for compiled in (True, False))
    for operation in first.operations:
        arguments = operation.from_, operation.to, operation.minimum, operation.maximum, operation.observed
        assert first.network.probe(*arguments) == second.network.probe(*arguments)
    for a in (1, 77, 500):
        assert first.network.distances_from(a) == second.network.distances_from(a)
        assert first.network.distance(a, a + 11) == first.network.distances_from(a)[a + 11]


def test_without_numba_the_plain_kernel_serves(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "numba", None)
    assert not load_kernel().compiled
    monkeypatch.undo()
    assert load_kernel().compiled
