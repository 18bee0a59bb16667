"""The planner's model of Deep Space 1: `domain.nddl` with the numbers of the hardware that is to be flown."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files

from planner.constraints.standard import STANDARD
from planner.errors import ModelError
from planner.language.nddl.builder import load_text
from planner.model.manager import ModelManager
from scenarios.ds1.procedures import missing_power, throttle_power, turn_duration

DOMAIN, HEADER = "domain.nddl", "capability.nddl"


@dataclass(frozen=True)
class Capability:
    """What the planner may count on. Durations are (shortest, longest) in seconds, powers in watts.

    `turns`: by (from, to) target, both ways and also for a target and itself. `throttle`: power by engine level, in the
    order in which a planner should prefer the levels. `power`: what the arrays give beyond the base load. `planning`:
    how long planning the next horizon takes. `arrays`: what they give, with the base load.
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
    planning: tuple[int, int]
    arrays: float


def build_model(capability: Capability) -> ModelManager:
    """The model manager of a spacecraft with these capabilities: one object of each class, named in lower case."""
    text = (files(__package__) / DOMAIN).read_text(encoding="utf-8")
    procedures = STANDARD.with_procedures(
        turn_duration(capability.turns),
        throttle_power(capability.throttle),
        missing_power(capability.arrays, capability.power),
    )
    headers = {HEADER: header_of(capability)}
    model, _, _ = load_text(text, procedures, DOMAIN, headers=headers, model_name="ds1")
    return model


def header_of(capability: Capability) -> str:
    """The types and numbers of `capability.nddl`."""
    return "\n".join([*_types(capability), *_durations(capability), *_powers(capability), ""])


def _types(capability: Capability) -> Iterator[str]:
    for target in capability.targets:
        if not target.isidentifier() or not target.isascii():
            raise ModelError(f"targets: expected names of letters, digits and underscores, found {target!r}")
    yield f"enum Target {{{', '.join(capability.targets)}}}"
    yield f"typedef int {{{', '.join(map(str, capability.throttle))}}} Level;"


def _durations(capability: Capability) -> Iterator[str]:
    spans = {
        "TURN": _hull(capability.turns.values()),
        "ENGINE_START": capability.engine_start,
        "ENGINE_STOP": capability.engine_stop,
        "CAMERA_WARMUP": capability.camera_warmup,
        "EXPOSURE": capability.exposure,
        "PLANNING": capability.planning,
    }
    for name, (shortest, longest) in spans.items():
        yield f"int {name}_MIN = {shortest}, {name}_MAX = {longest};"


def _powers(capability: Capability) -> Iterator[str]:
    powers = {
        "POWER": capability.power,
        "ENGINE_START_POWER": capability.engine_start_power,
        "CAMERA_POWER": capability.camera_power,
        "DOWNLINK_POWER": capability.downlink_power,
    }
    for name, watts in powers.items():
        yield f"float {name} = {float(watts)!r};"


def _hull(spans: Iterable[tuple[int, int]]) -> tuple[int, int]:
    shortest, longest = zip(*spans, strict=True)
    return min(shortest), max(longest)
