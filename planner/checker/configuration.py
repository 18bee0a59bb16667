"""Configuration constraints: for each token that is not a fact, every applicable schema is satisfied by the plan.

A schema's statements are worked through in order with backtracking over the choices that they leave: the token that
is the witness of a subgoal, the branch of an alternative, the value of a local variable. A witness must stand in its
temporal relation in every schedule (paper, section 2). A subgoal needs no witness where its token may lie wholly
outside the horizon: some schedule lets it end by the horizon's start or begin at the horizon's end.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from planner.checker.boundary import may_be_outside
from planner.checker.expressions import Expressions, Path, Wanted
from planner.checker.limits import is_narrower
from planner.checker.network import INF, told
from planner.checker.requirements import Link, Requirements
from planner.checker.uses import Choice, choice_of, mentions_uses, transactions
from planner.checker.view import Slot, View, closed
from planner.checker.violations import Violation
from planner.checker.witnesses import Witnesses
from planner.domains import Domain, Interval, Values
from planner.model.classes import ModelObject, Predicate, objects_in
from planner.model.resources import USES
from planner.model.rules import Confine, ForEach, Guard, Local, OneOf, Relate, Require, Statement, Subgoal

MOST_VALUES = 1000
"""A local variable with more values than this is tried at the ends of its range only."""
MOST_ROUNDS = 10
"""Local numbers are narrowed by what is said about them at most this often before one is chosen."""


@dataclass(frozen=True, slots=True)
class _State:
    """Choices made so far. `outside`: subgoals without witness; `links`: distances that concern them. `open`: local
    numbers without a value; `pending`: relations that are to hold once they have one. `uses`: what it uses."""

    names: Mapping[tuple[Path, str], Slot | Wanted | Domain]
    outside: tuple[Wanted, ...] = ()
    links: tuple[Link, ...] = ()
    open: tuple[tuple[Path, str], ...] = ()
    pending: tuple[tuple[Require, Path], ...] = ()
    uses: tuple[tuple[Require, Path], ...] = ()

    def bound(self, path: Path, name: str, meaning: Slot | Wanted | Domain) -> _State:
        return replace(self, names={**self.names, (path, name): meaning})


_Todo = tuple[tuple[Statement, Path], ...]


def check_configurations(view: View, uses: list[Choice]) -> Iterator[Violation]:
    """Parameter constraints of all tokens, configuration constraints of those that are not facts.

    `uses`: takes for each constraint the ways to satisfy it, by what they use of resources.
    """
    witnesses = Witnesses(view)
    for slot in view.slots.values():
        body = _Body(view, slot, witnesses)
        if not body.satisfied(slot.predicate.body, uses):
            text = f"{told(slot.host)} breaks a parameter constraint of its predicate: {body.obstacle}"
            yield Violation("parameter", text, slot.ids, (slot.object.name,))
        if slot.is_fact:
            continue
        for number, rule in enumerate(view.model.rules_for(slot.object.cls, slot.predicate.name)):
            body = _Body(view, slot, witnesses)
            if not body.satisfied(rule.body, uses):
                label = rule.where or f"rule {number + 1} of {slot.predicate.full_name}"
                text = f"{told(slot.host)} lacks support by {label}: {body.obstacle}"
                yield Violation("configuration", text, slot.ids, (slot.object.name,))


class _Body:
    """One body applied to one token. `obstacle`: what the furthest attempt to satisfy it ended at."""

    def __init__(self, view: View, slot: Slot, witnesses: Witnesses) -> None:
        self.view = view
        self.slot = slot
        self.witnesses = witnesses
        self.expressions = Expressions(view, slot)
        self.requirements = Requirements(self.expressions)
        self.obstacle = "it cannot be satisfied"
        self._furthest = -1

    def satisfied(self, statements: tuple[Statement, ...], uses: list[Choice]) -> bool:
        """Whether some choice of witnesses, branches and values satisfies all statements."""
        solutions = self._solutions(tuple((s, ()) for s in statements), _State({}), 0)
        if not mentions_uses(statements):
            return next(solutions, None) is not None
        ways = (tuple(transactions(self.expressions, self.slot, found.uses, found.names)) for found in solutions)
        choice = choice_of(ways)
        uses.append(choice)
        return bool(choice.ways)

    def _solutions(self, todo: _Todo, state: _State, depth: int) -> Iterator[_State]:
        if not todo:
            settled = self._settled(state, depth)
            if settled is not None:
                yield settled
            return
        (statement, path), rest = todo[0], todo[1:]
        for more, reached in self._ways(statement, path, state, depth):
            yield from self._solutions((*more, *rest), reached, depth + 1)

    def _ways(self, statement: Statement, path: Path, state: _State, depth: int) -> Iterator[tuple[_Todo, _State]]:
        """The ways to satisfy a statement: what it adds to do, and what has been chosen."""
        if isinstance(statement, Subgoal):
            for reached in self._subgoal(statement, path, state, depth):
                yield (), reached
        elif isinstance(statement, Confine):
            for reached in self._confine(statement, path, state, depth):
                yield (), reached
        elif isinstance(statement, Relate):
            origin = self.expressions.token(statement.origin, state.names, path)
            target = self.expressions.token(statement.target, state.names, path)
            links = self.requirements.relation(statement.relation, statement.bounds, origin, target)
            yield from self._linked(statement, links, state, depth)
        elif isinstance(statement, Require):
            yield from self._require(statement, path, state, depth)
        elif isinstance(statement, Local):
            for reached in self._local(statement, path, state):
                yield (), reached
        elif isinstance(statement, Guard):
            yield from self._guard(statement, path, state)
        elif isinstance(statement, ForEach):
            yield self._for_each(statement, path, state)
        else:
            yield from self._one_of(statement, path, state)

    def _subgoal(self, statement: Subgoal, path: Path, state: _State, depth: int) -> Iterator[_State]:
        model = self.view.model
        predicate = model.predicate(*statement.predicate)
        objects = model.objects_of(statement.predicate[0])
        target = statement.target and self.expressions.resolve(statement.target, state.names, path)
        for slot in self.witnesses.candidates(self.slot, predicate, statement.relation, statement.bounds):
            if slot.object not in objects or not _may_be(slot.object, target):
                continue
            links = self.requirements.relation(statement.relation, statement.bounds, self.slot, slot)
            if self.requirements.unsettled(links) is not None:
                yield state.bound(path, statement.name, slot)
        outside = self._outside(statement, predicate, path, state)
        if outside is not None:
            yield outside
        else:
            where = "" if target is None else f" of {target}"
            text = f"in every schedule it needs a fitting {predicate.full_name}{where} by {statement.relation}"
            self._blocked(depth, f"{text}{_bounds_said(statement)}, and the plan has none")

    def _confine(self, statement: Confine, path: Path, state: _State, depth: int) -> Iterator[_State]:
        """A constraint token of the plan that allows no more, or one that may be outside."""
        expressions, (cls, attribute) = self.expressions, statement.attribute
        model, objects = self.view.model, self.view.model.objects_of(cls)
        target = statement.target and expressions.resolve(statement.target, state.names, path)
        wanted = {
            model.predicate(*value.predicate).full_name: {
                name: expressions.domain(bound, state.names, path, expressions.range_of)
                for name, bound in value.parameters
            }
            for value in statement.values
        }
        for limit in self.view.limits.values():
            slot = limit.slot
            if slot.predicate.attribute != attribute or slot.object not in objects or not _may_be(slot.object, target):
                continue
            links = self.requirements.relation(statement.relation, statement.bounds, self.slot, slot)
            if is_narrower(limit, wanted) and self.requirements.unsettled(links) is not None:
                yield state.bound(path, statement.name, slot)
        predicate = Predicate(cls, attribute, attribute, duration=(0, INF))
        outside = self._outside(statement, predicate, path, state)
        if outside is not None:
            yield outside
        else:
            names = " or ".join(wanted) or "no value"
            text = f"in every schedule it needs {cls}.{attribute} to keep to {names} by {statement.relation}"
            self._blocked(depth, f"{text}{_bounds_said(statement)}, and no constraint token of the plan says so")

    def _outside(self, statement: Subgoal | Confine, predicate: Predicate, path: Path, state: _State) -> _State | None:
        """The state with the token of a statement outside of the horizon, if it may be there."""
        wanted = Wanted(f"{statement.name}@{len(state.names)}", predicate)
        links = self.requirements.relation(statement.relation, statement.bounds, self.slot, wanted)
        points = [self.view.network.point(self.slot.id, which) for which in ("start", "end")]
        if not may_be_outside(self.view.network, self.view.plan.horizon, [wanted], links, points):
            return None
        reached = state.bound(path, statement.name, wanted)
        return replace(reached, outside=(*state.outside, wanted), links=(*state.links, *links))

    def _linked(
        self, statement: Statement, links: list[Link], state: _State, depth: int
    ) -> Iterator[tuple[_Todo, _State]]:
        rest = self.requirements.unsettled(links)
        if rest is not None:
            yield (), replace(state, links=(*state.links, *rest))
        else:
            self._blocked(depth, f"{_said(statement)} does not hold in every schedule")

    def _require(self, statement: Require, path: Path, state: _State, depth: int) -> Iterator[tuple[_Todo, _State]]:
        links = self.requirements.links(statement.procedure, statement.arguments, state.names, path)
        if statement.procedure == USES.name:
            yield (), replace(state, uses=(*state.uses, (statement, path)))
        elif links is not None:
            yield from self._linked(statement, links, state, depth)
        elif not self.requirements.holds(statement.procedure, statement.arguments, state.names, path):
            self._blocked(depth, f"{self._evaluated(statement, path, state)} does not hold")
        elif state.open:
            yield (), replace(state, pending=(*state.pending, (statement, path)))
        else:
            yield (), state

    def _evaluated(self, statement: Require, path: Path, state: _State) -> str:
        """A relation with the values that its arguments have."""
        expressions = self.expressions
        values = [expressions.domain(a, state.names, path, expressions.range_of) for a in statement.arguments]
        said = (repr(a) if v is None else f"{a!r} = {v!r}" for a, v in zip(statement.arguments, values, strict=True))
        return f"{statement.procedure}({', '.join(said)})"

    def _local(self, statement: Local, path: Path, state: _State) -> Iterator[_State]:
        domain = closed(self.view.model.domain_of(statement.type))
        if isinstance(domain, Interval) and not domain.is_singleton:
            key = (path, statement.name)
            yield replace(state.bound(path, statement.name, domain), open=(*state.open, key))
            return
        for value in domain.values():
            one = domain.keep((value,)) if isinstance(domain, Values) else domain
            yield state.bound(path, statement.name, one)

    def _for_each(self, statement: ForEach, path: Path, state: _State) -> tuple[_Todo, _State]:
        """The body for every object that the plan leaves: at least for these it was carried out."""
        expressions = self.expressions
        left = expressions.domain(statement.over, state.names, path, expressions.range_of)
        todo: list[tuple[Statement, Path]] = []
        for thing in () if left is None else objects_in(left):
            inner = (*path, len(state.names))
            state = state.bound(inner, statement.name, self.view.model.objects_of(thing.cls).keep((thing,)))
            todo += [(inside, inner) for inside in statement.body]
        return tuple(todo), state

    def _guard(self, statement: Guard, path: Path, state: _State) -> Iterator[tuple[_Todo, _State]]:
        """A guard acts once its test is decided; over a local number it waits, and decides nothing."""
        verdict = self.requirements.decide(
            statement.test, statement.arguments, state.names, path, self.expressions.range_of
        )
        branch = statement.then if verdict is True else statement.otherwise if verdict is False else ()
        yield tuple((s, (*path, len(state.names))) for s in branch), state

    def _one_of(self, statement: OneOf, path: Path, state: _State) -> Iterator[tuple[_Todo, _State]]:
        for branch in statement.branches:
            yield tuple((s, (*path, len(state.names))) for s in branch), state

    def _settled(self, state: _State, depth: int) -> _State | None:
        """At the end: numbers for the local variables, and a place outside for what has no witness."""
        if state.outside:
            network = self.view.network
            if not may_be_outside(network, self.view.plan.horizon, state.outside, state.links, ()):
                names = ", ".join(w.predicate.full_name for w in state.outside)
                self._blocked(depth, f"{names} must happen within the horizon, and the plan has none that fits")
                return None
        if not state.pending:
            return state
        found = self._numbers(state, state.open)
        if found is None:
            self._blocked(depth, f"no values of the local variables satisfy {_said(state.pending[0][0])}")
        return found

    def _numbers(self, state: _State, left: tuple[tuple[Path, str], ...]) -> _State | None:
        """Values for local numbers with which all that waited for them holds."""
        if not left:
            held = all(self.requirements.holds(r.procedure, r.arguments, state.names, p) for r, p in state.pending)
            return state if held else None
        narrowed = self._all_narrowed(state, left)
        if narrowed is None:
            return None
        state = narrowed
        key = min(left, key=lambda one: _width(state.names[one]))
        domain = state.names[key]
        assert isinstance(domain, Interval)
        if not domain.integer or domain.size > MOST_VALUES:
            values = [v for v in (domain.lower, domain.upper, 0) if v in domain and abs(v) != float("inf")]
        else:
            values = list(domain.values())
        for value in values:
            chosen = state.bound(*key, Interval(value, value, domain.integer))
            found = self._numbers(chosen, tuple(k for k in left if k != key))
            if found is not None:
                return found
        return None

    def _all_narrowed(self, state: _State, left: tuple[tuple[Path, str], ...]) -> _State | None:
        """The state with local numbers narrowed until nothing changes, or often enough; None: one is left no value."""
        for _ in range(MOST_ROUNDS):
            before = state
            for key in left:
                domain = self._narrowed(state, key)
                if domain.is_empty:
                    return None
                if domain != state.names[key]:
                    state = state.bound(*key, domain)
            if state is before:
                break
        return state

    def _narrowed(self, state: _State, key: tuple[Path, str]) -> Domain:
        """What the pending relations leave of a local number, as far as their procedures tell."""
        domain = state.names[key]
        assert isinstance(domain, Interval)
        path, name = key
        for require, place in state.pending:
            times = self.expressions.range_of
            for ref, part in self.expressions.narrowed(require.procedure, require.arguments, state.names, place, times):
                if ref.path == (name,) and place[: len(path)] == path:
                    domain = domain.intersect(part)
        return domain

    def _blocked(self, depth: int, obstacle: str) -> None:
        if depth > self._furthest:
            self._furthest, self.obstacle = depth, obstacle


def _width(domain: object) -> float:
    """How far apart the values of a local number may be."""
    return domain.upper - domain.lower if isinstance(domain, Interval) else 0


def _may_be(thing: ModelObject, target: object) -> bool:
    """Whether an object is, as far as is known, the one that a subgoal names."""
    if isinstance(target, ModelObject):
        return thing is target
    return thing in target if isinstance(target, Values) else True


def _said(statement: Statement) -> str:
    if isinstance(statement, Require):
        return f"{statement.procedure}({', '.join(map(repr, statement.arguments))})"
    return f"{statement.origin} {statement.relation} {statement.target}" if isinstance(statement, Relate) else ""


def _bounds_said(statement: Subgoal | Confine) -> str:
    return "".join(f" [{lower:g} {upper:g}]" for lower, upper in statement.bounds)
