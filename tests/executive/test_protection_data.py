"""Fault protection as data: what cannot be is refused, and only what can matter is kept of telemetry."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from executive.bindings import Bindings, Standby
from executive.conditions import Condition
from executive.errors import BindingsError
from executive.port import TelemetryValue
from executive.protection import Monitor, Probe, Recovery, Response
from executive.sends import Conclusion, Confirmation, Send
from executive.subscription import Subscription
from tests.executive.test_protection import AGAIN, DOWN, IGNORED, ON, SENSOR, TRIPPED, WRONG


def test_only_crossings_of_a_threshold_are_kept() -> None:
    bindings = replace(_bare(), monitors=(SENSOR,))
    subscription = Subscription(bindings)
    assert bindings.thresholds().keys() == {"amps"}
    assert subscription.of({"amps": 0.9, "bus": "off", "other": 1}, {"amps": 0.7, "bus": "on"}) == {"bus": "off"}
    assert subscription.of({"amps": 0.1}, {"amps": 0.7}) == {"amps": 0.1}
    assert subscription.of({"amps": 0.9}, {}) == {"amps": 0.9}
    observed = Subscription(replace(bindings, observed=("amps",)))
    assert observed.of({"amps": 0.9}, {"amps": 0.7}) == {"amps": 0.9}


def _bare() -> Bindings:
    return Bindings((), Standby((), Confirmation((ON,))), lambda telemetry, conclusions: ())


WRONG_DATA: dict[str, tuple[object, str]] = {
    "a vote too many": (lambda: replace(SENSOR, needed=3), "monitor 'sensor'.needed: expected 1 to 2 of the votes"),
    "otherwise the same": (lambda: Response("x", otherwise=Conclusion("x", "y")), "expected another conclusion"),
    "a recovery of nothing": (
        lambda: Response("x", (Recovery("r", (), 1),)),
        "recoveries 'r'.steps: expected at least",
    ),
    "a probe faster than its answer": (
        lambda: Probe("p", Send("ping"), 2, 3),
        "probe 'p'.every: .* at least 3, found 2",
    ),
    "no such channel": (
        lambda: replace(_bare(), monitors=(Monitor("m", (Condition("executive.x", "==", 1),), 0, DOWN),)),
        "condition on 'executive.x': the executive has no such channel",
    ),
    "a parameter that a monitor does not have": (
        lambda: replace(
            _bare(), monitors=(replace(SENSOR, conclusion=TRIPPED),), responses=(Response(TRIPPED.name, (AGAIN,)),)
        ),
        r"drawn by monitor 'sensor', recovery 'switch it on' command 'pump.on': unknown parameter '\$rate'",
    ),
    "in a circle": (
        lambda: replace(
            _bare(),
            monitors=(SENSOR,),
            responses=(Response(WRONG.name, otherwise=DOWN), Response(DOWN.name, otherwise=WRONG)),
        ),
        "'bus sensor wrong' leads back to itself",
    ),
    "two responses": (
        lambda: replace(_bare(), responses=(IGNORED, IGNORED)),
        "expected one response to 'bus sensor wrong', found 2",
    ),
}


@given(st.lists(st.sampled_from([0.0, 0.05, 0.1, 0.11, 0.3, 0.5, 0.7, 2.0]), max_size=12))
def test_what_is_kept_decides_as_all_of_it_would(values: list[float]) -> None:
    """Value after value: every comparison has the same answer for what was kept last as for what was seen last."""
    more = Monitor("m", (Condition("amps", ">=", 0.5), Condition("amps", "<", 0.3)), 0, DOWN)
    bindings = replace(_bare(), monitors=(SENSOR, more))
    subscription, kept = Subscription(bindings), dict[str, TelemetryValue]()
    for value in values:
        kept.update(subscription.of({"amps": value}, kept))
        for condition in bindings.thresholds()["amps"]:
            assert condition.holds(kept) is condition.holds({"amps": value})


@pytest.mark.parametrize("case", WRONG_DATA)
def test_wrong_data_is_refused_with_its_place(case: str) -> None:
    make, message = WRONG_DATA[case]
    assert callable(make)
    with pytest.raises(BindingsError, match=message):
        make()
