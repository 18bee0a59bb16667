"""Standard procedures on real and unbounded intervals: sampled solutions stay, assigned reals decide, no NaN."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planner.constraints.standard import STANDARD
from planner.domains import BOOLEAN, REAL_RESOLUTION, Domain, Interval, Number, Universe, Values

INF = math.inf
QUICK = settings(derandomize=True, max_examples=30, deadline=None)
BRIEF = settings(derandomize=True, max_examples=25, deadline=None)

reals = st.one_of(
    st.floats(-100, 100).map(lambda v: round(v, 3)),
    st.floats(-1e6, 1e6),
    st.sampled_from([0.0, 1.0, -1.0, 0.1, 0.3, 1e-3, 90.0, -90.0]),
)
moderate = st.floats(-50, 50).map(lambda v: round(v, 4))
positive = st.floats(0.01, 50)


def _safe(value: float) -> float | None:
    return value if math.isfinite(value) else None


# A function gives the argument that the others determine: name -> (place, strategies of the others, function).
FUNCTIONS: dict[str, tuple[int, tuple[st.SearchStrategy[float], ...], Callable[..., float | None]]] = {
    "eq": (1, (reals,), lambda x: x),
    "addEq": (2, (reals, reals), lambda x, y: x + y),
    "eqSum": (0, (reals, reals, reals), lambda *x: sum(x)),
    "mulEq": (2, (reals, reals), lambda x, y: x * y),
    "divEq": (2, (moderate, positive), lambda x, y: x / y),
    "eqProduct": (0, (moderate, moderate, moderate), lambda *x: math.prod(x)),
    "neg": (1, (reals,), lambda x: -x),
    "absVal": (0, (reals,), abs),
    "diffSquare": (2, (moderate, moderate), lambda x, y: (x - y) ** 2),
    "distanceSquares": (2, (positive, positive), lambda x, y: math.sqrt(x + y)),
    "calcDistance": (0, (moderate,) * 4, lambda a, b, c, d: math.hypot(a - c, b - d)),
    "eqMaximum": (0, (reals, reals, reals), max),
    "eqMinimum": (0, (reals, reals, reals), min),
    "pow": (0, (positive, st.floats(-3, 3)), lambda b, e: b**e),
    "sqrt": (0, (positive,), math.sqrt),
    "floor": (0, (moderate,), math.floor),
    "ceil": (0, (moderate,), math.ceil),
    "sin": (0, (st.floats(-90, 90),), lambda x: math.sin(math.radians(x))),
}
NAMES = sorted(FUNCTIONS)


def _solution(data: st.DataObject, name: str) -> list[float]:
    place, strategies, function = FUNCTIONS[name]
    values = [data.draw(s) for s in strategies]
    result = function(*values)
    assert result is not None
    values.insert(place, float(result))
    return values


def _around(data: st.DataObject, value: float) -> Domain:
    """A numeric domain that has the value: a real interval, often with the value at an end, or an enumeration."""
    below, above = (data.draw(st.sampled_from([0.0, 0.0, 0.5, 3.0, INF])) for _ in range(2))
    if value == round(value) and data.draw(st.booleans()):
        return Interval(value - below, value + above)
    if data.draw(st.integers(0, 4)) == 0:
        return Universe("n", {value, value + 1, value - 2.5}).domain()
    return Interval(value - below, value + above, integer=False)


@pytest.mark.parametrize("name", NAMES)
@given(data=st.data())
@QUICK
def test_sampled_solutions_stay(name: str, data: st.DataObject) -> None:
    values = _solution(data, name)
    domains: Sequence[Domain] = [_around(data, v) for v in values]
    narrow = STANDARD.get(name).narrow
    for _ in range(4):
        narrowed = narrow(domains)
        assert narrowed is not None, f"{name}{tuple(domains)} lost {values}"
        for before, after, value in zip(domains, narrowed, values, strict=True):
            assert value in after, f"{name}{tuple(domains)}: {after} lost {value}"
            assert before.lower <= after.lower
            assert after.upper <= before.upper
        domains = narrowed


@pytest.mark.parametrize("name", NAMES)
@given(data=st.data())
@QUICK
def test_assigned_reals_decide(name: str, data: st.DataObject) -> None:
    values = _solution(data, name)
    narrow = STANDARD.get(name).narrow
    points: list[Domain] = [Interval(v, v, integer=False) for v in values]
    narrowed = narrow(points)
    assert narrowed is not None, f"{name}{tuple(values)}"
    assert all(d.is_singleton for d in narrowed)
    place = FUNCTIONS[name][0]
    wrong = values[place] + data.draw(st.sampled_from([-1, 1])) * 1e-4 * max(1.0, abs(values[place]))
    points[place] = Interval(wrong, wrong, integer=False)
    assert narrow(points) is None, f"{name}{tuple(values)} with {wrong}"


@pytest.mark.parametrize("name", NAMES)
@given(data=st.data())
@QUICK
def test_result_is_determined_by_the_rest(name: str, data: st.DataObject) -> None:
    values = _solution(data, name)
    place = FUNCTIONS[name][0]
    points: list[Domain] = [Interval(v, v, integer=False) for v in values]
    points[place] = Interval(-INF, INF, integer=False)
    narrowed = STANDARD.get(name).narrow(points)
    assert narrowed is not None
    width = narrowed[place].upper - narrowed[place].lower
    assert width <= REAL_RESOLUTION * max(1.0, *map(abs, values)), f"{name}: {narrowed}"
    assert values[place] in narrowed[place]


ENDS = st.sampled_from([-INF, -7, -2.5, -1, 0, 0.0, 1e-12, 0.5, 1, 3, 12, 1e300, INF])


@st.composite
def wide(draw: st.DrawFn) -> Domain:
    low, high = sorted((draw(ENDS), draw(ENDS)))
    integer = draw(st.booleans())
    found = Interval(low, high, integer)
    return Interval(low, INF, integer) if found.is_empty else found


@pytest.mark.parametrize("name", [n for n in STANDARD.names() if "Ancestor" not in n])
@given(data=st.data())
@BRIEF
def test_any_ends_give_numbers(name: str, data: st.DataObject) -> None:
    """Infinite, huge and tiny ends: narrower intervals or None, never NaN, never an error."""
    procedure = STANDARD.get(name)
    count = procedure.maximum or procedure.minimum + data.draw(st.integers(0, 2))
    first: Domain = BOOLEAN.domain() if procedure.kinds[0] == "boolean" else data.draw(wide())
    domains: Sequence[Domain] = [first, *(data.draw(wide()) for _ in range(count - 1))]
    for _ in range(3):
        narrowed = procedure.narrow(domains)
        if narrowed is None:
            return
        for before, after in zip(domains, narrowed, strict=True):
            if isinstance(before, Interval):
                assert isinstance(after, Interval)
                assert before.lower <= after.lower <= after.upper <= before.upper
        domains = narrowed


def _narrow(name: str, *domains: Domain) -> Any:
    return STANDARD.get(name).narrow(domains)


def _real(lower: Number, upper: Number) -> Interval:
    return Interval(lower, upper, integer=False)


KNOWN: list[tuple[str, list[Domain], list[tuple[Number, Number]]]] = [
    ("addEq", [_real(1, 2), _real(10, 20), _real(0, 15)], [(1, 2), (10, 14), (11, 15)]),
    ("temporalDistance", [Interval(0, 100), Interval(5, INF), Interval(0, 20)], [(0, 15), (5, 20), (5, 20)]),
    ("eqSum", [_real(10, 10), Interval(0, 4), Interval(0, 3), Interval(0, INF)], [(10, 10), (0, 4), (0, 3), (3, 10)]),
    ("mulEq", [Interval(-INF, INF), Interval(2, 3), Interval(5, 9)], [(2, 4), (2, 3), (5, 9)]),
    ("mulEq", [_real(-INF, INF), _real(0, 2), _real(4, 8)], [(2, INF), (0, 2), (4, 8)]),
    ("mulEq", [_real(-INF, INF), _real(-2, 0), _real(4, 8)], [(-INF, -2), (-2, 0), (4, 8)]),
    ("divEq", [_real(1, 10), _real(0, 2), _real(-INF, INF)], [(1, 10), (0, 2), (0.5, INF)]),
    ("absVal", [Interval(3, 5), Interval(-4, 9)], [(3, 5), (-4, 5)]),
    ("sqrt", [_real(-INF, INF), _real(-4, 9)], [(0, 3), (0, 9)]),
    ("eqMaximum", [Interval(5, 9), Interval(0, 4), Interval(0, 7)], [(5, 7), (0, 4), (5, 7)]),
    ("eqMinimum", [Interval(-9, 2), Interval(3, 8), Interval(-1, 7)], [(-1, 2), (3, 8), (-1, 2)]),
    ("pow", [_real(8, 27), _real(-INF, INF), Interval(3, 3)], [(8, 27), (2, 3), (3, 3)]),
    ("pow", [_real(-INF, INF), _real(-3, 2), Interval(2, 2)], [(0, 9), (-3, 2), (2, 2)]),
    ("mod", [Interval(-INF, INF), Interval(-INF, INF), Interval(3, 5)], [(-4, 4), (-INF, INF), (3, 5)]),
    ("mod", [Interval(0, INF), Interval(10, 12), Interval(5, 5)], [(0, 2), (10, 12), (5, 5)]),
    ("floor", [Interval(-9, 9), _real(1.5, 3.2)], [(1, 3), (1.5, 3.2)]),
    ("ceil", [Interval(-9, 2), _real(1.5, 3.2)], [(2, 2), (1.5, 2)]),
    ("sin", [_real(0.5, 2), _real(-200, 200)], [(0.5, 1), (30, 90)]),
    ("diffSquare", [_real(0, 0), _real(1, 9), _real(0, 16)], [(0, 0), (1, 4), (1, 16)]),
    ("distanceSquares", [_real(9, 9), _real(0, 100), _real(0, 5)], [(9, 9), (0, 16), (3, 5)]),
    ("calcDistance", [_real(0, 5), *(_real(0, 0),) * 2, _real(3, 3), _real(-9, 9)],
     [(3, 5), (0, 0), (0, 0), (3, 3), (-4, 4)]),
    ("withinBounds", [Interval(0, 10), Interval(2, 12), Interval(-3, 7)], [(2, 7), (2, 7), (2, 7)]),
    ("eq", [Interval(0, 9), _real(1.5, 4.5)], [(2, 4), (2, 4)]),
    ("lt", [Interval(0, 9), _real(1.5, 4.5)], [(0, 4), (1.5, 4.5)]),
    ("lt", [Interval(0, 9), _real(1.5, 4.0)], [(0, 3), (1.5, 4.0)]),
    ("rand", [Interval(-INF, INF)], [(0, 32767)]),
]  # fmt: skip


@pytest.mark.parametrize(("name", "domains", "expected"), KNOWN)
def test_known_bounds(name: str, domains: list[Domain], expected: list[tuple[Number, Number]]) -> None:
    narrowed: Any = domains
    for _ in range(3):
        narrowed = _narrow(name, *narrowed)
        assert narrowed is not None
    for found, (lower, upper) in zip(narrowed, expected, strict=True):
        assert found.lower == pytest.approx(lower, rel=1e-7, abs=1e-7)
        assert found.upper == pytest.approx(upper, rel=1e-7, abs=1e-7)


def test_order_of_reals_to_the_resolution() -> None:
    third, near = _real(1 / 3, 1 / 3), _real(1 / 3 + 1e-13, 1 / 3 + 1e-13)
    assert _narrow("eq", third, near) is not None
    assert _narrow("neq", third, near) is None
    assert _narrow("lt", third, near) is None
    assert _narrow("leq", near, third) is not None


def test_sums_of_decimals_are_exact_enough() -> None:
    total: Any = _real(0, 0)
    tenth = _real(0.1, 0.1)
    for _ in range(1000):
        total = _narrow("addEq", total, tenth, _real(-INF, INF))[2]
    assert _narrow("eq", total, Interval(100, 100)) is not None


def test_cancellation_keeps_the_small_term() -> None:
    large, small = 1e12, 1e-3
    assert _narrow("addEq", _real(large, large), _real(small, small), _real(large + small, large + small)) is not None


def test_halving_settles() -> None:
    """x = x / 2 from a chain of calls reaches its limit to the resolution in few steps."""
    x: Any = _real(0, 1)
    half = _real(0.5, 0.5)
    for _ in range(60):
        before = x
        x = _narrow("mulEq", x, half, x)[2]
        if x is before:
            break
    assert x is before
    assert x.upper < 1e-9


def test_numbers_of_different_kinds_are_equal_by_value() -> None:
    grid = Universe("grid", (0, 0.5, 1, 1.5, 2)).domain()
    other = Universe("other", (2.0, 1.5, 7)).domain()
    narrowed = _narrow("eq", grid, other, _real(0, 1.75))
    assert [list(d.values()) for d in narrowed[:2]] == [[1.5], [1.5]]
    assert (narrowed[2].lower, narrowed[2].upper) == (1.5, 1.5)
    x, y = _narrow("eq", grid, Interval(1, 9))
    assert list(x.values()) == [1, 2]
    assert (y.lower, y.upper) == (1, 2)


def test_many_enumerated_values_still_narrow_by_bounds() -> None:
    wide_range = Universe("wide", range(500)).domain()
    narrowed = _narrow("addEq", wide_range, wide_range, Interval(3, 5))
    assert isinstance(narrowed[0], Values)
    assert list(narrowed[0].values()) == [0, 1, 2, 3, 4, 5]
