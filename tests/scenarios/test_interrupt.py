"""Ctrl-C counts wherever it comes, also where Python cannot raise it."""

from __future__ import annotations

import signal
import subprocess
import sys
import weakref

import pytest

from scenarios.interrupt import children_deaf_to_it, interruptible


class Thing:
    pass


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_is_raised_at_once(number: signal.Signals) -> None:
    before = signal.getsignal(number)
    with interruptible() as check:
        check()
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(number)
        with pytest.raises(KeyboardInterrupt):
            check()
    assert signal.getsignal(number) is before


def test_only_children_are_deaf_to_it() -> None:
    """Held back while they begin, and heard after."""
    deaf = "import sys; print(); sys.exit(sys.stdin.read() != 'go on')"
    children = []

    def begin() -> None:
        with children_deaf_to_it():
            child = subprocess.Popen(
                [sys.executable, "-c", deaf], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
            )
            children.append(child)
            signal.raise_signal(signal.SIGINT)

    with interruptible(), pytest.raises(KeyboardInterrupt):
        begin()
    [child] = children
    assert child.stdout is not None
    child.stdout.readline()  # it is up, and would hear
    child.send_signal(signal.SIGINT)
    child.communicate("go on", timeout=30)
    assert child.returncode == 0


def test_it_is_not_lost_in_a_callback_of_the_collector(capsys: pytest.CaptureFixture[str]) -> None:
    with interruptible() as check:
        thing = Thing()
        reference = weakref.ref(thing, lambda _: signal.raise_signal(signal.SIGINT))
        del thing
        assert reference() is None
        with pytest.raises(KeyboardInterrupt):
            check()
    assert capsys.readouterr().err == ""


def test_what_else_goes_wrong_there_is_still_told(capsys: pytest.CaptureFixture[str]) -> None:
    heard: list[object] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.unraisablehook", heard.append)
        with interruptible():
            thing = Thing()
            reference = weakref.ref(thing, lambda _: 1 // 0)
            del thing
    assert reference() is None
    assert len(heard) == 1
