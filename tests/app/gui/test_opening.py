from __future__ import annotations

import argparse
import shutil
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from app.cli import load
from app.errors import UserError
from app.files.provenance import version
from app.gui.actions import actions, arriving, camera_actions, job_actions
from app.gui.panels.timeline import place
from app.gui.state.app_state import AppState
from app.gui.state.source import Source
from app.gui.update.jobs import start_due
from app.gui.work.opening import Opened, OpenRequest, open_path
from app.gui.work.settings import Places, Settings
from app.runs.run_folder import ClipRecord, RunFolder, RunRecord
from app.runs.train_run import TrainRequest
from app.scenes.drawer import draw_view
from assets import phantom_path
from renderer.clip import ClipError
from renderer.gaussians import DynamicGaussians
from renderer.phantom import PhantomParams, write_phantom
from renderer.readers.clip_options import ClipOptions
from renderer.sources import open_clip
from renderer.splat_files.inria_ply import ply_bytes
from renderer.train.config import TrainConfig
from renderer.train.events import Progress
from tests.app.gui.conftest import FakeJob, make_clip


def opened(path: Path) -> Opened:
    (answer,) = open_path(OpenRequest(path))
    return answer


def make_run(folder: Path, clip_path: Path, model: DynamicGaussians | None) -> RunFolder:
    clip, run = open_clip(clip_path), RunFolder(folder)
    record = ClipRecord(
        path=str(clip_path),
        name=clip.name,
        sha256="0" * 64,
        frames=len(clip),
        unit=clip.unit,
        cameras=(clip.cameras[0].to_json(),),
    )
    config = TrainConfig(iterations=40)
    run.create(
        RunRecord(version=version(), created="2020-01-01", clip=record, input="enhanced", config=config)
    )
    for iteration in (20, 40):
        run.log(Progress(iteration, 40, 0.1, 20.0 + iteration, 1.0, 0.0, 30))
    if model is not None:
        run.save_model(model)
    return run


def session(places: Places, path: Path) -> AppState:
    state = AppState(places, Settings(acknowledged=True))
    arriving.show_opened(state, path, opened(path))
    return state


def test_a_finished_run_shows_its_clip_its_model_and_its_curves(
    tmp_path: Path, places: Places, model: DynamicGaussians
) -> None:
    run = make_run(tmp_path / "run-1", phantom_path(), model)
    state = session(places, run.path)
    assert state.source.clip is not None
    assert state.source.clip.name == "phantom"
    assert state.scene.model is not None
    assert (state.scene.model.name, state.scene.model.live, state.scene.model.iteration) == (
        "run-1",
        False,
        40,
    )
    assert state.scene.model.cameras[0] == state.source.clip.cameras[0]
    assert state.runs.reconstruction.status == "finished"
    assert state.runs.reconstruction.input == "enhanced"
    assert [point.iteration for point in state.runs.reconstruction.told.progress] == [20, 40]
    assert not job_actions.can_continue(state)


def test_what_one_looks_at_stays_with_another_run_of_the_clip(
    tmp_path: Path, places: Places, model: DynamicGaussians
) -> None:
    first, second = (make_run(tmp_path / name, phantom_path(), model) for name in ("run-1", "run-2"))
    state = session(places, first.path)
    state.scene.size = (32, 24)
    actions.seek(state, 3)
    state.picture.view = replace(state.picture.view, zoom=2.0)
    camera_actions.turn(state, 0.3, 0.1)
    camera_actions.toggle_measuring(state)
    free = state.scene.viewer.free
    arriving.show_opened(state, second.path, opened(second.path))
    assert state.scene.model is not None
    assert (state.scene.model.name, state.timeline.frame_index, state.picture.view.zoom) == ("run-2", 3, 2.0)
    assert free is not None
    assert (state.scene.viewer.free, state.scene.viewer.measuring) == (free, False)
    other = make_clip(tmp_path / "other")
    arriving.show_opened(state, other.path, Opened(other))
    assert (state.timeline.frame_index, state.picture.view.zoom) == (0, None)
    assert state.scene.viewer.free is None


