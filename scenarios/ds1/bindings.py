"""How the tokens of the Deep Space 1 model become telecommands, and which telemetry proves them."""

from __future__ import annotations

from dataclasses import replace

from executive.bindings import Activity, Bindings, Finish, Maintained, Standby, plan_next
from executive.conditions import Condition, Telemetry
from executive.sends import Confirmation, Send
from planner.problem import TokenPattern
from scenarios.ds1.capability import EXPOSURE_S
from scenarios.ds1.protection import (
    ACS_HUNG,
    ARRAYS_WEAK,
    CAMERA_HUNG,
    CAMERA_STUCK_ON,
    ENGINE_FAILED,
    ENGINE_HUNG,
    ENGINE_TRIPPED,
    IMAGE_LOST,
    LPE_PROBE,
    MONITORS,
    NEB2_OFF,
    RADIO_HUNG,
    RECORDER_STUCK,
    RESPONSES,
)

PLAN_NEXT = TokenPattern("Planner.planNext")
"""The token whose execution is asking for the plan of the next horizon; as late as it may be, it knows most."""
FOREVER_S = 10**9
"""Longer than any horizon: what lasts this long is never planned to end."""

ON_TARGET = (Condition("acs.target", "==", "$target"), Condition("acs.state", "==", "settled"))
RADIO_OFF = (Send("radio.downlink", {"on": False}), Send("radio.power", {"on": False}))


def _is(channel: str, value: str) -> tuple[Condition, ...]:
    return (Condition(channel, "==", value),)


ACTIVITIES = (
    Activity(
        "Attitude.turn",
        parameters=("target",),
        contingent=True,
        start=(Send("acs.point", {"target": "$target"}),),
        started=Confirmation(unanswered=ACS_HUNG),
        finish=Finish(ON_TARGET, hold_early=True),
    ),
    Activity(
        "Attitude.point",
        parameters=("target",),
        maintained=(Maintained("pointing", ON_TARGET, persistence=25),),
    ),
    Activity(
        "Engine.startUp",
        contingent=True,
        start=(Send("ips.start"),),
        started=Confirmation(conclusion=ENGINE_HUNG),
        finish=Finish(_is("ips.state", "ready"), hold_early=True),
        stop=(Send("ips.stop"),),
    ),
    Activity(
        "Engine.thrust",
        parameters=("level",),
        start=(Send("ips.thrust", {"level": "$level"}),),
        started=Confirmation(
            (*_is("ips.state", "thrusting"), Condition("ips.level", "==", "$level")), within=10, conclusion=ENGINE_HUNG
        ),
        maintained=(Maintained("thrust", _is("ips.state", "thrusting"), 5, conclusion=ENGINE_TRIPPED, made_up=True),),
        stop=(Send("ips.stop"),),
    ),
    Activity(
        "Engine.shutDown",
        contingent=True,
        start=(Send("ips.stop"),),
        started=Confirmation(
            (Condition("ips.state", "!=", "thrusting"), Condition("ips.state", "!=", "ready")), conclusion=ENGINE_HUNG
        ),
        finish=Finish(_is("ips.state", "standby"), hold_early=True),
    ),
    Activity(
        "Camera.warmUp",
        contingent=True,
        start=(Send("micas.power", {"on": True}),),
        started=Confirmation(_is("micas.switch", "on"), within=10, retries=2, unanswered=CAMERA_HUNG),
        finish=Finish(_is("micas.state", "ready"), hold_early=True),
    ),
    Activity("Camera.ready", maintained=(Maintained("camera ready", _is("micas.state", "ready"), persistence=5),)),
    Activity(
        "Camera.takeImage",
        parameters=("target",),
        contingent=True,
        start=(Send("micas.expose", {"target": "$target", "seconds": EXPOSURE_S}),),
        started=Confirmation(_is("micas.state", "exposing"), within=5, unanswered=CAMERA_HUNG),
        finish=Finish(
            (*_is("micas.state", "ready"), Condition("micas.images", "increased_by", 1)),
            hold_early=True,
            conclusion=IMAGE_LOST,
            evidence=_is("micas.state", "ready"),
        ),
    ),
    Activity(
        "Camera.off",
        start=(Send("micas.power", {"on": False}),),
        started=Confirmation(
            _is("micas.switch", "off"), within=10, retries=2, conclusion=CAMERA_STUCK_ON, unanswered=CAMERA_HUNG
        ),
    ),
    replace(plan_next("Planner.planNext"), starts="latest"),
    Activity(
        "Radio.downlink",
        start=(Send("radio.power", {"on": True}), Send("radio.downlink", {"on": True})),
        started=Confirmation(_is("radio.state", "downlinking"), within=10, retries=1, unanswered=RADIO_HUNG),
        end=RADIO_OFF,
        ended=Confirmation(_is("radio.state", "off"), within=10, retries=1, unanswered=RADIO_HUNG),
        maintained=(Maintained("downlink", _is("radio.state", "downlinking"), persistence=5),),
        stop=RADIO_OFF,
    ),
)

