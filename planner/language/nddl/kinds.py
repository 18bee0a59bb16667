"""Whether what is compared, added or constrained as a number can be one: what the declared types tell."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from planner.language.nddl.errors import Complaint
from planner.language.nddl.scope import ValueMeaning, VariableMeaning
from planner.language.nddl.syntax import Expression, Name, Text

if TYPE_CHECKING:
    from planner.language.nddl.translator import Translator

_NUMBERS = ("int", "float", "bool")


def check_kinds(translator: Translator, kinds: Sequence[str], arguments: Sequence[Expression]) -> None:
    """A complaint for an argument that is no number where one is expected. `kinds`: the last one repeats."""
    for place, argument in enumerate(arguments):
        if kinds[min(place, len(kinds) - 1)] != "any":
            check_number(translator, argument)


def check_number(translator: Translator, node: Expression) -> None:
    """A complaint for an expression that is declared to be something else than a number or a truth value."""
    if isinstance(node, Text):
        raise Complaint(node.at, f'expected a number, found the text "{node.value}"')
    if not isinstance(node, Name):
        return
    found = translator.scope.meaning(node.path, node.at)
    if isinstance(found, ValueMeaning):
        raise Complaint(node.at, f"expected a number, found {node}, a value of {found.enumeration or 'enumerations'}")
    if isinstance(found, VariableMeaning):
        type_ = translator.symbols.base(found.type)
        if type_ not in _NUMBERS:
            raise Complaint(node.at, f"expected a number, found {node}, which is of type {found.type}")
