"""Small random resource problems and their exhaustive oracle: every schedule, and the level in each."""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

from planner.constraints.network import TimeVariable
from planner.constraints.standard import STANDARD
from planner.database import PlanDatabase
from planner.domains import Interval
from planner.language.builder import ModelBuilder
from planner.model.classes import Parameter
from planner.problem import TokenPattern
from planner.search.decisions import Activate
from planner.tokens.resources import Resource
from planner.tokens.token import Token

HORIZON = (0, 6)

Point = tuple[int, bool]
"""Of which transaction, and whether its end."""


@dataclass(frozen=True)
class Move:
    """A transaction: predicate, least and most quantity, bounds of its start, of its duration and of its end."""

    predicate: str
    quantity: tuple[int, int]
    start: tuple[int, int]
    duration: tuple[int, int] = (0, 0)


@dataclass(frozen=True)
class Case:
    """Moves on one resource with these members, and distances (from, to, minimum, maximum) between their times."""

    cls: str
    members: dict[str, Any]
    moves: tuple[Move, ...]
    distances: tuple[tuple[Point, Point, float, float], ...] = ()


@dataclass
class Built:
    """A case in a database, propagated unless inconsistent."""

    case: Case
    database: PlanDatabase
    tokens: list[Token] = field(default_factory=list)

    @property
    def resource(self) -> Resource:
        (found,) = self.database.tokens.resources.values()
        return found

    def point(self, point: Point) -> TimeVariable:
        token = self.tokens[point[0]]
        return token.end if point[1] else token.start

    def add(self, number: int) -> None:
        """State and activate one move."""
        move = self.case.moves[number]
        pattern = TokenPattern(
            f"{self.case.cls}.{move.predicate}", None, {}, move.start, (None, HORIZON[1]), move.duration
        )
        token = self.database.state(pattern, f"t{number}", "goal")
        if "quantity" in token.parameters:
            quantity = Interval(*map(float, move.quantity), integer=False)
            self.database.network.restrict(token.parameters["quantity"], quantity, token.name)
        (thing,) = self.database.tokens.resources
        Activate(token, thing).apply(self.database)
        self.tokens.append(token)

    def constrain(self) -> None:
        for from_, to, least, most in self.case.distances:
            self.database.network.distance(self.point(from_), self.point(to), least, most, "case")


def empty(case: Case) -> Built:
    builder = ModelBuilder("case", STANDARD)
    builder.manager.add_class("Machine", "Reusable")
    quantity = Parameter("quantity", Interval(0, math.inf, integer=False))
    builder.manager.add_predicate("Machine", "draws", (quantity,), attribute="level", duration=(0, math.inf))
    builder.object("thing", case.cls, case.members)
    return Built(case, PlanDatabase(builder.finish(), HORIZON))


def build(case: Case) -> Built:
    """The case in a database; Inconsistency when its times or its resource cannot be."""
    built = empty(case)
    for number in range(len(case.moves)):
        built.add(number)
    built.constrain()
    built.database.network.propagate()
    return built


Schedule = tuple[tuple[int, int, int], ...]
"""Start, end and quantity of each move."""


def schedules(case: Case) -> Iterator[Schedule]:
    """Every schedule of the case, with every extreme quantity; limits of the resource are not looked at."""
    choices = [
        [
            (start, start + length)
            for start in range(max(HORIZON[0], move.start[0]), min(HORIZON[1], move.start[1]) + 1)
            for length in range(move.duration[0], move.duration[1] + 1)
            if start + length <= HORIZON[1]
        ]
        for move in case.moves
    ]
    quantities = [sorted(set(move.quantity)) for move in case.moves]
    for times in itertools.product(*choices):
        if all(
            least <= times[to[0]][to[1]] - times[from_[0]][from_[1]] <= most
            for from_, to, least, most in case.distances
        ):
            for amounts in itertools.product(*quantities):
                yield tuple((*t, q) for t, q in zip(times, amounts, strict=True))


