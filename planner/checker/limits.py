"""Constraint tokens: throughout each of them its attribute has only values that it allows, in every schedule."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from planner.checker.network import PlanNetwork, told, unbounded
from planner.checker.view import Limit, Slot, View, allowed_by
from planner.checker.violations import Violation
from planner.domains import Domain, Interval
from planner.plan import PlanValue
from planner.problem import ConstraintPattern, Problem


def check_limits(view: View) -> Iterator[Violation]:
    """Each token of the timeline has an allowed value, or ends before the constraint token starts, or starts after it
    ends."""
    for limit in view.limits.values():
        over = limit.slot
        for slot in view.slots.values():
            beside = slot.object is over.object and slot.predicate.attribute == over.predicate.attribute
            if beside and not limit.allows(slot) and not _apart(view.network, over, slot):
                values = "".join(f", {name} {domain.value}" for name, domain in slot.values.items())
                text = f"{told(slot.host)}{values} may overlap {told(over.host)}, which does not allow it"
                yield Violation("constraint", text, (slot.id, over.id), (slot.object.name,))


def _apart(network: PlanNetwork, one: Slot, other: Slot) -> bool:
    """Whether one ends before the other starts in every schedule, or the other way round."""
    return any(
        network.at_most(network.point(later.id, "start"), network.point(earlier.id, "end"), 0)
        for earlier, later in ((one, other), (other, one))
    )


def check_stated_limits(view: View, problem: Problem) -> Iterator[Violation]:
    """The problem's constraint tokens are in the plan."""
    for pattern in problem.constraints:
        if not any(_is_what(view, limit, pattern.within(problem.horizon)) for limit in view.limits.values()):
            names = " or ".join(v.predicate for v in pattern.values) or "no value"
            text = f"the problem has {pattern.attribute} of {pattern.object or 'some object'} keep to {names}"
            yield Violation("constraint", f"{text}, and no constraint token of the plan says so")


def _is_what(view: View, limit: Limit, pattern: ConstraintPattern) -> bool:
    """Whether a constraint token is what a pattern asks for, in every schedule."""
    slot, network = limit.slot, view.network
    cls, _, attribute = pattern.attribute.partition(".")
    if slot.predicate.attribute != attribute or not view.model.is_subclass(slot.object.cls, cls):
        return False
    wanted = allowed_by(view.model, [PlanValue(v.predicate, v.parameters) for v in pattern.values])
    if pattern.object not in (None, slot.object.name) or not is_narrower(limit, wanted):
        return False
    start, end = network.point(slot.id, "start"), network.point(slot.id, "end")
    pairs = ((0, start, pattern.start), (0, end, pattern.end), (start, end, pattern.duration))
    return all(network.within(a, b, *unbounded(bounds)) for a, b, bounds in pairs)


def is_narrower(limit: Limit, wanted: Mapping[str, Mapping[str, Domain | None]]) -> bool:
    """Whether a constraint token allows no more than the wanted values; of a domain that is None nothing is known."""
    for predicate, limits in limit.allowed.items():
        if predicate not in wanted:
            return False
        for name, domain in wanted[predicate].items():
            if domain is not None and (name not in limits or not _within(limits[name], domain)):
                return False
    return True


def _within(part: Domain, whole: Domain) -> bool:
    """Whether all values of one domain are in the other, whatever the kinds of the two."""
    if isinstance(part, Interval) and not part.is_singleton:
        return isinstance(whole, Interval) and whole.lower <= part.lower and part.upper <= whole.upper
    return all(value in whole for value in part.values())
