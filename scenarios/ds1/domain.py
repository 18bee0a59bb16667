"""The planner's model of Deep Space 1 (the flown one was never released; this one is the project's own).

Sources of the rules: the spacecraft is pointed as a whole and does not turn while the camera exposes; the engine does
not thrust while it does (vibration); the ion engine is preceded by a start-up and followed by a shut-down. The numbers
come with `Capability`, from the hardware that is to be flown, so that the two cannot drift apart.

What nature decides (turns, warm-up, exposure with its read-out, engine start-up and shut-down) is contingent.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from planner.constraints.procedure import ConstraintProcedure
from planner.constraints.standard import STANDARD
from planner.domains import Domain, Interval, Values
from planner.language.builder import ClassBuilder, ModelBuilder
from planner.model.manager import ModelManager

IMAGES_PER_SESSION = 3
OFF_WITHIN_S = 1800
"""The camera is switched off this soon after a session, where its switch works."""


@dataclass(frozen=True)
class Capability:
    """What the planner may count on. Durations are (shortest, longest) in seconds, powers in watts.

    `turns`: by (from, to) target, both ways and also for a target and itself. `throttle`: power by engine level, in the
    order in which a planner should prefer the levels. `power`: what the arrays give beyond the base load.
    """

    targets: Sequence[str]
    turns: Mapping[tuple[str, str], tuple[int, int]]
    throttle: Mapping[int, float]
    power: float
    engine_start: tuple[int, int]
    engine_stop: tuple[int, int]
    engine_start_power: float
    camera_warmup: tuple[int, int]
    camera_power: float
    exposure: tuple[int, int]
    downlink_power: float


def build_model(capability: Capability) -> ModelManager:
    """The model manager of a spacecraft with these capabilities: one object of each class, named in lower case."""
    procedures = STANDARD.with_procedures(turn_duration(capability.turns), throttle_power(capability.throttle))
    model = ModelBuilder("ds1", procedures)
    model.enumeration("Target", capability.targets)
    model.enumeration("Level", capability.throttle)
    attitude = model.component("Attitude", ["mode"])
    engine = model.component("Engine", ["mode"])
    camera = model.component("Camera", ["mode", "switch"])
    navigation = model.component("Navigation", ["activity"])
    radio = model.component("Radio", ["mode"])
    for name in ("Attitude", "Engine", "Camera", "Navigation", "Radio"):
        model.object(name.lower(), name)
    model.object("power", "Reusable", {"capacity": capability.power})
    _attitude(attitude, capability)
    _engine(engine, capability)
    _camera(camera, capability)
    _navigation(navigation)
    _radio(radio, capability)
    return model.finish()


def _attitude(attitude: ClassBuilder, capability: Capability) -> None:
    shortest = min(lower for lower, _ in capability.turns.values())
    longest = max(upper for _, upper in capability.turns.values())
    point = attitude.predicate("point", {"target": "Target"}, attribute="mode")
    turn = attitude.predicate(
        "turn",
        {"origin": "Target", "target": "Target"},
        attribute="mode",
        duration=(shortest, longest),
        contingent=True,
    )
    with point.requires() as this:
        this.met_by(turn, target=this.target)
        this.meets(turn, origin=this.target)
    with turn.requires() as this:
        this.require(this.origin != this.target)
        this.constrain("turnDuration", this.origin, this.target, this.duration)
        this.met_by(point, target=this.origin)
        this.meets(point, target=this.target)


def _engine(engine: ClassBuilder, capability: Capability) -> None:
    uses = engine.predicate_of("Reusable", "uses")
    point = engine.predicate_of("Attitude", "point")
    standby = engine.predicate("standby", attribute="mode")
    start_up = engine.predicate("startUp", attribute="mode", duration=capability.engine_start, contingent=True)
    thrust = engine.predicate("thrust", {"heading": "Target", "level": "Level"}, attribute="mode")
    shut_down = engine.predicate("shutDown", attribute="mode", duration=capability.engine_stop, contingent=True)
    with standby.requires() as this:
        this.met_by(shut_down)
        this.meets(start_up)
    with start_up.requires() as this:
        this.met_by(standby)
        this.meets(thrust)
        this.equals(uses, quantity=capability.engine_start_power)
    with thrust.requires() as this:
        this.met_by(start_up)
        this.meets(shut_down)
        this.contained_by(point, target=this.heading)
        drawn = this.equals(uses)
        this.constrain("throttlePower", this.level, drawn.quantity)
    with shut_down.requires() as this:
        this.met_by(thrust)
        this.meets(standby)


def _camera(camera: ClassBuilder, capability: Capability) -> None:
    """Two attributes: the power switch, which draws the power, and the mode, which needs the switch."""
    uses = camera.predicate_of("Reusable", "uses")
    point = camera.predicate_of("Attitude", "point")
    engine_standby = camera.predicate_of("Engine", "standby")
    switched_off = camera.predicate("switchedOff", attribute="switch")
    switched_on = camera.predicate("switchedOn", attribute="switch")
    stuck_on = camera.predicate("stuckOn", attribute="switch", exogenous=True)
    off = camera.predicate("off", attribute="mode")
    warm_up = camera.predicate("warmUp", attribute="mode", duration=capability.camera_warmup, contingent=True)
    ready = camera.predicate("ready", attribute="mode")
    take = camera.predicate(
        "takeImage", {"target": "Target"}, attribute="mode", duration=capability.exposure, contingent=True
    )
    with switched_off.requires() as this:
        this.equals(off)
        this.meets(switched_on)
    with switched_on.requires() as this:
        this.relation("starts", warm_up)
        this.meets(switched_off)
        this.equals(uses, quantity=capability.camera_power)
    with stuck_on.requires() as this:
        this.equals(uses, quantity=capability.camera_power)
    with off.requires() as this:
        this.equals(switched_off)
        this.met_by(ready)
        this.meets(warm_up)
    with warm_up.requires() as this:
        this.relation("starts", switched_on)
        this.met_by(off)
        this.meets(ready)
    with ready.requires() as this:
        this.relation_to_one_of("met_by", (take, warm_up))
        this.relation_to_one_of("meets", (off, take))
        this.relation_to_one_of("contained_by", (switched_on, stuck_on))
    with take.requires() as this:
        this.met_by(ready)
        this.meets(ready)
        this.contained_by(point, target=this.target)  # no turning while exposing
        this.contained_by(engine_standby)  # no vibration while exposing


def _navigation(navigation: ClassBuilder) -> None:
    take = navigation.predicate_of("Camera", "takeImage")
    off = navigation.predicate_of("Camera", "off")
    session = navigation.predicate("session", {"target": "Target"}, attribute="activity")
    with session.requires() as this:
        images = [this.contains(take, target=this.target) for _ in range(IMAGES_PER_SESSION)]
        for earlier, later in pairwise(images):
            this.relate("before", earlier, later)
        with this.either() as switch:
            with switch.alternative() as works:
                works.contained_by(navigation.predicate_of("Camera", "switchedOn"))
                works.before(off, bounds=(0, OFF_WITHIN_S))
            with switch.alternative() as stuck:
                stuck.contained_by(navigation.predicate_of("Camera", "stuckOn"))


def _radio(radio: ClassBuilder, capability: Capability) -> None:
    uses = radio.predicate_of("Reusable", "uses")
    point = radio.predicate_of("Attitude", "point")
    downlink = radio.predicate("downlink", attribute="mode")
    with downlink.requires() as this:
        this.contained_by(point, target="earth")
        this.equals(uses, quantity=capability.downlink_power)


def turn_duration(turns: Mapping[tuple[str, str], tuple[int, int]]) -> ConstraintProcedure:
    """The attitude expert: how long a turn takes from one target to another."""

    def narrow(domains: Sequence[Domain]) -> Sequence[Domain] | None:
        """Duration is within the bounds of the turn from origin to target."""
        origin, target, duration = domains
        assert isinstance(origin, Values)
        assert isinstance(target, Values)
        left = [
            (a, b)
            for a in origin.values()
            for b in target.values()
            if (a, b) in turns and turns[a, b][0] <= duration.upper and turns[a, b][1] >= duration.lower
        ]
        if not left:
            return None
        lower, upper = min(turns[p][0] for p in left), max(turns[p][1] for p in left)
        return origin.keep(a for a, _ in left), target.keep(b for _, b in left), duration.bounded(lower, upper)

    return ConstraintProcedure("turnDuration", narrow, 3, 3)


def throttle_power(throttle: Mapping[int, float]) -> ConstraintProcedure:
    """The engine expert: how much power a throttle level draws."""

    def narrow(domains: Sequence[Domain]) -> Sequence[Domain] | None:
        """Power is what the level draws."""
        level, power = domains
        assert isinstance(level, Values)
        left = [v for v in level.values() if throttle.get(v, math.nan) in power]
        if not left:
            return None
        drawn = [throttle[v] for v in left]
        return level.keep(left), power.intersect(Interval(min(drawn), max(drawn), integer=False))

    return ConstraintProcedure("throttlePower", narrow, 2, 2)
