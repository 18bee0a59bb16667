"""Speed of the temporal network manager on a plan-like network.

Workload: timelines of 25 tokens (20 timelines at 1000 timepoints, 100 at 5000), durations and some successions bounded
on both sides, and one-sided precedences between timelines until there are 4.2 one-sided edges a timepoint, initial
bounds not counted. An operation is mark, tighten, propagate, check, undo. A quarter are new orderings, the others
tighten a duration or a succession; about 9 % are infeasible, and about 93 bounds change an operation at 1000
timepoints. Each is timed in two forms, the Python calls included: through `probe`, which is the five steps in one call,
and through the ordinary interface, a call a step.
"""

from __future__ import annotations

import gc
import random
import time
from collections.abc import Callable
from dataclasses import dataclass

from planner.temporal import kernel_python as layout
from planner.temporal.network import INFINITY, TemporalNetworkManager

NATIVE_US = {200: 0.52, 1000: 2.0, 5000: 9.6}
"""The same kind of workload and algorithm in C++ (-O2), the loop over operations native too: microseconds each."""

EDGES_PER_TIMEPOINT = 4.2
TOKENS_PER_TIMELINE = 25
OPERATIONS = 10_000
REPEATS = 9

# How loose the network is and how hard the operations bite, in ticks; tokens last 50 to 150.
SLACK_DUR, SLACK_CROSS = 60, 500
BOUNDED_GAPS = 0.3
ORDER, CUT = (-300, 230), (5, 63)


@dataclass(frozen=True, slots=True)
class Operation:
    """`minimum <= to - from_ <= maximum` for a while; a tightening of `constraint`, or a new ordering if that is -1."""

    constraint: int
    from_: int
    to: int
    minimum: int
    maximum: int
    observed: int


@dataclass(frozen=True, slots=True)
class Workload:
    """A consistent network, the times of one schedule of it, and operations on it."""

    network: TemporalNetworkManager
    times: list[int]
    operations: list[Operation]


