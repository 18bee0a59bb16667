"""Reusable resources: no schedule that the plan allows uses more than there is.

Tokens exceed a resource when their quantities together do and one schedule lets them all overlap. Looking at pairs is
enough: if every pair of them overlaps in some schedule, all do in one. For all to overlap means `start_i < end_j` for
all i and j. A negative cycle would alternate these edges, of weight -1, with paths from a start to an end, each of
which is at least 1 because no such pair is entailed to be apart; so there is none. Pairs that no schedule lets overlap
are sorted out first (by bounds, then by the network); then sets of tokens are searched, heaviest first.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from planner.checker.network import PlanNetwork, told
from planner.checker.view import Slot, View
from planner.checker.violations import Violation

MOST_SETS = 200_000
"""How many sets of tokens are looked at before the judgement is given up, which is a violation of its own."""


def check_resources(view: View) -> Iterator[Violation]:
    """Every reusable resource is kept within its capacity in every schedule."""
    users: dict[str, list[tuple[Slot, float]]] = {}
    for slot in view.slots.values():
        kind = view.model.kind_of(slot.predicate)
        if kind == "reusable":
            quantity = slot.values["quantity"]
            users.setdefault(slot.object.name, []).append((slot, float(quantity.lower)))
        elif kind == "reservoir":
            text = f"{told(slot.host)} is a transaction on a reservoir, which this checker cannot judge"
            yield Violation("resource", text, (slot.id,), (slot.object.name,))
    for name, using in users.items():
        members = view.model.object_named(name).members
        available = float(members["capacity"]) - float(members.get("level_min", 0))
        yield from _check(view.network, name, available, using)


def _check(network: PlanNetwork, name: str, capacity: float, users: list[tuple[Slot, float]]) -> Iterator[Violation]:
    users = sorted(((s, q) for s, q in users if q > 0 and _lasts(network, s)), key=lambda u: -u[1])
    if sum(q for _, q in users) <= capacity:
        return
    search = _Search(network, capacity, users)
    found = search.clash()
    if search.sets > MOST_SETS:
        text = f"{name}: not judged, more than {MOST_SETS} sets of tokens may overlap"
        yield Violation("resource", text, objects=(name,))
    elif found:
        used = ", ".join(f"{told(s.host)} {q:g}" for s, q in found)
        text = f"{name} has {capacity:g}, a schedule uses {sum(q for _, q in found):g} at once: {used}"
        yield Violation("resource", text, tuple(s.id for s, _ in found), (name,))


def _lasts(network: PlanNetwork, slot: Slot) -> bool:
    """Whether a use takes any time in some schedule."""
    return not network.at_most(network.point(slot.id, "start"), network.point(slot.id, "end"), 0)


class _Search:
    """Branch and bound for a set of tokens that is too heavy and may be at one time. `sets`: how many were tried."""

    def __init__(self, network: PlanNetwork, capacity: float, users: Sequence[tuple[Slot, float]]) -> None:
        self.network = network
        self.capacity = capacity
        self.users = users
        self.sets = 0
        self.starts = [network.point(s.id, "start") for s, _ in users]
        self.ends = [network.point(s.id, "end") for s, _ in users]
        self.apart: dict[tuple[int, int], bool] = {}
        upper, lower = np.array(network.upper), np.array(network.lower)
        before = upper[self.ends][:, None] <= lower[self.starts][None, :]
        self.near = ~(before | before.T)

    def clash(self) -> list[tuple[Slot, float]]:
        """A set of users beyond the capacity that some schedule lets overlap; empty when there is none."""
        return [self.users[i] for i in self._extend([], 0.0, list(range(len(self.users))))]

    def _extend(self, chosen: list[int], level: float, rest: list[int]) -> list[int]:
        self.sets += 1
        if self.sets > MOST_SETS:
            return []
        if level > self.capacity:
            return chosen
        available = sum(self.users[i][1] for i in rest)
        for number, user in enumerate(rest):
            if level + available <= self.capacity:
                return []
            quantity = self.users[user][1]
            available -= quantity
            beside = [i for i in rest[number + 1 :] if self._overlap(user, i)]
            found = self._extend([*chosen, user], level + quantity, beside)
            if found:
                return found
        return []

    def _overlap(self, a: int, b: int) -> bool:
        """Whether some schedule lets two users overlap."""
        if not self.near[a, b]:
            return False
        key = (min(a, b), max(a, b))
        if key not in self.apart:
            at_most, starts, ends = self.network.at_most, self.starts, self.ends
            self.apart[key] = at_most(starts[b], ends[a], 0) or at_most(starts[a], ends[b], 0)
        return not self.apart[key]