# Safe: pointed at the Earth, the wings at the Sun, nothing thrusting, nothing exposing. The camera is told to be off
# but may stay on: what it does shows in telemetry, and the next plan starts from there. PASM is on, so that the
# terminal behind it can be asked for signs of life.
STANDBY = Standby(
    commands=(Send("acs.standby"), Send("micas.power", {"on": False}), Send("pasm.power", {"on": True})),
    confirmation=Confirmation(
        (
            *_is("acs.state", "settled"),
            *_is("acs.target", "earth"),
            *_is("ips.state", "standby"),
            *_is("radio.state", "off"),
            Condition("micas.state", "!=", "exposing"),
            Condition("micas.state", "!=", "warming"),
        ),
        within=2400,
    ),
)


def state_now(telemetry: Telemetry, conclusions: frozenset[str]) -> tuple[TokenPattern, ...]:
    """The tokens that hold when the spacecraft stands by with this telemetry and these conclusions drawn."""
    health = "Engine.works" if conclusions.isdisjoint((ENGINE_FAILED.name, NEB2_OFF.name)) else "Engine.failed"
    weak = [given for given, conclusion in ARRAYS_WEAK.items() if conclusion.name in conclusions][:1]
    return (
        TokenPattern("Attitude.point", parameters={"target": str(telemetry["acs.target"])}),
        TokenPattern("Engine.standby"),
        TokenPattern(health, end=(FOREVER_S, None)),
        *_camera_now(telemetry, conclusions),
        *(TokenPattern("Arrays.weak", parameters={"given": given}, end=(FOREVER_S, None)) for given in weak),
    )


def _camera_now(telemetry: Telemetry, conclusions: frozenset[str]) -> tuple[TokenPattern, ...]:
    """Its mode and its switch. Where no images are kept it is of no use, but draws its power if it is on; without its
    bus it is neither of use nor a load."""
    on, stuck = telemetry["micas.switch"] == "on", TokenPattern("Camera.stuckOn", end=(FOREVER_S, None))
    retired = TokenPattern("Camera.retired", end=(FOREVER_S, None))
    if NEB2_OFF.name in conclusions and telemetry["neb2.status"] == "off":
        return (retired,)
    if RECORDER_STUCK.name in conclusions:
        return (retired, stuck) if on else (retired,)
    mode = TokenPattern("Camera.ready" if telemetry["micas.state"] == "ready" else "Camera.off")
    if CAMERA_STUCK_ON.name in conclusions and on:
        return mode, stuck
    return mode, TokenPattern("Camera.switchedOn" if on else "Camera.switchedOff")


BINDINGS = Bindings(
    activities=ACTIVITIES,
    standby=STANDBY,
    state=state_now,
    state_channels=("acs.target", "micas.state", "micas.switch"),
    observed=("power.bus",),
    probes=(LPE_PROBE,),
    monitors=MONITORS,
    responses=RESPONSES,
)
