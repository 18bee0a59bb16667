"""Stated problems in small models: guards, alternatives, codesignation, loops, resources, object variables."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from planner.constraints.standard import STANDARD
from planner.database import PlanDatabase
from planner.domains import Interval
from planner.language.builder import ClassBuilder, ModelBuilder
from planner.model.manager import ModelManager
from planner.problem import ConstraintPattern, TokenPattern
from scenarios.benchmarks.problems import altern_model
from tests.planner.domains_small import camera_model, rover_model


@cache
def _model(make: Callable[[], ModelManager]) -> ModelManager:
    """The one model of all databases of a world: operations name values of its domains."""
    return make()


def camera() -> PlanDatabase:
    """The paper's camera with two pictures to take."""
    database = PlanDatabase(_model(camera_model), (0, 60))
    database.state(TokenPattern("Engine.thrust", end=(5, 20)), "thrusting", "state")
    database.state(TokenPattern("Camera.picture", parameters={"asteroid": "Ida"}), "ida", "goal")
    database.state(TokenPattern("Camera.picture", end=(None, 40)), "any", "goal")
    database.state(TokenPattern("Engine.thrust"), "again", "rejectable")
    database.network.propagate()
    return database


def rovers() -> PlanDatabase:
    """Two rovers: object variables, members, guards, alternatives, batteries."""
    database = PlanDatabase(_model(rover_model), (0, 80))
    database.state(TokenPattern("Rover.at", "rover1", {"site": "base"}), "here", "state")
    database.state(TokenPattern("Rover.at", "rover2", {"site": ("hill", "base")}), "there", "state")
    database.state(TokenPattern("Light.sun", start=(10, 10), end=(40, 50)), "day", "fact")
    database.state(TokenPattern("Rover.sample", parameters={"site": "lake"}), "lake", "goal")
    database.state(TokenPattern("Rover.sample"), "sample", "rejectable")
    database.state(TokenPattern("Rover.drive", "rover2"), "drive", "rejectable")
    database.network.propagate()
    return database


def altern() -> PlanDatabase:
    """Two places to be at, some steps apart: chains of codesignations."""
    database = PlanDatabase(_model(altern_model), (10, 18))
    database.state(TokenPattern("Rover.At", parameters={"place": "Lander"}, start=(10, 10)), "first", "goal")
    database.state(TokenPattern("Rover.At", parameters={"place": "Rock"}, start=(14, 14)), "last", "goal")
    database.network.propagate()
    return database


def switches_model() -> ModelManager:
    """Guards on parameters, on each other's results and on durations; alternatives inside a guard; two rules that name
    their subgoals alike."""
    builder = ModelBuilder("switches", STANDARD)
    colour = builder.enumeration("Colour", ["red", "green", "blue"])
    line = builder.timeline("Line")
    show = line.predicate("show", {"colour": colour, "level": Interval(0, 5)}, duration=(1, 12))
    step = line.predicate("step", {"colour": colour, "other": colour, "size": Interval(0, 5)}, duration=(1, 6))
    lamp = builder.timeline("Lamp")
    on = lamp.predicate("on", {"colour": colour}, duration=(2, 20))
    dim = lamp.predicate("dim", {"level": Interval(0, 5)}, duration=(1, 20))
    with show.requires() as this:
        with this.when(this.colour == "red") as red:
            red.meets(step, colour=this.colour)
        with this.when(this.colour != "red") as calm:
            calm.contained_by(on, colour=this.colour)
            with calm.when(this.level == 2) as two:
                two.contained_by(dim, level=this.level)
    with show.requires() as this:
        this.met_by(step, other=this.colour)
    with step.requires() as this:
        this.require(this.colour != this.other)
        this.require(this.duration == this.size)
        with this.either() as either:
            with either.alternative() as one:
                one.contained_by(on, colour=this.other)
            with either.alternative() as other:
                other.contained_by(dim, level=this.size)
                with other.when(this.other == "blue") as blue:
                    blue.before(show, bounds=(0, 4), colour=this.other)
    with on.requires() as this, this.when(this.duration == 7) as seven:
        seven.before(dim, bounds=(0, 9))
    for name in ("Line", "Lamp"):
        for number in (1, 2):
            builder.object(f"{name.lower()}{number}", name)
    return builder.finish()


def switches() -> PlanDatabase:
    """Lines and lamps with shows to give."""
    database = PlanDatabase(_model(switches_model), (0, 50))
    database.state(TokenPattern("Line.show", "line1", {"colour": ("red", "green")}), "one", "goal")
    database.state(TokenPattern("Line.show", parameters={"level": 2}), "two", "goal")
    database.state(TokenPattern("Lamp.on", "lamp1"), "light", "rejectable")
    database.network.propagate()
    return database


