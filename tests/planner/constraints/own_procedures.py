"""A module of constraint procedures, as a model's author would write one."""

from scenarios.ds1.procedures import turn_duration

TURNS = turn_duration({("a", "b"): (3, 5)})
