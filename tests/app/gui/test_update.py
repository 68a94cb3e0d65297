from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.enhancement.frame_enhancer import PictureRequest, Pictures
from app.gui.actions import actions, arriving, camera_actions, closing, enhancement_actions, job_actions
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels
from app.gui.update.jobs import start_due
from app.gui.update.update import PATIENCE, PROMPT, onward, take_pictures, update
from app.gui.update.wishes import SLOW_VIEW, view_wish
from app.gui.work.background import Channel, Worker
from app.gui.work.opening import Opened
from app.runs.job import Cancelled, Failed, Paused, Resumed
from app.runs.progress_log import TrainingLog
from app.scenes.drawer import View
from enhance import EnhanceParams
from renderer.clip import Clip, ClipError
from renderer.gaussians import DynamicGaussians
from renderer.train.events import Evaluated, Finished, Omission, Preparing, Progress, Started, Warned
from tests.app.gui.conftest import FakeJob, image_of, make_clip
from tests.app.gui.settling import follow_run, served, settle, show_live

MakeFake = Callable[[object], FakeJob]
STARTED = Started(0, 100, 30, (Omission("motion", "nothing moves", "half the time"),))


def test_the_pair_on_screen_is_of_one_request(state: AppState, channels: Channels) -> None:
    settle(state, channels)
    shown = state.picture.pictures
    assert shown is not None
    assert shown.request == state.picture_request
    assert shown.enhanced is not None
    assert shown.statistics is not None
    np.testing.assert_array_equal(shown.original, image_of(0))
    assert not state.pictures_are_stale


def test_a_slider_changes_the_enhanced_picture_alone(state: AppState, channels: Channels) -> None:
    settle(state, channels)
    before = state.picture.pictures
    enhancement_actions.set_params(state, EnhanceParams(z=0.0))
    assert state.pictures_are_stale
    settle(state, channels)
    after = state.picture.pictures
    assert before is not None
    assert after is not None
    np.testing.assert_array_equal(before.original, after.original)
    assert not np.array_equal(before.enhanced, after.enhanced)
    assert after.request.params == EnhanceParams(z=0.0)


def test_a_quick_picture_is_shown_by_the_frame_after_the_slider_moved(
    state: AppState, channels: Channels, monkeypatch: pytest.MonkeyPatch
) -> None:
    settle(state, channels)
    monkeypatch.setattr("app.gui.update.update.PROMPT", 10.0)
    worker = Worker(served(channels), lambda: None)
    enhancement_actions.set_params(state, EnhanceParams(z=0.0))
    update(state, channels, 0.1)
    worker.close()
    assert not state.pictures_are_stale
    assert state.picture.pictures is not None
    assert state.picture.pictures.enhanced is not None


def test_a_slow_picture_holds_no_frame(state: AppState, channels: Channels) -> None:
    settle(state, channels)
    assert state.picture.pictures is not None
    state.picture.pictures = replace(state.picture.pictures, milliseconds=500.0)
    enhancement_actions.set_params(state, EnhanceParams(z=0.0))
    channels.pictures.wait = lambda seconds: pytest.fail("the frame waits")  # type: ignore[method-assign]
    update(state, channels, 0.1)
    assert state.pictures_are_stale


def test_a_picture_that_is_late_is_waited_for_once(state: AppState, channels: Channels) -> None:
    """It was quick before, and something holds it up now."""
    settle(state, channels)
    assert state.picture.pictures is not None
    state.picture.pictures = replace(state.picture.pictures, milliseconds=1.0)
    waits: list[float] = []
    channels.pictures.wait = waits.append  # type: ignore[method-assign]
    enhancement_actions.set_params(state, EnhanceParams(z=0.0))
    for frame in range(3):
        update(state, channels, 0.1 * frame)
        take_pictures(state, channels)
    assert waits == [PROMPT]


def test_clip_statistics_are_the_same_for_every_frame(state: AppState, channels: Channels) -> None:
    state.enhancement.scope = "clip"
    seen = []
    for index in (0, 3):
        actions.seek(state, index)
        settle(state, channels)
        assert state.picture.pictures is not None
        seen.append(state.picture.pictures.statistics)
    assert seen[0] == seen[1]
    assert seen[0] is not None
    assert seen[0].scope == "clip"


