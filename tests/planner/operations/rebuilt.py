"""The oracle: a fresh database given the operations that are left, in order, by the search's decisions.

It shares nothing with the package under test: the order on a timeline is folded from the predecessors that each
insertion had when it was issued, and what cannot be applied is tried again until nothing changes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from planner.constraints.network import Inconsistency
from planner.database import PlanDatabase
from planner.operations import Codesignation, Insertion, Restriction
from planner.search.decisions import Activate, Assign, Codesignate
from planner.tokens.token import TokenState


@dataclass(frozen=True)
class Record:
    """What was issued, and the numbers of all insertions then before it on its timeline, the nearest last."""

    number: int
    statement: Insertion | Codesignation | Restriction
    predecessors: tuple[int, ...] = ()


@dataclass
class Rebuilt:
    """A database given these operations. `applied`: the numbers of those in force."""

    make: Callable[[], PlanDatabase]
    records: Sequence[Record]
    applied: set[int] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.database = self.make()
        self.lines: dict[tuple[str, str], list[int]] = {}
        for record in self.records:
            self.take_up(record)
        for place in range(len(self.records)):
            self.attempt(self.records[place])
            while sum(self.attempt(record) for record in self.records[:place]):
                pass

    def take_up(self, record: Record) -> None:
        """Give an insertion its place among all: after the nearest predecessor that is not undone."""
        if isinstance(record.statement, Insertion) and record.statement.attribute:
            line = self.lines.setdefault((record.statement.object, record.statement.attribute), [])
            near = [n for n in record.predecessors if n in line]
            line.insert(line.index(near[-1]) + 1 if near else 0, record.number)

    def attempt(self, record: Record) -> bool:
        """Apply an operation if that is possible and not done; whether it was."""
        if record.number in self.applied:
            return False
        depth = self.database.trail.push()
        try:
            if self.apply(record):
                self.applied.add(record.number)
                return True
        except Inconsistency:
            pass
        self.database.trail.pop_to(depth)
        return False

    def apply(self, record: Record) -> bool:
        tokens, statement = self.database.tokens, record.statement
        named = {t.path: t for t in tokens.tokens}
        if isinstance(statement, Restriction):
            if statement.token is None:
                variable = tokens.variables.get(statement.variable)
            else:
                token = named.get(statement.token)
                variable = None if token is None else token.variable(statement.variable)
            if variable is None:
                return False
            Assign(variable, None, statement.domain).apply(self.database)
            return True
        token = named.get(statement.token)
        if token is None or token.state is not TokenState.INACTIVE:
            return False
        if isinstance(statement, Codesignation):
            host = named.get(statement.host)
            if host is None or host.state is not TokenState.ACTIVE:
                return False
            Codesignate(token, host).apply(self.database)
            return True
        thing = self.database.model.objects[statement.object]
        if not statement.attribute:
            Activate(token, thing).apply(self.database)
            return True
        line = self.lines[statement.object, statement.attribute]
        before = line[: line.index(record.number)]
        # Not the decision of the search, which besides keeps neighbours apart by what it knows of the model.
        self.database.network.restrict(token.object, tokens.domain_of_object(thing), record.number)
        tokens.insert(token, sum(n in self.applied for n in before), record.number)
        self.database.network.propagate()
        return True
