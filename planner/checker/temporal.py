"""Times: the network has schedules, says what the tokens say, orders the timelines, and leaves nature its choices.

Durations and constraints are statements; the bounds of starts and ends are taken as statements too, and must besides
be exactly what all statements together imply: a wider one would promise times that no schedule has. The duration of a
contingent token is nature's: it is what the domain declares for these parameter values (or what the problem states of
an activity under way), no constraint of the plan may narrow it. Whether an executive can cope with every choice of
nature is dynamic controllability, which is judged elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise

from planner.checker.network import INF, PlanNetwork, told, unbounded
from planner.checker.view import Slot, View
from planner.checker.violations import Violation
from planner.plan import Bounds


def check_consistency(network: PlanNetwork) -> Iterator[Violation]:
    """There is a schedule."""
    if network.conflict:
        text = f"no schedule satisfies all of: {'; '.join(network.conflict)}"
        yield Violation("inconsistent", text, network.conflict_tokens)


def check_bounds(view: View) -> Iterator[Violation]:
    """Written bounds of starts and ends are exactly those that the network implies."""
    for slot in (*view.slots.values(), *(limit.slot for limit in view.limits.values())):
        for which in ("start", "end"):
            written: Bounds = getattr(slot.host, which)
            implied = view.range_of(slot, which)
            if unbounded(written) != implied:
                text = f"{which} of {told(slot.host)} is written as {_said(unbounded(written))}, the plan's constraints"
                yield Violation("bounds", f"{text} imply {_said(implied)}", (slot.id,))


def check_durations(view: View) -> Iterator[Violation]:
    """Written durations are within what the predicate declares."""
    for slot in view.slots.values():
        lower, upper = unbounded(slot.host.duration)
        least, most = slot.predicate.duration
        if lower < least or upper > most or lower > upper:
            text = f"duration of {told(slot.host)} is written as {_said((lower, upper))}, the domain declares"
            yield Violation("duration", f"{text} {_said((least, most))}", (slot.id,))


def check_order(view: View) -> Iterator[Violation]:
    """On a timeline each token ends before the next starts, in every schedule."""
    for sequence in view.sequences():
        for earlier, later in pairwise(sequence):
            start, end = view.network.point(later.id, "start"), view.network.point(earlier.id, "end")
            if not view.network.at_most(start, end, 0):
                text = f"{told(earlier.host)} need not end before {told(later.host)} starts, its successor"
                yield Violation("order", text, (earlier.id, later.id), (earlier.object.name,))


def check_contingent(
    view: View, declared: Mapping[str, tuple[float, float]], flags: Mapping[str, bool]
) -> Iterator[Violation]:
    """Contingent tokens are those that the model says, with nature's whole choice and no more.

    `declared`: by host, the duration that nature may choose, for those of which it is known. `flags`: by host,
    whether the duration is nature's.
    """
    contingent = set()
    for slot in view.slots.values():
        expected = flags.get(slot.id, slot.predicate.contingent)
        if slot.host.contingent != expected:
            who = "nature" if expected else "the executive"
            text = f"the duration of {told(slot.host)} is decided by {who}, the plan says otherwise"
            yield Violation("contingent", text, (slot.id,))
        elif expected and slot.id in declared and unbounded(slot.host.duration) != declared[slot.id]:
            text = f"nature decides the duration of {told(slot.host)} within {_said(declared[slot.id])}, the plan has"
            yield Violation("contingent", f"{text} {_said(unbounded(slot.host.duration))}", (slot.id,))
        if slot.host.contingent:
            contingent.add(slot.id)
    yield from _check_narrowed(view, contingent)


def _check_narrowed(view: View, contingent: set[str]) -> Iterator[Violation]:
    slot_at: dict[tuple[int, int], Slot] = {
        (view.network.point(i, "start"), view.network.point(i, "end")): view.slots[i] for i in contingent
    }
    for c in view.plan.constraints:
        from_, to = view.network.index[c.from_], view.network.index[c.to]
        lower, upper = unbounded((c.min, c.max))
        if (to, from_) in slot_at:
            from_, to, lower, upper = to, from_, -upper, -lower
        slot = slot_at.get((from_, to))
        if slot is None:
            continue
        least, most = unbounded(slot.host.duration)
        if lower > least or upper < most:
            text = f"a constraint ({c.why}) narrows the duration of {told(slot.host)}, which nature decides within"
            yield Violation("contingent", f"{text} {_said((least, most))}, to {_said((lower, upper))}", (slot.id,))


def _said(bounds: tuple[float, float]) -> str:
    lower, upper = ("any" if abs(b) == INF else f"{b:g}" if b != int(b) else str(int(b)) for b in bounds)
    return f"[{lower} {upper}]"