class TwoSteps:
    """A picture channel whose answers the test lets through one by one."""

    def __init__(self) -> None:
        self.answers: list[Pictures] = []

    def work(self, request: PictureRequest) -> Iterator[Pictures]:
        yield self.answers.pop(0)


def test_the_first_frame_appears_before_its_enhanced_partner(state: AppState, channels: Channels) -> None:
    assert state.picture_request is not None
    steps = TwoSteps()
    steps.answers = [Pictures(state.picture_request, image_of(0))]
    channels.pictures = Channel(steps.work)
    settle(state, channels)
    assert state.picture.pictures is not None
    assert state.picture.pictures.enhanced is None


def test_a_later_frame_waits_for_its_partner_but_not_for_ever(state: AppState, channels: Channels) -> None:
    settle(state, channels)
    first, steps = state.picture.pictures, TwoSteps()
    channels.pictures = Channel(steps.work)
    actions.seek(state, 2)
    assert state.picture_request is not None
    steps.answers = [Pictures(state.picture_request, image_of(2))]
    settle(state, channels, now=10.0)
    assert state.picture.pictures is first
    settle(state, channels, now=10.0 + PATIENCE + 0.01)
    assert state.picture.pictures is not None
    np.testing.assert_array_equal(state.picture.pictures.original, image_of(2))


def test_a_clip_that_plays_enhanced_waits_for_every_partner(state: AppState, channels: Channels) -> None:
    settle(state, channels)
    first, steps = state.picture.pictures, TwoSteps()
    channels.pictures = Channel(steps.work)
    actions.toggle_play(state)
    actions.seek(state, 2)
    assert state.picture_request is not None
    steps.answers = [Pictures(state.picture_request, image_of(2))]
    settle(state, channels, now=10.0)
    settle(state, channels, now=20.0)
    assert state.timeline.playing
    assert state.picture.pictures is first


def test_a_moving_slider_never_flashes_the_original(state: AppState, channels: Channels) -> None:
    settle(state, channels)
    first, steps = state.picture.pictures, TwoSteps()
    channels.pictures = Channel(steps.work)
    enhancement_actions.set_params(state, EnhanceParams(z=0.1))
    assert state.picture_request is not None
    steps.answers = [Pictures(state.picture_request, image_of(0))]
    settle(state, channels, now=10.0)
    settle(state, channels, now=20.0)
    assert state.picture.pictures is first


def test_pictures_of_a_clip_that_was_left_are_dropped(
    state: AppState, channels: Channels, tmp_path: Path
) -> None:
    update(state, channels, 0.0)
    channels.pictures.run_waiting()
    other = make_clip(tmp_path / "other", 3)
    arriving.show_opened(state, other.path, Opened(other))
    update(state, channels, 0.1)
    assert state.picture.pictures is None
    settle(state, channels)
    assert state.picture.pictures is not None
    assert state.picture.pictures.request.clip is other


def test_a_frame_that_cannot_be_read_is_said_once(state: AppState, channels: Channels, clip: Clip) -> None:
    def broken(index: int) -> np.ndarray:
        raise ClipError(f"expected an image, got a cut-off file: {index}.png")

    settle(state, channels)
    state.source.clip = replace(clip, read_image=broken)
    settle(state, channels)
    assert state.window.banner is not None
    assert "0.png" in state.window.banner.message
    assert not state.timeline.playing
    state.window.banner = None
    settle(state, channels)
    assert state.window.banner is None


def test_playing_goes_at_the_clip_s_rate_and_wraps(state: AppState, channels: Channels) -> None:
    settle(state, channels)
    actions.toggle_play(state)
    frames = []
    for tick in range(1, 9):
        update(state, channels, tick * 0.1)
        frames.append(state.timeline.frame_index)
        settle(state, channels, tick * 0.1)
    assert frames == [1, 2, 3, 4, 5, 0, 1, 2]


