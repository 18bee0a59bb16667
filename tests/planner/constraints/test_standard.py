"""Every standard procedure against brute force: sound, exact on assigned variables, as strong as claimed."""

from __future__ import annotations

import itertools
import random
from collections.abc import Sequence
from typing import Any

import pytest

from planner.constraints.procedure import Narrowed
from planner.constraints.standard import STANDARD
from planner.domains import Domain, Interval, Universe, Values
from planner.errors import ModelError
from tests.planner.constraints.relations import COLOURS, RELATIONS, SYNONYMS, Relation

NAMES = STANDARD.names()
ROUNDS = 300


def test_names_of_the_language() -> None:
    expected = """
        eq neq leq lt addEq mulEq multEq neg diffSquare distanceSquares temporalDistance precedes
        strictlyPrecedes concurrent commonAncestor hasAncestor subsetOf absVal divEq allDiff calcDistance
        condAllDiff condEq countNonZeroes countZeroes eqMaximum max eqMinimum min eqProduct eqSum eqUnion
        memberImply or sin withinBounds testEq testNeq testLeq testLessThan testAnd testOr testNot
        testSingleton testSpecified abs pow sqrt mod floor ceil rand
    """
    assert sorted(expected.split()) == list(NAMES)


def test_every_procedure_has_a_relation() -> None:
    assert set(NAMES) == set(RELATIONS)


@pytest.mark.parametrize("name", NAMES)
def test_formula_and_scope(name: str) -> None:
    procedure = STANDARD.get(name)
    assert procedure.name == name
    assert any(sign in procedure.formula for sign in ("=", "<", " is ", "xi", "or", "implies"))
    with pytest.raises(ModelError, match=name):
        procedure.check_scope(procedure.minimum - 1)
    if procedure.maximum is not None:
        with pytest.raises(ModelError, match=name):
            procedure.check_scope(procedure.maximum + 1)


@pytest.mark.parametrize(("name", "meaning"), sorted(SYNONYMS.items()))
def test_synonyms_share_the_narrowing(name: str, meaning: str) -> None:
    assert STANDARD.get(name).narrow is STANDARD.get(meaning).narrow


def scopes(name: str, rounds: int = ROUNDS) -> list[list[Domain]]:
    rng = random.Random(name)
    procedure, relation = STANDARD.get(name), RELATIONS[name]
    found = [relation.scope(rng) for _ in range(rounds)]
    return [s for s in found if len(s) >= procedure.minimum]


def solutions(relation: Relation, domains: Sequence[Domain]) -> list[tuple[Any, ...]]:
    choices = [[frozenset(d.values())] if i in relation.sets else list(d.values()) for i, d in enumerate(domains)]
    return [values for values in itertools.product(*choices) if relation.holds(*values)]


def closed_under(name: str, domains: Sequence[Domain]) -> Narrowed:
    """Applied until nothing changes."""
    narrow = STANDARD.get(name).narrow
    for _ in range(200):
        narrowed = narrow(domains)
        if narrowed is None or all(a is b for a, b in zip(narrowed, domains, strict=True)):
            return narrowed
        domains = narrowed
    raise AssertionError(f"{name} does not settle on {domains}")


@pytest.mark.parametrize("name", NAMES)
def test_no_solution_is_lost(name: str) -> None:
    relation = RELATIONS[name]
    for domains in scopes(name):
        found = solutions(relation, domains)
        narrowed = closed_under(name, domains)
        if not found:
            continue
        assert narrowed is not None, f"{name}{tuple(domains)} has solutions such as {found[0]}"
        for place, (before, after) in enumerate(zip(domains, narrowed, strict=True)):
            assert set(after.values()) <= set(before.values())
            if place in relation.sets:
                assert after is before
                continue
            used = {values[place] for values in found}
            assert used <= set(after.values()), f"{name}{tuple(domains)}: {after} at {place} lost some of {used}"


@pytest.mark.parametrize("name", NAMES)
def test_same_object_where_nothing_changed(name: str) -> None:
    for domains in scopes(name, 100):
        narrowed = STANDARD.get(name).narrow(domains)
        for before, after in zip(domains, narrowed or domains, strict=True):
            assert after is before or after != before
            assert not after.is_empty


@pytest.mark.parametrize("name", NAMES)
def test_decides_assigned_variables(name: str) -> None:
    relation, narrow = RELATIONS[name], STANDARD.get(name).narrow
    rng = random.Random(name)
    for domains in scopes(name):
        points = [_point(d, rng.choice(list(d.values()))) for d in domains]
        holds = bool(solutions(relation, points))
        narrowed = narrow(points)
        assert (narrowed is not None) == holds, f"{name}{tuple(points)} should be {holds}"
        assert narrowed is None or all(a is b for a, b in zip(narrowed, points, strict=True))