def level(case: Case, schedule: Schedule, tick: int) -> float:
    """The level after everything that happens up to a tick."""
    total = member(case, "initial" if case.cls == "Reservoir" else "capacity", tick)
    for move, (start, end, quantity) in zip(case.moves, schedule, strict=True):
        if move.predicate == "produce":
            total += quantity * (start <= tick)
        elif move.predicate == "consume":
            total -= quantity * (start <= tick)
        else:
            total -= quantity * (start <= tick < end)
    return total


def member(case: Case, name: str, tick: float, default: float = 0.0) -> float:
    """The value of a member at a tick."""
    found = case.members.get(name, default)
    if isinstance(found, int | float):
        return found
    return next((value for start, value in reversed(found) if start <= tick), found[0][1])


def keeps(case: Case, schedule: Schedule) -> bool:
    """Whether a schedule keeps all limits at every tick."""
    for tick in range(HORIZON[0] - 1, HORIZON[1] + 1):
        now = level(case, schedule, tick)
        if now < member(case, "level_min", tick) or now > member(case, "level_max", tick, math.inf):
            return False
        for flow, rate in ((("consume", "draws"), "consumption_rate_max"), (("produce",), "production_rate_max")):
            moved = zip(case.moves, schedule, strict=True)
            if sum(q for m, (s, _, q) in moved if m.predicate in flow and s == tick) > member(
                case, rate, tick, math.inf
            ):
                return False
    for predicate, name in (("consume", "consumption_max"), ("produce", "production_max")):
        moved = zip(case.moves, schedule, strict=True)
        if sum(q for m, (_, _, q) in moved if m.predicate == predicate) > member(case, name, 0, math.inf):
            return False
    return True


def random_case(rng: random.Random, decided: bool = False, limits: bool = True) -> Case:
    """Up to four moves with some distances between them; limits that steps, rates and sums may tighten."""
    cls = rng.choice(["Machine", "Reservoir"])
    moves = []
    for _ in range(rng.randint(2, 4)):
        least = rng.randint(1, 3)
        quantity = (least, least if decided or rng.random() < 0.5 else least + 1)
        early = rng.randint(0, 3)
        start = (early, early + rng.randint(0, 3))
        if cls == "Reservoir":
            moves.append(Move(rng.choice(["produce", "consume"]), quantity, start))
        else:
            short = rng.randint(0 if rng.random() < 0.2 else 1, 2)
            moves.append(Move("draws", quantity, start, (short, short + rng.randint(0, 1))))
    points = [(n, side) for n in range(len(moves)) for side in ((False,) if cls == "Reservoir" else (False, True))]
    distances = []
    for _ in range(rng.randint(0, 3)):
        from_, to = rng.sample(points, 2)
        if from_[0] != to[0]:
            distances.append((from_, to, float(rng.randint(-2, 1)), rng.choice([math.inf, 1.0, 2.0])))
    case = Case(cls, {}, tuple(moves), tuple(distances))
    return replace(case, members=_limits(rng, cls) if limits else _loose(cls))


def _loose(cls: str) -> dict[str, Any]:
    return {"capacity": 10} if cls == "Machine" else {"initial": 0, "level_min": -100, "level_max": 100}


def _limits(rng: random.Random, cls: str) -> dict[str, Any]:
    if cls == "Machine":
        capacity = rng.randint(2, 6)
        members: dict[str, Any] = {"capacity": capacity, "level_min": rng.choice([0, 0, 1])}
        if rng.random() < 0.4:
            members["capacity"] = ((0, capacity), (rng.randint(1, 3), rng.randint(1, 6)), (4, capacity))
        if rng.random() < 0.3:
            members["consumption_rate_max"] = rng.randint(3, 5)
        return members
    members = {"initial": rng.randint(1, 5), "level_min": 0, "level_max": rng.randint(5, 9)}
    if rng.random() < 0.3:
        members["level_min"] = ((0, 0), (rng.randint(1, 3), rng.randint(1, 2)), (5, 0))
    if rng.random() < 0.4:
        name = rng.choice(["consumption_rate_max", "production_rate_max", "production_max", "consumption_max"])
        members[name] = rng.randint(3, 6)
    return members
