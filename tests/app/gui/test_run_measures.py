"""The measures of the finished run that is shown are those of `evaluate`, computed in the background."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import ImVec4

from app.evaluation.evaluate import measure_frame, open_evaluation
from app.evaluation.mean import mean_of_finite
from app.files.provenance import write_png
from app.gui.actions import arriving, edit_actions, run_actions
from app.gui.panels import run_measures
from app.gui.panels.reconstruction import draw_reconstruction
from app.gui.panels.run_measures import ROWS
from app.gui.state.app_state import AppState
from app.gui.style import widgets
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.work.opening import OpenRequest, open_path
from app.gui.work.run_measures import RunMeasuresRequest, measure_run
from app.gui.work.settings import Places
from app.runs.clip_selection import WHOLE
from app.runs.train_run import TrainRequest, run_training
from app.scenes.cpu_rendering import DrawOptions, draw_on_cpu
from app.scenes.scene import open_scene
from renderer.measuring.closeness import closeness
from renderer.near_plane import near_plane
from renderer.phantom import PhantomParams, write_phantom
from renderer.readers.clip_options import ClipOptions
from renderer.readers.lenses.calibration import Calibration, FoundLens, LensCalibration
from renderer.sources import open_clip
from renderer.train.config import TrainConfig
from tests.app.gui.ui import Ui

CONFIG = TrainConfig(iterations=12, n_gaussians=300, hold_out=True)


@pytest.fixture(scope="module")
def run_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("measured")
    write_phantom(folder / "clip", PhantomParams(n_frames=18, width=64, height=48, seed=1), "endonerf")
    list(
        run_training(
            TrainRequest(clip_path=folder / "clip", run_path=folder / "run", config=CONFIG, input="enhanced")
        )
    )
    return folder / "run"


@pytest.fixture
def opened(state: AppState, run_path: Path) -> AppState:
    (answer,) = open_path(OpenRequest(run_path))
    arriving.show_opened(state, run_path, answer)
    return state


@pytest.fixture
def lines(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What the panel says of the run's measures in the last frame."""
    said: list[str] = []
    real = widgets.muted

    def muted(text: str) -> None:
        said.append(text)
        real(text)

    cells = widgets.cell

    def cell(text: str, color: ImVec4 | None = None, tooltip: str = "") -> None:
        said.append(text)
        cells(text, color, tooltip)

    monkeypatch.setattr(run_measures, "muted", muted)
    monkeypatch.setattr(run_measures, "cell", cell)
    return said


def follow(state: AppState, ui: Ui, draw: Callable[[], None], channels: Channels, frames: int = 40) -> None:
    for step in range(frames):
        ui.frame(draw)
        update(state, channels, 1.0 + step)
        channels.run_measures.run_waiting()


def test_a_finished_run_is_measured_as_evaluate_does_and_says_so(
    opened: AppState, run_path: Path, ui: Ui, lines: list[str]
) -> None:
    channels = Channels()
    ui.frame(lambda: draw_reconstruction(opened))
    assert lines == ["Measuring the held-out frames…", *(text for row in ROWS for text in (row[0], "…"))]
    follow(opened, ui, lambda: draw_reconstruction(opened), channels)
    found = opened.runs.measures
    assert found is not None
    assert found.is_whole
    evaluation = open_evaluation(run_path)
    wanted = []
    for index in evaluation.indices:
        frame = evaluation.trained_clip.read_frame(index)
        near = near_plane(evaluation.model, frame.camera)
        drawn = draw_on_cpu(evaluation.model.at(frame.time), frame.camera, DrawOptions(near))
        wanted.append(measure_frame(frame, drawn, evaluation.clip, None, {}, evaluation.seldom))
    assert found.count == len(wanted) == 3
    for _, name, _, _ in ROWS:
        expected = mean_of_finite(getattr(each, name) for each in wanted)
        assert found.mean(name) == (None if expected is None else pytest.approx(expected))
    opened.runs.measures = replace(found, frames=found.frames[:1])
    lines.clear()
    ui.frame(lambda: draw_reconstruction(opened))
    assert lines[0] == "Measuring the held-out frames: 1 of 3"
    opened.runs.measures = found
    lines.clear()
    ui.frame(lambda: draw_reconstruction(opened))
    assert lines[:2] == ["Mean of 3 held-out frames", "PSNR"]
    covered = found.mean("coverage")
    assert covered is not None
    assert lines[-2:] == ["Covered tissue", f"{int(1000 * covered) / 10:.1f} %"]


