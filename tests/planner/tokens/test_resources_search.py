"""Search over small resource problems against every schedule: a plan when there is one, with good ones only."""

from __future__ import annotations

import itertools
import random
from collections import Counter

import pytest

from planner.constraints.network import Inconsistency
from planner.search.engines import ENGINES
from planner.search.outcome import Limits
from planner.tokens.resources import Clash
from tests.planner.tokens.resource_cases import (
    Built,
    Case,
    Move,
    Schedule,
    build,
    empty,
    keeps,
    random_case,
    schedules,
)
from tests.planner.tokens.snapshot import snapshot

LIMITS = Limits(max_steps=3000, max_seconds=60)


def judged(seed: int, engine: str) -> str:
    """What the search makes of a random case: `plan` or `none`, both rightly; else what is wrong."""
    case = random_case(random.Random(seed))
    found = list(schedules(case))
    good = [s for s in found if keeps(case, s)]
    try:
        built = build(case)
    except Inconsistency:
        return "none" if not good else f"{case}: inconsistent, but there is {good[0]}"
    outcome = ENGINES[engine].search(built.database, LIMITS, None, None)
    if not outcome.complete:
        if not outcome.exhausted:
            return f"{case}: gave up"
        return "none" if not good else f"{case}: no plan, but there is {good[0]}"
    left = [s for s in found if allowed(built, s)]
    bad = [s for s in left if not keeps(case, s)]
    if bad or not left:
        return f"{case}: the plan allows {bad[0] if bad else 'nothing'}"
    return "plan"


def allowed(built: Built, schedule: Schedule) -> bool:
    """Whether the plan allows the schedule: quantities, and the distances between all times."""
    temporal = built.database.temporal
    at = {0: 0}
    for token, (start, end, quantity) in zip(built.tokens, schedule, strict=True):
        if quantity not in token.parameters["quantity"].domain:
            return False
        at[token.start.timepoint], at[token.end.timepoint] = start, end
    for a, b in itertools.permutations(at, 2):
        least, most = temporal.distance(a, b)
        if not least <= at[b] - at[a] <= most:
            return False
    return True


@pytest.mark.parametrize("engine", sorted(ENGINES))
def test_a_plan_is_found_exactly_when_there_is_one(engine: str) -> None:
    verdicts = Counter(judged(seed, engine) for seed in range(120))
    assert set(verdicts) == {"plan", "none"}, [v for v in verdicts if ":" in v][:1]
    assert min(verdicts.values()) > 20


def test_a_use_without_length_is_a_way_out() -> None:
    """Two uses that do not fit together and have to overlap, one of which may have no length."""
    moves = (Move("draws", (3, 3), (2, 2), (2, 2)), Move("draws", (3, 3), (3, 3), (0, 1)))
    built = build(Case("Machine", {"capacity": 5}, moves))
    assert ENGINES["chronological"].search(built.database, LIMITS, None, None).complete
    assert built.tokens[1].duration.domain.upper == 0


def test_looks_between_additions_change_nothing() -> None:
    """A resource that was judged after every move says in the end what one judged once says."""
    judged_so = Counter[bool]()
    for seed in range(80):
        case = random_case(random.Random(seed))
        try:
            once, often = build(case), empty(case)
            for number in range(len(case.moves)):
                often.add(number)
                often.resource.clash()
            often.constrain()
            often.database.network.propagate()
        except Inconsistency:
            continue
        assert (once.resource.clash() is None) == (often.resource.clash() is None)
        assert once.resource.envelope() == often.resource.envelope()
        judged_so[once.resource.clash() is None] += 1
    assert min(judged_so[True], judged_so[False]) > 10


