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
    assert str(first) == "/".join(one)
    assert (first == second) == (str(first) == str(second))
    assert first == TokenPath.of(str(first))
    assert hash(first) == hash(TokenPath.of(str(first)))
    assert first != str(first)


def test_a_long_path_is_made_compared_and_freed_without_recursion() -> None:
    first, second = (built(["step"] * 100_000) for _ in range(2))
    assert first == second
    assert first != second.then("more")
    assert len(str(first)) == 5 * 100_000 - 1
