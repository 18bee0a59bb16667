"""No text ends in anything but a plan, a reason why there is none, or an error of the language."""

from __future__ import annotations

import contextlib
import re

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from planner.errors import PlannerError
from tests.planner.language.nddl.running import EXAMPLES, Run

TEXTS = {path.name: path.read_text(encoding="utf-8") for path in sorted(EXAMPLES.glob("*.nddl"))}
WORDS = [
    *"(){}[];,.:=<>+-*/!&|\"'#\\@",
    "::",
    "class",
    "predicate",
    "if",
    "else",
    "foreach",
    "goal",
    "new",
    "inf",
    "0",
    "eq",
]


def survives(text: str) -> None:
    """Load, carry out and search a little; only the language's own errors may come of it."""
    with contextlib.suppress(PlannerError):
        Run(text, max_steps=20, max_seconds=1.0)


@pytest.mark.parametrize("name", TEXTS)
@settings(max_examples=15, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
@given(cut=st.floats(0, 1))
def test_truncated(name: str, cut: float) -> None:
    survives(TEXTS[name][: int(cut * len(TEXTS[name]))])


@pytest.mark.parametrize("name", TEXTS)
@settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_mutated(name: str, data: st.DataObject) -> None:
    pieces = re.findall(r"\w+|//.*|\s+|[^\w\s]", TEXTS[name])
    places = [n for n, piece in enumerate(pieces) if not piece.isspace() and not piece.startswith("//")]
    for _ in range(data.draw(st.integers(1, 3))):
        place, other = (places[int(data.draw(st.floats(0, 0.9999)) * len(places))] for _ in range(2))
        action = data.draw(st.sampled_from(("drop", "double", "swap", "replace", "take", "take", "misspell")))
        if action == "drop":
            pieces[place] = ""
        elif action == "double":
            pieces[place] *= 2
        elif action == "swap":
            pieces[place], pieces[other] = pieces[other], pieces[place]
        elif action == "replace":
            pieces[place] = data.draw(st.sampled_from(WORDS))
        elif action == "misspell":
            pieces[place] += "x"
        else:
            pieces[place] = pieces[other]
    survives("".join(pieces))


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.text(max_size=60))
def test_any_text(text: str) -> None:
    survives(text)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    st.lists(
        st.sampled_from([*WORDS, "x", "y", "int", "t", "Timeline", "in", "extends", "enum", "typedef"]), max_size=30
    )
)
def test_any_words(words: list[str]) -> None:
    survives(" ".join(words))


@pytest.mark.parametrize(
    "text",
    [
        "(" * 100_000,
        "int x = " + "(" * 5000 + "1" + ")" * 5000 + ";",
        "if (true) " * 5000 + ";",
        "{" * 5000 + "}" * 5000,
        "int x; x == " + "1 + " * 5000 + "1;",
        "int x; x == " + "-" * 5000 + "1;",
        "bool b; b == " + "!" * 5000 + "b;",
        "class A " * 5000,
        "enum E {" + "a, " * 5000,
        "class A { A() { x = new A(); } A x; } A a = new A();",
        "int x; x = 99999999999999999999999999999999;",
        "class A extends B {} class B extends A {} A a = new A();",
        "typedef A [0 1] B; typedef B [0 1] A; A x;",
        'int x = "text"; string s = 5; bool b = 2;',
        "int x = [5 3];",
        "int x = 1 / 0;",
        'x.y.z.specify(1); a(b); "s"; 5; ;;;',
        "PlannerConfig w = new PlannerConfig(5, 5, 1);",
        "PlannerConfig w = new PlannerConfig(-inf, +inf, +inf);",
        "/* never closed",
        '"never closed',
        "\x00\x01\x02",
    ],
)
def test_nasty(text: str) -> None:
    survives(text)
