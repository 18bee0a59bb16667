"""A removal in place is a change like any other: undoing its level puts everything back, whatever was removed."""

from __future__ import annotations

import pytest

from planner.constraints.standard import STANDARD
from planner.database import PlanDatabase
from planner.domains import Interval
from planner.language.builder import ModelBuilder
from planner.operations import Operation
from planner.operations.operations import Operations
from planner.operations.removal import Removal
from planner.operations.retraction import Retraction, Unsuited
from planner.problem import TokenPattern
from tests.planner.operations.driver import Driver
from tests.planner.operations.worlds import WORLDS
from tests.planner.tokens.snapshot import snapshot


def removals_undone(world: str, seed: int) -> int:
    """Remove each operation in place, undo the level that it took, and compare; the number of removals."""
    driver = Driver(WORLDS[world], seed)
    undone = 0
    for _ in range(4):
        driver.run(7, check=0)
        undone += sum(removed_and_undone(driver.operations, place) for place in range(len(driver.operations.in_force)))
        driver.compare()
    return undone


def removed_and_undone(operations: Operations, place: int) -> bool:
    """Take one operation out and undo that, if it can be taken out in place; whether that changed anything."""
    database, operation = operations.database, operations.in_force[place]
    before = snapshot(database)
    retraction = Retraction(database, operations._register, operations._precedences)
    try:
        retraction.run(operation)
    except Unsuited:
        return False
    levels = {o: o.depth for o in retraction.suspended.values()}
    depth = database.trail.push()
    removal = Removal(retraction)
    removal.carry_out()
    database.network.propagate()
    removal.unsettle()
    changed = snapshot(database) != before  # not so when the operation restricted nothing
    database.trail.pop_to(depth)
    for suspended, level in levels.items():
        suspended.depth = level
        operations._register.wake(suspended)
    after = snapshot(database)
    assert [key for key in before if before[key] != after[key]] == []
    return changed


def test_a_restriction_stated_before_the_one_undone_stays() -> None:
    """What two successive changes of a duration posted is told apart."""
    builder = ModelBuilder("lamps", STANDARD)
    builder.timeline("Lamp").predicate("shine")
    builder.object("lamp", "Lamp")
    database = PlanDatabase(builder.finish(), (0, 60))
    tokens = [database.state(TokenPattern("Lamp.shine", duration=(4, 9)), name, "goal") for name in ("one", "other")]
    database.network.propagate()
    operations = Operations(database)
    restriction = operations.restrict(tokens[1].duration, Interval(8, 9))
    assert isinstance(restriction, Operation)
    operations.insert("one", "lamp")
    operations.undo(restriction)
    assert database.temporal.distance(tokens[1].start.timepoint, tokens[1].end.timepoint) == (4, 9)


@pytest.mark.parametrize("world", WORLDS)
def test_a_removal_is_undone_exactly(world: str) -> None:
    assert sum(removals_undone(world, seed) for seed in range(8)) > 60
