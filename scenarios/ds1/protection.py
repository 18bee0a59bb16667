"""Fault protection of Deep Space 1 as data: what speaks for which conclusion, and what is done about it.

Monitors, conclusions and responses follow the flown cases: a hung terminal is reset, a status sensor that two others
contradict is not believed, a thruster that stays closed is worked around by the mode that does not need it, and an
engine that does not confirm its commands gets no more of them. Of the project's own: arrays that give less than planned
are planned with, a recorder that keeps no images ends the imaging, and wheels that do not hold give way to thrusters.
"""

from __future__ import annotations

from collections.abc import Iterator

from executive.bindings import MODE
from executive.conditions import Condition
from executive.port import TelemetryValue
from executive.protection import Monitor, Probe, Recovery, Response, Step, concluded_channel, probe_channel
from executive.sends import Conclusion, Confirmation, Send
from executive.sequencer import RESTART

CAMERA_STUCK_ON = Conclusion("micas.switch stuck_on", "the camera's power switch does not go off")
IMAGE_LOST = Conclusion("micas image lost", "an image was read out and is not on the recorder")
RECORDER_STUCK = Conclusion("recorder stuck", "the recorder takes no images")
CAMERA_HUNG = Conclusion("micas.terminal hung", "the camera's terminal does not answer")
ACS_HUNG = Conclusion("acs.terminal hung", "the terminal of the attitude control does not answer")
RADIO_HUNG = Conclusion("radio.terminal hung", "the radio's terminal does not answer")
LPE_HUNG = Conclusion("lpe.terminal hung", "the terminal of the LPE does not answer")
LPE_DEAD = Conclusion("lpe.terminal dead", "the terminal of the LPE does not answer, and resets do not help")
ENGINE_HUNG = Conclusion("ips.terminal hung", "commands to the ion engine do not get through")
ENGINE_TRIPPED = Conclusion("ips tripped", "the ion engine broke off thrusting by itself")
ENGINE_FAILED = Conclusion("ips failed", "the ion engine is not to be relied on")
ENGINE_RUNS_ON = Conclusion("ips runs on", "the ion engine thrusts without a plan")
NEB1_STATUS_FALSE = Conclusion("neb1.status stuck_off", "the status sensor of bus NEB1 says off, and the bus is on")
NEB1_OFF = Conclusion("neb1 off", "bus NEB1 has no power")
NEB2_OFF = Conclusion("neb2 off", "bus NEB2 has no power: neither camera nor PASM nor ion engine")
PASM_STATUS_FALSE = Conclusion("pasm.status stuck_off", "the status of switch PASM says off, and what it feeds answers")
X_THRUSTER_CLOSED = Conclusion("rcs.x_thruster stuck_closed", "a valve of the x-thrusters stays closed")
UNSTEADY = Conclusion("rcs unsteady", "neither mode of the thrusters holds the attitude")
ARRAYS_WEAK = {
    lower: Conclusion(f"power.arrays weak {lower}", f"the arrays give less than planned: {lower} to {lower + 100} W")
    for lower in range(50, 2500, 100)
}
"""By the least that they give (watts). Bands, since what is concluded has to be discrete."""
WHEELS_LOST = Conclusion("wheels lost", "the wheels do not hold the attitude")
Z_THRUSTER_CLOSED = Conclusion("rcs.z_thruster stuck_closed", "a valve of the z-thrusters stays closed")

# The LPE's terminal hangs on PASM, which standby switches on. What the flown executive waited before its diagnosis was
# 42 s: a probe's 6 and these.
ENDING_COMMANDS = ("ips.stop",)
"""The commands at which the flown executive could hang (18 May 1999), where a scenario wants it to."""

LPE_PROBE = Probe("lpe", Send("lpe.status"), every=300, within=6)
LPE_SILENT_S = 36
LPE = probe_channel("lpe")

# Off target without turning back: the rate of a slew is ten times this, and it starts and brakes within seconds.
DRIFT_ERROR_RAD = 1.0e-3
DRIFT_RATE_RAD_S = 2.0e-4
DRIFT_S = 10
# Wheels are slow to take back what the star tracker corrects after a slew, which is less than this.
WHEELS_DRIFT_ERROR_RAD = 1.3e-3
# With one thruster less a slew creeps to its end: that is not yet the second fault.
DRIFT_AGAIN_S = 90
# Settled, and off target longer than thrusters ever leave it: over this for 9 s at the most with pulses of 5 ms, never
# with those of 1 ms. With a valve closed a pair pushes to one side only: found before an image is smeared by it.
LOOSE_ERROR_RAD = 2.0e-4
LOOSE_S = 60
# The longest healthy slew takes 1470 s. In standby, one that takes longer is not on its way.
ENDLESS_S = 1600
# A healthy slew turns at its limit of 2.62e-3 at the most.
OVER_RATE_RAD_S = 3.4e-3
OVER_RATE_S = 5
STEADY_WITHIN_S = 1800
RESTART_WITHIN_S = 2400
# What loads take from the battery is within the planner's reserve and noise up to this; the wings, which follow a slew
# for minutes, do not stay in a band of 100 W as long as this.
OVERDRAWN_W = 60.0
OVERDRAWN_S = 60


