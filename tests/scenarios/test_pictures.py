"""Pictures of a recording through the headless viewer, and the choice of the moment that they show."""

from __future__ import annotations

from pathlib import Path

import pytest

from scenarios.pictures import PicturesError, read_moments, take_pictures
from tests.scenarios import recorded_run as run
from tests.scenarios.recorded import event, small


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recording") / "run.rrd"
    with run.recorder(path) as recorder:
        run.tell(recorder, run.journal()[0])
    return path


def test_the_cursor_is_put_on_the_detection(recording: Path, tmp_path: Path) -> None:
    assert read_moments(recording) == [run.DETECTED, run.END]
    with small(tmp_path / "r.rrd") as recorder:
        recorder.event(event(0, "run.started", scenario="x", seed=1))
        recorder.event(event(1000, "run.finished", outcome="completed"))
    assert read_moments(tmp_path / "r.rrd") == [500]


@pytest.mark.gl
def test_pictures_of_every_tab(recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every view draws without a report (take_pictures raises on one), and no viewer process is left."""
    monkeypatch.setattr("scenarios.pictures._TOASTS_SECONDS", 0.0)
    psutil = pytest.importorskip("psutil")
    before = {process.pid for process in psutil.process_iter()}
    try:
        pictures = take_pictures(recording, tmp_path / "pictures", [run.DETECTED], (960, 540))
    except PicturesError as error:
        if "mesa-vulkan-drivers" in str(error):
            pytest.skip(str(error))
        raise
    names = ["0_mission", "1_attitude", "2_power", "3_camera", "4_plan_network", "5_events"]
    assert [p.name for p in pictures] == [f"{name}_06-03-00.png" for name in names]
    for picture in pictures:
        head = picture.read_bytes()[:24]
        assert head[:8] == b"\x89PNG\r\n\x1a\n"
        assert (int.from_bytes(head[16:20], "big"), int.from_bytes(head[20:24], "big")) == (960, 540)
    assert len({p.read_bytes() for p in pictures}) == 6
    new = [p for p in psutil.process_iter(["cmdline"]) if p.pid not in before]
    assert [p for p in new if "--headless" in (p.info["cmdline"] or [])] == []


def test_without_a_graphics_driver_the_package_is_named(
    recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for variable in ("VK_ICD_FILENAMES", "VK_DRIVER_FILES"):
        monkeypatch.setenv(variable, "/nonexistent")
    monkeypatch.setenv("WGPU_BACKEND", "vulkan")
    with pytest.raises(PicturesError, match="mesa-vulkan-drivers"):
        take_pictures(recording, tmp_path / "pictures")


def test_a_missing_or_foreign_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(PicturesError, match="no file"):
        take_pictures(tmp_path / "none.rrd", tmp_path)
    (tmp_path / "text.rrd").write_text("not a recording")
    with pytest.raises(PicturesError, match=r"text\.rrd"):
        take_pictures(tmp_path / "text.rrd", tmp_path)
