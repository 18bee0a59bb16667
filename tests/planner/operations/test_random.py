"""Random operations, undone in any order: always the plan of a fresh database given the operations that are left."""

from __future__ import annotations

from collections import Counter

import pytest

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
