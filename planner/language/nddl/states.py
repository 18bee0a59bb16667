"""What a rule says about the state of a token that it asks for: `eq(t.state, ACTIVE)`, or `t.state == ACTIVE`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from planner.language.nddl.errors import Complaint, Position
from planner.language.nddl.scope import Scope, StateMeaning
from planner.language.nddl.syntax import Expression, Name
from planner.model import rules

STATES = ("INACTIVE", "ACTIVE", "MERGED", "REJECTED")


def state_said(scope: Scope, arguments: Sequence[Expression]) -> tuple[StateMeaning, str] | None:
    """The token's state and the value of it that an equality speaks of; None when it is about something else."""
    if len(arguments) != 2:
        return None
    names = [a for a in arguments if isinstance(a, Name)]
    values = [a.path[0] for a in names if len(a.path) == 1 and a.path[0] in STATES]
    others = [a for a in names if a.path[-1] == "state"]
    if len(values) != 1 or len(others) != 1:
        return None
    found = scope.meaning(others[0].path, others[0].at)
    return (found, values[0]) if isinstance(found, StateMeaning) else None


def keep_active(out: list[rules.Statement], said: tuple[StateMeaning, str], at: Position) -> None:
    """Let the subgoal among these statements whose state is said to be ACTIVE stand alone.

    A rule applies to active tokens, so of its own token there is nothing to say.
    """
    (meaning, state), path = said, said[0].token.ref.path
    if state != "ACTIVE":
        raise Complaint(at, f"a rule can ask for a token that is ACTIVE, not for one that is {state}", True)
    if path in ((), ("this",)):
        return
    for place, statement in enumerate(out):
        if isinstance(statement, rules.Subgoal) and (statement.name,) == path:
            out[place] = replace(statement, solitary=True)
            return
    raise Complaint(at, f"say beside the subgoal {meaning.token.ref!r} that it is ACTIVE, not inside of a guard", True)