def test_cameras_that_training_estimated_are_measured_through(unposed: Path, tmp_path: Path) -> None:
    """Also beside the clip as it was opened, which does not know them."""
    config = TrainConfig(iterations=4, n_gaussians=500)
    list(run_training(TrainRequest(clip_path=unposed, run_path=tmp_path / "run", config=config)))
    scene, evaluation = open_scene(tmp_path / "run"), open_evaluation(tmp_path / "run")
    assert scene.poses_are_estimated
    *_, last = measure_run(RunMeasuresRequest(scene, open_clip(unposed), WHOLE, config))
    frames = (evaluation.trained_clip.read_frame(index) for index in evaluation.indices)
    drawn = (
        (frame, evaluation.drawn(index)) for frame, index in zip(frames, evaluation.indices, strict=True)
    )
    wanted = [closeness(seen.bytes, seen.alpha, frame, None) for frame, seen in drawn]
    assert last.mean("psnr") == pytest.approx(mean_of_finite(each.psnr for each in wanted))


def test_images_are_undistorted_by_a_lens_that_training_found(opened: AppState, tmp_path: Path) -> None:
    """While the clip is open as its files are."""
    scene, images = opened.scene.model, tmp_path / "images"
    assert scene is not None
    assert scene.record.clip is not None
    lens = LensCalibration(fx=60, fy=60, cx=31.5, cy=23.5, distortion=(-0.2, 0, 0, 0))
    found = Calibration(lens=lens, found=FoundLens(deviation=0.01))
    record = replace(scene.record, clip=replace(scene.record.clip, calibration=found))
    opened.scene.model = replace(scene, record=record)
    asked = opened.run_measures_request
    assert asked is not None
    assert asked.lens == found
    images.mkdir()
    for at in range(3):
        write_png(images / f"{at}.png", np.random.default_rng(at).integers(0, 256, (48, 64, 3), np.uint8), {})
    seen = replace(asked, clip=open_clip(images), part=WHOLE).as_trained()
    straight = open_clip(images, ClipOptions(calibration=found))
    np.testing.assert_array_equal(seen.read_image(1), straight.read_image(1))


def test_measures_of_the_trained_model_say_so_beside_an_edited_one(
    opened: AppState, ui: Ui, lines: list[str]
) -> None:
    channels, note = Channels(), "Of the model as trained, without the edits."
    follow(opened, ui, lambda: draw_reconstruction(opened), channels)
    assert note not in lines
    edit_actions.follow(opened)
    edit_actions.toggle(opened)
    opened.editing.wish = None
    edit_actions.select_all(opened)
    edit_actions.hide(opened)
    ui.frame(lambda: draw_reconstruction(opened))
    assert note in lines


def test_a_run_from_another_folder_is_named(opened: AppState, run_path: Path, places: Places) -> None:
    assert run_actions.shown_from_elsewhere(opened) == run_path
    opened.places = replace(places, runs=run_path.parent)
    assert run_actions.shown_from_elsewhere(opened) is None


def test_all_but_all_of_the_tissue_is_never_said_to_be_all() -> None:
    (said,) = [said for label, _, said, _ in ROWS if label == "Covered tissue"]
    assert (said(1.0), said(0.9999), said(0.9973)) == ("100.0 %", "99.9 %", "99.7 %")


def test_nothing_is_measured_out_of_sight_or_with_another_depth(opened: AppState, ui: Ui) -> None:
    channels = Channels()
    follow(opened, ui, lambda: None, channels, 3)
    assert channels.run_measures.asked is None
    before = opened.source.options
    opened.source.options = replace(before, depth="brightness")
    follow(opened, ui, lambda: draw_reconstruction(opened), channels, 3)
    assert channels.run_measures.asked is None
    opened.source.options = before
    follow(opened, ui, lambda: draw_reconstruction(opened), channels, 3)
    assert channels.run_measures.asked is not None
    assert isinstance(before, ClipOptions)


def test_a_run_that_cannot_be_measured_says_where_to_read_why(
    opened: AppState, ui: Ui, lines: list[str]
) -> None:
    assert opened.source.clip is not None

    def gone(index: int) -> None:
        raise OSError("no such file")

    broken = replace(opened.source.clip, read_frame=gone)
    opened.source.clip = broken
    follow(opened, ui, lambda: draw_reconstruction(opened), Channels(), 4)
    lines.clear()
    ui.frame(lambda: draw_reconstruction(opened))
    assert lines == ["Not measured: see the log."]
    assert any("the run cannot be measured" in line for line in opened.window.log)
