"""Executing a network against drawn contingent durations, by this executive's strategy or by the usual one.

`rte`: the dispatchable network with its waits. `stn`: what executives do that propagate a plain simple temporal network
completely: contingent links count as ordinary ones, each timepoint happens at its earliest time in the minimal network,
and what is observed tightens the rest. The comparison says what knowing that durations are uncontrollable is worth.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from executive.dispatcher import Choice, Dispatcher
from planner.temporal.controllability import DispatchableNetwork, check, original_network
from planner.temporal.stnu import CONTINGENT, FROM, MAX, MIN, TO, UNBOUNDED, Stnu

IntArray = NDArray[np.int64]
Strategy = Literal["rte", "stn"]
Nature = Literal["early", "late", "extremes", "uniform", "adversarial"]
NATURES: tuple[Nature, ...] = get_args(Nature)
# How long the contingent link of this number lasts (ticks), asked just after its activation in the given execution.
DrawDuration = Callable[[int, Dispatcher], int]

_FAR = 1 << 62


@dataclass(frozen=True, slots=True)
class SimulationResult:
    """`satisfied` of `runs` broke no link. `violations`: by link, in how many runs it was broken or left undone."""

    runs: int
    satisfied: int
    violations: Mapping[int, int]


def simulate(
    stnu: Stnu,
    runs: int,
    strategy: Strategy = "rte",
    seed: int = 0,
    nature: Nature | None = None,
    choice: Choice = "earliest",
) -> SimulationResult:
    """Execute the network `runs` times from tick 0.

    `nature`: how durations are drawn; without it the runs take all early, all late, random extremes, uniform and
    adversarial in turn. Adversarial: of the extremes the one that leaves the neighbours the least room. A network that
    is not controllable is executed as by stn, an inconsistent one by its links as they are.
    """
    network = network_for(stnu, strategy)
    rng = np.random.default_rng(seed)
    satisfied, violations = 0, dict[int, int]()
    for run in range(runs):
        draw = durations(network, nature or NATURES[run % len(NATURES)], rng)
        broken = broken_links(stnu, execute(network, draw, choice))
        satisfied += not broken
        for link in broken:
            violations[link] = violations.get(link, 0) + 1
    return SimulationResult(runs, satisfied, dict(sorted(violations.items())))


def simulate_file(path: Path, runs: int, strategy: Strategy = "rte", seed: int = 0) -> dict[str, object]:
    """`simulate` on a network file as one line of a report. Raises NetworkFormatError for what is not a network."""
    result = simulate(Stnu.load(path), runs, strategy, seed)
    return {
        "file": str(path),
        "strategy": strategy,
        "seed": seed,
        "runs": result.runs,
        "satisfied": result.satisfied,
        "violations": sum(result.violations.values()),
        "violations_by_constraint": {str(link): count for link, count in result.violations.items()},
    }


def network_for(stnu: Stnu, strategy: Strategy) -> DispatchableNetwork:
    """The network that the strategy dispatches."""
    if strategy == "rte":
        return check(stnu).network or _minimal_network(stnu)
    return _minimal_network(stnu)


def execute(network: DispatchableNetwork, draw: DrawDuration, choice: Choice = "earliest") -> tuple[int | None, ...]:
    """One execution from tick 0: when each timepoint happened, None for what nothing could bring about any more."""
    dispatcher = Dispatcher(network)
    rows = network.contingents.tolist()
    activated: dict[int, list[int]] = {}
    for number, row in enumerate(rows):
        activated.setdefault(row[0], []).append(number)
    running: list[tuple[int, int]] = []  # (time of the end, contingent)
    now = 0
    while True:
        decision = dispatcher.next_decision(now, choice)
        if running and (decision is None or running[0][0] <= decision.time):  # what happens by then is observed first
            now, number = heapq.heappop(running)
            happening: tuple[int, ...] = (rows[number][1],)
        elif decision is not None:
            now, happening = decision.time, decision.timepoints
        else:
            return tuple(dispatcher.time(node) for node in range(len(network.timepoints)))
        for node in happening:
            dispatcher.happened(node, now)
            for number in activated.get(node, ()):
                heapq.heappush(running, (now + draw(number, dispatcher), number))


def durations(network: DispatchableNetwork, nature: Nature, rng: np.random.Generator) -> DrawDuration:
    """Nature of the given temper; see `simulate`."""
    rows = network.contingents.tolist()

    def uniform(number: int, dispatcher: Dispatcher) -> int:
        del dispatcher
        return int(rng.integers(rows[number][2], rows[number][3], endpoint=True))

    def adversarial(number: int, dispatcher: Dispatcher) -> int:
        activation, end, least, most, _ = rows[number]
        begin = dispatcher.time(activation)
        assert begin is not None
        room_early, room_late = dispatcher.slack_if(end, begin + least), dispatcher.slack_if(end, begin + most)
        if room_early == room_late:
            return int(rng.choice((least, most)))
        shorter: bool = room_early < room_late
        return int(least if shorter else most)

    simple: dict[Nature, DrawDuration] = {
        "early": lambda number, _: rows[number][2],
        "late": lambda number, _: rows[number][3],
        "extremes": lambda number, _: int(rng.choice(rows[number][2:4])),
        "uniform": uniform,
        "adversarial": adversarial,
    }
    return simple[nature]


def broken_links(stnu: Stnu, times: tuple[int | None, ...]) -> tuple[int, ...]:
    """The links that the times break, or whose ends did not both happen."""
    broken = []
    for index, (from_, to, lower, upper, _) in enumerate(stnu.table.tolist()):
        begin, end = times[from_], times[to]
        if begin is None or end is None or end - begin < lower or (upper != UNBOUNDED and end - begin > upper):
            broken.append(index)
    return tuple(broken)


def _minimal_network(stnu: Stnu) -> DispatchableNetwork:
    """All-pairs shortest paths with contingent links as ordinary ones (Dechter, Meiri and Pearl 1991).

    As time passes, an end that has not been observed moves later, and with it everything that it bounds from below.
    Among what has not happened that concerns only what must not precede the end, so it is said as waits for the end.
    """
    n = len(stnu.timepoints)
    distance = np.full((n, n), _FAR, dtype=np.int64)
    np.fill_diagonal(distance, 0)
    for row in stnu.table:
        if row[MAX] != UNBOUNDED:
            distance[row[FROM], row[TO]] = min(distance[row[FROM], row[TO]], row[MAX])
        if row[MIN] != -UNBOUNDED:
            distance[row[TO], row[FROM]] = min(distance[row[TO], row[FROM]], -row[MIN])
    for middle in range(n):
        into, out = distance[:, middle], distance[middle]
        from_, to = np.nonzero(into < _FAR)[0], np.nonzero(out < _FAR)[0]
        block = np.ix_(from_, to)
        distance[block] = np.minimum(distance[block], into[from_, None] + out[None, to])
        if (np.diagonal(distance) < 0).any():
            return original_network(stnu)
    x, y = np.nonzero((distance < _FAR) & ~np.eye(n, dtype=np.bool_))
    edges = np.column_stack((x, y, distance[x, y]))
    chosen = np.nonzero(stnu.table[:, CONTINGENT])[0]
    contingents = np.column_stack((stnu.table[chosen][:, (FROM, TO, MIN, MAX)], chosen))
    waits = [
        (number, node, -most)
        for number, (_, end, _, most, _) in enumerate(contingents.tolist())
        for node in np.nonzero(distance[:, end] <= 0)[0].tolist()
        if most > 0 and node not in contingents[:, 1]
    ]
    rows = np.array(waits, dtype=np.int64).reshape(len(waits), 3)
    return DispatchableNetwork(stnu.timepoints, stnu.ticks_per_unit, edges, rows, contingents)
