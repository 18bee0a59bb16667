"""Every search engine against an exhaustive oracle on small random domains: sound, complete, deterministic."""

from __future__ import annotations

import json
import random
from collections import Counter
from collections.abc import Callable, Iterator

import pytest

from planner.checker import check
from planner.constraints.network import ConstraintNetworkManager, Inconsistency
from planner.constraints.standard import STANDARD
from planner.database import PlanDatabase
from planner.domains import Interval
from planner.extraction import extract
from planner.language.builder import ModelBuilder
from planner.plan import FlexiblePlan
from planner.planning import plan
from planner.search.culprits import Culprits
from planner.search.decisions import Codesignate, Decision, Insert
from planner.search.engines import ENGINES
from planner.search.flaws import OpenToken
from planner.search.outcome import Limits
from planner.tokens.coverage import Coverage
from planner.tokens.instance import GuardInstance
from planner.tokens.token import Token
from tests.planner.search.ground import Oracle, Small, random_small, schedules, violations
from tests.planner.search.ground_models import model_of, problem_of

LIMITS = Limits(max_steps=3000, max_seconds=20)


def solve(small: Small, engine: str = "chronological") -> tuple[FlexiblePlan | None, bool, set[str], bool]:
    """The plan, whether the search space was exhausted, the facts' identifiers, whether tokens stayed open."""
    problem = problem_of(small)
    database = PlanDatabase(model_of(small), problem.horizon)
    try:
        for role, patterns in (("state", problem.state), ("fact", problem.facts)):
            for pattern in patterns:
                database.state(pattern, role, "state" if role == "state" else "fact")
        for goal in problem.goals:
            database.state(goal.token, goal.id, "goal")
        database.network.propagate()
    except Inconsistency:
        return None, True, set(), False
    outcome = ENGINES[engine].search(database, LIMITS, None, None)
    if not outcome.complete:
        return None, outcome.exhausted, set(), False
    found = extract(database)
    slots = [slot for line in found.timelines for slot in line.slots]
    facts = {slot[0] for slot in slots if found.token(slot[0]).fact}
    return found, False, facts, bool(database.tokens.open_tokens)


def disagreements(seeds: range, engine: str = "chronological", keeping: bool = False) -> Iterator[tuple[int, str]]:
    """Every seed with what came of it: agreement by kind, or what is wrong."""
    for seed in seeds:
        small = random_small(random.Random(seed), keeping)
        found, exhausted, facts, still_open = solve(small, engine)
        if found is not None:
            wrong = [v for at in schedules(found) for v in violations(small, found, at, facts)]
            wrong += map(str, check(found, model_of(small)) if keeping else ())
            if still_open:
                yield seed, "open at the boundary"
            elif wrong:
                yield seed, f"WRONG: unsound: {wrong[0]}"
            else:
                yield seed, "solved" if next(schedules(found), None) else "WRONG: a plan without a schedule"
            continue
        verdict = Oracle(small).feasible()
        if not exhausted or verdict is None:
            yield seed, "too large"
        else:
            yield seed, "WRONG: incomplete" if verdict else "impossible"


@pytest.mark.parametrize("engine", ENGINES)
def test_search_against_the_oracle(engine: str) -> None:
    results = list(disagreements(range(350), engine))
    assert not [r for r in results if r[1].startswith("WRONG")]
    counts = Counter(kind for _, kind in results)
    assert counts["solved"] > 80
    assert counts["impossible"] > 60


@pytest.mark.parametrize("engine", ENGINES)
def test_search_with_constraint_tokens_against_the_oracle(engine: str) -> None:
    results = list(disagreements(range(150), engine, keeping=True))
    assert not [r for r in results if r[1].startswith("WRONG")]
    counts = Counter(kind for _, kind in results)
    assert counts["solved"] > 20
    assert counts["impossible"] > 30


def _without(forgotten: Callable[[Decision], bool]) -> Callable[[OpenToken, PlanDatabase], Iterator[Decision]]:
    whole = OpenToken.decisions

    def decisions(flaw: OpenToken, database: PlanDatabase) -> Iterator[Decision]:
        return (d for d in whole(flaw, database) if not forgotten(d))

    return decisions


@pytest.mark.parametrize(
    "forgotten",
    [
        pytest.param(lambda d: isinstance(d, Insert) and d.position == 0, id="first slot"),
        pytest.param(lambda d: isinstance(d, Insert) and d.position > 0, id="later slots"),
        pytest.param(lambda d: isinstance(d, Codesignate), id="hosts"),
    ],
)
def test_a_forgotten_decision_is_seen(monkeypatch: pytest.MonkeyPatch, forgotten: Callable[[Decision], bool]) -> None:
    monkeypatch.setattr(OpenToken, "decisions", _without(forgotten))
    assert any(kind.startswith("WRONG") for _, kind in disagreements(range(200)))


def _first_side(coverage: Coverage) -> Iterator[str]:
    yield next(iter(coverage.side.domain.values()))


