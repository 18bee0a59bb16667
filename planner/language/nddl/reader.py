"""A cursor over the tokens of a text, with complaints that say what was expected and what was found."""

from __future__ import annotations

from planner.language.nddl.errors import Complaint, Position, Report, Source
from planner.language.nddl.lexer import END, Lexeme, lexemes

MAX_DEPTH = 60
"""Nested blocks and brackets beyond this are refused."""
MAX_OPERATORS = 200
"""Operators of one statement beyond this are refused: trees stay shallow enough for plain recursion."""


class Reader:
    """The tokens of a text and a place among them."""

    __slots__ = ("depth", "index", "lexeme", "operators", "report", "source", "tokens")

    def __init__(self, source: Source, report: Report) -> None:
        self.source = source
        self.report = report
        self.tokens = lexemes(source, report)
        self.index = 0
        self.depth = 0
        self.operators = 0
        self.lexeme = self.tokens[0]

    def at(self) -> Position:
        """Where the present token stands."""
        return Position(self.source, self.lexeme.offset)

    def advance(self) -> Lexeme:
        """Take the present token."""
        taken = self.lexeme
        if taken.kind != END:
            self.index += 1
            self.lexeme = self.tokens[self.index]
        return taken

    def ahead(self, count: int = 1) -> Lexeme:
        """The token that many places on."""
        return self.tokens[min(self.index + count, len(self.tokens) - 1)]

    def sees(self, text: str) -> bool:
        """Whether the present token is that mark or word (a string literal never is)."""
        return self.lexeme.text == text and self.lexeme.kind != "text"

    def accept(self, text: str) -> bool:
        """Take that mark or word if it is the present token."""
        if self.lexeme.text == text and self.lexeme.kind != "text":
            self.advance()
            return True
        return False

    def expect(self, text: str, why: str = "") -> Lexeme:
        """Take that mark or word; a complaint otherwise."""
        if not self.sees(text):
            raise self.unexpected(f"'{text}'{why}")
        return self.advance()

    def name(self, what: str) -> str:
        """Take a name; a complaint otherwise."""
        if self.lexeme.kind != "name":
            raise self.unexpected(what)
        return self.advance().text

    def path(self, what: str) -> tuple[str, ...]:
        """Take `a.b.c`."""
        names = [self.name(what)]
        while self.sees("."):
            self.advance()
            names.append(self.name("a name after '.'"))
        return tuple(names)

    def unexpected(self, expected: str) -> Complaint:
        """The complaint that something else than this stands here."""
        return Complaint(self.at(), f"expected {expected}, found {self.found()}")

    def found(self) -> str:
        """The present token for a message."""
        return "the end of the file" if self.lexeme.kind == END else f"'{self.lexeme.text[:40]}'"

    def enter(self) -> None:
        """Go one level deeper; a complaint when that is too deep. `leave` comes in a `finally`."""
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise Complaint(self.at(), f"nested too deeply: more than {MAX_DEPTH} levels")

    def leave(self) -> None:
        """Come back from a level."""
        self.depth -= 1

    def count_operator(self) -> None:
        """One more operator in this statement; a complaint when that is too many."""
        self.operators += 1
        if self.operators > MAX_OPERATORS:
            raise Complaint(self.at(), f"expression too long: more than {MAX_OPERATORS} operators in one statement")

    def skip_statement(self, started: int) -> None:
        """After a complaint: go to the end of the statement that started at that token, and past a `;` or a block."""
        depth = 0
        first = self.index
        self.index = max(started, min(self.index, len(self.tokens) - 1))
        # Brackets that the statement opened before the complaint are closed by its rest.
        for token in self.tokens[started:first]:
            depth += (token.text == "{") - (token.text == "}") if token.kind == "mark" else 0
        self.lexeme = self.tokens[self.index]
        while self.lexeme.kind != END:
            text = self.lexeme.text if self.lexeme.kind == "mark" else ""
            if text == "{":
                depth += 1
            elif text == "}":
                if depth <= 0:
                    break
                depth -= 1
            self.advance()
            if depth <= 0 and text in (";", "}"):
                break
        if self.index == started:
            self.advance()
