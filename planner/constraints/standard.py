"""The standard registry: the constraint names of NDDL, case as written there, and what a front end's expressions need.

The meaning of each is the first line of its narrowing's docstring; two names for one relation share the narrowing. A
function's first argument is its result. `uses` is not here: it posts a transaction on a resource, which is the business
of the resources, not a relation between variables.
"""

from __future__ import annotations

from collections.abc import Iterator

from planner.constraints import arithmetic, equality, functions, hierarchy, logic, sets
from planner.constraints.procedure import ConstraintProcedure, Narrowing, ProcedureRegistry

ANY = ("any",)
NUMERIC = ("numeric",)
TEST = ("boolean", "any")
NUMERIC_TEST = ("boolean", "numeric")

# names, narrowing, fewest arguments, most (None: any number), kinds
_TABLE: tuple[tuple[str, Narrowing, int, int | None, tuple[str, ...]], ...] = (
    ("eq concurrent", equality.eq, 2, None, ANY),
    ("neq", equality.neq, 2, 2, ANY),
    ("leq precedes", equality.leq, 2, 2, NUMERIC),
    ("lt strictlyPrecedes", equality.lt, 2, 2, NUMERIC),
    ("withinBounds", equality.within_bounds, 3, 3, NUMERIC),
    ("addEq temporalDistance", arithmetic.add_eq, 3, 3, NUMERIC),
    ("eqSum", arithmetic.eq_sum, 2, None, NUMERIC),
    ("mulEq multEq", arithmetic.mul_eq, 3, 3, NUMERIC),
    ("divEq", arithmetic.div_eq, 3, 3, NUMERIC),
    ("eqProduct", arithmetic.eq_product, 2, None, NUMERIC),
    ("neg", arithmetic.neg, 2, 2, NUMERIC),
    ("absVal abs", arithmetic.abs_val, 2, 2, NUMERIC),
    ("diffSquare", arithmetic.diff_square, 3, 3, NUMERIC),
    ("distanceSquares", arithmetic.distance_squares, 3, 3, NUMERIC),
    ("calcDistance", arithmetic.calc_distance, 5, 5, NUMERIC),
    ("eqMaximum max", functions.eq_maximum, 2, None, NUMERIC),
    ("eqMinimum min", functions.eq_minimum, 2, None, NUMERIC),
    ("pow", functions.power, 3, 3, NUMERIC),
    ("sqrt", functions.sqrt, 2, 2, NUMERIC),
    ("mod", functions.mod, 3, 3, NUMERIC),
    ("floor", functions.floor, 2, 2, NUMERIC),
    ("ceil", functions.ceil, 2, 2, NUMERIC),
    ("sin", functions.sin, 2, 2, NUMERIC),
    ("rand", functions.rand, 1, 1, NUMERIC),
    ("or", logic.any_true, 1, None, ANY),
    ("testEq", logic.test_eq, 3, 3, TEST),
    ("testNeq", logic.test_neq, 3, 3, TEST),
    ("testLeq", logic.test_leq, 3, 3, NUMERIC_TEST),
    ("testLessThan", logic.test_less_than, 3, 3, NUMERIC_TEST),
    ("testAnd", logic.test_and, 2, None, TEST),
    ("testOr", logic.test_or, 2, None, TEST),
    ("testNot", logic.test_not, 2, 2, TEST),
    ("testSingleton testSpecified", logic.test_singleton, 2, 2, TEST),
    ("countZeroes", logic.count_zeroes, 2, None, ("numeric", "any")),
    ("countNonZeroes", logic.count_non_zeroes, 2, None, ("numeric", "any")),
    ("allDiff", sets.all_diff, 2, None, ANY),
    ("condEq", sets.cond_eq, 3, None, TEST),
    ("condAllDiff", sets.cond_all_diff, 3, None, TEST),
    ("subsetOf", sets.subset_of, 2, 2, ANY),
    ("eqUnion", sets.eq_union, 2, None, ANY),
    ("memberImply", sets.member_imply, 4, 4, ANY),
    ("hasAncestor", hierarchy.has_ancestor, 2, 2, ANY),
    ("commonAncestor", hierarchy.common_ancestor, 3, 3, ANY),
)


def _procedures() -> Iterator[ConstraintProcedure]:
    for names, narrow, minimum, maximum, kinds in _TABLE:
        for name in names.split():
            yield ConstraintProcedure(name, narrow, minimum, maximum, kinds)


STANDARD = ProcedureRegistry({procedure.name: procedure for procedure in _procedures()})
EQUAL = STANDARD.get("eq")
