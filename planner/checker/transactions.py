"""What a plan takes from its resources and gives to them: its tokens on them, and the constraint `uses`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from planner.checker.network import told
from planner.checker.view import Slot, View

Flow = Literal["uses", "produces", "consumes"]


@dataclass(frozen=True, slots=True, eq=False)
class Transaction:
    """A quantity of a resource, by name, that a token takes from `start` to `end`, or gives or takes at `start`.

    `start`, `end`: timepoints of the plan's network.
    """

    resource: str
    flow: Flow
    quantity: float
    slot: Slot
    start: int
    end: int

    def __str__(self) -> str:
        return f"{told(self.slot.host)} {self.quantity:g}"


def transactions_of(view: View) -> Iterator[Transaction]:
    """The tokens of a plan that are transactions, where they move anything."""
    for slot in view.slots.values():
        kind = view.model.kind_of(slot.predicate)
        if kind not in ("reusable", "reservoir"):
            continue
        declared = slot.values.get("quantity")
        quantity = 1.0 if declared is None else float(declared.lower)
        flow: Flow = "uses"
        if kind == "reservoir":
            flow = "produces" if slot.predicate.name == "produce" else "consumes"
        if quantity > 0:
            ends = view.network.point(slot.id, "start"), view.network.point(slot.id, "end")
            yield Transaction(slot.object.name, flow, quantity, slot, *ends)
