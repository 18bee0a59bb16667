"""Small domain models that several tests plan in."""

from __future__ import annotations

from planner.constraints.standard import STANDARD
from planner.domains import Interval
from planner.language.builder import ClassBuilder, ModelBuilder
from planner.model.manager import ModelManager


def camera_model() -> ModelManager:
    """The paper's example (section 2, Figure 2): a picture needs the engine off and the asteroid in view."""
    builder = ModelBuilder("camera and engine", STANDARD)
    asteroid = builder.enumeration("Asteroid", ["Gaspra", "Ida"])
    engine, camera, attitude = (builder.timeline(name) for name in ("Engine", "Camera", "Attitude"))
    off = engine.predicate("off")
    engine.predicate("thrust", duration=(5, 50))
    ready = camera.predicate("ready")
    picture = camera.predicate("picture", {"asteroid": asteroid}, duration=(3, 6))
    point_at = attitude.predicate("pointAt", {"asteroid": asteroid})
    attitude.predicate("turn", duration=(4, 8), contingent=True)
    with picture.requires() as this:
        this.contained_by(off)
        this.contained_by(point_at, asteroid=this.asteroid)
        this.before(ready, bounds=(0, 0))
        this.after(ready, bounds=(0, 0))
    for name in ("engine", "camera", "attitude"):
        builder.object(name, name.capitalize())
    return builder.finish()


def rover_model() -> ModelManager:
    """Two rovers that drive between sites: object variables, members, arithmetic, guards, alternatives, a battery."""
    builder = ModelBuilder("rovers", STANDARD)
    site = builder.enumeration("Site", ["base", "hill", "lake"])
    builder.manager.add_class("Battery", "Reusable")
    power = builder.manager.predicate("Battery", "uses")
    rover = builder.timeline("Rover", {"battery": "Battery", "speed": "int"})
    light = builder.timeline("Light")
    at = rover.predicate("at", {"site": site}, duration=(1, 30))
    drive = rover.predicate(
        "drive", {"from_": site, "to": site, "length": Interval(2, 6), "cost": Interval(1, 3)}, duration=(1, 9)
    )
    sample = rover.predicate("sample", {"site": site, "deep": "bool"}, duration=(2, 3))
    sun = light.predicate("sun", {"strength": Interval(0, 4)}, exogenous=True)
    lamp = light.predicate("lamp", duration=(1, 20))
    uses = ClassBuilder(builder, "Battery").predicate_of("Battery", power.name)

    with drive.requires() as this:
        this.require(this.from_ != this.to)
        this.require(this.duration == this.length)
        this.met_by(at, site=this.from_)
        this.meets(at, site=this.to)
        this.equals(uses.of("battery"), quantity=this.cost)
    with at.requires() as this, this.when(this.site == "lake") as inside:
        inside.relation("startsAfter", at, bounds=(1, 20), site="hill")
    with sample.requires() as this:
        this.met_by(at, site=this.site)
        with this.either() as either:
            with either.alternative() as one:
                one.contained_by(sun)
                one.require(this.deep == True)  # noqa: E712 - a term of the language
            with either.alternative() as other:
                other.contained_by(lamp)
    batteries = [builder.object(f"battery{n}", "Battery", {"capacity": 3, "level_min": 0}) for n in (1, 2)]
    for n, battery in enumerate(batteries, 1):
        builder.object(f"rover{n}", "Rover", {"battery": battery, "speed": n})
    builder.object("sky", "Light")
    return builder.finish()