def test_the_model_file_opens_its_run(tmp_path: Path, model: DynamicGaussians) -> None:
    run = make_run(tmp_path / "run-1", phantom_path(), model)
    answer = opened(run.model_path)
    assert answer.run is not None
    assert answer.run.path == run.path


def test_the_record_of_a_run_opens_its_run(tmp_path: Path, places: Places, model: DynamicGaussians) -> None:
    run = make_run(tmp_path / "run-1", phantom_path(), model)
    state = AppState(places, Settings(acknowledged=True))
    actions.open_path(state, run.record_path)
    assert state.source.opening is not None
    assert state.source.opening.path == run.path


def test_a_file_of_splats_is_shown_alone(tmp_path: Path, places: Places, model: DynamicGaussians) -> None:
    run = make_run(tmp_path / "run-1", phantom_path(), model)
    state = session(places, run.path)
    raw = model.raw
    raw.means[0] = np.nan
    (tmp_path / "some.ply").write_bytes(ply_bytes(raw))
    arriving.show_opened(state, tmp_path / "some.ply", opened(tmp_path / "some.ply"))
    assert state.source.clip is None
    assert state.runs.reconstruction.status == "none"
    assert state.scene.model is not None
    assert (len(state.scene.model.model), state.scene.model.name) == (len(model) - 1, "some.ply")
    assert any("1 of" in line for line in state.window.log)
    state.scene.size = (32, 24)
    assert state.view_request is not None
    (view,) = draw_view(state.view_request)
    assert view.image.any()
    assert state.scene.model.record.splats is not None
    assert state.scene.model.record.splats.name == "some.ply"


def test_an_unfinished_run_can_be_continued(tmp_path: Path, places: Places) -> None:
    run = make_run(tmp_path / "run-1", phantom_path(), None)
    state = session(places, run.path)
    assert state.scene.model is None
    assert job_actions.can_continue(state)
    jobs: list[FakeJob] = []
    job_actions.continue_reconstruction(state)
    start_due(state, lambda request: jobs.append(FakeJob(request)) or jobs[0])
    request = jobs[0].request
    assert isinstance(request, TrainRequest)
    assert (request.resume, request.run_path, request.config) == (True, run.path, run.record().config)
    assert any("Continue" in line for line in state.window.log)


def test_a_run_whose_clip_is_gone_still_shows_its_model(
    tmp_path: Path, places: Places, model: DynamicGaussians
) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(phantom_path(), copy)
    run = make_run(tmp_path / "run-1", copy, model)
    shutil.rmtree(copy)
    state = session(places, run.path)
    assert state.source.clip is None
    assert state.scene.model is not None
    state.scene.size = (32, 24)
    actions.seek_view(state, 0.5)
    assert state.view_request is not None
    assert state.view_request.time == 0.5
    assert any("clip cannot be opened" in line for line in state.window.log)
    count = len(state.scene.model.cameras)
    assert place(state) % 13 == f"frame 13 / {count}"
    state.scene.model = replace(state.scene.model, first=5)
    actions.seek_view(state, 2 / count)
    assert place(state) % 3 == f"frame 8 · 3 / {count}"


def test_a_lone_model_file_is_refused_in_one_line(tmp_path: Path, model: DynamicGaussians) -> None:
    path = tmp_path / "model.safetensors"
    model.save(path)
    with pytest.raises(UserError, match="run") as caught:
        opened(path)
    assert "\n" not in str(caught.value)


def test_a_text_is_no_file_of_cameras_unless_it_lies_beside_some(tmp_path: Path) -> None:
    notes = tmp_path / "notes.txt"
    notes.write_text("hello")
    with pytest.raises(ClipError, match=r"expected an image or a video, got .*notes\.txt$"):
        opened(notes)
    (tmp_path / "images.txt").write_text("# Nothing.")
    with pytest.raises(UserError, match=r"expected a report, views or cameras: .*cameras\.txt$"):
        opened(notes)


