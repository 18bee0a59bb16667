"""Random syntax trees, of everything that the grammar has."""

from __future__ import annotations

import math

from hypothesis import strategies as st

from planner.language.nddl import syntax
from planner.language.nddl.printer import render
from planner.model.relations import RELATIONS

names = st.sampled_from(["a", "b", "At", "x1", "from_", "$z", "location", "_p"])
paths = st.lists(names, min_size=1, max_size=3).map(tuple)
whole = st.integers(-(10**12), 10**12).map(syntax.Number)
real = st.floats(-1e9, 1e9, allow_nan=False).map(lambda v: syntax.Number(v, True))
infinite = st.builds(syntax.Number, st.sampled_from([math.inf, -math.inf]), st.booleans())
numbers = whole | real | infinite
texts = st.text(st.characters(codec="utf-8", exclude_categories=["Cs", "Cc"]) | st.sampled_from('\n\t"\\'), max_size=8)
ranges = st.builds(syntax.Range, numbers, numbers | st.builds(syntax.Name, paths))
choices = st.lists(numbers | st.builds(syntax.Name, paths), max_size=3).map(tuple).map(syntax.Choice)
leaves = (
    numbers
    | texts.map(syntax.Text)
    | st.booleans().map(syntax.Truth)
    | st.builds(syntax.Name, paths)
    | ranges
    | choices
)
OPERATORS = ["||", "&&", "==", "!=", "<", "<=", ">", ">=", "+", "-", "*", "/"]


def _unary(operand: st.SearchStrategy[syntax.Expression]) -> st.SearchStrategy[syntax.Unary]:
    # A minus before a number is a number.
    signed = operand.filter(lambda e: not isinstance(e, syntax.Number))
    return st.builds(syntax.Unary, st.just("-"), signed) | st.builds(syntax.Unary, st.just("!"), operand)


expressions: st.SearchStrategy[syntax.Expression] = st.recursive(
    leaves,
    lambda inner: (
        st.builds(syntax.Binary, st.sampled_from(OPERATORS), inner, inner)
        | _unary(inner)
        | st.builds(syntax.Call, names, st.lists(inner, max_size=3).map(tuple))
        | st.builds(syntax.New, names, st.lists(inner, max_size=2).map(tuple))
    ),
    max_leaves=6,
)
arguments = st.lists(expressions, max_size=3).map(tuple)
declarators = st.builds(syntax.Declarator, names, st.none() | expressions)
declarations = st.builds(
    syntax.Declaration, names, st.lists(declarators, min_size=1, max_size=3).map(tuple), st.booleans()
)
subgoals = st.builds(syntax.TokenReference, paths, names, st.sampled_from([None, "condition", "effect"])) | st.builds(
    syntax.TokenReference, paths
)
by_name = st.builds(syntax.TokenReference, st.just(()), names).map(lambda t: (t,))
targets = by_name | st.lists(subgoals, max_size=3).map(tuple)
bounds = st.builds(syntax.Bounds, numbers, numbers)
relations = st.builds(
    syntax.Relation,
    st.none() | names,
    st.sampled_from(sorted(RELATIONS)),
    st.lists(bounds, max_size=2).map(tuple),
    targets,
)
messages = st.none() | texts
simple = (
    declarations
    | relations
    | st.builds(syntax.Assignment, st.builds(syntax.Name, paths), expressions)
    | st.builds(syntax.Constraint, st.builds(syntax.Call, st.sampled_from(["eq", "leq", "f"]), arguments), messages)
    | st.builds(syntax.Requirement, expressions, messages)
    | st.builds(syntax.Goal, st.sampled_from(["goal", "rejectable", "fact"]), targets)
    | st.builds(syntax.Method, paths, st.sampled_from(["specify", "close", "merge"]), arguments)
    | st.builds(syntax.Allocation, st.builds(syntax.New, names, arguments))
    | st.builds(syntax.Super, arguments)
    | st.builds(syntax.Contingent, ranges)
)
allowed = st.builds(syntax.AllowedValue, paths, st.lists(st.tuples(names, expressions), max_size=2).map(tuple))
keeps = st.builds(
    syntax.Keep,
    st.sampled_from(sorted(RELATIONS)),
    st.lists(bounds, max_size=2).map(tuple),
    st.lists(allowed, min_size=1, max_size=3).map(tuple),
)
bodies = st.lists(simple, max_size=3).map(tuple)
statements = st.recursive(
    simple,
    lambda inner: (
        st.builds(
            syntax.If, expressions, st.lists(inner, max_size=2).map(tuple), st.lists(inner, max_size=2).map(tuple)
        )
        | st.builds(syntax.ForEach, names, st.builds(syntax.Name, paths), st.lists(inner, max_size=2).map(tuple))
        | st.lists(st.lists(inner, max_size=2).map(tuple), min_size=2, max_size=3).map(tuple).map(syntax.Either)
        | keeps
    ),
    max_leaves=4,
)
predicates = st.builds(syntax.PredicateDefinition, names, bodies, st.booleans(), st.booleans()).map(
    # an action happens because the plan has it: only a predicate can be exogenous
    lambda p: p if not p.action else syntax.PredicateDefinition(p.name, p.body, True, False)
)
attributes = st.builds(syntax.AttributeDefinition, names, st.lists(predicates, max_size=2).map(tuple))
parameters = st.lists(st.tuples(names, names), max_size=2).map(tuple)


@st.composite
def classes(draw: st.DrawFn) -> syntax.ClassDefinition:
    """A class, or its announcement."""
    name = draw(names)
    if draw(st.booleans()):
        return syntax.ClassDefinition(name, None, None)
    constructors = st.builds(syntax.Constructor, st.just(name), parameters, bodies)
    members = draw(st.lists(declarations | predicates | attributes | constructors, max_size=4))
    return syntax.ClassDefinition(name, draw(st.none() | names), tuple(members))


programs = st.lists(
    statements
    | classes()
    | texts.map(syntax.Include)
    | st.builds(syntax.Enumeration, names, st.lists(names, min_size=1, max_size=3).map(tuple))
    | st.builds(syntax.Typedef, names, ranges | choices, names)
    | st.builds(syntax.RuleDefinition, names, names, st.lists(statements, max_size=3).map(tuple))
    | st.just(syntax.Signature(("constraint", "f", "(", "a", ",", "b", ")", ";"))),
    max_size=4,
).map(tuple)


class Sample:
    """A program that is shown as its text: Hypothesis takes minutes to write such a tree out."""

    def __init__(self, program: tuple[syntax.Statement, ...]) -> None:
        self.program = program
        self.text = render(program)

    def __repr__(self) -> str:
        return self.text


@st.composite
def samples(draw: st.DrawFn) -> Sample:
    """A program with its text."""
    return Sample(draw(programs))
