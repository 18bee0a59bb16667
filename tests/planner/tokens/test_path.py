"""Paths of tokens are values, equal where their texts are."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from planner.tokens.path import TokenPath

texts = st.text(alphabet="ab/:", max_size=8)


def built(parts: list[str]) -> TokenPath:
    path = TokenPath.of(parts[0])
    for part in parts[1:]:
        path = path.then(part)
    return path


@given(st.lists(texts, min_size=1, max_size=4), st.lists(texts, min_size=1, max_size=4))
def test_paths_are_equal_where_their_texts_are(one: list[str], two: list[str]) -> None:
    first, second = built(one), built(two)
    assert first.text == "/".join(one)
    assert (first == second) == (first.text == second.text)
    assert first == TokenPath.of(first.text)
    assert hash(first) == hash(TokenPath.of(first.text))
    assert first != first.text


def test_a_long_path_is_made_compared_and_freed_without_recursion() -> None:
    first, second = (built(["step"] * 100_000) for _ in range(2))
    assert first == second
    assert first != second.then("more")
    assert len(first.text) == 5 * 100_000 - 1


def test_people_see_both_ends_of_a_long_path() -> None:
    assert str(built(list("abcdefgh"))) == "a/b/c/d/e/f/g/h"
    assert str(built(list("abcdefghi"))) == "a/.../d/e/f/g/h/i"
