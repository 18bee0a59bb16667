"""Ctrl-C counts wherever it comes, also where Python cannot raise it."""

from __future__ import annotations

import signal
import weakref

import pytest

from scenarios.interrupt import interruptible


class Thing:
    pass


def test_it_is_raised_at_once() -> None:
    before = signal.getsignal(signal.SIGINT)
    with interruptible() as check:
        check()
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is before


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