def keeping_model() -> ModelManager:
    """Rules that keep attributes to values: of parameters of their own, of another token, of a member of an object."""
    builder = ModelBuilder("keeping", STANDARD)
    colour = builder.enumeration("Colour", ["red", "green", "blue"])
    lamp, stage = builder.timeline("Lamp", {"tint": colour}), builder.timeline("Stage")
    shine = lamp.predicate("shine", {"colour": colour}, duration=(1, 15))
    blink = lamp.predicate("blink", {"level": Interval(0, 5)}, duration=(1, 9))
    play = stage.predicate("play", {"colour": colour, "level": Interval(0, 5)}, duration=(2, 20))
    pause = stage.predicate("pause", duration=(1, 30))
    with play.requires() as this:
        this.throughout(shine.where(colour=this.colour), blink.where(level=this.level))
        with this.when(this.colour == "red") as red:
            kept = red.constraint_token("after", [shine.where(colour=["green", "blue"])], (0, 9))
            red.require(kept.duration >= 3)
            red.contains(shine, colour="red")
    with pause.requires() as this, this.either() as either:
        with either.alternative() as dark:
            dark.constraint_token("contained_by", [], attribute="Lamp.state")
        with either.alternative() as calm:
            calm.throughout(blink.where(level=1))
    with shine.requires() as this, this.when(this.duration == 5) as five:
        five.constraint_token("starts_before_end", [pause])
    for number in (1, 2):
        builder.object(f"lamp{number}", "Lamp", {"tint": "red"})
    builder.object("stage", "Stage")
    return builder.finish()


def keeping() -> PlanDatabase:
    """Plays and pauses to give under lamps, and constraint tokens of the problem's own."""
    database = PlanDatabase(_model(keeping_model), (0, 60))
    database.state(TokenPattern("Stage.play", end=(None, 30)), "play", "goal")
    database.state(TokenPattern("Stage.play", parameters={"colour": ("red", "blue")}, start=(10, 10)), "again", "goal")
    database.state(TokenPattern("Stage.pause"), "pause", "rejectable")
    database.state(TokenPattern("Lamp.shine", "lamp1", start=(5, 30), end=(None, 40)), "light", "rejectable")
    database.state(TokenPattern("Lamp.shine", "lamp1", {"colour": ("green", "blue")}, (12, 20)), "glow", "rejectable")
    database.state(TokenPattern("Lamp.blink", parameters={"level": (1, 2)}), "signal", "rejectable")
    database.state(TokenPattern("Lamp.blink", "lamp1", start=(14, 18), duration=(6, None)), "flash", "rejectable")
    shine = TokenPattern("Lamp.shine", parameters={"colour": ("red", "green")})
    database.confine(ConstraintPattern("Lamp.state", (shine,), "lamp1", (0, 12), (20, 60)), "mood")
    database.confine(ConstraintPattern("Lamp.state", (TokenPattern("Lamp.blink"),), "lamp1", duration=(4, 9)), "wink")
    database.network.propagate()
    return database


def workshop_model() -> ModelManager:
    """Workers that draw from one of two supplies and take from a tank what somebody filled in."""
    builder = ModelBuilder("workshop", STANDARD)
    worker = builder.timeline("Worker")
    work = worker.predicate("work", {"supply": "Reusable", "draw": Interval(1, 3), "hard": "bool"}, duration=(2, 9))
    take = ClassBuilder(builder, "Reservoir").predicate_of("Reservoir", "consume")
    with work.requires() as this:
        this.constrain("uses", this.supply, this.draw, this.start, this.end)
        with this.when(this.hard == True) as hard:  # noqa: E712 - a term of the language
            hard.relation("starts", take, quantity=this.draw)
    for number in (1, 2):
        builder.object(f"worker{number}", "Worker")
        builder.object(f"supply{number}", "Reusable", {"capacity": 3.0, "level_min": 0.0})
    tank = {"initial": 4.0, "level_min": 0.0, "level_max": 9.0, "consumption_max": 5.0}
    builder.object("tank", "Reservoir", tank)
    return builder.finish()


def workshop() -> PlanDatabase:
    """More work than the supplies allow at once."""
    database = PlanDatabase(_model(workshop_model), (0, 25))
    for number, name in enumerate(("one", "two", "three", "four")):
        window = (3 * number, 3 * number + 1 + 5 * (number % 2))
        database.state(TokenPattern("Worker.work", parameters={"draw": (2, 3)}, start=window), name, "goal")
    database.state(TokenPattern("Reservoir.produce", "tank", start=(4, 4)), "filling", "goal")
    database.state(TokenPattern("Reservoir.consume", "tank", end=(None, 12)), "spill", "rejectable")
    database.network.propagate()
    return database


WORLDS: dict[str, Callable[[], PlanDatabase]] = {
    "camera": camera,
    "rovers": rovers,
    "altern": altern,
    "switches": switches,
    "workshop": workshop,
    "keeping": keeping,
}
