"""NDDL text to tokens: one regular expression, one pass."""

from __future__ import annotations

import re
from typing import NamedTuple

from planner.language.nddl.errors import Complaint, Position, Report, Source

_PATTERN = re.compile(
    r"""
      (?P<space>[ \t\r\n\f]+|//[^\n]*|/\*.*?\*/)
    | (?P<real>
        (?: [0-9]+\.[0-9]*(?:[eE][+-]?[0-9]+)?[fFdD]?
          | \.[0-9]+(?:[eE][+-]?[0-9]+)?[fFdD]?
          | [0-9]+[eE][+-]?[0-9]+[fFdD]?
          | [0-9]+[fFdD] ) (?![\w.]) )
    | (?P<whole>[0-9]+[lL]?)
    | (?P<name>[A-Za-z_$][A-Za-z_0-9$]*)
    | (?P<text>"(?:[^"\\\n]|\\.)*")
    | (?P<include>\#[ \t]*include)
    | (?P<open>/\*)
    | (?P<mark>::|==|!=|<=|>=|&&|\|\||<:|[-+*/<>=!(){}\[\],;:.?|&])
    | (?P<other>.)
    """,
    re.VERBOSE | re.DOTALL,
)

END = "end"
"""The kind of the token after the last."""


class Lexeme(NamedTuple):
    """A token: its kind (`whole`, `real`, `name`, `text`, `include`, `mark`, `end`), its text and its offset."""

    kind: str
    text: str
    offset: int


def lexemes(source: Source, report: Report) -> list[Lexeme]:
    """The tokens of a text, with an `end` token last; what is no token is complained about and skipped."""
    found: list[Lexeme] = []
    text = source.text
    offset, end = 0, len(source.text)
    while offset < end:
        for match in _PATTERN.finditer(text, offset):
            kind = match.lastgroup
            if kind == "space":
                continue
            if kind in ("other", "open"):
                offset = _skip_unreadable(source, match.start(), report)
                break
            assert kind is not None
            found.append(Lexeme(kind, match.group(), match.start()))
        else:
            break
    found.append(Lexeme(END, "", end))
    return found


def _skip_unreadable(source: Source, offset: int, report: Report) -> int:
    """Complain about what stands at an offset and return where reading can go on."""
    text = source.text
    at = Position(source, offset)
    if text.startswith("/*", offset):
        report.complain(Complaint(at, "this comment is never closed: expected '*/'"))
        return len(text)
    line_end = text.find("\n", offset)
    line_end = len(text) if line_end < 0 else line_end
    if text[offset] == '"':
        report.complain(Complaint(at, "this string is not closed on its line: expected '\"'"))
        return line_end
    if text[offset] == "#":
        word = text[offset:line_end].split()[0]
        message = f"expected '#include \"file\"', found {word!r}: NDDL has no other preprocessor directive"
        report.complain(Complaint(at, message))
        return line_end
    if text[offset] == "'":
        report.complain(Complaint(at, "names of values in single quotes are of NDDL 1: leave the quotes out"))
        return _QUOTED.match(text, offset).end()  # type: ignore[union-attr]
    report.complain(Complaint(at, f"{text[offset]!r} does not belong to the language"))
    return offset + 1


_QUOTED = re.compile(r"'(?:\w*')?")


_ESCAPES = {"b": "\b", "t": "\t", "n": "\n", "f": "\f", "r": "\r", '"': '"', "'": "'", "\\": "\\"}
_ESCAPE = re.compile(r"\\(?:u([0-9a-fA-F]{4})|([0-7]{1,3})|(.))", re.DOTALL)


def unquoted(text: str) -> str:
    """The value of a string literal."""

    def value(match: re.Match[str]) -> str:
        code, octal, letter = match.groups()
        if code is not None:
            return chr(int(code, 16))
        if octal is not None:
            return chr(int(octal, 8))
        return _ESCAPES.get(letter, letter)

    return _ESCAPE.sub(value, text[1:-1])


def quoted(value: str) -> str:
    """The string literal of a value."""
    letters = {v: k for k, v in _ESCAPES.items() if k != "'"}
    return '"' + "".join(f"\\{letters[c]}" if c in letters else c for c in value) + '"'
