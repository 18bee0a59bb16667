"""What several tests of the simulator do with a spacecraft."""

from __future__ import annotations

from sim import Acknowledgement, Spacecraft, SpacecraftConfig

FAST = SpacecraftConfig(engine_start_s=(5.0, 10.0), engine_stop_s=(2.0, 4.0), camera_warmup_s=(5.0, 9.0))


def command(craft: Spacecraft, name: str, /, **arguments: float | int | str | bool) -> None:
    """Send and insist on an accepting answer."""
    answer = craft.send(name, arguments)
    assert answer == Acknowledgement(True), (name, arguments, answer)


def until(craft: Spacecraft, channel: str, value: object, limit_s: int = 4000) -> int:
    """Advance second by second until a channel has a value; seconds that took."""
    start = craft.time
    while craft.telemetry()[channel] != value:
        assert craft.time - start < limit_s, (
            f"{channel} is {craft.telemetry()[channel]}, not {value}, after {limit_s} s"
        )
        craft.advance(craft.time + 1)
    return craft.time - start


def slew(craft: Spacecraft, target: str, limit_s: int = 4000) -> int:
    """Point at a target; seconds to settled."""
    command(craft, "acs.point", target=target)
    return until(craft, "acs.state", "settled", limit_s)


def thrusting(craft: Spacecraft, level: int) -> None:
    """Start the engine and thrust."""
    command(craft, "ips.start")
    until(craft, "ips.state", "ready")
    command(craft, "ips.thrust", level=level)
