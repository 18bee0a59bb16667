"""Names of tokens as paths: a statement's name, then the names of the subgoals that lead to the token.

A chain of subgoals may be as long as the plan. So a path is one step and the path before it, compared and hashed
without making its text.
"""

from __future__ import annotations


class TokenPath:
    """`one/2:step0`: a value, whose equality is that of its text. Slashes part the steps, whoever wrote them."""

    __slots__ = ("_hash", "before", "step")

    def __init__(self, before: TokenPath | None, step: str) -> None:
        self.before = before
        self.step = step
        self._hash: int = hash((None if before is None else before._hash, step))

    @classmethod
    def of(cls, text: str) -> TokenPath:
        """The path that a text writes out."""
        first, *rest = text.split("/")
        path = cls(None, first)
        for step in rest:
            path = cls(path, step)
        return path

    def then(self, text: str) -> TokenPath:
        """The path that goes on with a step."""
        path = self
        for step in text.split("/") if "/" in text else (text,):
            path = TokenPath(path, step)
        return path

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, TokenPath):
            return False
        one: TokenPath | None = self
        two: TokenPath | None = other
        while one is not two:
            if one is None or two is None or one.step != two.step:
                return False
            one, two = one.before, two.before
        return True

    def __hash__(self) -> int:
        return self._hash

    def __str__(self) -> str:
        steps = []
        path: TokenPath | None = self
        while path is not None:
            steps.append(path.step)
            path = path.before
        return "/".join(reversed(steps))

    __repr__ = __str__
