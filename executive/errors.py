"""What the executive raises.

ExecutiveError
    BindingsError   a binding of a domain's predicates that cannot work; says which activity or monitor, and which field
    JournalError    a journal entry that is not plain data, or comes after the journal was closed; a file that is none
    ResumeError     a run that cannot be taken up again, because it does not repeat what its journal says

In flight nothing is raised: whatever goes wrong there is a value (`monitor.Violation`) and has a defined consequence.
"""

from __future__ import annotations


class ExecutiveError(Exception):
    """Anything a user of the executive did that cannot work."""


class BindingsError(ExecutiveError):
    """The bindings are wrong; the message names the activity and the field."""


class JournalError(ExecutiveError):
    """The journal cannot take an entry, or a file is no journal; the message names the event or the line."""


class ResumeError(ExecutiveError):
    """A run flown again departs from its journal; the message says at which line, and both lines."""


class RecordedError(Exception):
    """What a planner raised, in the words of the journal; raised in its place when the run is flown again."""
