"""Which constraint procedures the operators, functions and tests of NDDL are, and other names that procedures have.

The headers of EUROPA register most constraints under several names, some of them older than NDDL; models use them.
"""

from __future__ import annotations

SINGLETON_TESTS = ("isSingleton", "isSpecified")
RESULT_LAST = {"+": "addEq", "*": "mulEq", "/": "divEq"}
FUNCTIONS = {"max": "eqMaximum", "min": "eqMinimum"} | {
    name: name for name in ("abs", "pow", "sqrt", "mod", "floor", "ceil", "rand", "sin")
}
COMPARISONS = {"==": "eq", "!=": "neq", "<": "lt", "<=": "leq", ">": "lt", ">=": "leq"}
TESTS = {"==": "testEq", "!=": "testNeq", "<": "testLessThan", "<=": "testLeq", ">": "testLessThan", ">=": "testLeq"}
MIRRORED = (">", ">=")
_OTHER_NAMES = {
    "eq": "Equal asame fasame",
    "neq": "NotEqual",
    "leq": "LessThanEqual",
    "lt": "LessThan lessThan",
    "addEq": "AddEqual",
    "mulEq": "MultEqual",
    "allDiff": "AllDiff adiff fadiff fneq",
    "condAllDiff": "CondAllDiff",
    "condEq": "CondAllSame condasame",
    "countNonZeroes": "CountNonZeros countNonZeros cardeq",
    "countZeroes": "CountZeros countZeros",
    "eqMaximum": "EqualMaximum fallmax",
    "eqMinimum": "EqualMinimum fallmin",
    "eqProduct": "EqualProduct product",
    "eqSum": "EqualSum sum",
    "memberImply": "MemberImply",
    "or": "Or for",
    "subsetOf": "SubsetOf Singleton",
    "temporalDistance": "temporaldistance",
    "testEq": "TestEqual testEQ",
    "testNeq": "testNEQ",
    "testLeq": "testLEQ condleq",
    "testLessThan": "TestLessThan condlt",
    "testAnd": "testAND",
    "testOr": "testOR",
    "withinBounds": "WithinBounds",
}
ALIASES = {other: name for name, others in _OTHER_NAMES.items() for other in others.split()}
"""The name by which a procedure is known here, for each other name that it has."""
