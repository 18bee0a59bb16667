"""`Operations`: the operations in force on a plan database, and how one of them is undone.

Each operation in force has a level of the trail, so that undoing the newest is undoing its level. Undoing an earlier
one undoes the levels down to its own and issues the later operations again, each to a fixpoint.
"""

from __future__ import annotations

from dataclasses import dataclass

from planner.constraints.network import AnyVariable, Inconsistency
from planner.database import PlanDatabase
from planner.domains import Domain
from planner.errors import nearest
from planner.model.classes import ModelObject
from planner.operations.order import Precedences
from planner.operations.register import Register
from planner.operations.removal import Removal
from planner.operations.restricting import restrict, variable_of
from planner.operations.retraction import Retraction, Unsuited
from planner.operations.statements import Codesignation, Insertion, Operation, Restriction, Statement
from planner.tokens.path import TokenPath
from planner.tokens.token import GIVEN, Token, TokenState


@dataclass(frozen=True, slots=True)
class Refusal:
    """A new operation that is inconsistent with those in force. `explanation`: what together makes it impossible."""

    statement: Statement
    explanation: tuple[str, ...]

    def __bool__(self) -> bool:
        """False, as an operation is true."""
        return False


@dataclass(frozen=True, slots=True)
class _Level:
    """A level of the trail. `operation`: the one that opened it; None: some were taken out in place, the lowest level
    of which was `lowest`. `turn`: the latest operation that had been issued then."""

    operation: Operation | None
    turn: int
    lowest: int = 0


