"""Random operations, undone in any order: always the plan of a fresh database given the operations that are left."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable

import pytest

from planner.constraints.retraction import Changing, history
from planner.domains import Domain
from planner.operations import Operation, Operations
from planner.operations.order import Lineup, Precedences
from planner.operations.removal import Removal
from planner.operations.retraction import Retraction
from planner.tokens import withdrawal
from planner.tokens.manager import TokenNetworkManager
from planner.tokens.resources import PendingUse
from planner.tokens.token import Token
from tests.planner.operations.driver import Driver
from tests.planner.operations.worlds import WORLDS

SEEDS, STEPS = 25, 30


@pytest.mark.parametrize("world", WORLDS)
def test_any_order(world: str) -> None:
    counts: Counter[str] = Counter()
    for seed in range(SEEDS):
        driver = Driver(WORLDS[world], seed)
        driver.run(STEPS, check=0.4)
        driver.compare()
        counts += driver.counts
    assert counts["undone out of order"] > 80
    assert min(counts[kind] for kind in ("inserted", "codesignated", "restricted", "refused", "dormant")) > 10


def _nothing(*_: object) -> None:
    """Forget to do it."""


def _at_the_end(lineup: Lineup, operation: Operation, predecessor: Operation | None) -> None:
    lineup._line.append(operation)


def _no_edges(precedences: Precedences, token: Token) -> list[int]:
    return []


def _stays_over_its_timeline(
    manager: TokenNetworkManager, token: Token, leave: Callable[..., None] = withdrawal._leave_slot
) -> None:
    if token.kind != "constraint":
        leave(manager, token)


def _stands(retraction: Retraction, variable: Changing, after: float, before: Domain) -> float:
    """The first change after the one that goes stands by itself, whatever it rests on."""
    later = [c.at for c in history(retraction.network, variable) if c.at > after]
    return min(later, default=math.inf)


@pytest.mark.parametrize(
    ("owner", "name", "planted", "world"),
    [
        (Retraction, "_drop_effects", _nothing, "altern"),
        (Retraction, "_review_guards", _nothing, "switches"),
        (Removal, "_close_gap", _nothing, "camera"),
        (Removal, "_restrict_anew", _nothing, "switches"),
        (Retraction, "_stands_by_itself", _stands, "switches"),
        (Removal, "unsettle", _nothing, "altern"),
        (Precedences, "of", _no_edges, "camera"),
        (Lineup, "enter", _at_the_end, "camera"),
        (Operations, "_retry", _nothing, "altern"),
        (Retraction, "_drop_pruning", _nothing, "workshop"),
        (PendingUse, "withdraw", _nothing, "workshop"),
        (withdrawal, "_leave_slot", _stays_over_its_timeline, "keeping"),
        (Retraction, "_drop_derived_from_time", _nothing, "keeping"),
    ],
)
def test_a_planted_bug_is_seen(
    monkeypatch: pytest.MonkeyPatch, owner: object, name: str, planted: Callable[..., object], world: str
) -> None:
    monkeypatch.setattr(owner, name, planted)
    with pytest.raises((AssertionError, ValueError, IndexError, KeyError)):
        _wander(world)


def _wander(world: str) -> None:
    for seed in range(30):
        Driver(WORLDS[world], seed).run(40, check=0.5)
