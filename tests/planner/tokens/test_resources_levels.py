"""Levels against every schedule: the envelope is exact, the first violation is one, pruning takes nothing away."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator

from planner.constraints.network import Inconsistency
from tests.planner.tokens.resource_cases import (
    HORIZON,
    Built,
    Case,
    Schedule,
    build,
    keeps,
    level,
    random_case,
    schedules,
)

TICKS = range(HORIZON[0] - 1, HORIZON[1] + 2)


def cases(count: int, limits: bool) -> Iterator[tuple[Case, list[Schedule], Built]]:
    for seed in range(count):
        case = random_case(random.Random(seed), limits=limits)
        found = list(schedules(case))
        if not found:
            continue
        try:
            yield case, found, build(case)
        except Inconsistency:
            assert limits
            assert not any(keeps(case, s) for s in found), case


def test_the_envelope_is_what_schedules_reach() -> None:
    seen = wide = 0
    for case, found, built in cases(250, limits=False):
        bands = built.resource.envelope()
        for tick in TICKS:
            levels = [level(case, s, tick) for s in found]
            band = [b for b in bands if b.start <= tick][-1]
            assert (band.lowest, band.highest) == (min(levels), max(levels)), (case, tick)
            wide += band.lowest < band.highest
        seen += 1
    assert seen > 150
    assert wide > 200


def test_the_envelope_follows_later_constraints() -> None:
    """What is known about the order of events goes on being right when more constraints come, and when they go."""
    for seed in range(60):
        rng = random.Random(seed)
        case = random_case(rng, limits=False)
        if not list(schedules(case)):
            continue
        built = build(case)
        database = built.database
        before = built.resource.envelope()
        pairs = (rng.sample(range(len(case.moves)), 2) for _ in range(2))
        more = tuple(((a, False), (b, False), float(rng.randint(0, 1)), math.inf) for a, b in pairs)
        tighter = Case(case.cls, case.members, case.moves, case.distances + more)
        found = list(schedules(tighter))
        database.trail.push()
        for from_, to, least, most in more:
            database.network.distance(built.point(from_), built.point(to), least, most, "more")
        try:
            database.network.propagate()
            bands = built.resource.envelope()
            for tick in TICKS:
                levels = [level(tighter, s, tick) for s in found]
                band = [b for b in bands if b.start <= tick][-1]
                assert (band.lowest, band.highest) == (min(levels), max(levels)), (tighter, tick)
        except Inconsistency:
            assert not found
        database.trail.pop_to(0)
        assert built.resource.envelope() == before


def test_the_grounded_profile_is_the_earliest_schedule() -> None:
    for case, found, built in cases(150, limits=False):
        earliest = [(min(s[n][0] for s in found), min(s[n][1] for s in found)) for n in range(len(case.moves))]
        runs = [s for s in found if [(a, b) for a, b, _ in s] == earliest]
        bands = built.resource.grounded()
        for tick in TICKS:
            levels = [level(case, s, tick) for s in runs]
            band = [b for b in bands if b.start <= tick][-1]
            assert (band.lowest, band.highest) == (min(levels), max(levels)), (case, tick)


def test_a_clash_is_found_exactly_when_some_schedule_commits_it() -> None:
    verdicts = set()
    for case, found, built in cases(250, limits=True):
        left = [s for s in found if allowed(built, s)]
        broken = not all(keeps(case, s) for s in left)
        assert (built.resource.clash() is not None) == broken, case
        verdicts.add(broken)
    assert verdicts == {True, False}


def test_pruning_keeps_every_schedule_that_keeps_the_limits() -> None:
    pruned = 0
    for case, found, built in cases(250, limits=True):
        for schedule in found:
            assert not keeps(case, schedule) or allowed(built, schedule), (case, schedule)
            pruned += not allowed(built, schedule)
    assert pruned > 150


def allowed(built: Built, schedule: Schedule) -> bool:
    """Whether the schedule is within all bounds of the database."""
    return all(
        start in token.start.domain and end in token.end.domain and quantity in token.parameters["quantity"].domain
        for token, (start, end, quantity) in zip(built.tokens, schedule, strict=True)
    )
