import importlib.metadata
import shutil
from collections import namedtuple

from sim import RenderingUnavailable, doctor


def by_need(findings):
    return {finding.need.split(" ", 1)[0]: finding for finding in findings}


def test_a_machine_that_runs_these_tests_can_fly(tmp_path):
    findings = doctor.examine(tmp_path / "not" / "there" / "yet")
    assert set(by_need(findings)) == {"Python", "mujoco", "numpy", "numba", "flight", "offscreen", "rerun-sdk", "disk"}
    assert all(finding.ok for finding in findings if finding.required), findings
    assert "settled" in by_need(findings)["flight"].found


def test_what_is_missing_comes_with_its_remedy(tmp_path, monkeypatch):
    def nothing(name):
        raise importlib.metadata.PackageNotFoundError(name)

    def no_gl():
        raise RenderingUnavailable("none that works")

    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr(importlib.metadata, "version", nothing)
    monkeypatch.setattr(doctor, "find_backend", no_gl)
    monkeypatch.setattr(shutil, "disk_usage", lambda place: usage(1, 1, 5_000_000))
    found = by_need(doctor.examine(tmp_path))
    assert (found["mujoco"].ok, found["mujoco"].remedy) == (False, "pip install 'mujoco>=4.0'")
    assert (found["offscreen"].ok, found["offscreen"].required) == (False, False)
    assert "libegl1" in found["offscreen"].remedy
    assert not found["disk"].ok
    assert "5 MB free" in found["disk"].found


def test_old_versions_are_seen(tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.metadata, "version", lambda name: "3.9.1")
    found = by_need(doctor.examine(tmp_path))
    assert not found["mujoco"].ok
    assert found["numpy"].ok
