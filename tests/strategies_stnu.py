"""Random networks with uncertainty: lanes of activities that share a start, with links across them.

`lanes_network` looks like a plan: each lane is a sequence of activities, start to end, some of whose durations nature
decides, with gaps between them and deadlines and synchronisations across lanes. `tangle` is anything at all, small, to
reach the corners that plans do not have: zero bounds, chains of contingent links, links into their ends.
"""

from __future__ import annotations

import random

from hypothesis import strategies as st

from planner.temporal.controllability import check
from planner.temporal.stnu import Link, Stnu, TickRow


def lanes_network(seed: int, timepoints: int, contingent: float = 0.5, slack: int = 8) -> Stnu:
    """A plan-like network of about `timepoints` (at least 3); `contingent`: the share of activities nature decides.

    `slack` widens what the executive is asked for, so that more of the networks are controllable.
    """
    rng = random.Random(seed)
    names, rows = ["origin"], list[TickRow]()
    lanes = max(1, min(rng.randint(1, 8), (timepoints - 1) // 2))
    activities: list[list[tuple[int, int]]] = [[] for _ in range(lanes)]
    while len(names) + 2 <= timepoints:
        lane = activities[rng.randrange(lanes)]
        begin, end = len(names), len(names) + 1
        names += [f"start{begin}", f"end{begin}"]
        low = rng.randint(0, 6)
        spread = rng.choice((0, 1, 2, 4, 8)) if rng.random() < 0.9 else 20
        natural = rng.random() < contingent
        rows.append((begin, end, low, low + spread if natural or rng.random() < 0.7 else None, natural))
        before = lane[-1][1] if lane else 0
        gap = rng.choice((0, 0, 1, 2))
        rows.append((before, begin, gap, None if rng.random() < 0.6 else gap + rng.randint(0, slack), False))
        lane.append((begin, end))
    everything = [node for lane in activities for pair in lane for node in pair]
    for _ in range(rng.randint(0, max(1, len(everything) // 4))):
        first, second = rng.sample(sorted(everything), 2)
        kind = rng.random()
        if kind < 0.4:
            rows.append((first, second, rng.choice((0, 0, 1)), None, False))
        elif kind < 0.8:
            low = rng.randint(-slack, slack)
            rows.append((first, second, low, low + rng.randint(0, 3 * slack), False))
        else:
            rows.append((0, second, None, rng.randint(6, 8 * slack + 4 * len(everything)), False))
    return Stnu.from_ticks(names, rows)


def tight_network(seed: int, timepoints: int, contingent: float = 0.7, tries: int | None = None) -> Stnu:
    """A controllable plan-like network with little room: narrow links added one by one while it stays controllable."""
    rng = random.Random(seed)
    stnu = lanes_network(seed, timepoints, contingent, 40)
    while not check(stnu).controllable:
        stnu = Stnu(stnu.timepoints, stnu.links[: -max(1, len(stnu.links) // 8)])
    for _ in range(timepoints if tries is None else tries):
        first, second = rng.sample(range(timepoints if timepoints % 2 else timepoints - 1), 2)
        low = rng.randint(-12, 12)
        link = Link(first, second, low, low + rng.choice((1, 3, 6, 10)))
        candidate = Stnu(stnu.timepoints, (*stnu.links, link))
        if check(candidate).controllable:
            stnu = candidate
    return stnu


def tangle(rng: random.Random, nodes: int, links: int, largest: int = 4) -> Stnu:
    """Any well-formed network of `nodes` timepoints and up to `links` links with bounds up to `largest`."""
    rows, decided = list[TickRow](), set[int]()
    for _ in range(links):
        a, c = rng.sample(range(nodes), 2)
        if rng.random() < 0.5 and c not in decided and len(decided) < nodes // 2:
            low = rng.randint(0, largest)
            rows.append((a, c, low, low + rng.randint(0, largest), True))
            decided.add(c)
        else:
            low = rng.randint(-largest, largest)
            upper = low + rng.randint(-1, 2 * largest)
            rows.append((a, c, None if rng.random() < 0.2 else low, None if rng.random() < 0.2 else upper, False))
    return Stnu.from_ticks([f"t{i}" for i in range(nodes)], rows)


@st.composite
def tangles(draw: st.DrawFn, nodes: int = 6, links: int = 9, largest: int = 4) -> Stnu:
    """`tangle` for property tests; shrinks by its seed and sizes."""
    size = draw(st.integers(2, nodes))
    count = draw(st.integers(1, links))
    return tangle(random.Random(draw(st.integers(0, 2**32))), size, count, draw(st.integers(1, largest)))


@st.composite
def lanes_networks(draw: st.DrawFn, timepoints: int = 40) -> Stnu:
    """`lanes_network` for property tests."""
    return lanes_network(
        draw(st.integers(0, 2**32)),
        draw(st.integers(3, timepoints)),
        draw(st.sampled_from((0.2, 0.5, 0.8))),
        draw(st.sampled_from((3, 8, 16))),
    )
