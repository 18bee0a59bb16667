"""Families of planning problems that grow with a number N, for the benchmarks of the planner."""

from __future__ import annotations

from planner.constraints.standard import STANDARD
from planner.language.builder import ModelBuilder
from planner.model.manager import ModelManager


def altern_model() -> ModelManager:
    """A rover that is at a place, goes, and is at another."""
    builder = ModelBuilder("altern", STANDARD)
    place = builder.enumeration("Place", ["Hill", "Rock", "Lander"])
    rover = builder.timeline("Rover")
    at = rover.predicate("At", {"place": place}, duration=(1, 1))
    going = rover.predicate("Going", {"from_": place, "to_": place}, duration=(1, 1))
    with at.requires() as this:
        this.meets(going, from_=this.place)
        this.met_by(going, to_=this.place)
    with going.requires() as this:
        this.require(this.from_ != this.to_)
        this.met_by(at, place=this.from_)
        this.meets(at, place=this.to_)
    builder.object("rover", "Rover")
    return builder.finish()
