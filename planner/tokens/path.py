"""Names of tokens as paths: a statement's name, then the names of the subgoals that lead to the token.

A chain of subgoals may be as long as the plan. So a path is one step and the path before it, compared and hashed
without making its text.
"""

from __future__ import annotations

LONG = 8
"""A path of more steps is not written out for people."""


class TokenPath:
    """`one/2:step0`: a value, whose equality is that of its text. Slashes part the steps, whoever wrote them.

    `str` is for people, who would not read a text as long as a plan: the middle of a long path is left out.
    """

    __slots__ = ("_hash", "_root", "before", "length", "step")

    def __init__(self, before: TokenPath | None, step: str) -> None:
        self.before = before
        self.step = step
        self.length: int = 1 if before is None else before.length + 1
        self._root: TokenPath | None = None if before is None else before._root or before
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

    @property
    def text(self) -> str:
        """The whole path, which `of` reads."""
        return "/".join(self._last(self.length))

    def __str__(self) -> str:
        if self._root is None or self.length <= LONG:
            return self.text
        return "/".join((self._root.step, "...", *self._last(LONG - 2)))

    __repr__ = __str__

    def _last(self, count: int) -> list[str]:
        steps: list[str] = []
        path: TokenPath | None = self
        while path is not None and len(steps) < count:
            steps.append(path.step)
            path = path.before
        return steps[::-1]
