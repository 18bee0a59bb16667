"""Solver hints: what a modeller knows of the order in which flaws, and the choices of each, are best tried.

They are orders and nothing else: whatever they say, the problems that have a plan are the same. So a filter does not
leave a flaw as it is, which would be no plan, but puts it off until no other token or variable is left. The format of
their files: `hint_files.py`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any, Literal

from planner.constraints.heuristics import VALUE_HEURISTICS, Scalar, in_order, listed_first, shuffled
from planner.constraints.network import Variable
from planner.errors import HintsError, nearest
from planner.model.classes import objects_in
from planner.model.manager import ModelManager
from planner.model.rules import ForEach, Guard, Local, OneOf
from planner.search.decisions import Activate, Codesignate, Decision, Insert
from planner.tokens.groups import Rank
from planner.tokens.instance import RuleInstance
from planner.tokens.token import Token

HIGHEST = 1000
"""The highest priority; the lowest is minus this."""
LAST = -HIGHEST - 1
"""The priority of what a filter puts off."""


@dataclass(frozen=True, slots=True)
class Hint:
    """What is said, and of which flaws: tokens of a class and a predicate, or a variable of theirs or of their rules.

    None: of any, or nothing. `values`: one of `VALUE_HEURISTICS`, "random", or those to try first. `classes`: `cls` and
    those below it, as far as a model is known.
    """

    cls: str | None = None
    predicate: str | None = None
    variable: str | None = None
    priority: int | None = None
    values: str | tuple[Scalar, ...] | None = None
    prefer: Literal["codesignate", "insert"] | None = None
    slot: Literal["first", "last"] | None = None
    classes: frozenset[str] = frozenset()

    def is_of(self, token: Token | None) -> bool:
        """Whether class and predicate are those of a token, or are not asked for."""
        if token is None:
            return self.cls is None and self.predicate is None
        if self.predicate not in (None, token.predicate.name):
            return False
        if self.cls is None or token.predicate.cls in self.classes:
            return True
        things = objects_in(token.object.domain)
        return bool(things) and all(thing.cls in self.classes for thing in things)

    def is_of_variable(self, variable: Variable) -> bool:
        """Whether the variable is meant; a hint without one means every parameter of the tokens."""
        of, name = variable.of, variable.part
        if isinstance(of, RuleInstance):
            token, name = of.token, name.removeprefix(of.path)
        else:
            token = of if isinstance(of, Token) else None
        meant = isinstance(of, Token) if self.variable is None else self.variable == name
        return meant and self.is_of(token)


@dataclass(frozen=True, slots=True)
class Hints:
    """Hints, of which the first one that says something of a flaw counts. `where`: their file, for complaints;
    `variables`: one of `VARIABLE_HEURISTICS`.

    `seed`: of the random orders. Each is a function of it and of the variable's name alone: a search that comes by
    again finds it as it was, and what was undone leaves no trace.
    """

    hints: tuple[Hint, ...] = ()
    seed: int = 0
    where: str = "hints"
    variables: str = "fewest-values"

    def of_model(self, model: ModelManager) -> Hints:
        """These hints for a model; HintsError for a name that it does not have."""
        return replace(self, hints=tuple(self._of_model(n, hint, model) for n, hint in enumerate(self.hints)))

    def _of_model(self, number: int, hint: Hint, model: ModelManager) -> Hint:
        known = [cls.name for cls in model.classes()]
        if hint.cls is not None and hint.cls not in known:
            there = f"there is no class named {hint.cls!r}{nearest(hint.cls, known)}"
            raise HintsError(f"{self.where}: hint[{number}].class: {there}")
        below = frozenset(name for name in known if hint.cls is not None and model.is_subclass(name, hint.cls))
        predicates = dict.fromkeys(name for cls in below or known for name in model.predicates_of(cls))
        if hint.predicate is not None and hint.predicate not in predicates:
            there = f"there is no predicate named {hint.predicate!r}{nearest(hint.predicate, predicates)}"
            raise HintsError(f"{self.where}: hint[{number}].predicate: {there}")
        if hint.variable is not None and (hint.cls is not None or hint.predicate is not None):
            values = ((c, p) for c in below or known for p in model.predicates_of(c) if hint.predicate in (None, p))
            variables = dict.fromkeys(name for cls, predicate in values for name in _variables(model, cls, predicate))
            if hint.variable not in variables:
                there = f"there is no variable named {hint.variable!r}{nearest(hint.variable, variables)}"
                raise HintsError(f"{self.where}: hint[{number}].variable: {there}")
        return replace(hint, classes=below)

    @property
    def has_priorities(self) -> bool:
        """Whether any flaw is to be decided earlier or later than others."""
        return any(hint.priority is not None for hint in self.hints)

    def urgency(self, token: Token) -> int:
        """Where the token goes is decided the earlier, the lower this is; 0 or more."""
        found = (h.priority for h in self.hints if h.priority is not None and h.variable is None and h.is_of(token))
        return HIGHEST - next(found, 0)

    def ranking(self, order: Callable[[Token, int], Rank]) -> Callable[[Token, int], Rank]:
        """An order of tokens, below that of their priorities."""
        if not self.has_priorities:
            return order
        return lambda token, decisions: (self.urgency(token), *order(token, decisions))

    def urgency_of_variable(self, variable: Variable) -> int:
        """The same for a value; only a hint with a variable speaks of when it is decided."""
        named = (h for h in self.hints if h.priority is not None and h.variable is not None)
        return HIGHEST - next((h.priority or 0 for h in named if h.is_of_variable(variable)), 0)

    def values_of(self, variable: Variable) -> Iterator[Any]:
        """The values of a variable with finitely many, as they are to be tried."""
        order = next((h.values for h in self.hints if h.values is not None and h.is_of_variable(variable)), None)
        if order is None or variable.domain.is_singleton:
            return iter(in_order(variable))
        if order == "random":
            return shuffled(variable, self.seed)
        if isinstance(order, tuple):
            return listed_first(variable, order)
        return iter(VALUE_HEURISTICS[order](variable))

    def arranged(self, token: Token, decisions: Iterator[Decision]) -> Iterator[Decision]:
        """The decisions on a token as they are to be tried; rejection stays last."""
        prefer = next((h.prefer for h in self.hints if h.prefer is not None and _is_of_token(h, token)), None)
        slot = next((h.slot for h in self.hints if h.slot is not None and _is_of_token(h, token)), None)
        if prefer != "insert" and slot != "last":
            return decisions
        kinds: dict[type, list[Decision]] = {}
        for decision in decisions:
            kinds.setdefault(type(decision), []).append(decision)
        placed = _last_first(kinds.pop(Insert, [])) if slot == "last" else kinds.pop(Insert, [])
        placed += kinds.pop(Activate, [])
        merged = kinds.pop(Codesignate, [])
        return chain(*((placed, merged) if prefer == "insert" else (merged, placed)), *kinds.values())


def _variables(model: ModelManager, cls: str, predicate: str) -> Iterator[str]:
    """The parameters of a predicate and the local variables of its rules."""
    found = model.predicate(cls, predicate)
    yield from (parameter.name for parameter in found.parameters)
    pending = [*found.body, *(statement for rule in model.rules_for(cls, predicate) for statement in rule.body)]
    while pending:
        statement = pending.pop()
        if isinstance(statement, Local | OneOf):
            yield statement.name
        if isinstance(statement, Guard):
            pending += (*statement.then, *statement.otherwise)
        elif isinstance(statement, OneOf):
            pending += chain(*statement.branches)
        elif isinstance(statement, ForEach):
            pending += statement.body


def _is_of_token(hint: Hint, token: Token) -> bool:
    return hint.variable is None and hint.is_of(token)


def _last_first(inserts: Iterable[Decision]) -> list[Decision]:
    """The latest slot of each timeline first, the timelines in the order in which they came."""
    timelines: dict[Any, list[Decision]] = {}
    for insert in inserts:
        assert isinstance(insert, Insert)
        timelines.setdefault(insert.object, []).insert(0, insert)
    return [insert for slots in timelines.values() for insert in slots]
