"""What the network says of its consistency, and its heuristics, against every assignment of small networks."""

from __future__ import annotations

import random
from collections import Counter
from itertools import product

import pytest

from planner.constraints.consistency import Verdict, allows, of_constraint, of_network
from planner.constraints.heuristics import (
    VALUE_HEURISTICS,
    VARIABLE_HEURISTICS,
    fewest_values_per_constraint,
    least_constraining,
)
from planner.constraints.network import Constraint, ConstraintNetworkManager, Inconsistency, Variable
from planner.constraints.standard import STANDARD
from planner.domains import Interval
from planner.temporal.network import TemporalNetworkManager
from planner.trail import Trail

RELATIONS = {
    "neq": lambda x, y: x != y,
    "lt": lambda x, y: x < y,
    "leq": lambda x, y: x <= y,
    "eq": lambda x, y: x == y,
}


class Small:
    """Up to four variables with few values and random relations between them."""

    def __init__(self, rng: random.Random) -> None:
        self.trail = Trail()
        temporal = TemporalNetworkManager()
        self.trail.join(temporal)
        self.network = ConstraintNetworkManager(self.trail, temporal)
        self.variables = [
            self.network.variable(f"x{n}", Interval(low, low + rng.randint(0, 2)), None)
            for n in range(rng.randint(2, 4))
            for low in (rng.randint(0, 2),)
        ]
        self.network.propagate()
        self.trail.push()
        self.rows: list[tuple[str, int, int]] = []
        self.posted: list[Constraint] = []
        for _ in range(rng.randint(1, 5)):
            name = rng.choice(sorted(RELATIONS))
            a, b = rng.sample(range(len(self.variables)), 2)
            self.rows.append((name, a, b))
            scope = (self.variables[a], self.variables[b])
            self.posted.append(self.network.post(STANDARD.get(name), scope, f"c{len(self.rows)}"))

    def solutions(self) -> list[tuple[int, ...]]:
        values = [[int(v) for v in variable.domain.values()] for variable in self.variables]
        return [s for s in product(*values) if all(RELATIONS[name](s[a], s[b]) for name, a, b in self.rows)]


def test_the_network_s_verdict_is_never_wrong_and_final_once_assigned() -> None:
    seen: Counter[Verdict] = Counter()
    for seed in range(400):
        small = Small(random.Random(seed))
        every = small.solutions()
        verdict, blamed = of_network(small.network)
        seen[verdict] += 1
        assert verdict != "inconsistent" or (not every and blamed)
        assert verdict != "consistent" or every
        if verdict != "undecided":
            continue
        for solution in every:
            depth = small.trail.push()
            for variable, value in zip(small.variables, solution, strict=True):
                small.network.restrict(variable, Interval(value, value), "choice")
            assert of_network(small.network)[0] == "consistent"
            small.trail.pop_to(depth)
    assert min(seen.values()) > 30


def test_a_constraint_and_a_value_by_themselves() -> None:
    for seed in range(300):
        small = Small(random.Random(seed))
        for (name, a, b), constraint in zip(small.rows, small.posted, strict=True):
            pairs = product(*(list(small.variables[n].domain.values()) for n in (a, b)))
            some = [RELATIONS[name](x, y) for x, y in pairs]
            expected = {"inconsistent"} if not any(some) else {"consistent"} if len(some) == 1 else {"undecided"}
            assert of_constraint(constraint) in expected | ({"undecided"} if not any(some) and len(some) > 1 else set())
        every = small.solutions()
        for place, variable in enumerate(small.variables):
            for value in variable.domain.values():
                # Never a value of a solution; for relations of two, just those that some relation gives no partner.
                assert allows(variable, value) or all(s[place] != value for s in every)
                assert allows(variable, value) == all(
                    any(
                        RELATIONS[name](value if a == place else other, value if b == place else other)
                        for other in small.variables[b if a == place else a].domain.values()
                    )
                    for name, a, b in small.rows
                    if place in (a, b)
                )
            assert not allows(variable, 99)


def bench(*domains: Interval) -> tuple[ConstraintNetworkManager, list[Variable]]:
    trail, temporal = Trail(), TemporalNetworkManager()
    trail.join(temporal)
    network = ConstraintNetworkManager(trail, temporal)
    return network, [network.variable(f"x{n}", domain, None) for n, domain in enumerate(domains)]


def test_variable_heuristics() -> None:
    network, (wide, narrow, busy, done, endless) = bench(
        Interval(0, 9), Interval(0, 1), Interval(0, 2), Interval(3, 3), Interval(0, float("inf"))
    )
    for _ in range(2):
        network.post(STANDARD.get("neq"), (busy, wide), "c")
    everything = [endless, done, wide, narrow, busy]
    chosen = {name: heuristic(everything) for name, heuristic in VARIABLE_HEURISTICS.items()}
    assert chosen == {"first-stated": wide, "fewest-values": narrow, "fewest-values-per-constraint": busy}
    assert fewest_values_per_constraint([done, endless]) is None


def test_value_heuristics() -> None:
    network, (x, y, z) = bench(Interval(0, 3), Interval(0, 3), Interval(1, 3))
    network.post(STANDARD.get("lt"), (x, y), "c")
    network.post(STANDARD.get("neq"), (x, z), "c")
    assert {name: list(heuristic(x)) for name, heuristic in VALUE_HEURISTICS.items()} == {
        "in-order": [0, 1, 2, 3],
        "min": [0, 1, 2, 3],
        "max": [3, 2, 1, 0],
        "least-constraining": [0, 1, 2, 3],
    }
    # 0 leaves three values to y and all to z; 3 leaves none to y.
    assert list(least_constraining(x)) == [0, 1, 2, 3]
    first, *_, last = least_constraining(y)
    assert (first, last) == (3, 0)


@pytest.mark.parametrize("name", VARIABLE_HEURISTICS)
@pytest.mark.parametrize("values", VALUE_HEURISTICS)
def test_every_order_finds_a_solution_where_there_is_one(name: str, values: str) -> None:
    """Whatever the order, a search that is complete decides alike."""
    for seed in range(60):
        small = Small(random.Random(seed))
        assert _search(small, name, values) == bool(small.solutions())


def _search(small: Small, name: str, values: str) -> bool:
    try:
        small.network.propagate()
    except Inconsistency:
        return False
    variable = VARIABLE_HEURISTICS[name](small.variables)
    if variable is None:
        return True
    for value in VALUE_HEURISTICS[values](variable):
        depth = small.trail.push()
        small.network.restrict(variable, Interval(value, value), "choice")
        if _search(small, name, values):
            small.trail.pop_to(depth)
            return True
        small.trail.pop_to(depth)
    return False