def _point(domain: Domain, value: Any) -> Domain:
    return Interval(value, value) if isinstance(domain, Interval) else domain.keep((value,))


@pytest.mark.parametrize("name", [n for n in NAMES if RELATIONS[n].arc_consistent])
def test_enumerated_domains_are_arc_consistent(name: str) -> None:
    relation = RELATIONS[name]
    rounds = 0
    for domains in scopes(name):
        if not all(isinstance(d, Values) for d in domains):
            continue
        rounds += 1
        found = solutions(relation, domains)
        narrowed = closed_under(name, domains)
        if not found:
            assert narrowed is None, f"{name}{tuple(domains)} has no solution, found {narrowed}"
            continue
        assert narrowed is not None
        for place, after in enumerate(narrowed):
            used = {values[place] for values in found}
            assert place in relation.sets or set(after.values()) == used, f"{name}{tuple(domains)}: {narrowed}"
    assert rounds > 0 or name in ("sin", "countZeroes", "countNonZeroes")


@pytest.mark.parametrize("name", [n for n in NAMES if RELATIONS[n].bounds_consistent])
def test_intervals_are_bounds_consistent(name: str) -> None:
    """Each end of an interval is part of a solution in which intervals take any value between their ends."""
    relation = RELATIONS[name]
    for domains in scopes(name):
        narrowed = closed_under(name, domains)
        if narrowed is None or not any(isinstance(d, Interval) for d in narrowed):
            continue
        found = solutions(relation, narrowed)
        for place, after in enumerate(narrowed):
            if isinstance(after, Interval) and place not in relation.sets:
                used = {values[place] for values in found}
                assert {after.lower, after.upper} <= used, f"{name}{tuple(domains)}: {narrowed}"


@pytest.mark.parametrize("name", NAMES)
def test_open_domains_conclude_nothing(name: str) -> None:
    """With a domain opened: it stays, and what is left holds every solution that the domain could get values for."""
    relation = RELATIONS[name]
    rng = random.Random(name)
    opened_rounds = 0
    for domains in scopes(name, 150):
        places = [i for i, d in enumerate(domains) if isinstance(d, Values)]
        if not places:
            continue
        opened_rounds += 1
        place = rng.choice(places)
        before = domains[place]
        assert isinstance(before, Values)
        universe = Universe("open", before.universe.values, is_open=True)
        scope = [*domains[:place], Values(universe, before.bits), *domains[place + 1 :]]
        narrowed = closed_under(name, scope)
        whole = [*domains[:place], before.universe.domain(), *domains[place + 1 :]]
        if place in relation.sets:
            assert narrowed is not None
            assert all(a is b for a, b in zip(narrowed, scope, strict=True))
            continue
        found = solutions(relation, whole)
        assert narrowed is not None or not found, f"{name}{tuple(scope)}"
        for i, after in enumerate(narrowed or ()):
            if i == place:
                assert after is scope[place]
            else:
                assert {values[i] for values in found} <= set(after.values()) or i in relation.sets
    assert opened_rounds > 0 or not any(isinstance(d, Values) for s in scopes(name) for d in s)


@pytest.mark.parametrize("name", NAMES)
def test_all_open_never_fails(name: str) -> None:
    procedure = STANDARD.get(name)
    for values in ((), (1,), (1, 2)):
        universe = Universe("open", values, is_open=True)
        scope = [universe.domain() for _ in range(max(procedure.minimum, 2) if procedure.maximum != 1 else 1)]
        narrowed = procedure.narrow(scope)
        assert narrowed is not None
        assert all(a is b for a, b in zip(narrowed, scope, strict=True))


def test_numbers_are_not_colours() -> None:
    colour, number = COLOURS.domain(("red",)), Interval(0, 5)
    assert STANDARD.get("eq").narrow((colour, number)) is None
    assert STANDARD.get("neq").narrow((colour, number)) == (colour, number)
    narrowed = STANDARD.get("testEq").narrow((Universe("b", (False, True)).domain(), colour, number))
    assert narrowed is not None
    assert list(narrowed[0].values()) == [False]


def test_union_holds_as_sets() -> None:
    universe = Universe("n", range(5))
    a, b, c = universe.domain((1, 2, 3)), universe.domain((1, 4)), universe.domain((2,))
    assert STANDARD.get("eqUnion").narrow((a, b, c)) == [universe.domain((1, 2)), universe.domain((1,)), c]


def test_guard_waits_for_the_singleton() -> None:
    b, x = Universe("b", (False, True)).domain(), Interval(0, 3)
    narrow = STANDARD.get("testSingleton").narrow
    assert narrow((b, x)) == (b, x)
    narrowed = narrow((b, Interval(2, 2)))
    assert narrowed is not None
    assert list(narrowed[0].values()) == [True]
