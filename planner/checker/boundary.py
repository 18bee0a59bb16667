"""The horizon rule: may tokens that the plan does not have lie wholly outside the horizon?"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

from planner.checker.expressions import Wanted
from planner.checker.network import INF, PlanNetwork
from planner.checker.requirements import Link, Point


def may_be_outside(
    network: PlanNetwork,
    horizon: tuple[int, int],
    wanted: Sequence[Wanted],
    links: Sequence[Link],
    points: Sequence[int],
) -> bool:
    """Whether tokens with their declared durations and these links to each other and to the plan could all be, and
    each of them, in some schedule, end by the horizon's start or begin at its end.

    `points`: further timepoints of the plan through which the links may act on each other.
    """
    real = {0, *points, *(p for link in links for p in (link.from_, link.to) if isinstance(p, int))}
    nodes: list[Point] = [*sorted(real)]
    for token in wanted:
        nodes += [(token.name, "start"), (token.name, "end")]
    place = {point: number for number, point in enumerate(nodes)}
    size = len(nodes)
    far = [[0.0 if a == b else INF for b in range(size)] for a in range(size)]
    for a, b in product(sorted(real), repeat=2):
        far[place[a]][place[b]] = network.distance(a, b)
    lasting = [Link((w.name, "start"), (w.name, "end"), *w.predicate.duration) for w in wanted]
    for link in [*links, *lasting]:
        a, b = place[link.from_], place[link.to]
        far[a][b] = min(far[a][b], link.maximum)
        far[b][a] = min(far[b][a], -link.minimum)
    for middle, a, b in product(range(size), repeat=3):
        far[a][b] = min(far[a][b], far[a][middle] + far[middle][b])
    if any(far[a][a] < 0 for a in range(size)):
        return False
    origin = place[0]
    return all(
        -far[place[w.name, "end"]][origin] <= horizon[0] or far[origin][place[w.name, "start"]] >= horizon[1]
        for w in wanted
    )
