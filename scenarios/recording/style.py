"""How things are named and coloured: labels of tokens, colours by kind of activity, elapsed time, entity names.

Colours are 0xRRGGBBAA. Red belongs to faults and failures alone; grey is rest, amber is change between states.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

RED = 0xE11D48FF
DARK_RED = 0x7A1528FF
FADED_RED = 0x4A1A24FF
ORANGE = 0xD9770BFF
AMBER = 0xC79A2EFF
GREEN = 0x1F8A5BFF
GREY = 0x4B5563FF
BLUE = 0x2B5C9EFF
LEVELS = {"TRACE": 0x8A94A3FF, "DEBUG": 0xA9B4C4FF, "INFO": 0xF1F4F8FF, "WARN": 0xF3B25BFF, "ERROR": 0xFF8A8AFF}
"""Colours of the log's texts, all readable on black."""
LINES = (0x4C9BE8FF, 0xE8883AFF, 0x34B27BFF, 0xC778DDFF, 0xE2C044FF, 0x3FC1C9FF, 0xE86A92FF, 0x9AA5B1FF, 0xB8DE6FFF)
"""Colours of the lines of plots, apart from each other and readable on black."""
_MAGENTA = 0xA21CAFFF
_THRUST = 0xC2501EFF
_HUES = (
    0x2468B4FF,
    0x0E8F83FF,
    0x6A4BD8FF,
    0x2E8B47FF,
    0x1D4FD7FF,
    0x8A5A2BFF,
    0x0E7FA8FF,
    0x7C8B1FFF,
    0x9A4F96FF,
    0x4C6FA5FF,
    0x5B8A72FF,
    0xA07A1CFF,
)
_KINDS: tuple[tuple[str, int], ...] = (
    (r"(?i)^(off|idle|none|hold|inactive|standby|sleep|stow|safe|quiet|not_?)", GREY),
    (r"(?i)(standby|idle|_off$|switchedoff|inactive)", GREY),
    (r"(?i)(turn|slew|warm|start|stop|shut|switch(?!ed)|open|close|closing|transit|desat|unload|boot|prepar)", AMBER),
    (r"(?i)(image|imaging|observe|observing|observation|photo|picture|expos|session)", _MAGENTA),
    (r"(?i)(thrust|burn|fire|firing)", _THRUST),
)


class Palette:
    """Colours of activities, one for each predicate with its textual parameters.

    Kinds that every mission has are recognised by their words; the others take hues in the order in which they are
    first seen, so that one run has the same colour for the same activity in every view.
    """

    def __init__(self) -> None:
        self._given: dict[str, int] = {}

    def colour(self, predicate: str, parameters: Mapping[str, Any]) -> int:
        """0xRRGGBBAA of an activity; its class does not matter."""
        predicate = predicate.rpartition(".")[2] or predicate
        for words, colour in _KINDS:
            if re.search(words, predicate):
                return colour
        texts = [v for v in parameters.values() if isinstance(v, str)]
        key = " ".join([predicate, *texts[:1]])
        return self._given.setdefault(key, _HUES[len(self._given) % len(_HUES)])


def dim(colour: int, share: float = 0.5) -> int:
    """The colour at `share` of its brightness over black, opaque."""
    channels = [round(((colour >> shift) & 0xFF) * share) for shift in (24, 16, 8)]
    return channels[0] << 24 | channels[1] << 16 | channels[2] << 8 | 0xFF


def lighten(colour: int, share: float = 0.45) -> int:
    """The colour moved by `share` towards white: readable as a line or as text on black."""
    channels = [round(c + (255 - c) * share) for c in ((colour >> shift) & 0xFF for shift in (24, 16, 8))]
    return channels[0] << 24 | channels[1] << 16 | channels[2] << 8 | 0xFF


def token_label(predicate: str, parameters: Mapping[str, Any]) -> str:
    """The predicate and its first two decided parameters, a number with its name: `PointAt Earth`, `thrust level 6`."""
    decided = []
    for name, value in parameters.items():
        if isinstance(value, str):
            decided.append(value.rpartition(".")[2] or value)
        elif isinstance(value, bool):
            continue
        elif isinstance(value, int | float):
            decided.append(f"{name} {value:g}")
    short = predicate.rpartition(".")[2] or predicate
    return " ".join([short, *decided[:2]])


def elapsed(time: int) -> str:
    """Simulation seconds as `2d 11:54:07`, or `11:54:07` within the first day."""
    sign, time = ("-", -time) if time < 0 else ("", time)
    days, rest = divmod(time, 86_400)
    clock = f"{rest // 3600:02d}:{rest // 60 % 60:02d}:{rest % 60:02d}"
    return f"{sign}{days}d {clock}" if days else f"{sign}{clock}"


def entity(name: str) -> str:
    """A name as one part of an entity path: letters, digits, `_`, `-` and `.` stay, the rest becomes `_`."""
    return re.sub(r"[^\w.-]+", "_", name, flags=re.ASCII).strip("_") or "_"