class Operations:
    """The operations on a database in which a problem has been stated and propagated.

    The database changes only through this object as long as it is used. ValueError for what makes no sense now, such
    as inserting a token that is not open; a `Refusal` for what is inconsistent. `in_place`: undo by dependency where
    that is exact; otherwise always by replay.
    """

    def __init__(self, database: PlanDatabase, *, in_place: bool = True) -> None:
        self.database = database
        self.in_place = in_place
        self._floor = database.trail.depth
        self._levels: list[_Level] = []
        self._register = Register()
        self._precedences = Precedences(database)
        self._count = 0

    # What there is

    @property
    def issued(self) -> tuple[Operation, ...]:
        """The operations that were issued and not undone, in order of issue."""
        return tuple(self._register.issued.values())

    @property
    def in_force(self) -> tuple[Operation, ...]:
        """Those that act on the plan, in order of issue."""
        return tuple(o for o in self._register.issued.values() if o.depth is not None)

    @property
    def dormant(self) -> tuple[Operation, ...]:
        """Those that wait for a token or a host to come back, in order of issue."""
        return tuple(self._register.in_order())

    def open_tokens(self) -> tuple[str, ...]:
        """The paths of the tokens that are neither inserted nor codesignated."""
        return tuple(token.path.text for token in self.database.tokens.open_tokens.values())

    def openings(self, token: str) -> tuple[tuple[str, ...], tuple[tuple[str, int], ...]]:
        """Where an open token could go as far as bounds can tell: hosts, and (object, position) of empty slots."""
        found = self._token(token)
        hosts, places = self.database.tokens.openings(found)
        return tuple(h.path.text for h in hosts), tuple((thing.name, position) for thing, position in places)

    # The operations

    def insert(self, token: Token | str, object_: ModelObject | str, position: int = 0) -> Operation | Refusal:
        """Give an open token a slot of its own: before the token at `position` of the object's timeline. A constraint
        token has no position: it lies over whatever slots it meets."""
        found, thing = self._open(token), self._object(object_)
        if found.predicate.exogenous and found.role not in GIVEN:
            raise ValueError(f"{found.name}: no plan brings about {found.predicate.full_name}, expected a host")
        if thing not in found.object.domain:
            raise ValueError(f"{found.name}: expected one of {found.object.domain!r}, found {thing}")
        attribute = found.predicate.attribute if found.kind == "timeline" else ""
        operation = self._operation(Insertion(found.path, thing.name, attribute))
        if attribute:
            sequence = self.database.tokens.timelines[thing, found.predicate.attribute].sequence
            if not 0 <= position <= len(sequence):
                raise ValueError(f"{found.name}: expected a position from 0 to {len(sequence)}, found {position}")
            before = sequence[position - 1].placed_by if position else None
            assert before is None or isinstance(before, Operation)
            self._register.place(operation, before)
        return self._issue(operation)

    def codesignate(self, token: Token | str, host: Token | str) -> Operation | Refusal:
        """Let an open token be one with an active one of the same predicate."""
        found, other = self._open(token), self._token(host)
        if other.state is not TokenState.ACTIVE:
            raise ValueError(f"{other.name}: expected an active host, found {other.state.name.lower()}")
        predicate = found.predicate
        if predicate is not other.predicate or found.solitary or found.must_host:
            raise ValueError(f"{found.name}: cannot be one with {other!r}")
        return self._issue(self._operation(Codesignation(found.path, other.path)))

    def restrict(self, variable: AnyVariable, domain: Domain) -> Operation | Refusal:
        """Restrict a variable of a token or of a rule to a domain."""
        tokens = self.database.tokens
        if tokens.variables.get(variable.name) is variable:
            return self._issue(self._operation(Restriction(None, variable.name, domain)))
        token = variable.of
        if not isinstance(token, Token) or tokens.by_path.get(token.path) is not token:
            raise ValueError(f"{variable.name}: expected a variable of a token or of a rule, with a name of its own")
        return self._issue(self._operation(Restriction(token.path, variable.part, domain)))

    def undo(self, operation: Operation) -> None:
        """Make the plan that of the other operations.

        By undoing a level if it is the newest; else in place; else, where the order of events matters, by replay.
        """
        self._check_levels()
        if self._register.issued.get(operation.number) is not operation:
            raise ValueError(f"{operation!r}: expected an operation that is not undone")
        self._register.leave(operation)
        if operation.depth is None:
            return
        newest = operation.depth == self.database.trail.depth - 1
        if newest or not self.in_place or not self._retract(operation):
            self._replay(operation.depth)

    # Levels

    def _check_levels(self) -> None:
        if self.database.trail.depth != self._floor + len(self._levels):
            raise ValueError("levels of the trail were opened or closed by others")

    def _issue(self, operation: Operation) -> Operation | Refusal:
        self._count = operation.number
        self._register.enter(operation)
        if self._enter(operation):
            self._retry()
            return operation
        self._register.leave(operation)
        return Refusal(operation.statement, operation.reason)

    def _retract(self, operation: Operation) -> bool:
        """Take an operation out in place; False, and nothing has changed, if only replay is exact."""
        if self._order_matters():
            return False
        database, count = self.database, len(self._levels)
        retraction = Retraction(database, self._register, self._precedences)
        try:
            retraction.run(operation)
        except Unsuited:
            return False
        before = [(o, o.depth) for o in retraction.suspended.values() if o.depth is not None]
        depth = database.trail.push()
        self._levels.append(_Level(None, self._count, min(level for _, level in before)))
        removal = Removal(retraction)
        try:
            removal.carry_out()
            database.network.propagate()
            done = True
        except Inconsistency:
            done = False
        if done:
            removal.unsettle()
            self._retry()
            if not self._order_matters():
                return True
        self._drop_levels(count)
        database.trail.pop_to(depth)
        for suspended, level in before:
            suspended.depth = level
            self._register.wake(suspended)
        return False

    def _order_matters(self) -> bool:
        return any(map(self._is_displaced, self._register.hopeful(self.database.tokens.by_path.keys())))

    def _is_displaced(self, operation: Operation) -> bool:
        """Whether a dormant operation waits for more than something that is not there: which of two operations that
        exclude each other acts depends on the order in which they came."""
        statement = operation.statement
        if operation.reason:
            return True
        if isinstance(statement, Restriction):
            return False
        token = self.database.tokens.by_path.get(statement.token)
        return token is not None and token.state is not TokenState.INACTIVE

    def _drop_levels(self, count: int) -> None:
        for level in self._levels[count:]:
            if level.operation is not None:
                self._register.suspend(level.operation)
        del self._levels[count:]

    def _replay(self, depth: int) -> None:
        """Undo the levels from a depth on and issue their operations again, but those that were undone.

        Levels that lie above a removal in place but speak of a time before it are no plan of the operations that are
        left: they go too.
        """
        place = len(self._levels)
        while place > depth - self._floor:
            place -= 1
            if self._levels[place].operation is None:
                depth = min(depth, self._levels[place].lowest)
        turn = self._levels[place].turn
        self._drop_levels(place)
        self.database.trail.pop_to(depth)
        last, self._count = self._count, turn
        self._retry()
        for operation in self._register.after(turn):
            self._count = operation.number
            if operation.depth is None and self._is_ready(operation):
                self._enter(operation)
            self._retry()
        self._count = last

    def _retry(self) -> None:
        """Bring back what can come back, in order of issue, until nothing changes."""
        again = True
        while again:
            again = False
            for operation in self._register.hopeful(self.database.tokens.by_path.keys()):
                if operation.number <= self._count and self._is_ready(operation):
                    again |= self._enter(operation)

    def _enter(self, operation: Operation) -> bool:
        """Bring an operation into force on a level of its own; False, and the reason, if it is inconsistent."""
        database = self.database
        depth = database.trail.push()
        try:
            before = database.tokens.measure()
            self._apply(operation)
            operation.extent = database.tokens.extent_since(before)
            database.network.propagate()
        except Inconsistency as inconsistency:
            operation.reason = tuple(dict.fromkeys(map(str, database.network.explain(inconsistency))))
            database.trail.pop_to(depth)
            return False
        operation.depth, operation.reason = depth, ()
        self._register.wake(operation)
        self._levels.append(_Level(operation, self._count))
        return True

    # Single operations

    def _is_ready(self, operation: Operation) -> bool:
        """Whether what the operation speaks of is there."""
        tokens, statement = self.database.tokens, operation.statement
        if isinstance(statement, Restriction):
            return variable_of(self.database, statement) is not None
        token = tokens.by_path.get(statement.token)
        if token is None or token.state is not TokenState.INACTIVE:
            return False
        if isinstance(statement, Insertion):
            return True
        host = tokens.by_path.get(statement.host)
        return host is not None and host.state is TokenState.ACTIVE

    def _apply(self, operation: Operation) -> None:
        tokens, statement = self.database.tokens, operation.statement
        if isinstance(statement, Codesignation):
            tokens.merge(tokens.by_path[statement.token], tokens.by_path[statement.host], operation)
            return
        restrict(self.database, operation)
        if isinstance(statement, Insertion):
            token = tokens.by_path[statement.token]
            if statement.attribute:
                self._take_slot(operation, token)
            else:
                tokens.activate(token, operation)

    def _take_slot(self, operation: Operation, token: Token) -> None:
        """Insert a token after the nearest predecessor that is there."""
        tokens, network = self.database.tokens, self.database.network
        sequence, lineup = tokens.timeline_of(token).sequence, self._register.lineup(operation)
        assert lineup is not None
        before, position = lineup.predecessor(operation), 0
        if before is not None:
            assert isinstance(before.statement, Insertion)
            position = sequence.index(tokens.by_path[before.statement.token]) + 1
        edge = network.posted
        tokens.insert(token, position, operation)
        if position > 0:
            self._precedences.note(edge, sequence[position - 1], token)
            edge += 1
        if position + 1 < len(sequence):
            self._precedences.note(edge, token, sequence[position + 1])

    # Names

    def _token(self, token: Token | str) -> Token:
        """The token of a name, or a token that is the one of its name."""
        path = TokenPath.of(token) if isinstance(token, str) else token.path
        found = self.database.tokens.by_path.get(path)
        if found is None or (found is not token and not isinstance(token, str)):
            raise ValueError(f"{str(path)!r}: expected the name of a single token of the plan")
        return found

    def _open(self, token: Token | str) -> Token:
        found = self._token(token)
        if found.state is not TokenState.INACTIVE:
            raise ValueError(f"{found.name}: expected an open token, found it {found.state.name.lower()}")
        return found

    def _operation(self, statement: Statement) -> Operation:
        self._check_levels()
        return Operation(self._count + 1, statement)

    def _object(self, object_: ModelObject | str) -> ModelObject:
        objects = self.database.model.objects
        name = object_ if isinstance(object_, str) else object_.name
        if name not in objects:
            raise ValueError(f"{name!r}: there is no object of that name{nearest(name, objects)}")
        return objects[name]
