"""Random operations and undoing, compared with the oracle after each."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable

from planner.database import PlanDatabase
from planner.domains import Domain, Interval
from planner.operations import Insertion, Operation, Operations, Refusal
from planner.search.flaws import next_flaw
from planner.tokens.token import GIVEN, Token, TokenState
from tests.planner.operations.described import described
from tests.planner.operations.rebuilt import Rebuilt, Record


class Driver:
    """A database under random operations. `counts`: what happened."""

    def __init__(self, make: Callable[[], PlanDatabase], seed: int) -> None:
        self.make = make
        self.rng = random.Random(seed)
        self.database = make()
        self.operations = Operations(self.database)
        self.records: dict[int, Record] = {}
        self.lines: dict[tuple[str, str], list[int]] = {}
        self.counts: Counter[str] = Counter()

    def run(self, steps: int, check: float = 1.0) -> None:
        """Random steps, each compared with the oracle with a probability."""
        for _ in range(steps):
            if self.rng.random() < 0.3:
                next_flaw(self.database)  # a search may look between the operations, and notes what it finds
            issued = self.operations.issued
            if issued and self.rng.random() < 0.3:
                self.undo(self.rng.choice(issued))
            else:
                self.rng.choice([self.place, self.place, self.merge, self.restrict])()
            if self.rng.random() < check:
                self.compare()

    def compare(self) -> None:
        """The state is that of a fresh database given the operations that are left."""
        rebuilt = Rebuilt(self.make, [self.records[o.number] for o in self.operations.issued])
        self.counts["compared"] += 1
        assert {o.number for o in self.operations.in_force} == rebuilt.applied
        expected, found = described(rebuilt.database), described(self.database)
        different = [key for key in expected if expected[key] != found[key]]
        assert not different, f"these differ: {different}: {_first(expected[different[0]], found[different[0]])}"

    def undo(self, operation: Operation) -> None:
        self.counts["undone dormant" if operation.depth is None else "undone"] += 1
        self.counts["undone out of order"] += operation is not self.operations.issued[-1]
        self.operations.undo(operation)
        del self.records[operation.number]
        for line in self.lines.values():
            if operation.number in line:
                line.remove(operation.number)
        self.counts["dormant"] += len(self.operations.dormant)

    def place(self) -> None:
        token = self.some_open()
        if token is None or (token.predicate.exogenous and token.role not in GIVEN):
            return
        things = [thing for thing in self.database.model.objects.values() if thing in token.object.domain]
        thing, position, before = self.rng.choice(things), 0, []
        places = self.operations.openings(token.name)[1]
        if places and self.rng.random() < 0.8:
            name, position = self.rng.choice(places)
            thing = self.database.model.objects[name]
        key = (thing.name, token.predicate.attribute)
        if token.kind == "timeline":
            sequence = self.database.tokens.timelines[thing, token.predicate.attribute].sequence
            position = min(position, len(sequence))
            line = self.lines.setdefault(key, [])
            before = line[: line.index(sequence[position - 1].placed_by.number) + 1] if position else []
        done = self.issued(self.operations.insert(token, thing, position), "inserted", before)
        if done is not None and token.kind == "timeline":
            self.lines[key].insert(len(before), done.number)

    def merge(self) -> None:
        token = self.some_open()
        if token is None or token.must_host or token.predicate.solitary:
            return
        hosts = list(self.operations.openings(token.name)[0])
        if not hosts or self.rng.random() < 0.1:
            all_of_them = self.database.tokens.tokens
            hosts = [t.name for t in all_of_them if t.predicate is token.predicate and t.state is TokenState.ACTIVE]
        if hosts:
            self.issued(self.operations.codesignate(token.name, self.rng.choice(hosts)), "codesignated", [])

    def restrict(self) -> None:
        tokens = self.database.tokens
        wanted = [v for v in tokens.still_undecided() if self.rng.random() < 0.8]
        if not wanted or self.rng.random() < 0.3:
            token = self.rng.choice(tokens.tokens)
            wanted = [token.object, token.start, token.end, token.duration, *token.parameters.values()]
        variable = self.rng.choice(wanted)
        self.issued(self.operations.restrict(variable, self.some_of(variable.domain)), "restricted", [])

    def issued(self, done: Operation | Refusal, kind: str, before: list[int]) -> Operation | None:
        """Keep the record of an operation; a refused one must be inconsistent for the oracle too."""
        if isinstance(done, Operation):
            self.counts[kind] += 1
            self.records[done.number] = Record(done.number, done.statement, tuple(before))
            return done
        self.counts["refused"] += 1
        assert done.explanation
        number = 10**6
        statement = done.statement
        assert not isinstance(statement, Insertion) or before is not None
        records = [self.records[o.number] for o in self.operations.issued] + [Record(number, statement, tuple(before))]
        assert number not in Rebuilt(self.make, records).applied
        return None

    def some_open(self) -> Token | None:
        found = list(self.database.tokens.open_tokens.values())
        shallow = [t for t in found if t.depth < 3]
        return self.rng.choice(shallow) if shallow else None

    def some_of(self, domain: Domain) -> Domain:
        if isinstance(domain, Interval):
            low, high = max(domain.lower, -5), min(domain.upper, 60)
            a, b = sorted(self.rng.randint(int(low), max(int(low), int(high))) for _ in range(2))
            return Interval(a, b if self.rng.random() < 0.6 else a, domain.integer)
        values = sorted(domain.values(), key=str)
        return domain.keep(self.rng.sample(values, self.rng.randint(1, max(1, len(values) - 1))))


def _first(expected: object, found: object) -> str:
    if isinstance(expected, dict) and isinstance(found, dict):
        for key in sorted({*expected, *found}, key=str):
            if expected.get(key) != found.get(key):
                return f"{key}: expected {expected.get(key)}, found {found.get(key)}"
    return f"expected {expected}, found {found}"
