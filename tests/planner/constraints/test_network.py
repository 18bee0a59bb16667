"""The constraint network: one door for change, a joint fixpoint with the temporal network, sufficient explanations."""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Callable, Iterator

import pytest

from planner.constraints import explanation
from planner.constraints.network import (
    AnyVariable,
    Constraint,
    ConstraintNetworkManager,
    DurationVariable,
    Inconsistency,
)
from planner.constraints.standard import STANDARD
from planner.constraints.temporal_forms import post_temporal
from planner.domains import Interval, Universe
from planner.temporal.network import TemporalNetworkManager
from planner.trail import Trail

COLOURS = Universe("colour", ["red", "green", "blue"])


class Bench:
    """A network with plain variables x0 to x3, a label, times t0 to t3 and the durations between neighbours."""

    def __init__(self) -> None:
        self.trail = Trail()
        self.temporal = TemporalNetworkManager()
        self.trail.join(self.temporal)
        self.network = ConstraintNetworkManager(self.trail, self.temporal)
        network = self.network
        self.plain: list[AnyVariable] = [network.variable(f"x{n}", Interval(0, 9), None) for n in range(4)]
        self.label = network.variable("label", COLOURS.domain(), None)
        self.times = [network.timepoint(f"t{n}", 0, 9, "frame") for n in range(4)]
        self.durations: list[AnyVariable] = [
            DurationVariable(f"d{n}", self.times[n], self.times[n + 1], Interval(-9, 9), None) for n in range(3)
        ]
        self.variables = [*self.plain, *self.times, *self.durations]
        network.propagate()


Operation = tuple[str, tuple[int, ...], tuple[int, ...]]
PROCEDURES = {"eq": 2, "leq": 2, "lt": 2, "neq": 2, "addEq": 3, "mulEq": 3}


def random_operation(rng: random.Random, count: int) -> Operation:
    kind = rng.choice(["restrict", "distance", *PROCEDURES])
    size = {"restrict": 1, "distance": 2}.get(kind, PROCEDURES.get(kind, 0))
    low = rng.randint(0, 6)
    return kind, tuple(rng.sample(range(count), size)), (low, low + rng.randint(0, 5))


def apply(bench: Bench, operation: Operation, owner: str) -> None:
    kind, places, (low, high) = operation
    network = bench.network
    if kind == "restrict":
        network.restrict(bench.variables[places[0]], Interval(low, high), owner)
    elif kind == "distance":
        a, b = (bench.times[p % 4] for p in places)
        if a is not b:
            network.distance(a, b, low - 3, high - 3, owner)
    else:
        scope = [bench.variables[p] for p in places]
        if not post_temporal(network, kind, scope, owner):
            network.post(STANDARD.get(kind), scope, owner)
    network.propagate()


def explained(seed: int, length: int = 16) -> tuple[list[Operation], set[int]] | None:
    """Random operations up to the first inconsistency, and those that its explanation names; None without one."""
    rng, bench = random.Random(seed), Bench()
    operations: list[Operation] = []
    for number in range(length):
        operations.append(random_operation(rng, len(bench.variables)))
        if rng.random() < 0.3:
            bench.trail.push()
        try:
            apply(bench, operations[-1], f"operation {number}")
        except Inconsistency as inconsistency:
            owners = bench.network.explain(inconsistency)
            assert len({id(o) for o in owners}) == len(owners)
            return operations, {int(o.split()[1]) for o in owners if o != "frame"}
    return None


def consistent(operations: list[Operation], chosen: set[int]) -> bool:
    bench = Bench()
    try:
        for number in sorted(chosen):
            apply(bench, operations[number], f"operation {number}")
    except Inconsistency:
        return False
    return True


def judged(seeds: range) -> Iterator[tuple[bool, bool]]:
    """For every seed with an inconsistency: whether its explanation suffices, and whether it leaves something out."""
    for seed in seeds:
        result = explained(seed)
        if result is not None:
            operations, chosen = result
            yield not consistent(operations, chosen), len(chosen) < len(operations)


def test_every_explanation_suffices() -> None:
    results = list(judged(range(500)))
    assert all(suffices for suffices, _ in results)
    assert len(results) > 300
    assert sum(smaller for _, smaller in results) > len(results) / 2


def test_an_explanation_that_forgets_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(explanation._Tracer, "_changes", lambda *_: None)
    assert not all(suffices for suffices, _ in judged(range(300)))


def test_an_explanation_from_the_present_bounds_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    def only_now(tracer: explanation._Tracer, timepoint: int, side: explanation.Side, edges: int) -> tuple[int, ...]:
        return tracer.network.temporal.explain(timepoint, side)

    monkeypatch.setattr(explanation._Tracer, "_chain_then", only_now)
    assert not all(suffices for suffices, _ in judged(range(1200)))


