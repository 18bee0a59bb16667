"""Families of NDDL problems that grow with a number N, written out as text.

altern   N tokens in a chain, places and the ways between them, each asked for by the one before
order    N goals, ten a timeline, to be put in order
stn      N tokens in a chain with N/2 further distances; nothing to decide
job      N/4 jobs of four operations in turn, one on each of four timelines
thrash   K variables beside the point, then three that cannot all differ
queens   N queens as a bare constraint problem
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator


def altern(size: int) -> Iterator[str]:
    """The last of the two goals is as late as the chain allows."""
    first, last = 1, 1 + 2 * ((size - 1) // 2)
    yield f"""
enum Place {{north, middle, south}};
class Walker extends Timeline {{
  predicate at {{Place here; eq(duration, 1);}}
  predicate walk {{Place origin, target; eq(duration, 1); neq(origin, target);}}
}}
Walker::at {{met_by(walk came); eq(came.target, here); meets(walk goes); eq(goes.origin, here);}}
Walker::walk {{met_by(at left); eq(left.here, origin); meets(at reached); eq(reached.here, target);}}
PlannerConfig world = new PlannerConfig({first}, {first + size}, 1000000);
Walker walker = new Walker();
close();
goal(walker.at begin); begin.here.specify(south); begin.start.specify({first});
goal(walker.at finish); finish.here.specify(north); finish.start.specify({last});"""


_BENCH = "class Bench extends Timeline {int number; Bench(int n) {number = n;} predicate work {int piece;}}"


def _works(bench: str, name: str, length: int, horizon: int) -> str:
    within = f"leq(0, {name}.start); leq({name}.end, {horizon});"
    return f"goal({bench}.work {name}); eq({name}.duration, {length}); {within} {name}.activate();"


def order(size: int) -> Iterator[str]:
    """Twice the room that ten pieces of work need."""
    lengths = [2 + (3 * piece) % 5 for piece in range(10)]
    horizon = 2 * sum(lengths)
    yield f"{_BENCH}\nPlannerConfig world = new PlannerConfig(0, {horizon}, 1000000);"
    benches = range(max(1, size // 10))
    yield from (f"Bench bench{number} = new Bench({number});" for number in benches)
    yield "close();"
    for number in benches:
        for piece, length in enumerate(lengths):
            yield _works(f"bench{number}", f"work{number}_{piece}", length, horizon)


def stn(size: int) -> Iterator[str]:
    """Distances between tokens up to fifty apart, wide enough to hold together."""
    rng = random.Random(size)
    yield "class Link extends Object {predicate holds {}}"
    yield f"PlannerConfig world = new PlannerConfig(0, {1000 * size}, 1000000);\nLink link = new Link();\nclose();"
    for number in range(size):
        yield f"goal(link.holds h{number}); leq(1, h{number}.duration); leq(h{number}.duration, 12);"
    yield f"leq(0, h0.start); leq(h{size - 1}.end, {1000 * size});"
    yield from (f"h{number} before h{number + 1};" for number in range(size - 1))
    for _ in range(size // 2):
        first = rng.randrange(size - 1)
        second = min(size - 1, first + rng.randint(1, 50))
        yield f"temporalDistance(h{first}.start, [1 {1000 * (second - first)}], h{second}.start);"
    yield from (f"h{number}.activate();" for number in range(size))


def job(size: int) -> Iterator[str]:
    """Four benches, which the jobs visit in turn, each beginning at another."""
    horizon = 10 * size
    yield f"{_BENCH}\nPlannerConfig world = new PlannerConfig(0, {horizon}, 1000000);"
    yield from (f"Bench bench{number} = new Bench({number});" for number in range(4))
    yield "close();"
    for number in range(size // 4):
        for step in range(4):
            length = 1 + (5 * number + 3 * step) % 7
            yield _works(f"bench{(number + step) % 4}", f"work{number}_{step}", length, horizon)
        yield from (f"work{number}_{step} before work{number}_{step + 1};" for step in range(3))


def thrash(size: int) -> Iterator[str]:
    """Going back to the newest decision tries 2 ** K assignments of what is beside the point."""
    yield "typedef int [0 1] Bit;"
    yield from (f"Bit aside{number};" for number in range(size))
    yield "Bit x; Bit y; Bit z; neq(x, y); neq(y, z); neq(x, z);"


def queens(size: int) -> Iterator[str]:
    """A row for each column; no two on a diagonal."""
    yield f"typedef int [0 {size - 1}] Row;"
    yield from (f"Row q{column};" for column in range(size))
    for first in range(size):
        for second in range(first + 1, size):
            pair = f"{first}_{second}"
            yield f"neq(q{first}, q{second}); int up{pair}; int down{pair};"
            yield f"addEq(q{first}, {second - first}, up{pair}); neq(q{second}, up{pair});"
            yield f"addEq(q{second}, {second - first}, down{pair}); neq(q{first}, down{pair});"


FAMILIES: dict[str, Callable[[int], Iterator[str]]] = {
    family.__name__: family for family in (altern, order, stn, job, thrash, queens)
}


def text(family: str, size: int) -> str:
    """The problem of a family's name and a size as one text."""
    return "\n".join(FAMILIES[family](size)) + "\n"
