"""Undo is exact: whatever random operations do in a level, the database after `pop_to` is the one before `push`."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from planner.constraints.network import ConstraintNetworkManager, Inconsistency
from planner.database import PlanDatabase
from planner.problem import TokenPattern
from planner.search.decisions import Decision, Order, Reject
from planner.search.flaws import OpenToken, Undecided, next_flaw
from planner.trail import Trail
from tests.planner.domains_small import camera_model, rover_model
from tests.planner.tokens.snapshot import snapshot


def camera() -> PlanDatabase:
    database = PlanDatabase(camera_model(), (0, 60))
    database.state(TokenPattern("Engine.thrust", end=(5, 20)), "thrusting", "state")
    database.state(TokenPattern("Camera.picture", parameters={"asteroid": "Ida"}), "ida", "goal")
    database.state(TokenPattern("Camera.picture", end=(None, 40)), "any", "goal")
    database.state(TokenPattern("Engine.thrust"), "again", "rejectable")
    database.network.propagate()
    return database


def rovers() -> PlanDatabase:
    database = PlanDatabase(rover_model(), (0, 80))
    database.state(TokenPattern("Rover.at", "rover1", {"site": "base"}), "here", "state")
    database.state(TokenPattern("Rover.at", "rover2", {"site": ("hill", "base")}), "there", "state")
    database.state(TokenPattern("Light.sun", start=(10, 10), end=(40, 50)), "day", "fact")
    database.state(TokenPattern("Rover.sample", parameters={"site": "lake"}), "lake", "goal")
    database.state(TokenPattern("Rover.sample"), "sample", "rejectable")
    database.state(TokenPattern("Rover.drive", "rover2"), "drive", "rejectable")
    database.network.propagate()
    return database


WORLDS: dict[str, Callable[[], PlanDatabase]] = {"camera": camera, "rovers": rovers}


def operations(database: PlanDatabase, rng: random.Random) -> Iterator[Decision]:
    """Operations to try in random order: insert, activate, codesignate, reject, assign, order."""
    tokens = list(database.tokens.open_tokens.values())
    flaws = [OpenToken(t) for t in tokens] + [
        Undecided(v) for v in database.tokens.undecided if v.domain.size < math.inf
    ]
    found: list[Decision] = [d for f in flaws for d in _some(f.decisions(database), rng)]
    found += [Reject(t) for t in tokens if t.role == "rejectable"]
    if len(database.tokens.tokens) > 1:
        first, second = rng.sample(database.tokens.tokens, 2)
        found.append(Order(first.end, second.start))
    rng.shuffle(found)
    yield from found[:3]


def _some(decisions: Iterator[Decision], rng: random.Random) -> list[Decision]:
    listed = [d for d, _ in zip(decisions, range(20), strict=False)]
    return rng.sample(listed, min(3, len(listed)))


def wander(database: PlanDatabase, seed: int, steps: int) -> tuple[int, int]:
    """Random levels and operations, comparing at every undo; the numbers of undone levels and of failed operations."""
    rng = random.Random(seed)
    before: list[dict[str, Any]] = []
    undone = failed = 0
    for _ in range(steps):
        if before and rng.random() < 0.25:
            depth = rng.randrange(len(before))
            database.trail.pop_to(depth)
            compare(before[depth], snapshot(database))
            undone += len(before) - depth
            del before[depth:]
            continue
        next_flaw(database)  # what a search looks up and notes on the way is undone too
        for decision in operations(database, rng):
            before.append(snapshot(database))
            database.trail.push()
            try:
                decision.apply(database)
            except Inconsistency as inconsistency:
                database.network.explain(inconsistency)
                database.trail.pop_to(len(before) - 1)
                compare(before.pop(), snapshot(database))
                failed += 1
                continue
            break
    if before:
        database.trail.pop_to(0)
        compare(before[0], snapshot(database))
    return undone, failed


def compare(expected: dict[str, Any], found: dict[str, Any]) -> None:
    different = [key for key in expected if expected[key] != found[key]]
    assert not different, f"after undo these differ: {different}"


@pytest.mark.parametrize("world", WORLDS)
def test_undo_is_exact(world: str) -> None:
    undone = failed = 0
    for seed in range(30):
        levels, failures = wander(WORLDS[world](), seed, 30)
        undone, failed = undone + levels, failed + failures
    assert undone > 100
    assert failed > 10


@pytest.mark.parametrize("world", WORLDS)
def test_every_operation_takes_part(world: str) -> None:
    kinds = set()
    for seed in range(10):
        database, rng = WORLDS[world](), random.Random(seed)
        for _ in range(25):
            for decision in operations(database, rng):
                depth = database.trail.push()
                try:
                    decision.apply(database)
                except Inconsistency:
                    database.trail.pop_to(depth)
                    continue
                kinds.add(type(decision).__name__)
                break
    expected = {"Insert", "Codesignate", "Reject", "Assign", "Order"}
    assert kinds >= (expected | {"Activate"} if world == "rovers" else expected)


def _forget_watchers(trail: Trail, container: list[Any], value: Any) -> None:
    container.append(value)


def _forget_domains(network: ConstraintNetworkManager, variable: Any, old: Any, because: Any) -> None:
    """Leave no record of a domain change."""


def _forget_assign(trail: Trail, thing: Any, attribute: str, value: Any) -> None:
    setattr(thing, attribute, value)


def _forget_call(trail: Trail, undo: Callable[..., object], *arguments: Any) -> None:
    """Leave no record of what a function should undo, such as a timeline's new token."""


@pytest.mark.parametrize(
    ("owner", "name", "forgetful"),
    [
        (Trail, "append", _forget_watchers),
        (Trail, "assign", _forget_assign),
        (Trail, "call", _forget_call),
        (ConstraintNetworkManager, "_note", _forget_domains),
    ],
)
def test_a_forgotten_record_is_seen(
    monkeypatch: pytest.MonkeyPatch, owner: type, name: str, forgetful: Callable[..., None]
) -> None:
    database = rovers()
    monkeypatch.setattr(owner, name, forgetful)
    with pytest.raises((AssertionError, KeyError, IndexError)):
        wander(database, 3, 30)


def test_a_level_opens_at_a_fixpoint_only() -> None:
    database = camera()
    database.network.distance(database.tokens.tokens[0].end, database.tokens.tokens[1].start, 0, 5, "test")
    with pytest.raises(ValueError, match="expected `propagate` before `push`"):
        database.trail.push()
    database.network.propagate()
    assert database.trail.push() == 0
