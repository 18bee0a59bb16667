"""Which tokens of the plan may satisfy a subgoal, found by array comparisons on two schedules before any search."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from planner.checker.view import Slot, View
from planner.model.classes import Predicate
from planner.model.relations import distances

Times = npt.NDArray[np.float64]


class _Group:
    """The slots of one predicate with their times in the two schedules, each of shape (n,)."""

    def __init__(self, view: View, slots: Sequence[Slot]) -> None:
        self.slots = slots
        network = view.network
        points = {which: [network.point(s.id, which) for s in slots] for which in ("start", "end")}
        self.times: list[dict[str, Times]] = [
            {f"t.{which}": np.array([schedule[p] for p in points[which]], float) for which in points}
            for schedule in (network.earliest, network.latest)
        ]


class Witnesses:
    """The slots of a plan by predicate, and by the token whose configuration constraint asked for them."""

    def __init__(self, view: View) -> None:
        self.view = view
        by_predicate: dict[str, list[Slot]] = {}
        self._asked: dict[str, dict[str, Slot]] = {}
        for slot in view.slots.values():
            by_predicate.setdefault(slot.predicate.full_name, []).append(slot)
            for token in slot.tokens:
                if token.master is not None:
                    self._asked.setdefault(view.slot_of(token.master).id, {})[slot.id] = slot
        self._groups = {name: _Group(view, slots) for name, slots in by_predicate.items()}

    def candidates(
        self, slot: Slot, predicate: Predicate, relation: str, bounds: Sequence[tuple[float, float]]
    ) -> Iterator[Slot]:
        """Slots of a predicate that stand in the relation to this one in both schedules, those asked for first."""
        asked = self._asked.get(slot.id, {})
        for found in asked.values():
            if found.predicate is predicate:
                yield found
        group = self._groups.get(predicate.full_name)
        if group is None:
            return
        network = self.view.network
        fits = np.ones(len(group.slots), bool)
        for schedule, times in zip((network.earliest, network.latest), group.times, strict=True):
            own = {f"o.{which}": schedule[network.point(slot.id, which)] for which in ("start", "end")}
            for d in distances(relation, bounds):
                apart = _side(own, times, d.to) - _side(own, times, d.from_)
                fits &= (d.minimum <= apart) & (apart <= d.maximum)
        for index in np.flatnonzero(fits).tolist():
            if group.slots[index].id not in asked:
                yield group.slots[index]


def _side(own: dict[str, float], times: dict[str, Times], side: str) -> Times | float:
    return times[side] if side in times else own[side]