def test_a_clip_whose_first_picture_is_damaged_is_refused(tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(phantom_path(), copy)
    first = min((copy / "images").iterdir())
    first.write_bytes(first.read_bytes()[:200])
    with pytest.raises(ClipError, match=first.name):
        opened(copy)


@pytest.fixture
def inverted(tmp_path: Path) -> Path:
    """A clip whose masks have 255 on the tissue."""
    folder = tmp_path / "inverted"
    params = PhantomParams(n_frames=3, width=64, height=48, tools=True)
    write_phantom(folder, params, "endonerf")
    for path in (folder / "masks").iterdir():
        cv2.imwrite(str(path), 255 - cv2.imread(str(path), cv2.IMREAD_UNCHANGED))
    return folder


def test_what_is_said_at_the_start_reaches_the_clip_and_its_reconstruction(
    places: Places, inverted: Path
) -> None:
    with pytest.raises(ClipError, match="--mask-polarity tissue"):
        opened(inverted)
    state = AppState(places, Settings(acknowledged=True), Source(ClipOptions(mask_polarity="tissue")))
    actions.open_path(state, inverted)
    assert state.source.opening is not None
    (answer,) = open_path(state.source.opening)
    arriving.show_opened(state, inverted, answer)
    assert state.source.clip is not None
    assert state.source.clip.read_frame(0).tissue_mask.mean() > 0.5
    jobs: list[FakeJob] = []
    job_actions.start_reconstruction(state)
    start_due(state, lambda request: jobs.append(FakeJob(request)) or jobs[0])
    request = jobs[0].request
    assert isinstance(request, TrainRequest)
    assert request.clip_options.mask_polarity == "tissue"


def test_the_flags_of_the_app_are_those_of_the_refusals(
    inverted: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    started: list[tuple[tuple[Path, ...], ClipOptions]] = []

    def run_app(paths: tuple[Path, ...], options: ClipOptions, live: object) -> None:
        assert live is None
        started.append((paths, options))

    monkeypatch.setattr("app.gui.window.run_app", run_app)
    monkeypatch.setattr("app.commands.gui.has_display", lambda: True)
    command, parser = load("gui"), argparse.ArgumentParser()
    command.add_flags(parser)
    command.run(parser.parse_args([str(inverted), "--mask-polarity", "tissue", "--bottom-rows", "4"]))
    assert started == [((inverted,), ClipOptions(mask_polarity="tissue", bottom_rows=4))]
    # As a file manager gives what is marked.
    command.run(parser.parse_args([str(inverted), str(inverted.parent)]))
    assert started[1:] == [((inverted, inverted.parent), ClipOptions())]
    with pytest.raises(UserError, match="no such file or folder: missing"):
        command.run(parser.parse_args([str(inverted), "missing.mp4"]))
    with pytest.raises(UserError, match="--mask-polarity"):
        command.run(parser.parse_args([str(inverted), "--mask-polarity", "tisue"]))


def test_of_a_cut_video_it_is_said_in_sight_that_a_part_is_missing(places: Places, tmp_path: Path) -> None:
    path, noise = tmp_path / "cut.avi", np.random.default_rng(0)
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 25.0, (64, 48))
    for _ in range(60):
        writer.write(noise.integers(0, 255, (48, 64, 3), dtype=np.uint8))
    writer.release()
    assert opened(path).warning == ""
    content = path.read_bytes()
    path.write_bytes(content[: int(0.6 * len(content))])
    cut, state = opened(path), AppState(places)
    assert cut.clip is not None
    arriving.show_opened(state, path, cut)
    assert state.window.banner is not None
    said = f"the file is cut off or damaged at its end: {len(cut.clip)} of 60 frames are whole"
    assert state.window.banner.message == said