def _is(channel: str, value: TelemetryValue) -> Condition:
    return Condition(channel, "==", value)


def _reset(terminal: str) -> Step:
    return Step((Send("terminal.reset", {"name": terminal}),))


def _drifting(error_rad: float) -> tuple[Condition, ...]:
    return (
        _is("acs.state", "slewing"),
        Condition("acs.error_rad", ">", error_rad),
        Condition("acs.rate_rad_s", "<", DRIFT_RATE_RAD_S),
    )


_ENDLESS = (_is(MODE, "standby"), _is("acs.state", "slewing"))
_ON_WHEELS = (_is("acs.actuators", "wheels"),)
_SETTLED = (_is("acs.state", "settled"),)


def _lost_steering(mode: str, first: Conclusion, other: Conclusion) -> Iterator[Monitor]:
    """The attitude drifts off or is held loosely, or a slew runs away or finds no end, while that mode steers.

    It speaks for a thruster that the mode depends on; once the other mode has been found wanting, against both.
    """
    steering = (_is("acs.actuators", "thrusters"), _is("rcs.mode", mode))
    too_fast = (Condition("acs.rate_rad_s", ">", OVER_RATE_RAD_S),)
    loose = (
        *steering,
        *_SETTLED,
        Condition("acs.error_rad", ">", LOOSE_ERROR_RAD),
        _is(concluded_channel(other), False),
    )
    yield Monitor(f"loose under {mode}", loose, LOOSE_S, first)
    for conclusion, known, words, persistence in (
        (first, False, "", DRIFT_S),
        (UNSTEADY, True, " too", DRIFT_AGAIN_S),
    ):
        when = (*steering, _is(concluded_channel(other), known))
        yield Monitor(
            f"drift under {mode}{words}", (*when, *_drifting(DRIFT_ERROR_RAD)), persistence, conclusion, until=_SETTLED
        )
        yield Monitor(f"over-rate under {mode}{words}", (*when, *too_fast), OVER_RATE_S, conclusion, until=_SETTLED)
        yield Monitor(f"endless slew under {mode}{words}", (*when, *_ENDLESS), ENDLESS_S, conclusion, until=_SETTLED)


def _overdrawn(lower: int, conclusion: Conclusion) -> Monitor:
    """Pointed steadily, the loads that were planned take more than the arrays give, which is steadily this."""
    steady = (_is("acs.state", "settled"), *_from_to("power.array_W", lower, lower + 100))
    overdrawn = Condition("power.margin_W", "<", -OVERDRAWN_W)
    return Monitor(f"overdrawn at {lower} W", (overdrawn, *steady), OVERDRAWN_S, conclusion)


def _from_to(channel: str, lower: float, upper: float) -> tuple[Condition, Condition]:
    return Condition(channel, ">=", lower), Condition(channel, "<", upper)


MONITORS = (
    Monitor(
        "lpe-silent", (_is(LPE, "silent"), _is("pasm.switch", "on"), _is("neb2.status", "on")), LPE_SILENT_S, LPE_HUNG
    ),
    Monitor(
        "neb2-power",
        (_is("neb2.status", "off"),),
        6,
        NEB2_OFF,
        votes=(Condition("neb2.current_A", "<=", 0.05), _is(LPE, "silent")),
        needed=1,
    ),
    # Of three witnesses of NEB1 (status, current, the star tracker behind it) the majority is believed.
    Monitor(
        "neb1-status",
        (_is("neb1.status", "off"),),
        6,
        NEB1_STATUS_FALSE,
        votes=(Condition("neb1.current_A", ">", 0.05), Condition("tracker.state", "!=", "off")),
        needed=2,
    ),
    Monitor(
        "neb1-power",
        (_is("neb1.status", "off"),),
        6,
        NEB1_OFF,
        votes=(Condition("neb1.current_A", "<=", 0.05), _is("tracker.state", "off")),
        needed=1,
    ),
    Monitor("pasm-status", (_is("pasm.switch", "off"), _is(LPE, "answers")), 6, PASM_STATUS_FALSE),
    *_lost_steering("x_for_y", X_THRUSTER_CLOSED, Z_THRUSTER_CLOSED),
    *_lost_steering("z_for_y", Z_THRUSTER_CLOSED, X_THRUSTER_CLOSED),
    Monitor("drift on wheels", (*_ON_WHEELS, *_drifting(WHEELS_DRIFT_ERROR_RAD)), DRIFT_S, WHEELS_LOST, until=_SETTLED),
    Monitor("endless slew on wheels", (*_ON_WHEELS, *_ENDLESS), ENDLESS_S, WHEELS_LOST, until=_SETTLED),
    *(_overdrawn(lower, conclusion) for lower, conclusion in ARRAYS_WEAK.items()),
    Monitor("thrust-in-standby", (_is(MODE, "standby"), _is("ips.state", "thrusting")), 30, ENGINE_RUNS_ON),
)