def test_frames_of_an_uneven_clip_last_as_long_as_in_the_file(clip: Clip) -> None:
    uneven = replace(clip, frame_times=(0.0, 0.1, 0.2, 1.2, 1.3, 1.4))
    playhead, frames = 0.0, []
    for _ in range(17):
        playhead = onward(uneven, (0, 5), playhead, 0.1 + 1e-9)
        frames.append(int(playhead))
    assert frames == [1, *[2] * 10, 3, 4, 5, 0, 1, 2]
    assert onward(uneven, (2, 3), 3.5, 0.06) == pytest.approx(2.01)
    assert onward(uneven, (2, 3), 0.0, 0.1) == 2.0


def test_playing_waits_for_the_pictures(state: AppState, channels: Channels) -> None:
    settle(state, channels)
    actions.toggle_play(state)
    for tick in range(1, 6):  # Nothing is done in the background.
        update(state, channels, tick * 0.1)
    assert state.timeline.frame_index == 1


def test_playing_that_falls_behind_says_how_far(state: AppState, channels: Channels) -> None:
    settle(state, channels)
    actions.toggle_play(state)
    for tick in range(1, 81):  # The pictures of a frame come in four times the time that it lasts.
        update(state, channels, tick * 0.1)
        if tick % 4 == 0:
            settle(state, channels, tick * 0.1)
    assert state.timeline.pace == pytest.approx(0.25, abs=0.05)
    for tick in range(81, 161):
        update(state, channels, tick * 0.1)
        settle(state, channels, tick * 0.1)
    assert state.timeline.pace > 0.95
    actions.toggle_play(state)
    update(state, channels, 16.2)
    assert state.timeline.pace == 1


@pytest.mark.parametrize("content", ["missing", "empty", "text"])
def test_opening_nonsense_is_one_sentence_and_keeps_what_is_open(
    state: AppState, channels: Channels, clip: Clip, tmp_path: Path, content: str
) -> None:
    path = tmp_path / {"missing": "nothing", "empty": "folder", "text": "words.mp4"}[content]
    if content == "empty":
        path.mkdir()
    elif content == "text":
        path.write_text("not a video")
    actions.open_path(state, path)
    settle(state, channels)
    assert state.window.banner is not None
    assert str(path) in state.window.banner.message
    assert "\n" not in state.window.banner.message
    assert state.source.opening is None
    assert state.source.clip is clip


def test_a_job_is_followed_from_start_to_end(
    state: AppState, channels: Channels, make_job: MakeFake, model: DynamicGaussians
) -> None:
    job_actions.start_reconstruction(state)
    start_due(state, make_job)
    job, run = state.runs.reconstruction.job, state.runs.reconstruction
    assert isinstance(job, FakeJob)
    progress = Progress(10, 100, 0.5, 20.0, 1.0, 9.0, 30)
    stage = Preparing("matching left and right images", 3, 27, 2.0, 16.0)
    job.inbox = [stage]
    update(state, channels, 0.1)
    assert (run.status, run.preparing) == ("starting", stage)
    job.inbox = [STARTED, progress]
    update(state, channels, 0.1)
    assert (run.status, run.told.progress, run.omitted) == ("running", (progress,), STARTED.omitted)
    job.inbox, job.model = [Paused()], model
    update(state, channels, 0.2)
    follow_run(state)
    assert run.status == "paused"
    assert state.scene.model is not None
    assert state.scene.model.live
    job.inbox = [Resumed(), Warned("few Gaussians"), Evaluated(100, 31.0)]
    job.inbox.append(Finished(100, 12.0, model, wall_seconds=40.0))
    update(state, channels, 0.3)
    assert (run.status, run.warnings, run.told.evaluated[-1].psnr) == ("finished", ["few Gaussians"], 31.0)
    assert run.progress == replace(progress, wall_seconds=40.0)
    follow_run(state)
    assert not state.scene.model.live
    assert job.told[-1] == "close"
    assert run.job is None


