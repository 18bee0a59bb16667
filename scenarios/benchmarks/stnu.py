"""How long the controllability check, building a network and a dispatch decision take.

The networks are plan-like and controllable, from fixed seeds. Each
figure is the best of several runs, except the decisions: median and 99th percentile of all those of one execution.
"""

from __future__ import annotations

import random
import time
from collections.abc import Callable

import numpy as np

from executive.dispatcher import Dispatcher
from planner.temporal import _controllability_python
from planner.temporal.controllability import check, check_with
from planner.temporal.stnu import Bound, Link, Stnu, TickRow


def lanes(timepoints: int, contingent: int, seed: int = 1) -> Stnu:
    """A controllable network: lanes of activities from one origin, `contingent` of them nature's, and links across.

    The links across are kept when the network stays controllable with them, which most do.
    """
    rng = random.Random(seed)
    activities = (timepoints - 1) // 2
    natural = set(rng.sample(range(activities), contingent))
    last = [0] * max(2, timepoints // 25)
    rows: list[tuple[int, int, int | None, int | None, bool]] = []
    for activity in range(activities):
        begin, lane, low = 1 + 2 * activity, activity % len(last), rng.randint(1, 30)
        high = low + rng.randint(1, 20) if activity in natural else (low + 40 if rng.random() < 0.5 else None)
        rows += [(begin, begin + 1, low, high, activity in natural), (last[lane], begin, 0, None, False)]
        last[lane] = begin + 1
    count = 1 + 2 * activities
    stnu = Stnu.from_ticks([f"t{i}" for i in range(count)], rows)
    for _ in range(activities // 5):
        wider = Stnu(stnu.timepoints, (*stnu.links, *(_across(rng, count, len(last)) for _ in range(10))))
        if check(wider).controllable:
            stnu = wider
    return stnu


def _across(rng: random.Random, count: int, lane_count: int) -> Link:
    """A link to something planned a little later: after it, at most so long after it, or close to it."""
    first = rng.randrange(1, count - 1)
    second = min(count - 1, first + rng.randint(1, 4 * lane_count))
    kind = rng.random()
    if kind < 0.5:
        return Link(first, second, 0, None)
    if kind < 0.8:
        return Link(first, second, 0, rng.randint(60, 400))
    return Link(first, second, -rng.randint(30, 90), rng.randint(60, 200))


def tick_rows(stnu: Stnu) -> list[TickRow]:
    """The links of a network of whole ticks, as the rows that a caller without a file has."""
    return [(link.from_, link.to, _ticks(link.min), _ticks(link.max), link.contingent) for link in stnu.links]


def _ticks(bound: Bound) -> int | None:
    return None if bound is None else int(bound)


def best_ms(run: Callable[[], object], repeats: int = 5) -> float:
    """Milliseconds of the fastest of `repeats` runs."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        run()
        times.append(time.perf_counter() - begin)
    return 1e3 * min(times)


def decision_us(stnu: Stnu, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Microseconds of each decision and of each event's propagation in one execution with random durations."""
    network = check(stnu).network
    assert network is not None
    dispatcher, rng = Dispatcher(network), random.Random(seed)
    ends: dict[int, int] = {}
    now, decisions, events = 0, [], []
    while not dispatcher.finished:
        begin = time.perf_counter()
        decision = dispatcher.next_decision(now)
        decisions.append(time.perf_counter() - begin)
        first = min(ends, key=lambda node: ends[node]) if ends else None
        if first is not None and (decision is None or ends[first] <= decision.time):
            now, happening = ends.pop(first), [first]
        else:
            assert decision is not None
            now, happening = decision.time, list(decision.timepoints)
        for node in happening:
            begin = time.perf_counter()
            violation = dispatcher.happened(node, now)
            events.append(time.perf_counter() - begin)
            assert violation is None
            for activation, end, least, most, _ in network.contingents.tolist():
                if activation == node:
                    ends[end] = now + rng.randint(least, most)
    return 1e6 * np.array(decisions), 1e6 * np.array(events)


def measure() -> dict[str, object]:
    """All figures of this benchmark."""
    small, large = lanes(161, 80), lanes(1001, 100)
    rows = tick_rows(small)
    decisions, events = decision_us(large)
    network = check(large).network
    assert network is not None
    return {
        "dc_check_ms": {
            "160": best_ms(lambda: check(small), 200),
            "1000": best_ms(lambda: check(large), 10),
        },
        "dc_check_plain_python_ms": {
            "160": best_ms(lambda: check_with(_controllability_python.check_links, small), 3),
            "1000": best_ms(lambda: check_with(_controllability_python.check_links, large), 1),
        },
        "build_and_check_160_ms": best_ms(lambda: check(Stnu.from_ticks(small.timepoints, rows)), 200),
        "links": {"160": len(small.links), "1000": len(large.links)},
        "dispatchable_1000": {"edges": len(network.edges), "waits": len(network.waits)},
        "decision_us_p50": float(np.percentile(decisions, 50)),
        "decision_us_p99": float(np.percentile(decisions, 99)),
        "event_us_p50": float(np.percentile(events, 50)),
        "event_us_p99": float(np.percentile(events, 99)),
    }