def _steer_by(name: str, send: Send) -> tuple[Recovery, Recovery]:
    """Another way to steer, proven by the end of the longest slew; thrust is broken off meanwhile."""
    thrusting = _is("ips.state", "thrusting")
    idle = Step((Send("ips.idle"),), Confirmation((Condition("ips.state", "!=", "thrusting"),), within=5))
    return (
        Recovery(f"thrust off, {name}", (idle, Step((send,))), STEADY_WITHIN_S, when=(thrusting,)),
        Recovery(name, (Step((send,)),), STEADY_WITHIN_S),
    )


_X_FOR_Y = _steer_by("steer by the x-thrusters about Y", Send("rcs.mode", {"mode": "x_for_y"}))
_Z_FOR_Y = _steer_by("steer by the z-thrusters about Y", Send("rcs.mode", {"mode": "z_for_y"}))
_WHEELS = _steer_by("steer by the wheels", Send("acs.actuators", {"name": "wheels"}))
_THRUSTERS = _steer_by("steer by the thrusters", Send("acs.actuators", {"name": "thrusters"}))
_RELIGHT = Step((Send("ips.thrust", {"level": "$level"}),), Confirmation((_is("ips.state", "thrusting"),), within=10))
_START = Step((Send("ips.start"),), Confirmation((_is("ips.state", "ready"),), within=RESTART_WITHIN_S))
_STOP = Step((Send("ips.stop"),))
_UNMOVED = (Condition("ips.state", "!=", "starting"),)

RESPONSES = (
    Response(
        LPE_HUNG.name,
        (Recovery("reset the terminal", (_reset("lpe"),), within=12, attempts=2),),
        otherwise=LPE_DEAD,
        replan="never",
    ),
    Response(LPE_DEAD.name, forbids=("lpe.",), replan="never"),
    Response(NEB1_STATUS_FALSE.name, vetoes={"neb1.status": "on"}, replan="never"),
    Response(NEB1_OFF.name, replan="never"),
    Response(NEB2_OFF.name, forbids=("ips.", "lpe."), waives=("ips.state",)),
    Response(PASM_STATUS_FALSE.name, vetoes={"pasm.switch": "on"}, replan="never"),
    Response(
        X_THRUSTER_CLOSED.name,
        (*_Z_FOR_Y, *_WHEELS),
        lasts=True,
        restores=("pointing", "thrust"),
        masks=(Z_THRUSTER_CLOSED.name, UNSTEADY.name, ENGINE_TRIPPED.name),
    ),
    Response(
        Z_THRUSTER_CLOSED.name,
        (*_X_FOR_Y, *_WHEELS),
        lasts=True,
        restores=("pointing", "thrust"),
        masks=(X_THRUSTER_CLOSED.name, UNSTEADY.name, ENGINE_TRIPPED.name),
    ),
    Response(UNSTEADY.name, _WHEELS, lasts=True, restores=("pointing", "thrust"), masks=(ENGINE_TRIPPED.name,)),
    Response(
        WHEELS_LOST.name,
        _THRUSTERS,
        lasts=True,
        restores=("pointing", "thrust"),
        masks=(X_THRUSTER_CLOSED.name, Z_THRUSTER_CLOSED.name, UNSTEADY.name, ENGINE_TRIPPED.name),
    ),
    Response(IMAGE_LOST.name, otherwise=RECORDER_STUCK, replan="never"),
    Response(CAMERA_HUNG.name, (Recovery("reset the terminal", (_reset("micas"),), within=5),)),
    Response(ACS_HUNG.name, (Recovery("reset the terminal", (_reset("acs"),), within=5),)),
    Response(RADIO_HUNG.name, (Recovery("reset the terminal", (_reset("radio"),), within=5),)),
    # Where the engine has done what it was told, it is the answer that was lost: nothing to reset, nothing to rely on.
    Response(
        ENGINE_HUNG.name,
        (
            Recovery("reset the terminal", (_reset("ips"),), within=5, when=_UNMOVED),
            Recovery("restart the command sequencer", (Step((Send(RESTART),)),), within=5, when=_UNMOVED),
        ),
        otherwise=ENGINE_FAILED,
    ),
    Response(
        ENGINE_TRIPPED.name,
        (
            Recovery("light it again", (_RELIGHT,), within=10, attempts=3, when=(_is("ips.state", "ready"),)),
            Recovery("start it again", (_START, _RELIGHT), within=10, when=(_is("ips.state", "standby"),)),
        ),
        otherwise=ENGINE_FAILED,
    ),
    Response(ENGINE_FAILED.name, forbids=("ips.",), waives=("ips.state",)),
    Response(
        ENGINE_RUNS_ON.name,
        (
            Recovery("reset the terminal and stop", (_reset("ips"), _STOP), within=10, attempts=2),
            Recovery("restart the command sequencer and stop", (Step((Send(RESTART),)), _STOP), within=10),
        ),
        otherwise=ENGINE_FAILED,
    ),
)