@pytest.mark.parametrize(("name", "planted"), [("is_settled", property(lambda _: True)), ("sides", _first_side)])
def test_a_value_astride_forgotten_is_seen(monkeypatch: pytest.MonkeyPatch, name: str, planted: object) -> None:
    monkeypatch.setattr(Coverage, name, planted)
    assert any(kind.startswith("WRONG") for _, kind in disagreements(range(400), keeping=True))


def _guard_ignored(guard: GuardInstance, network: ConstraintNetworkManager) -> None:
    """Never act."""


def test_a_forgotten_guard_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(GuardInstance, "run", _guard_ignored)
    assert any(kind.startswith("WRONG") for _, kind in disagreements(range(200)))


def test_the_same_problem_twice_gives_the_same_plan() -> None:
    for seed in range(40):
        small = random_small(random.Random(seed))
        texts = set()
        for _ in range(2):
            result = plan(model_of(small), problem_of(small))
            texts.add(json.dumps(result.plan.to_json() if result.plan else None))
        assert len(texts) == 1, seed


def test_after_a_failure_the_database_is_as_before() -> None:
    checked = 0
    for seed in range(120):
        small = random_small(random.Random(seed))
        problem = problem_of(small)
        database = PlanDatabase(model_of(small), problem.horizon)
        try:
            for goal in problem.goals:
                database.state(goal.token, goal.id, "goal")
            database.network.propagate()
        except Inconsistency:
            continue
        names = [t.name for t in database.tokens.tokens]
        outcome = ENGINES["chronological"].search(database, LIMITS, None, None)
        if not outcome.complete:
            checked += 1
            assert [t.name for t in database.tokens.tokens] == names
            assert database.trail.depth == 0
            assert all(OpenToken(t).token.state == 0 for t in database.tokens.tokens)
    assert checked > 5


def _only_who_asked(culprits: Culprits, token: Token) -> list[object]:
    return [token.owner]


def _nothing(culprits: Culprits, instance: object) -> list[object]:
    return []


@pytest.mark.parametrize(("name", "careless"), [("_behind_openings", _only_who_asked), ("_behind_instance", _nothing)])
def test_a_jump_too_far_is_seen(
    monkeypatch: pytest.MonkeyPatch, name: str, careless: Callable[..., list[object]]
) -> None:
    monkeypatch.setattr(Culprits, name, careless)
    assert any(kind.startswith("WRONG") for _, kind in disagreements(range(150), "backjumping"))


def test_backjumping_does_not_try_what_is_beside_the_point() -> None:
    """Free variables before an unsatisfiable core: their alternatives cannot help. In the portfolio it is the third."""
    steps = {}
    for engine in ENGINES:
        database = PlanDatabase(ModelBuilder("core", STANDARD).finish(), (0, 1))
        names = [*(f"free{n}" for n in range(8)), "x", "y", "z"]
        variables = {name: database.network.variable(name, Interval(0, 1), name) for name in names}
        for one, other in (("x", "y"), ("y", "z"), ("x", "z")):
            database.tokens.require("neq", (variables[one], variables[other]), "core")
        for variable in variables.values():
            database.tokens.must_be_decided(variable)
        database.network.propagate()
        outcome = ENGINES[engine].search(database, LIMITS, None, None)
        assert outcome.exhausted
        steps[engine] = outcome.steps
    assert (steps["chronological"], steps["backjumping"]) == (1022, 10)
    assert steps["portfolio"] < 600


def test_decisions_are_counted_as_they_are_listed() -> None:
    counted = 0
    for seed in range(60):
        small = random_small(random.Random(seed))
        problem = problem_of(small)
        database = PlanDatabase(model_of(small), problem.horizon)
        try:
            for goal in problem.goals:
                database.state(goal.token, goal.id, "goal")
            for pattern in problem.facts:
                database.state(pattern, "fact", "fact")
            database.network.propagate()
        except Inconsistency:
            continue
        ENGINES["chronological"].search(database, Limits(max_steps=20), None, None)
        for token in database.tokens.open_tokens.values():
            flaw = OpenToken(token)
            assert flaw.count(database) == len(list(flaw.decisions(database)))
            counted += 1
    assert counted > 50


def test_what_does_not_fit_cannot_be_decided(monkeypatch: pytest.MonkeyPatch) -> None:
    """Wherever a search comes, each place that is left out of a token's decisions fails when it is tried."""
    tried = 0
    decisions = OpenToken.decisions

    def watched(flaw: OpenToken, database: PlanDatabase) -> Iterator[Decision]:
        nonlocal tried
        for unfit in flaw.unfit(database):
            tried += 1
            depth = database.trail.push()
            with pytest.raises(Inconsistency):
                unfit.apply(database)
            database.trail.pop_to(depth)
        return decisions(flaw, database)

    monkeypatch.setattr(OpenToken, "decisions", watched)
    for seed in range(250):
        solve(random_small(random.Random(seed)))
    assert tried > 50