def build(timepoints: int, seed: int = 1, *, operations: int = OPERATIONS, compiled: bool | None = None) -> Workload:
    """The workload for a number of timepoints."""
    rng = random.Random(seed)
    network = TemporalNetworkManager((0, 100_000), compiled=compiled)
    times = [0]
    starts: list[list[int]] = []
    for _ in range(max(1, timepoints // (2 * TOKENS_PER_TIMELINE))):
        clock = rng.randint(0, 200)
        timeline: list[int] = []
        for _ in range(TOKENS_PER_TIMELINE):
            start, end = (network.add_timepoint(0, 100_000) for _ in range(2))
            length, gap = rng.randint(50, 150), rng.randint(0, 40)
            if timeline:
                network.post(start - 1, start, 0, 3 * gap + 60 if rng.random() < BOUNDED_GAPS else INFINITY)
            times += [clock + gap, clock + gap + length]
            clock = times[end]
            network.post(start, end, length - rng.randint(0, SLACK_DUR), length + rng.randint(0, SLACK_DUR))
            timeline.append(start)
        starts.append(timeline)
    bounded = [(row[0], row[1], row[2], row[3], row[4]) for row in network.constraints()]
    ordered = sorted(range(1, len(times)), key=times.__getitem__)
    for _ in range(int(EDGES_PER_TIMEPOINT * timepoints) - 2 * len(bounded)):
        place = rng.randrange(len(ordered) - 1)
        later = min(len(ordered) - 1, place + rng.randint(1, len(starts) * 4))
        first, second = ordered[place], ordered[later]
        network.post(first, second, times[second] - times[first] - rng.randint(0, SLACK_CROSS), INFINITY)
    if not network.propagate():
        raise AssertionError("the schedule satisfies every constraint")
    return Workload(network, times, [_operation(rng, bounded, ordered, times, len(starts)) for _ in range(operations)])


def _operation(
    rng: random.Random, bounded: list[tuple[int, int, int, int, int]], ordered: list[int], times: list[int], width: int
) -> Operation:
    if rng.random() < 0.25:
        place = rng.randrange(len(ordered) - 1)
        later = min(len(ordered) - 1, place + rng.randint(1, 2 * width))
        first, second = ordered[place], ordered[later]
        return Operation(-1, first, second, times[second] - times[first] + rng.randint(*ORDER), INFINITY, second)
    constraint, from_, to, minimum, maximum = rng.choice(bounded)
    cut = rng.randint(*CUT)
    if rng.random() < 0.5:
        return Operation(constraint, from_, to, minimum + cut, maximum, to)
    return Operation(constraint, from_, to, minimum, maximum - cut, to)


def one_call(network: TemporalNetworkManager, operations: list[Operation]) -> None:
    """Every operation through `probe`."""
    probe = network.probe
    for operation in operations:
        probe(operation.from_, operation.to, operation.minimum, operation.maximum, operation.observed)


def call_by_call(network: TemporalNetworkManager, operations: list[Operation]) -> None:
    """Every operation through mark, tighten or post, propagate, two reads, undo."""
    for operation in operations:
        mark = network.mark()
        if operation.constraint >= 0:
            network.tighten(operation.constraint, operation.minimum, operation.maximum)
        else:
            network.post(operation.from_, operation.to, operation.minimum, operation.maximum)
        if network.propagate():
            network.lower(operation.observed)
            network.upper(operation.observed)
        network.undo_to(mark)


def microseconds(
    run: Callable[[TemporalNetworkManager, list[Operation]], None], workload: Workload, repeats: int = REPEATS
) -> float:
    """The time of an operation, garbage collection off: best of some repeats for each slice of 250 operations.

    Slices of about a millisecond keep what else the machine does out of the figure.
    """
    slices = [workload.operations[first : first + 250] for first in range(0, len(workload.operations), 250)]
    best = [float("inf")] * len(slices)
    gc.disable()
    try:
        for _ in range(repeats):
            for place, operations in enumerate(slices):
                begin = time.perf_counter()
                run(workload.network, operations)
                best[place] = min(best[place], time.perf_counter() - begin)
    finally:
        gc.enable()
    return sum(best) / len(workload.operations) * 1e6


def character(workload: Workload) -> dict[str, float]:
    """What the operations do: share infeasible, bounds set and different bounds changed, averages an operation."""
    network = workload.network
    infeasible = writes = bounds = 0
    for operation in workload.operations:
        mark = network.mark()
        network.post(operation.from_, operation.to, operation.minimum, operation.maximum)
        if network.propagate():
            records = network._trail_view[4 * mark : 4 * network.mark()].tolist()
            labels = [records[row + 1] for row in range(0, len(records), 4) if records[row] == layout.SET]
            writes += len(labels)
            bounds += len(set(labels))
        else:
            infeasible += 1
        network.undo_to(mark)
    count = len(workload.operations)
    return {"infeasible": infeasible / count, "writes": writes / count, "bounds": bounds / count}


def us_per_op(sizes: tuple[int, ...] = (200, 1000, 5000), *, compiled: bool | None = None) -> dict[int, float]:
    """Microseconds an operation in one call, by number of timepoints."""
    return {n: microseconds(one_call, build(n, compiled=compiled)) for n in sizes}


def rows(sizes: tuple[int, ...] = (200, 1000, 5000)) -> list[dict[str, float]]:
    """One row a size, for the table."""
    table = []
    for n in sizes:
        workload = build(n)
        one, steps = microseconds(one_call, workload), microseconds(call_by_call, workload)
        row = {"timepoints": n, "us_per_op": one, "us_call_by_call": steps, "native_us": NATIVE_US[n]}
        table.append({**row, "ratio_to_native": one / NATIVE_US[n], **character(workload)})
    return table


def measure() -> dict[str, object]:
    """All figures of this benchmark: microseconds an operation by number of timepoints, and a row a size."""
    table = rows()
    return {"us_per_op": {str(int(row["timepoints"])): row["us_per_op"] for row in table}, "rows": table}
