"""Files of a model through time play as fast as its clip, from the command line and from the window."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from shutil import copytree

import cv2
import pytest

from app.exports.browser.page import read_page
from app.exports.exporting import ExportRequest
from app.exports.records import BrowserModel
from app.gui.actions import export_actions
from app.gui.actions.export_doubts import doubts
from app.gui.actions.export_records import request_of as window_request
from app.gui.work.settings import Places
from app.runs.run_folder import RunFolder
from app.runs.train_run import run_training
from app.scenes.clip_speed import clip_speed
from app.scenes.scene import open_scene
from renderer.readers.clip_options import ClipOptions
from tests.app.conftest import Cli, request_of
from tests.app.gui.exporting import Exporter

FRAMES, RATE = 24, 25.0
ASSUMED = "how fast the clip goes is not known: 15 frames a second are assumed"


@pytest.fixture(scope="module")
def film(clip_path: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The frames of the phantom again and again, as a video. Read only."""
    path = tmp_path_factory.mktemp("film") / "scope.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), RATE, (64, 48))
    images = sorted((clip_path / "images").iterdir())
    for place in range(FRAMES):
        writer.write(cv2.imread(str(images[place % len(images)])))
    writer.release()
    return path


@pytest.fixture(scope="module")
def filmed_run(film: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Trained on every second frame. Read only."""
    path, options = tmp_path_factory.mktemp("filmed") / "run", ClipOptions(depth="brightness", frame_step=2)
    list(run_training(request_of(film, path, clip_options=options)))
    return path


def former(run: Path, folder: Path, clip: Path) -> Path:
    """The run as an earlier version wrote it, of a clip that lies there."""
    made = folder / "former"
    copytree(run, made)
    record = json.loads((made / "run.json").read_text())
    del record["clip"]["frames_per_second"]
    record["clip"]["path"] = str(clip)
    (made / "run.json").write_text(json.dumps(record))
    return made


def seconds_of(page: Path) -> float:
    _, scene, _ = read_page(page.read_text())
    return float(scene["seconds"])


def test_a_run_records_how_fast_its_frames_follow(filmed_run: Path, runs: dict[str, Path]) -> None:
    assert RunFolder(filmed_run).record().clip.frames_per_second == pytest.approx(RATE / 2)
    assert RunFolder(runs["original"]).record().clip.frames_per_second is None, "images do not tell"


def test_files_through_time_take_as_long_as_the_clip(
    filmed_run: Path, film: Path, tmp_path: Path, vesselsplat: Cli
) -> None:
    page, gone = tmp_path / "a.html", tmp_path / "gone.avi"
    for run in (filmed_run, former(filmed_run, tmp_path, film)):
        call = vesselsplat("export", run, "--html", page)
        assert (call.code, call.error) == (0, "")
        assert seconds_of(page) == pytest.approx(FRAMES / RATE)
        assert vesselsplat("export", run, "--html", page, "--frames-per-second", 6).error == ""
        assert seconds_of(page) == pytest.approx(FRAMES / 2 / 6)
    (tmp_path / "former").rename(tmp_path / "other")
    call = vesselsplat("export", former(filmed_run, tmp_path, gone), "--html", page)
    assert call.error.startswith(ASSUMED)
    assert call.error.count("\n") == 1
    assert seconds_of(page) == pytest.approx(FRAMES / 2 / 15)


def test_the_speed_is_assumed_aloud_only_where_something_plays(
    runs: dict[str, Path], tmp_path: Path, vesselsplat: Cli
) -> None:
    surface = vesselsplat("export", runs["original"], "--mesh", tmp_path / "a.glb", "--vertices", 200)
    assert surface.error.startswith(ASSUMED)
    for flags in (("--ply", tmp_path / "ply"), ("--mesh", tmp_path / "mesh", "--vertices", 200)):
        assert vesselsplat("export", runs["original"], *flags, "--frames", 0).error == ""


def test_a_video_of_the_frames_goes_as_the_clip(filmed_run: Path, tmp_path: Path, vesselsplat: Cli) -> None:
    call = vesselsplat("export", filmed_run, "--video", tmp_path / "a.mp4", "--size", 32, 24)
    assert call.code == 0, call.error
    facts = json.loads((tmp_path / "a.mp4.json").read_text())
    assert facts["frames_per_second"] == pytest.approx(RATE / 2)


@pytest.mark.parametrize("is_former", [False, True])
def test_the_window_agrees(
    is_former: bool, filmed_run: Path, film: Path, tmp_path: Path, places: Places
) -> None:
    run = former(filmed_run, tmp_path, film) if is_former else filmed_run
    window = Exporter(places, run)
    export_actions.choose_what(window.state, "page for browsers")
    assert doubts(window.state) == ""
    record = made(window)
    speed = clip_speed(open_scene(run))
    assert speed is not None
    assert record.seconds == pytest.approx(record.clip_frames / speed)


def test_the_window_says_that_it_assumes(runs: dict[str, Path], places: Places) -> None:
    window = Exporter(places, runs["original"])
    export_actions.choose_what(window.state, "splats of this moment")
    assert doubts(window.state) == ""
    for what in ("page for browsers", "video through time"):
        export_actions.choose_what(window.state, what)
        assert doubts(window.state).startswith("How fast the clip goes is not known")
    assert made(window).seconds == pytest.approx(10 / 15)


def test_the_window_says_that_uneven_frames_are_evened_out(filmed_run: Path, places: Places) -> None:
    """Of a model, whose moments are numbered; videos of the panes keep the times."""
    window = Exporter(places, filmed_run)
    clip = window.state.source.clip
    assert clip is not None
    times = tuple(index / RATE + (index > 3) for index in range(len(clip)))
    window.state.source.clip = replace(clip, frame_times=times)
    for what in ("page for browsers", "video through time"):
        export_actions.choose_what(window.state, what)
        said = "The frame rate of the clip varies: here frames follow evenly, at its average."
        assert doubts(window.state) == said
    for what in ("video of both panes", "splats of this moment"):
        export_actions.choose_what(window.state, what)
        assert doubts(window.state) == ""


def made(window: Exporter) -> BrowserModel:
    """What a page for browsers says of itself."""
    request: ExportRequest = window_request(window.state, "page for browsers", "a")
    assert isinstance(request.record, BrowserModel)
    return request.record
