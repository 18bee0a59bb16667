"""Why each token of a plan is there, as lines for a person and as JSON."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from planner.plan import FlexiblePlan, PlanToken
from planner.rationale import TokenRationale
from scenarios.drawing.text import bounds, parameters


@dataclass(frozen=True, slots=True)
class Rationale:
    """The rationales of a plan's tokens."""

    plan: FlexiblePlan
    tokens: tuple[TokenRationale, ...]

    def to_json(self) -> dict[str, Any]:
        """What `--json` prints."""
        return {
            "tokens": [
                {
                    "id": why.token,
                    "name": why.name,
                    "role": why.role,
                    "because": why.because,
                    "placing": why.placing,
                    "required_by": why.required_by,
                    "host": why.host,
                    "supports": list(why.supports),
                }
                for why in self.tokens
            ]
        }

    def lines(self) -> list[str]:
        """What a person reads: every slot with the reasons of all tokens that are one in it."""
        shown = {token.id: token for token in (*self.plan.tokens, *self.plan.boundary)}
        guests: dict[str, list[TokenRationale]] = {}
        for why in self.tokens:
            if why.host is not None:
                guests.setdefault(why.host, []).append(why)
        found: list[str] = []
        for why in self.tokens:
            if why.placing not in ("codesignated", "outside"):
                found += _host(why, guests.get(why.token, ()), shown)
        outside = [why for why in self.tokens if why.placing == "outside"]
        if outside:
            found.append("left open, since it may lie outside of the horizon:")
            found += [f"  {_named(shown[why.token])}: {_reason(why, shown)}" for why in outside]
        return found


def _host(why: TokenRationale, guests: Sequence[TokenRationale], shown: dict[str, PlanToken]) -> Iterator[str]:
    token = shown[why.token]
    place = f"{token.object}.{token.attribute}"
    yield f"{_named(token)} on {place}, start {bounds(token.start)}, end {bounds(token.end)}"
    yield f"    {_reason(why, shown)}"
    for guest in guests:
        yield f"    one with it, {guest.token}: {_reason(guest, shown)}"
    if why.supports:
        yield f"    supports {', '.join(_named(shown[i]) for i in why.supports)}"


def _reason(why: TokenRationale, shown: dict[str, PlanToken]) -> str:
    if why.required_by is None:
        word = {"subgoal": "stated", "state": "holds at the start"}.get(why.role, why.role)
        return f"{word}: {why.because}"
    name = why.name.rpartition("/")[2]
    return f"required by {_named(shown[why.required_by])}, as {name!r} in {why.because}"


def _named(token: PlanToken) -> str:
    return f"{token.id} {token.predicate}({parameters(token)})"
