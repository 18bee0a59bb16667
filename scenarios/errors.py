"""What the scenario layer raises: `ScenarioError` for bad input, with the file and the field or line in its message."""


class ScenarioError(Exception):
    """A scenario, an option or a run folder is not what it should be."""
