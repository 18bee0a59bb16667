"""Random histories against Floyd-Warshall: the compiled kernel, its plain twin and the reference, step by step."""

from __future__ import annotations

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.temporal.network import INFINITY, TemporalNetworkManager
from tests.planner.temporal.network_oracle import (
    Reference,
    all_pairs,
    check_conflict,
    check_explanations,
    consistent,
    image,
)

STEPS = 120


class History:
    """One random history, lived by both kernels and the reference at once."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        self.networks = [TemporalNetworkManager((-60, 60), compiled=compiled) for compiled in (True, False)]
        self.reference = Reference()
        self.marks: list[tuple[int, Reference, list[tuple[object, ...]]]] = []
        self.counts = {True: 0, False: 0}
        self.size = self.rng.choice((3, 6, 12))
        self.slack = self.rng.choice((4, 15, 40))

    def run(self, steps: int) -> None:
        actions = [self.add, self.post, self.post, self.post, self.restrict, self.tighten, self.remove]
        actions += [self.push, self.pop, self.watch, self.changed, self.propagate, self.propagate, self.probe]
        for _ in range(steps):
            self.rng.choice(actions)()
            self.compare()

    def bounds(self) -> tuple[int, int]:
        middle = self.rng.randint(-self.slack // 2, self.slack)
        minimum, maximum = middle - self.rng.randint(0, self.slack), middle + self.rng.randint(-1, self.slack)
        shape = self.rng.random()
        return (-INFINITY if shape < 0.2 else minimum), (INFINITY if shape > 0.8 else maximum)

    def points(self) -> tuple[int, int]:
        n = len(self.reference.points)
        return self.rng.randrange(n), self.rng.randrange(n)

    def add(self) -> None:
        if len(self.reference.points) > self.size:
            return
        lower, upper = self.rng.randint(-90, 0), self.rng.randint(0, 90)
        if self.rng.random() < 0.03:
            lower, upper = 70, 80
        self.reference.points.append((max(lower, -60), min(upper, 60)))
        assert {network.add_timepoint(lower, upper) for network in self.networks} == {len(self.reference.points) - 1}

    def post(self) -> None:
        (from_, to), (minimum, maximum) = self.points(), self.bounds()
        expected = self.reference.post(from_, to, minimum, maximum)
        assert {network.post(from_, to, minimum, maximum, 7) for network in self.networks} == {expected}

    def restrict(self) -> None:
        (point, _), (minimum, maximum) = self.points(), self.bounds()
        expected = self.reference.post(0, point, minimum, maximum)
        assert {network.restrict(point, minimum, maximum) for network in self.networks} == {expected}

    def live(self) -> list[int]:
        return [key for key in range(self.reference.posted) if key not in self.reference.removed]

    def tighten(self) -> None:
        if not self.live():
            return
        constraint, (minimum, maximum) = self.rng.choice(self.live()), self.bounds()
        self.reference.tighten(constraint, minimum, maximum)
        for network in self.networks:
            network.tighten(constraint, minimum, maximum)

    def remove(self) -> None:
        if self.reference.posted == 0:
            return
        chosen = [self.rng.randrange(self.reference.posted) for _ in range(self.rng.randint(1, 4))]
        self.reference.remove(chosen)
        for network in self.networks:
            network.remove(chosen)
        if all(lower <= upper for lower, upper in self.reference.points):
            check_explanations(self.networks[0], self.reference)

    def push(self) -> None:
        images = [image(network) for network in self.networks]
        self.marks.append((self.networks[0].mark(), self.reference.snapshot(), images))

    def pop(self) -> None:
        if not self.marks:
            return
        depth = self.rng.randrange(len(self.marks)) if self.rng.random() < 0.3 else len(self.marks) - 1
        mark, self.reference, images = self.marks[depth]
        del self.marks[depth:]
        for network, expected in zip(self.networks, images, strict=True):
            network.undo_to(mark)
            assert image(network) == expected

    def watch(self) -> None:
        point, _ = self.points()
        self.reference.watched.add(point)
        for network in self.networks:
            network.watch(point)

    def changed(self) -> None:
        found = [network.changed() for network in self.networks]
        assert found[0] == found[1]
        assert len(found[0]) == len(set(found[0]))
        assert set(found[0]) == self.reference.unread
        self.reference.unread = set()

    def propagate(self) -> None:
        before = [image(network) for network in self.networks]
        verdict = self.reference.propagate()
        assert {network.propagate() for network in self.networks} == {verdict}
        self.counts[verdict] += 1
        if verdict:
            check_explanations(self.networks[0], self.reference)
            return
        assert [image(network) for network in self.networks] == before
        for network in self.networks:
            check_conflict(network, self.reference)
        assert self.networks[0].conflict_cycle() == self.networks[1].conflict_cycle()
        queued = [key for key in self.networks[0].conflict() if key in {entry[0] for entry in self.reference.queue}]
        if self.marks and self.rng.random() < 0.5:
            self.pop()
        elif queued:
            self.reference.remove(queued)
            for network in self.networks:
                network.remove(queued)

    def probe(self) -> None:
        (from_, to), (minimum, maximum), (seen, _) = self.points(), self.bounds(), self.points()
        trial = self.reference.snapshot()
        trial.post(from_, to, minimum, maximum)
        before = [image(network) for network in self.networks]
        found = {network.probe(from_, to, minimum, maximum, seen) for network in self.networks}
        assert [image(network) for network in self.networks] == before
        assert found == {trial.bounds()[seen] if trial.propagate() else None}

    def compare(self) -> None:
        expected = self.reference.bounds()
        proper = all(lower <= upper for lower, upper in self.reference.points)
        d = all_pairs(self.reference.points, self.reference.rows)
        a, b = self.points()
        for network in self.networks:
            if proper:
                assert [(network.lower(t), network.upper(t)) for t in range(len(expected))] == expected
                assert network.distance(a, b) == (-d[b, a], d[a, b])
                assert [tuple(pair) for pair in network.distances_from(a)] == list(zip(-d[:, a], d[a], strict=True))
                later, sooner = network.reach(a, True, -1), network.reach(a, False, -1)
                assert [(later(t), sooner(t)) for t in range(len(d))] == list(zip(d[a], d[:, a], strict=True))
                near = network.reach(a, True, 2)
                assert all(d[a, t] <= near(t) <= network.upper(t) - network.lower(a) for t in range(len(d)))
        first, second = self.networks
        assert image(first) == image(second)
        rows = {row[0]: row[1:5] for row in first.constraints()}
        assert all(rows[key] == row for key, row in self.reference.rows.items())
        assert not rows.keys() & self.reference.removed


@pytest.mark.parametrize("seed", range(60))
def test_random_history(seed: int) -> None:
    history = History(seed)
    history.run(STEPS)


def test_histories_meet_both_verdicts() -> None:
    feasible = infeasible = 0
    for seed in range(12):
        history = History(1000 + seed)
        history.run(STEPS)
        feasible += history.counts[True]
        infeasible += history.counts[False]
    assert feasible > 50
    assert infeasible > 50


edges = st.tuples(st.integers(0, 5), st.integers(0, 5), st.integers(-12, 12), st.integers(0, 15))


@settings(max_examples=150, deadline=None, derandomize=True)
@given(st.lists(edges, max_size=14), st.randoms(use_true_random=False), st.booleans())
def test_removal_in_any_order_equals_never_posted(
    rows: list[tuple[int, int, int, int]], rng: random.Random, compiled: bool
) -> None:
    network = TemporalNetworkManager((-50, 50), compiled=compiled)
    for _ in range(5):
        network.add_timepoint(-50, 50)
    points = [(0, 0)] + [(-50, 50)] * 5
    kept: dict[int, tuple[int, int, int, int]] = {}
    for from_, to, low, width in rows:
        row = (from_, to, low, low + width)
        mark = network.mark()
        constraint = network.post(*row)
        if network.propagate():
            kept[constraint] = row
        else:
            network.undo_to(mark)
    order = list(kept)
    rng.shuffle(order)
    start, before = network.mark(), image(network)
    for constraint in order:
        network.remove([constraint])
        del kept[constraint]
        d = all_pairs(points, kept)
        assert [(network.lower(t), network.upper(t)) for t in range(6)] == list(zip(-d[:, 0], d[0], strict=True))
    network.undo_to(start)
    assert image(network) == before


@settings(max_examples=150, deadline=None, derandomize=True)
@given(st.lists(edges, min_size=1, max_size=14), st.booleans())
def test_one_batch_equals_one_by_one(rows: list[tuple[int, int, int, int]], compiled: bool) -> None:
    points = [(0, 0)] + [(-50, 50)] * 5
    network = TemporalNetworkManager((-50, 50), compiled=compiled)
    for _ in range(5):
        network.add_timepoint(-50, 50)
    posted = {network.post(a, b, low, low + width): (a, b, low, low + width) for a, b, low, width in rows}
    d = all_pairs(points, posted)
    assert network.propagate() == consistent(d)
    if consistent(d):
        assert [(network.lower(t), network.upper(t)) for t in range(6)] == list(zip(-d[:, 0], d[0], strict=True))
