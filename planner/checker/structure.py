"""Structure: every token has its place, and everything that a plan names exists."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from planner.checker.network import INF, told
from planner.checker.view import Limit, Slot, allowed_by, value_of, values_of
from planner.checker.violations import Violation
from planner.errors import ModelError
from planner.model.classes import Predicate
from planner.model.manager import ModelManager
from planner.model.rules import AllowedValue, Constant
from planner.plan import CODESIGNATED, ORIGIN, FlexiblePlan, PlanToken


def check_names(plan: FlexiblePlan, model: ModelManager) -> Iterator[Violation]:
    """What the plan names is there: identifiers once, objects, timelines, masters, timepoints."""
    if plan.model != model.name:
        yield Violation("structure", f"the plan is for model {plan.model!r}, it is judged by {model.name!r}")
    if plan.horizon[0] >= plan.horizon[1]:
        yield Violation("structure", f"the horizon {list(plan.horizon)} is empty")
    known = Counter(token.id for token in plan.tokens)
    for token_id, count in known.items():
        if count > 1:
            yield Violation("structure", f"{count} tokens have the identifier {token_id}", (token_id,))
    for name in sorted(set(plan.objects) ^ set(model.objects)):
        where = "the plan has" if name in plan.objects else "the model has"
        yield Violation("structure", f"only {where} an object {name}", objects=(name,))
    for token in plan.tokens:
        if token.master is not None and token.master not in known:
            yield Violation("structure", f"the master {token.master} of {told(token)} is not in the plan", (token.id,))
    points = {f"{i}.{which}" for i in known for which in ("start", "end")} | {ORIGIN}
    for constraint in plan.constraints:
        for point in (constraint.from_, constraint.to):
            if point not in points:
                yield Violation("structure", f"a constraint names {point!r}, which is no timepoint of the plan")


def check_tokens(plan: FlexiblePlan, model: ModelManager) -> Iterator[Violation]:
    """Predicates, objects and attributes fit; parameters are decided, within their domains."""
    for token in plan.tokens:
        if token.allowed is not None:
            yield from _check_limit(token, model)
            continue
        try:
            predicate = model.predicate_named(token.predicate)
            thing = model.object_named(token.object)
        except ModelError as error:
            yield Violation("structure", f"{token.id}: {error}", (token.id,), (token.object,))
            continue
        if not model.is_subclass(thing.cls, predicate.cls):
            text = f"{told(token)}: class {thing.cls} of {thing} has no predicate {token.predicate}"
            yield Violation("structure", text, (token.id,), (token.object,))
        if token.attribute != predicate.attribute:
            text = f"{told(token)}: is a value of {predicate.attribute}, the plan has it on {token.attribute}"
            yield Violation("structure", text, (token.id,), (token.object,))
        yield from _check_parameters(token, predicate, model)


def _check_limit(token: PlanToken, model: ModelManager) -> Iterator[Violation]:
    """A constraint token is on a timeline of its object and allows values of that."""
    try:
        thing = model.object_named(token.object)
        model.check_allowed(
            (thing.cls, token.attribute),
            [
                AllowedValue(
                    ((declared := model.predicate_named(value.predicate)).cls, declared.name),
                    tuple((name, Constant()) for name in value.parameters),
                )
                for value in token.allowed or ()
            ],
        )
    except ModelError as error:
        yield Violation("structure", f"{told(token)}: {error}", (token.id,), (token.object,))
        return
    for value in token.allowed or ():
        types = {p.name: p.type for p in model.predicate_named(value.predicate).parameters}
        for name, given in value.parameters.items():
            if values_of(model.domain_of(types[name]), given) is None:
                text = f"{told(token)}: {name} of {value.predicate} is {given!r}, expected some of"
                yield Violation("parameter", f"{text} {model.domain_of(types[name])!r}", (token.id,))


def _check_parameters(token: PlanToken, predicate: Predicate, model: ModelManager) -> Iterator[Violation]:
    declared = {p.name: p.type for p in predicate.parameters}
    for name in sorted(set(declared) ^ set(token.parameters)):
        what = "lacks" if name in declared else "has an unknown"
        yield Violation("parameter", f"{told(token)} {what} parameter {name}", (token.id,))
    for name, value in token.parameters.items():
        if name in declared and value_of(model.domain_of(declared[name]), value) is None:
            domain = model.domain_of(declared[name])
            text = f"{told(token)}: {name} is {value!r}, expected one value of {domain!r}"
            yield Violation("parameter", text, (token.id,))


def check_places(plan: FlexiblePlan, model: ModelManager) -> Iterator[Violation]:
    """Timelines are those of the model, each once; every token of one is in exactly one of its slots."""
    places: dict[str, list[tuple[str, str]]] = {token.id: [] for token in plan.tokens}
    seen = Counter((timeline.object, timeline.attribute) for timeline in plan.timelines)
    for (thing, attribute), count in seen.items():
        found = thing in model.objects and model.attributes_of(model.objects[thing].cls).get(attribute)
        if not found or found.kind != "timeline":
            yield Violation("structure", f"{thing}.{attribute} is no timeline of the model", objects=(thing,))
        if count > 1:
            yield Violation("structure", f"the timeline {thing}.{attribute} is listed {count} times", objects=(thing,))
    for timeline in plan.timelines:
        for number, slot in enumerate(timeline.slots):
            where = f"slot {number + 1} of {timeline.object}.{timeline.attribute}"
            if not slot:
                yield Violation("structure", f"{where} is empty", objects=(timeline.object,))
            for token_id in slot:
                if token_id not in places:
                    yield Violation("structure", f"{where} names {token_id}, which is not in the plan", (token_id,))
                else:
                    places[token_id].append((timeline.object, timeline.attribute))
    for token in plan.tokens:
        if token.allowed is None:
            yield from _check_place(token, places[token.id], model)
        elif places[token.id]:
            yield Violation("structure", f"{told(token)}, a constraint token, is in a slot", (token.id,))


def _check_place(token: PlanToken, places: list[tuple[str, str]], model: ModelManager) -> Iterator[Violation]:
    kind = model.kind_of(model.predicate_named(token.predicate))
    if kind != "timeline":
        if places:
            yield Violation("structure", f"{told(token)} is on a timeline, its attribute is {kind}", (token.id,))
    elif len(places) != 1:
        yield Violation("structure", f"{told(token)} is in {len(places)} slots, expected one", (token.id,))
    elif places[0] != (token.object, token.attribute):
        text = f"{told(token)} is on the timeline {'.'.join(places[0])}, expected {token.object}.{token.attribute}"
        yield Violation("structure", text, (token.id,), (token.object, places[0][0]))


def slots_of(plan: FlexiblePlan, model: ModelManager) -> dict[str, Slot]:
    """The slots of a plan without violations so far, by host."""
    groups = [slot for timeline in plan.timelines for slot in timeline.slots]
    placed = {token_id for group in groups for token_id in group}
    others = [token.id for token in plan.tokens if token.id not in placed and token.allowed is None]
    groups += _codesignated(plan, others)
    slots = {}
    for group in groups:
        host = plan.token(group[0])
        predicate = model.predicate_named(host.predicate)
        values = {}
        for parameter in predicate.parameters:
            value = value_of(model.domain_of(parameter.type), host.parameters[parameter.name])
            assert value is not None
            values[parameter.name] = value
        slots[host.id] = Slot(tuple(map(plan.token, group)), predicate, model.object_named(host.object), values)
    return slots


def _codesignated(plan: FlexiblePlan, tokens: Sequence[str]) -> list[tuple[str, ...]]:
    """Tokens off timelines, each host with those that constraints on both of its timepoints say are one with it."""
    sides: dict[tuple[str, str], set[str]] = {}
    for c in plan.constraints:
        (host, _, side), (token, _, other) = c.from_.partition("."), c.to.partition(".")
        if c.why == CODESIGNATED and side == other and (c.min, c.max) == (0, 0):
            sides.setdefault((host, token), set()).add(side)
    groups: dict[str, list[str]] = {token: [token] for token in tokens}
    for (host, token), said in sides.items():
        if said == {"start", "end"} and host in groups and groups.get(token) == [token] and host != token:
            groups[host].append(token)
            del groups[token]
    return [tuple(group) for group in groups.values()]


def limits_of(plan: FlexiblePlan, model: ModelManager) -> dict[str, Limit]:
    """The constraint tokens of a plan without violations so far."""
    limits = {}
    for token in plan.tokens:
        if token.allowed is None:
            continue
        thing = model.object_named(token.object)
        predicate = Predicate(thing.cls, token.predicate, token.attribute, duration=(0, INF))
        limits[token.id] = Limit(Slot((token,), predicate, thing, {}), allowed_by(model, token.allowed))
    return limits


def check_codesignation(slots: dict[str, Slot]) -> Iterator[Violation]:
    """The tokens of a slot are one: predicate, object, parameters, times, contingency."""
    for slot in slots.values():
        host = slot.host
        for token in slot.tokens[1:]:
            differing = [
                name
                for name in ("predicate", "object", "parameters", "start", "end", "duration", "contingent")
                if getattr(token, name) != getattr(host, name)
            ]
            if differing:
                text = f"{told(token)} shares a slot with {told(host)} but differs in {', '.join(differing)}"
                yield Violation("codesignation", text, (host.id, token.id), (host.object,))
