"""What it costs to undo one operation of a plan.

Two plans of so many tokens. `altern`: a rover that is at places and goes between them, every token asked for by the one
before: found by the search's own choice of flaws, its decisions issued as operations. `shows`: independent goals on one
timeline, each with a subgoal that is codesignated with a lamp that is on.

Timed for each kind of operation, medians over samples: undoing it in order, as the newest; undoing one in the middle of
the plan, in place; the same by replay of what came later. `gone` is the mean number of operations that go out of force
with it: an insertion in `altern` takes along whatever it supports, and undoing it in order undoes all of that first,
which takes `gone_in_order_us`. `ratio` is in place against that, `single_ratio` against the newest operation alone.
"""

from __future__ import annotations

import statistics
import time
from collections import defaultdict
from collections.abc import Callable, Iterator

from planner.constraints.standard import STANDARD
from planner.database import PlanDatabase
from planner.domains import Values
from planner.language.builder import ModelBuilder
from planner.operations import Operation, Operations
from planner.problem import TokenPattern
from planner.search.collector import patient_collector
from planner.search.decisions import Assign, Codesignate, Decision, Insert
from planner.search.flaws import next_flaw
from planner.tokens.path import TokenPath
from scenarios.benchmarks.problems import altern_model

SAMPLES, REPLAYS = 40, 2


def altern(tokens: int) -> Operations:
    """A chain of tokens, each the subgoal of the one before."""
    database = PlanDatabase(altern_model(), (10, 10 + tokens))
    last = 10 + tokens - 1 - (tokens - 1) % 2
    database.state(TokenPattern("Rover.At", parameters={"place": "Lander"}, start=(10, 10)), "first", "goal")
    database.state(TokenPattern("Rover.At", parameters={"place": "Rock"}, start=(last, last)), "last", "goal")
    database.network.propagate()
    operations = Operations(database)
    while (found := next_flaw(database)) is not None:
        if not any(issue(operations, decision) for decision in found[1]):
            raise RuntimeError(f"nothing resolves {found[0]!r}: expected a plan without backtracking")
    return operations


def issue(operations: Operations, decision: Decision) -> bool:
    """A decision of the search as an operation."""
    if isinstance(decision, Insert):
        return bool(operations.insert(decision.token, decision.object, decision.position))
    if isinstance(decision, Codesignate):
        return bool(operations.codesignate(decision.token, decision.host))
    assert isinstance(decision, Assign)
    return bool(operations.restrict(decision.variable, decision.domain))


def shows(tokens: int) -> Operations:
    """Independent goals one after another, with room to move."""
    builder = ModelBuilder("shows", STANDARD)
    colour = builder.enumeration("Colour", ["red", "green"])
    line, lamp = builder.timeline("Line"), builder.timeline("Lamp")
    show, on = line.predicate("show", {"colour": colour}, duration=(1, 3)), lamp.predicate("on")
    with show.requires() as this:
        this.contained_by(on)
    for name in ("line", "lamp"):
        builder.object(name, name.capitalize())
    database = PlanDatabase(builder.finish(), (0, 3 * tokens))
    database.state(TokenPattern("Lamp.on", "lamp"), "lit", "state")
    for number in range(tokens):
        window = (3 * number, 3 * number + 9)
        database.state(TokenPattern("Line.show", "line", start=window), f"show{number}", "goal")
    database.network.propagate()
    operations = Operations(database)
    operations.insert("lit", "lamp")
    for number in range(tokens):
        operations.insert(f"show{number}", "line", number)
        operations.codesignate(f"show{number}/on0", "lit")
        colours = database.tokens.by_path[TokenPath.of(f"show{number}")].parameters["colour"]
        assert isinstance(colours.domain, Values)
        operations.restrict(colours, colours.domain.keep(["red"]))
    return operations


def by_kind(operations: Operations) -> dict[str, list[Operation]]:
    """The operations by what they say."""
    kinds: dict[str, list[Operation]] = defaultdict(list)
    for operation in operations.issued:
        kinds[kind_of(operation)].append(operation)
    return kinds


def kind_of(operation: Operation) -> str:
    """What an operation says, in a word."""
    return type(operation.statement).__name__.lower()


def in_order_us(operations: Operations) -> dict[str, float]:
    """Undoing the newest, over and over, until half of the plan is left."""
    times: dict[str, list[float]] = defaultdict(list)
    for operation in reversed(operations.issued[len(operations.issued) // 2 :]):
        times[kind_of(operation)].append(timed_us(operations, operation))
    return {kind: statistics.median(found) for kind, found in times.items()}


def middle(
    make: Callable[[int], Operations], tokens: int, kind: str, newest: dict[str, float], *, replay: bool = False
) -> tuple[float, float, float]:
    """Undoing operations of one kind, from the end of the plan to its beginning, and what goes out of force with them.

    Median time, mean number of operations gone, and the median time that undoing those takes in order, each as the
    newest, in which state it takes what `newest` says of its kind.
    """
    operations = make(tokens)
    operations.in_place = not replay
    found = by_kind(operations)[kind]
    count = REPLAYS if replay else min(SAMPLES, len(found))
    times, counts, in_order = [], [], []
    for number in reversed(range(count)):
        operation = found[len(found) * (number + 1) // (count + 1)]
        if operation.depth is not None:
            before = operations.in_force
            times.append(timed_us(operations, operation))
            gone = [other for other in before if other.depth is None or other is operation]
            counts.append(len(gone))
            in_order.append(sum(newest[kind_of(other)] for other in gone))
    return statistics.median(times), statistics.mean(counts), statistics.median(in_order)


def timed_us(operations: Operations, operation: Operation) -> float:
    """Undoing an operation, in microseconds of the processor."""
    started = time.process_time()
    operations.undo(operation)
    return 1e6 * (time.process_time() - started)


def measure(sizes: tuple[int, ...] = (300, 1000)) -> dict[str, object]:
    """All figures of this benchmark: a row for each plan, size and kind of operation."""
    with patient_collector():
        altern(30)
        return {"rows": [row for make in (altern, shows) for tokens in sizes for row in rows(make, tokens)]}


def rows(make: Callable[[int], Operations], tokens: int) -> Iterator[dict[str, object]]:
    """One row a kind of operation."""
    started = time.process_time()
    operations = make(tokens)
    built_s = time.process_time() - started
    kinds = {kind: len(found) for kind, found in by_kind(operations).items()}
    newest = in_order_us(operations)
    for kind, alone in newest.items():
        in_place, gone, in_order = middle(make, tokens, kind, newest)
        row: dict[str, object] = {"plan": make.__name__, "tokens": tokens, "built_s": round(built_s, 2), "kind": kind}
        row |= {"count": kinds[kind], "in_order_us": round(alone, 1), "in_place_us": round(in_place, 1)}
        row |= {"gone": round(gone, 1), "gone_in_order_us": round(in_order, 1), "ratio": round(in_place / in_order, 1)}
        row["single_ratio"] = round(in_place / alone, 1)
        row["replay_us"] = round(middle(make, tokens, kind, newest, replay=True)[0], 1)
        yield row
