"""A reconstruction of a part of the open clip, in the window: what it is of, and at which frames."""

from __future__ import annotations

from pathlib import Path

import pytest

from app.enhancement.image_mask import PictureMask
from app.gui.actions import actions, arriving, clip_actions, job_actions, run_actions
from app.gui.panels.reconstruction import draw_reconstruction
from app.gui.state.app_state import AppState
from app.gui.state.panes import why_not
from app.gui.update.jobs import start_due
from app.gui.work.omissions import find_omissions
from app.gui.work.opening import OpenRequest, open_path
from app.gui.work.runs import RunFinder
from app.runs.clip_selection import WHOLE, ClipPart
from app.runs.train_run import TrainRequest, run_training
from app.scenes.view_request import ViewRequest
from renderer.gaussians import DynamicGaussians
from renderer.phantom import PhantomParams, write_phantom
from renderer.sources import open_clip
from renderer.train.config import TrainConfig
from tests.app.gui.conftest import FakeJob, start_live
from tests.app.gui.ui import Ui

MASK = PictureMask(text=(0, 0, 9, 9))


def trimmed(state: AppState, first: int, last: int) -> None:
    for frame, start in ((first, True), (last, False)):
        actions.seek(state, frame)
        clip_actions.trim_here(state, start=start)


@pytest.fixture
def live(state: AppState, model: DynamicGaussians) -> AppState:
    """Frames 2 to 4 of 6 are being reconstructed."""
    trimmed(state, 2, 4)
    clip_actions.set_mask(state, MASK)
    start_live(state, model)
    return state


def test_trim_and_mask_go_along_and_stay_what_they_were(live: AppState) -> None:
    request = live.runs.reconstruction.request
    assert request is not None
    assert request.part == ClipPart(trim=(2, 4), mask=MASK)
    clip_actions.untrim(live)
    job_actions.start_reconstruction(live)
    start_due(live, FakeJob)
    assert live.runs.reconstruction.request is request
    assert live.runs.queue[0].request.part == ClipPart(mask=MASK)


def test_the_3d_view_is_at_the_frame_that_the_pictures_are(live: AppState) -> None:
    """Its time is of the part; before and after it stands at its ends."""
    times = []
    for frame in range(6):
        actions.seek(live, frame)
        times.append(live.time)
    assert times == pytest.approx([0, 0, 0, 1 / 3, 2 / 3, 2 / 3])
    for time, frame in ((0.0, 2), (1 / 3, 3), (0.99, 4), (1.0, 4)):
        actions.seek_view(live, time)
        assert live.timeline.frame_index == frame
    assert live.has_frames
    live.scene.viewer.snapped = True
    for frame in (2, 3, 4):
        actions.seek(live, frame)
        assert live.frame_request is not None
        assert live.frame_request.frame == frame


def test_no_frame_beyond_it_is_shown_as_reconstructed(live: AppState) -> None:
    for frame in range(6):
        actions.seek(live, frame)
        reason = why_not(live, "render")
        assert bool(reason) == (frame not in (2, 3, 4)), reason
        if not reason:
            assert live.scene.model is not None
            assert ViewRequest.of_clip_frame(live.scene.model, frame).time == pytest.approx((frame - 2) / 3)


def test_what_is_left_out_is_looked_up_of_the_part(state: AppState) -> None:
    trimmed(state, 1, 1)
    state.runs.asks_for_omissions = True
    request = state.omissions_request
    assert request is not None
    *_, alone = find_omissions(request)
    assert any("deformation" in omission.what for omission in alone.omitted)  # One frame does not move.


def test_the_panel_says_so_before_anything_is_started(ui: Ui, state: AppState) -> None:
    ui.frame(lambda: draw_reconstruction(state))
    assert state.source.training_part == WHOLE
    trimmed(state, 2, 4)
    assert state.source.training_part.told(6) == "frames 3 to 5 of 6"
    ui.frame(lambda: draw_reconstruction(state))


def test_a_run_of_a_part_is_found_opened_and_continued_as_such(state: AppState, tmp_path: Path) -> None:
    clip = tmp_path / "real"
    write_phantom(clip, PhantomParams(n_frames=10, width=64, height=48, seed=1), "endonerf")
    part = ClipPart(trim=(3, 8), mask=MASK)
    config = TrainConfig(iterations=6, n_gaussians=300, checkpoint_every=2)
    path = state.places.runs / "part"
    list(run_training(TrainRequest(clip_path=clip, run_path=path, config=config, part=part)))
    (path / "model.safetensors").unlink()
    (answer,) = open_path(OpenRequest(path))
    arriving.show_opened(state, path, answer)
    assert state.source.clip is not None
    assert len(state.source.clip) == 10  # All of it is there to be looked at,
    assert state.source.part == part  # and what the run is of is marked.
    assert state.scene.model is not None
    assert (state.scene.model.first, len(state.scene.model.cameras), state.has_frames) == (3, 6, True)
    job_actions.continue_reconstruction(state)
    start_due(state, FakeJob)
    assert state.runs.reconstruction.request is not None
    assert state.runs.reconstruction.request.part == part
    state.runs.reconstruction.status = "failed"
    (tmp_path / "elsewhere").mkdir()
    state.source.clip, state.runs.is_listed = open_clip(clip.rename(tmp_path / "elsewhere" / "real")), True
    assert state.runs_request is not None
    (found,) = RunFinder().find(state.runs_request)
    assert [run.request.part for run in found.runs] == [part]
    assert not run_actions.why_not_continue(state, found.runs[0])