def test_undo_is_exact() -> None:
    """After any operations are undone, the database and what is derived of the resource are as before them."""
    for seed in range(40):
        rng = random.Random(seed)
        built = empty(random_case(rng))
        states = []
        database = built.database
        try:
            for number in range(len(built.case.moves)):
                states.append(everything(built))
                database.trail.push()
                built.add(number)
            built.constrain()
            database.network.propagate()
            for _ in range(4):
                clash = built.resource.clash()
                if clash is None or not (remedies := list(clash.remedies())):
                    break
                states.append(everything(built))
                database.trail.push()
                apply(built, remedies[rng.randrange(len(remedies))])
        except Inconsistency:
            pass
        while states:
            database.trail.pop_to(len(states) - 1)
            assert everything(built) == states.pop()


def test_a_transaction_taken_out_leaves_what_the_others_make() -> None:
    """Out of order, with the same level as if it had never been there, and back again by undo."""
    for seed in range(60):
        rng = random.Random(seed)
        case = random_case(rng, limits=False)
        if not list(schedules(case)):
            continue
        gone = rng.randrange(len(case.moves))
        kept = [n for n in range(len(case.moves)) if n != gone]
        built, without = build(case), empty(case)
        for number in kept:
            without.add(number)
        renumbered = {n: without.tokens[k] for k, n in enumerate(kept)}
        for from_, to, least, most in case.distances:
            if gone not in (from_[0], to[0]):
                one, two = renumbered[from_[0]], renumbered[to[0]]
                ends = (one.end if from_[1] else one.start, two.end if to[1] else two.start)
                without.database.network.distance(*ends, least, most, "case")
        without.database.network.propagate()
        if any(gone in (a[0], b[0]) for a, b, _, _ in case.distances):
            continue
        before = built.resource.envelope(), everything(built)
        built.database.trail.push()
        built.resource.remove(built.tokens[gone])
        assert built.resource.envelope() == without.resource.envelope()
        built.database.trail.pop_to(0)
        assert (built.resource.envelope(), everything(built)) == before


def everything(built: Built) -> tuple[object, ...]:
    resource = built.resource
    ledgers = [resource.level, *resource.rates.values()]
    derived = [(len(ledger.events), tuple(ledger.precedence.before), tuple(ledger._safe)) for ledger in ledgers]
    return snapshot(built.database), derived, resource._pruned_at


def apply(built: Built, remedy: object) -> None:
    from planner.search.decisions import Limit, Order
    from planner.tokens.resources import Precede, Within

    if isinstance(remedy, Precede):
        Order(remedy.first, remedy.second, remedy.gap).apply(built.database)
    else:
        assert isinstance(remedy, Within)
        Limit(remedy.variable, remedy.domain).apply(built.database)


def test_a_search_that_fails_leaves_the_database_as_it_was() -> None:
    failed = 0
    for seed in range(80):
        case = random_case(random.Random(seed), decided=True)
        try:
            built = build(case)
        except Inconsistency:
            continue
        before = snapshot(built.database)
        outcome = ENGINES["chronological"].search(built.database, LIMITS, None, None)
        if not outcome.complete:
            failed += 1
            assert snapshot(built.database) == before
    assert failed > 5


def test_remedies_never_depend_on_what_was_looked_at() -> None:
    """Asking twice, or after a look at the envelope, gives the same remedies in the same order."""
    asked = 0
    for seed in range(80):
        case = random_case(random.Random(seed))
        try:
            one, two = build(case), build(case)
        except Inconsistency:
            continue
        two.resource.envelope()
        first, second = told(one.resource.clash()), told(two.resource.clash())
        assert first == second == told(one.resource.clash())
        asked += bool(first)
    assert asked > 20


def told(clash: Clash | None) -> list[str]:
    return [] if clash is None else [repr(clash), *map(repr, clash.remedies())]


def test_random_cases_cover_all_kinds() -> None:
    kinds = Counter(kind for seed in range(120) for kind in random_case(random.Random(seed)).members)
    wanted = {"capacity", "initial", "level_min", "level_max", "production_max", "consumption_max"}
    assert wanted | {"production_rate_max", "consumption_rate_max"} <= set(kinds)
    assert isinstance(random_case(random.Random(0)), Case)
