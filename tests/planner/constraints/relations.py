"""What each standard constraint means on assigned variables, written down a second time and plainly.

Each relation has a generator of small scopes, so that brute force can compare. `sets` are the places of arguments
that are read as sets (the relation gets the frozenset of the domain's values there).
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from planner.domains import BOOLEAN, Domain, Interval, Universe


class Part:
    """An object of a tree of parts."""

    def __init__(self, name: str, parent: Part | None = None) -> None:
        self.name = name
        self.parent = parent

    def __repr__(self) -> str:
        return self.name

    def is_under(self, other: Part) -> bool:
        return self.parent is not None and (self.parent is other or self.parent.is_under(other))


def _tree() -> list[Part]:
    root, other = Part("root"), Part("other")
    left, right = Part("left", root), Part("right", root)
    return [root, other, left, right, Part("l1", left), Part("l2", left), Part("r1", right), Part("o1", other)]


TREE = Universe("parts", _tree())
COLOURS = Universe("colours", ("red", "green", "blue", "grey"))
NUMBERS = Universe("numbers", (-3, -2, -1, 0, 1, 2, 3, 4))
OTHER_NUMBERS = Universe("other numbers", (5, 3, 1, 0, -2, 2))

Maker = Callable[[random.Random], Domain]


def subset(universe: Universe) -> Maker:
    def make(rng: random.Random) -> Domain:
        return universe.domain(rng.sample(universe.values, rng.randint(1, min(4, len(universe.values)))))

    return make


def integers(low: int, high: int, width: int = 4) -> Maker:
    def make(rng: random.Random) -> Domain:
        start = rng.randint(low, high)
        return Interval(start, min(high, start + rng.randint(0, width)))

    return make


def either(*makers: Maker) -> Maker:
    return lambda rng: rng.choice(makers)(rng)


BOOL = subset(BOOLEAN)
INTEGER = integers(-4, 6)
SET = either(subset(NUMBERS), subset(OTHER_NUMBERS))
NUMBER = either(INTEGER, SET)
TRUTH = either(BOOL, integers(0, 1, 1), integers(-1, 2))


@dataclass(frozen=True)
class Relation:
    """`kinds`: a scope has one maker for each argument; the last one is repeated up to `repeat` more times."""

    holds: Callable[..., bool]
    kinds: tuple[tuple[Maker, ...], ...]
    repeat: int = 0
    sets: tuple[int, ...] = ()
    # Every value left is used by a solution, on enumerated domains.
    arc_consistent: bool = True
    # Both ends of each interval left are used by a solution.
    bounds_consistent: bool = True

    def scope(self, rng: random.Random) -> list[Domain]:
        makers = list(rng.choice(self.kinds))
        makers += makers[-1:] * rng.randint(0, self.repeat)
        return [make(rng) for make in makers]


def _different(values: tuple[Any, ...]) -> bool:
    return all(a != b for i, a in enumerate(values) for b in values[:i])


def _power(r: int, b: int, e: int) -> bool:
    return not (b == 0 and e < 0) and math.isclose(r, float(b) ** e, abs_tol=1e-9)


def _kinds(*makers: Maker) -> tuple[tuple[Maker, ...], ...]:
    return tuple((m, m) for m in makers)


SAME_KINDS = _kinds(INTEGER, SET, NUMBER, subset(COLOURS), BOOL)
TESTS = tuple((BOOL, m, m) for m in (INTEGER, SET, NUMBER, subset(COLOURS)))
PAIR = ((INTEGER, INTEGER), (NUMBER, NUMBER), (SET, SET))
TRIPLE = ((INTEGER,) * 3, (NUMBER,) * 3, (SET,) * 3)
NUMERIC_TESTS = ((BOOL, INTEGER, INTEGER), (BOOL, NUMBER, NUMBER))

RELATIONS: dict[str, Relation] = {
    "eq": Relation(lambda *x: len(set(x)) == 1, SAME_KINDS, repeat=2),
    "neq": Relation(lambda x, y: x != y, SAME_KINDS),
    "leq": Relation(lambda x, y: x <= y, PAIR),
    "lt": Relation(lambda x, y: x < y, PAIR),
    "withinBounds": Relation(lambda x, y, z: y <= x <= z, TRIPLE),
    "addEq": Relation(lambda x, y, z: x + y == z, TRIPLE),
    "eqSum": Relation(lambda r, *x: r == sum(x), PAIR, repeat=2),
    "mulEq": Relation(lambda x, y, z: x * y == z, TRIPLE, bounds_consistent=False),
    "divEq": Relation(lambda x, y, z: y != 0 and x == z * y, TRIPLE, bounds_consistent=False),
    "eqProduct": Relation(lambda r, *x: r == math.prod(x), PAIR, repeat=2, bounds_consistent=False),
    "neg": Relation(lambda x, y: x == -y, PAIR),
    "absVal": Relation(lambda x, y: x == abs(y), PAIR),
    "diffSquare": Relation(lambda x, y, a: a == (x - y) ** 2, TRIPLE, bounds_consistent=False),
    "distanceSquares": Relation(lambda x, y, a: a >= 0 and a * a == x + y, TRIPLE, bounds_consistent=False),
    "calcDistance": Relation(
        lambda d, x1, y1, x2, y2: d >= 0 and d * d == (x1 - x2) ** 2 + (y1 - y2) ** 2,
        ((integers(0, 6),) + (INTEGER,) * 4, (NUMBER,) * 5),
        arc_consistent=False,
        bounds_consistent=False,
    ),
    "eqMaximum": Relation(lambda r, *x: r == max(x), PAIR, repeat=2),
    "eqMinimum": Relation(lambda r, *x: r == min(x), PAIR, repeat=2),
    "pow": Relation(
        _power,
        ((integers(-30, 70, 40), INTEGER, integers(-2, 4)), (SET, SET, SET), (NUMBER, NUMBER, NUMBER)),
        arc_consistent=False,
        bounds_consistent=False,
    ),
    "sqrt": Relation(
        lambda r, x: r >= 0 and r * r == x,
        ((INTEGER, integers(-3, 30, 9)), (SET, SET), (NUMBER, NUMBER)),
        bounds_consistent=False,
    ),
    "mod": Relation(
        lambda r, x, y: y != 0 and r == x - y * int(x / y), TRIPLE, arc_consistent=False, bounds_consistent=False
    ),
    "floor": Relation(lambda r, x: r == x, PAIR),
    "ceil": Relation(lambda r, x: r == x, PAIR),
    "sin": Relation(
        lambda r, x: -90 <= x <= 90 and math.isclose(r, math.sin(math.radians(x)), abs_tol=1e-9),
        ((integers(-1, 1), lambda rng: Universe("angles", (-120, -90, 0, 30, 90, 180)).domain()),),
        bounds_consistent=False,
    ),
    "rand": Relation(lambda x: 0 <= x <= 32767, ((INTEGER,), (SET,), (integers(32760, 32775, 9),))),
    "or": Relation(lambda *x: any(v != 0 for v in x), ((TRUTH,), (BOOL,)), repeat=3),
    "testEq": Relation(lambda b, x, y: b == (x == y), TESTS),
    "testNeq": Relation(lambda b, x, y: b == (x != y), TESTS),
    "testLeq": Relation(lambda b, x, y: b == (x <= y), NUMERIC_TESTS),
    "testLessThan": Relation(lambda b, x, y: b == (x < y), NUMERIC_TESTS),
    "testAnd": Relation(lambda b, *x: b == all(v != 0 for v in x), ((BOOL, BOOL), (BOOL, TRUTH)), repeat=2),
    "testOr": Relation(lambda b, *x: b == any(v != 0 for v in x), ((BOOL, BOOL), (BOOL, TRUTH)), repeat=2),
    "testNot": Relation(lambda b, x: b == (x == 0), ((BOOL, BOOL), (BOOL, TRUTH))),
    # b says only that x is decided: any assigned x makes it true. Until then b is free, so nothing is claimed.
    "testSingleton": Relation(
        lambda b, x: bool(b), ((BOOL, INTEGER), (BOOL, subset(COLOURS))), arc_consistent=False, bounds_consistent=False
    ),
    "countZeroes": Relation(
        lambda n, *x: n == sum(v == 0 for v in x), ((integers(-1, 4), TRUTH), (SET, BOOL)), repeat=3
    ),
    "countNonZeroes": Relation(
        lambda n, *x: n == sum(v != 0 for v in x), ((integers(-1, 4), TRUTH), (SET, BOOL)), repeat=3
    ),
    "allDiff": Relation(lambda *x: _different(x), SAME_KINDS, repeat=3),
    "condEq": Relation(lambda b, *x: b == (len(set(x)) == 1), TESTS, repeat=2),
    "condAllDiff": Relation(lambda b, *x: b == _different(x), TESTS, repeat=2),
    "subsetOf": Relation(lambda x, allowed: x in allowed, SAME_KINDS, sets=(1,)),
    "eqUnion": Relation(
        lambda *x: len(set(x)) == 1, SAME_KINDS, repeat=2, arc_consistent=False, bounds_consistent=False
    ),
    "memberImply": Relation(
        lambda a, b, c, d: a not in b or c in d,
        tuple((m,) * 4 for m in (INTEGER, SET, NUMBER, subset(COLOURS))),
        sets=(1, 3),
    ),
    "hasAncestor": Relation(lambda x, r: x.is_under(r), ((subset(TREE), subset(TREE)),)),
    "commonAncestor": Relation(lambda x, y, r: x.is_under(r) and y.is_under(r), ((subset(TREE),) * 3,)),
}
SYNONYMS = {
    "concurrent": "eq",
    "precedes": "leq",
    "strictlyPrecedes": "lt",
    "temporalDistance": "addEq",
    "multEq": "mulEq",
    "abs": "absVal",
    "max": "eqMaximum",
    "min": "eqMinimum",
    "testSpecified": "testSingleton",
}
RELATIONS |= {name: RELATIONS[meaning] for name, meaning in SYNONYMS.items()}