def test_the_curves_of_a_run_that_goes_on_never_run_backwards(
    state: AppState, channels: Channels, make_job: MakeFake
) -> None:
    job_actions.start_reconstruction(state)
    start_due(state, make_job)
    run = state.runs.reconstruction
    assert isinstance(run.job, FakeJob)
    run.told = TrainingLog(tuple(Progress(done, 100, 0.5, 20.0, 1.0, 9.0, 30) for done in (10, 20, 27)))
    run.job.inbox = [replace(STARTED, iteration=20), Progress(25, 100, 0.4, 21.0, 1.0, 9.0, 30)]
    update(state, channels, 0.1)
    assert [point.iteration for point in run.told.progress] == [10, 20, 25]


@pytest.mark.parametrize(
    ("event", "status", "told"),
    [
        (Cancelled(), "cancelled", "reconstruction cancelled; Continue resumes it"),
        (Failed("out of memory"), "failed", "the reconstruction failed: out of memory"),
    ],
)
def test_a_job_that_ends_early_says_so(
    state: AppState, channels: Channels, make_job: MakeFake, event: object, status: str, told: str
) -> None:
    job_actions.start_reconstruction(state)
    start_due(state, make_job)
    assert isinstance(state.runs.reconstruction.job, FakeJob)
    state.runs.reconstruction.job.inbox = [STARTED, Progress(5, 100, 0.4, 21.0, 1.0, 9.0, 30), event]
    update(state, channels, 0.1)
    assert state.runs.reconstruction.status == status
    assert state.window.log[-1] == told
    assert job_actions.can_continue(state)


def test_what_has_not_done_a_step_is_not_said_to_be_resumed(
    state: AppState, channels: Channels, make_job: MakeFake
) -> None:
    job_actions.start_reconstruction(state)
    start_due(state, make_job)
    assert closing.what_is_kept(state) == "It has not done an iteration yet."
    assert isinstance(state.runs.reconstruction.job, FakeJob)
    state.runs.reconstruction.job.inbox = [STARTED, Cancelled()]
    update(state, channels, 0.1)
    assert state.window.log[-1] == "reconstruction cancelled"


def test_the_view_is_asked_for_only_when_it_changes(
    state: AppState, channels: Channels, make_job: MakeFake, model: DynamicGaussians
) -> None:
    job_actions.start_reconstruction(state)
    start_due(state, make_job)
    show_live(state, model)
    state.scene.size = (32, 24)
    settle(state, channels)
    first = state.scene.view
    assert first is not None
    assert first.image.shape == (24, 32, 3)
    settle(state, channels)
    assert state.scene.view is first
    camera_actions.turn(state, 0.1, 0.0)
    settle(state, channels)
    assert state.scene.view is not first


def test_a_slow_view_is_reduced_only_while_it_moves(
    state: AppState, make_job: MakeFake, model: DynamicGaussians
) -> None:
    job_actions.start_reconstruction(state)
    start_due(state, make_job)
    show_live(state, model)
    state.scene.size = (32, 24)
    request = state.view_request
    assert request is not None
    state.scene.view = View(request, np.zeros((24, 32, 3), np.uint8), 2 * SLOW_VIEW)
    assert view_wish(state) == request
    state.scene.dragged = True
    reduced = view_wish(state)
    assert reduced is not None
    assert reduced.reduced
    assert (reduced.camera.width, reduced.camera.height) == (16, 12)
    state.scene.view = View(request, state.scene.view.image, 0.5 * SLOW_VIEW)
    assert view_wish(state) == request


def test_toasts_go_away_by_themselves(state: AppState, channels: Channels) -> None:
    actions.announce(state, "saved")
    update(state, channels, 1.0)
    assert state.window.toast is not None
    update(state, channels, 60.0)
    assert state.window.toast is None


def test_but_not_behind_the_questions_of_the_start(
    state: AppState, channels: Channels, tmp_path: Path
) -> None:
    state.session.recoverable = tmp_path / "left.vesselsplat"
    actions.announce(state, "of 2 items only a.png opens")
    update(state, channels, 60.0)
    assert state.window.toast is not None
    state.session.recoverable = None
    update(state, channels, 62.0)
    assert state.window.toast is not None
    update(state, channels, 70.0)
    assert state.window.toast is None
