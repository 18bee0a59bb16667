"""What the scenario layer raises, with the file and the field or line in its message.

ScenarioError
    RunBrokenError   not bad input: the machine could not keep what a run writes (a full disk)
"""


class ScenarioError(Exception):
    """A scenario, an option or a run folder is not what it should be."""


class RunBrokenError(ScenarioError):
    """A file of a run could not be written, which ended the run; the message says which, why and when."""