def test_the_fixpoint_keeps_every_solution() -> None:
    """Against all assignments: a value of a solution is never removed, and assigned variables decide."""
    rng = random.Random(5)
    relations: dict[str, Callable[..., bool]] = {
        "eq": lambda a, b: a == b,
        "leq": lambda a, b: a <= b,
        "lt": lambda a, b: a < b,
        "neq": lambda a, b: a != b,
        "addEq": lambda a, b, c: a + b == c,
        "mulEq": lambda a, b, c: a * b == c,
    }
    for _ in range(20):
        bench = Bench()
        variables = [*bench.plain[:2], *bench.times[:2], bench.durations[0]]
        solutions = [(a, b, s, e, e - s) for a, b, s, e in itertools.product(range(10), repeat=4)]
        try:
            for _ in range(4):
                name = rng.choice(list(relations))
                places = rng.sample(range(5), PROCEDURES[name])
                scope = [variables[p] for p in places]
                if not post_temporal(bench.network, name, scope, "test"):
                    bench.network.post(STANDARD.get(name), scope, "test")
                solutions = [s for s in solutions if relations[name](*(s[p] for p in places))]
                bench.network.propagate()
                for place, variable in enumerate(variables):
                    assert all(s[place] in variable.domain for s in solutions)
        except Inconsistency:
            assert not solutions
        else:
            if all(v.domain.is_singleton for v in variables):
                assert len(solutions) == 1


def test_a_procedure_on_a_time_ends() -> None:
    # A timepoint shows its new bounds only after the temporal network's own propagation.
    bench = Bench()
    bench.network.post(STANDARD.get("eq"), (bench.times[0], bench.plain[0]), "test")
    bench.network.restrict(bench.plain[0], Interval(4, 5), "test")
    bench.network.propagate()
    assert bench.times[0].domain == Interval(4, 5)
    bench.network.restrict(bench.times[0], Interval(5, 9), "test")
    bench.network.propagate()
    assert bench.plain[0].domain == Interval(5, 5)


def test_a_duration_is_bounded_from_both_sides() -> None:
    bench = Bench()
    network, duration = bench.network, bench.durations[0]
    network.post(STANDARD.get("eq"), (duration, bench.plain[0]), "test")
    network.restrict(bench.times[0], Interval(2, 3), "test")
    network.restrict(bench.times[1], Interval(6, 8), "test")
    network.propagate()
    assert duration.domain == bench.plain[0].domain == Interval(3, 6)
    network.restrict(bench.plain[0], Interval(6, 9), "test")
    network.propagate()
    assert (bench.times[0].domain, bench.times[1].domain) == (Interval(2, 2), Interval(8, 8))


def test_restrict_says_whether_anything_changed_and_blames_only_what_moved() -> None:
    bench = Bench()
    network = bench.network
    assert not network.restrict(bench.label, COLOURS.domain(), "same")
    assert network.restrict(bench.label, COLOURS.domain(["red"]), "red")
    assert network.restrict(bench.times[0], Interval(3, 9), "late")
    network.propagate()
    _, _, _, minimum, maximum, number = list(bench.temporal.constraints())[-1]
    assert (minimum, network.stakeholder_named(number)) == (3, "late")
    assert maximum > 10**9  # the upper end is the frame's doing, not this owner's


def test_a_label_without_values_is_explained() -> None:
    bench = Bench()
    bench.network.restrict(bench.label, COLOURS.domain(["red", "green"]), "not blue")
    bench.network.restrict(bench.plain[0], Interval(1, 2), "irrelevant")
    with pytest.raises(Inconsistency) as raised:
        bench.network.restrict(bench.label, COLOURS.domain(["blue"]), "blue")
    assert set(bench.network.explain(raised.value)) == {"not blue", "blue"}


def test_a_time_without_values_is_explained() -> None:
    bench = Bench()
    bench.network.restrict(bench.times[0], Interval(5, math.inf), "late")
    bench.network.propagate()
    with pytest.raises(Inconsistency) as raised:
        bench.network.restrict(bench.times[0], Interval(-math.inf, 3), "early")
    assert set(bench.network.explain(raised.value)) >= {"late", "early"}


def test_a_temporal_cycle_is_explained() -> None:
    bench = Bench()
    a, b, c = bench.times[:3]
    for owner, one, two in (("ab", a, b), ("bc", b, c), ("ca", c, a)):
        bench.network.distance(one, two, 1, math.inf, owner)
    with pytest.raises(Inconsistency) as raised:
        bench.network.propagate()
    assert set(bench.network.explain(raised.value)) == {"ab", "bc", "ca"}


def test_undo_forgets_the_queue() -> None:
    bench = Bench()
    depth = bench.trail.push()
    constraint: Constraint = bench.network.post(STANDARD.get("lt"), bench.plain[:2], "test")
    assert constraint.queued
    bench.trail.pop_to(depth)
    assert not constraint.queued
    bench.network.propagate()
    assert [v.domain for v in bench.plain[:2]] == [Interval(0, 9), Interval(0, 9)]
    assert not any(v.watchers for v in bench.plain)
