"""What a reconstruction is made of: the depth of the clip, and the settings of its frames."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui
from PIL import Image

from app.gui.actions import (
    actions,
    clip_actions,
    depth_actions,
    enhancement_actions,
    history_actions,
    job_actions,
)
from app.gui.state.app_state import AppState
from app.gui.state.source import Source
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.views.measurement import Located, Measurement
from app.gui.work.depths import DepthRequest, read_depth
from app.gui.work.opening import OpenRequest, open_path
from app.gui.work.settings import UNKNOWN, Places, Settings, load_clips
from app.runs.run_folder import RunFolder
from app.runs.train_run import TrainRequest, run_training
from assets import phantom_path
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from renderer.camera import Camera
from renderer.readers.clip_options import ClipOptions
from renderer.sources import open_bare, open_clip
from renderer.train.config import TrainConfig
from tests.app.gui.driver import Driver, is_settled, wait
from tests.app.gui.settling import keep_all, served
from tests.renderer.eyes import write_eyes


def to_choices(ctx: imgui.test_engine.TestContext) -> None:
    """What follows is found among the choices of a reconstruction."""
    ctx.window_focus("//Reconstruction")
    ctx.yield_(2)
    ctx.set_ref(ctx.window_info("//Reconstruction/choices").id_)


def write_video(path: Path, n_frames: int = 6) -> Path:
    """A folder of RGB images, as a video is: no depth, no right images."""
    path.mkdir(parents=True)
    rng = np.random.default_rng(3)
    lit = np.linspace(90, 200, 48)[None, :, None] * [1.0, 0.6, 0.5]
    for index in range(n_frames):
        Image.fromarray((lit + rng.normal(0, 6, (40, 48, 3))).clip(0, 255).astype(np.uint8)).save(
            path / f"{index:02d}.png"
        )
    return path


def turn(state: AppState, channels: Channels, times: int = 6) -> None:
    for _ in range(times):
        update(state, channels, state.window.now + 0.5)
        for channel in served(channels):
            while channel.run_waiting():
                pass


def opened(places: Places, path: Path, source: Source | None = None) -> tuple[AppState, Channels]:
    state, channels = AppState(places, Settings(acknowledged=True), source or Source()), Channels()
    actions.open_path(state, path)
    turn(state, channels)
    return state, channels


def test_a_clip_without_depth_can_be_guessed_and_loses_nothing(places: Places, tmp_path: Path) -> None:
    state, channels = opened(places, write_video(tmp_path / "video"))
    assert "Choose Depth first" in job_actions.why_not_reconstruct(state)
    assert "--depth" not in job_actions.why_not_reconstruct(state)
    assert depth_actions.why_no_depth(state).endswith("Guessed: no scale, so no distances in mm.")
    assert depth_actions.chosen_way(state) is None
    assert "no measured depth" in depth_actions.why_not(state, "measured")
    assert "no right images" in depth_actions.why_not(state, "stereo")
    depth_actions.choose_way(state, "stereo")  # Greyed.
    assert state.source.depth_wish is None
    enhancement_actions.set_params(state, EnhanceParams(z=0.3))
    actions.seek(state, 4)
    turn(state, channels)
    shown = state.picture.pictures
    assert shown is not None
    depth_actions.choose_way(state, "guessed")
    assert "Reading" in job_actions.why_not_reconstruct(state)
    update(state, channels, state.window.now + 0.01)
    channels.depths.run_waiting()
    update(state, channels, state.window.now + 0.01)
    assert state.picture.pictures is not None
    assert state.picture.pictures.enhanced is shown.enhanced  # Not even for a moment.
    turn(state, channels)
    assert job_actions.why_not_reconstruct(state) == ""
    assert (state.timeline.frame_index, state.enhancement.params) == (4, EnhanceParams(z=0.3))
    assert state.picture.pictures.request == state.picture_request
    assert depth_actions.without_scale(state) == "Guessed, from brightness: no scale, so no distances in mm."
    assert state.source.clip is not None
    assert state.source.clip.unit == "scene units"


def test_where_there_are_frames_enough_for_it_motion_is_offered_first(places: Places, tmp_path: Path) -> None:
    state, _ = opened(places, write_video(tmp_path / "video", 8))
    assert depth_actions.why_not(state, "motion") == ""
    assert "From motion if the endoscope moves" in depth_actions.why_no_depth(state)


def test_the_choice_is_in_the_request_and_is_there_the_next_time(places: Places, tmp_path: Path) -> None:
    path = write_video(tmp_path / "video")
    state, channels = opened(places, path)
    depth_actions.choose_way(state, "guessed")
    turn(state, channels)
    clip_actions.untrim(state)  # What is kept besides leaves it.
    job_actions.start_reconstruction(state)
    assert state.runs.queue[0].request.clip_options == ClipOptions(depth="brightness")
    keep_all(state)
    again, _ = opened(places, path, Source(known=load_clips(places.config)))
    assert again.source.clip is not None
    assert again.source.clip.depth_origin == "brightness"
    assert depth_actions.chosen_way(again) == "guessed"
    said, _ = opened(places, path, Source(ClipOptions(depth="off"), known=load_clips(places.config)))
    assert said.source.options.depth == "off"  # A flag goes before what was chosen.


def test_a_clip_is_shown_before_the_depth_that_was_chosen_for_it_is_read(
    places: Places, tmp_path: Path
) -> None:
    path = write_video(tmp_path / "video")
    known = {str(path): replace(UNKNOWN, depth="brightness")}
    state, channels = AppState(places, Settings(acknowledged=True), Source(known=known)), Channels()
    actions.open_path(state, path)
    update(state, channels, 0.5)
    channels.opening.run_waiting()
    update(state, channels, 1.0)
    assert state.source.clip is not None
    assert not state.source.clip.has_depth
    assert depth_actions.said(state) == "Reading the clip with this depth…"
    turn(state, channels)
    assert state.source.clip.depth_origin == "brightness"
    assert depth_actions.chosen_way(state) == "guessed"


def test_a_depth_that_is_chosen_again_while_it_is_read_arrives(places: Places, tmp_path: Path) -> None:
    state, channels = opened(places, write_video(tmp_path / "video"))
    depth_actions.choose_source(state, "brightness")
    update(state, channels, state.window.now + 0.01)
    depth_actions.choose_source(state, "brightness")
    turn(state, channels)
    assert state.source.depth_wish is None
    assert state.source.clip is not None
    assert state.source.clip.depth_origin == "brightness"


def test_why_there_is_no_depth_names_no_path(places: Places, tmp_path: Path) -> None:
    state, _ = opened(places, write_video(tmp_path / "video"))
    assert state.source.clip is not None
    why = f"no stereo depth: the rows are apart: {state.source.clip.path}"
    state.source.clip = replace(state.source.clip, why_no_depth=why)
    assert depth_actions.why_no_depth(state).startswith("No stereo depth: the rows are apart. Guessed")


def test_undo_takes_the_depth_back(places: Places, tmp_path: Path) -> None:
    state, channels = opened(places, write_video(tmp_path / "video"))
    enhancement_actions.settle_params(state)
    depth_actions.choose_way(state, "guessed")
    turn(state, channels)
    enhancement_actions.settle_params(state)
    assert history_actions.undo_name(state) == "Undo depth"
    history_actions.undo(state)
    turn(state, channels)
    assert state.source.clip is not None
    assert not state.source.clip.has_depth
    history_actions.redo(state)
    turn(state, channels)
    assert state.source.clip.has_depth


def test_measured_depth_is_the_clip_s_own_again(places: Places, tmp_path: Path) -> None:
    path = Path(shutil.copytree(phantom_path(), tmp_path / "phantom"))
    state, channels = opened(places, path)
    assert depth_actions.chosen_way(state) == "measured"
    for way, unit, option in (("guessed", "scene units", "brightness"), ("measured", "mm", "auto")):
        depth_actions.choose_way(state, way)  # type: ignore[arg-type]
        turn(state, channels)
        assert state.source.clip is not None
        assert (state.source.clip.unit, state.source.options.depth) == (unit, option)
        assert depth_actions.chosen_way(state) == way


def test_a_depth_that_is_gone_is_no_obstacle_to_open(tmp_path: Path) -> None:
    path = write_video(tmp_path / "video")
    (read,) = open_path(OpenRequest(path, ClipOptions(depth="stereo")))
    assert "without the chosen depth" in read.warning
    assert read.options.depth == "auto"
    assert read.clip is not None


def test_a_run_with_guessed_depth_has_no_lengths_in_mm(places: Places, tmp_path: Path) -> None:
    path, run = write_video(tmp_path / "video"), places.runs / "guessed"
    config = TrainConfig(method="static", iterations=4, n_gaussians=200)
    options = ClipOptions(depth="brightness")
    list(run_training(TrainRequest(clip_path=path, run_path=run, config=config, clip_options=options)))
    assert RunFolder(run).record().clip.options.depth == "brightness"
    state, _ = opened(places, run)
    assert state.scene.model is not None
    assert state.scene.model.unit == "scene units"
    distance = (
        Measurement().with_point(Located((0.0, 0.0, 1.0)), 0.0).with_point(Located((0.0, 0.5, 1.0)), 0.0)
    )
    assert distance.text(state.scene.model.unit) == "0.5 units (no scale)"


def test_a_run_cut_short_goes_on_with_the_depth_that_it_had(places: Places, tmp_path: Path) -> None:
    state, channels = opened(places, write_video(tmp_path / "video"))
    depth_actions.choose_way(state, "guessed")
    turn(state, channels)
    run = state.runs.reconstruction
    run.request = TrainRequest(
        clip_path=tmp_path / "video", run_path=places.runs / "cut", config=TrainConfig(),
        clip_options=state.source.options,
    )  # fmt: skip
    run.clip, run.status = state.source.clip, "cancelled"
    depth_actions.choose_source(state, "auto")
    turn(state, channels)
    job_actions.continue_reconstruction(state)
    (waiting,) = state.runs.queue
    assert waiting.request.clip_options.depth == "brightness"
    assert waiting.clip is None
    turn(state, channels)
    assert state.runs.queue[0].clip is not None
    assert state.runs.queue[0].clip.has_depth


def test_frames_follow_the_image_unless_unlinked(state: AppState) -> None:
    run = state.runs.reconstruction
    run.input = "enhanced"
    enhancement_actions.set_params(state, VesselParams(strength=1.0))
    assert job_actions.frame_settings(state) == VesselParams(strength=1.0)
    job_actions.link_settings(state, linked=False)
    enhancement_actions.set_params(state, EnhanceParams(d_factor=0.4))
    assert job_actions.frame_settings(state) == VesselParams(strength=1.0)
    assert run.kept is not None
    assert job_actions.moment(run.kept).count(":") == 1
    assert job_actions.moment(replace(run.kept, since="2020-01-02 09:30")) == "2020-01-02"
    job_actions.keep_settings_now(state)
    assert job_actions.frame_settings(state) == EnhanceParams(d_factor=0.4)
    job_actions.link_settings(state, linked=True)
    enhancement_actions.set_params(state, EnhanceParams())
    assert job_actions.frame_settings(state) == EnhanceParams()


@pytest.mark.display
def test_depth_and_frames_are_chosen_by_hand(places: Places, tmp_path: Path) -> None:
    driver = Driver(places, opens=write_video(tmp_path / "video"))
    state, jobs = driver.state, driver.jobs

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state) and state.source.depth_ways is not None, "the clip")
        ctx.window_focus("//Reconstruction")
        ctx.yield_(2)
        ctx.item_click("//Reconstruction/###start")
        ctx.yield_(3)
        assert not jobs  # Greyed.
        ctx.set_ref(ctx.window_info("//Reconstruction/choices").id_)
        ctx.combo_click("##depth/###guessed")
        wait(ctx, lambda: depth_actions.without_scale(state) != "", "depth")
        ctx.combo_click("##Frames/Enhanced")
        ctx.yield_(2)
        ctx.item_click("###linked")
        kept = state.enhancement.params
        ctx.window_focus("//Enhancement")
        ctx.yield_(2)
        ctx.item_input_value("//Enhancement/**/##strength", 0.5)
        ctx.set_ref("")
        ctx.yield_(2)
        assert state.enhancement.params.strength == 0.5
        assert job_actions.frame_settings(state) == kept
        ctx.window_focus("//Reconstruction")
        ctx.yield_(2)
        ctx.item_click("//Reconstruction/###start")
        wait(ctx, lambda: bool(jobs), "the job")
        request = jobs[0].request
        assert isinstance(request, TrainRequest)
        assert request.enhance_params == kept
        assert request.clip_options.depth == "brightness"
        state.window.closing = "agreed"

    driver.run(drive)


@pytest.mark.display
def test_baseline_and_field_of_view_are_typed_and_give_a_stereo_pair_a_scale(
    places: Places, tmp_path: Path
) -> None:
    write_eyes(
        tmp_path / "pair", "left/{:06d}.png", "right/{:06d}.png", 2, width=192, height=144, seed=41, tools=0
    )
    driver = Driver(places, opens=tmp_path / "pair")
    state = driver.state

    def drive(ctx: imgui.test_engine.TestContext) -> None:
        wait(ctx, lambda: is_settled(state) and state.source.depth_ways is not None, "the pair")
        clip = state.source.clip
        assert clip is not None
        assert depth_actions.without_scale(state) != ""
        before = clip.read_frame(0).depth
        assert before is not None
        to_choices(ctx)
        ctx.item_input_value("##baseline", "4.5")
        wait(ctx, lambda: depth_actions.without_scale(state) == "", "a scale")
        ctx.item_input_value("##view", "80")
        wait(ctx, lambda: state.source.options.field_of_view == 80, "another view")
        ctx.item_input_value("##view", "500")
        ctx.yield_(3)
        assert state.window.banner is not None
        assert "Field of view: expected" in state.window.banner.message
        assert state.source.options.field_of_view == 80
        clip = state.source.clip
        assert clip is not None
        now = clip.read_frame(0).depth
        assert now is not None
        assert clip.unit == "mm"
        camera = clip.read_frame(0).camera
        assert camera == clip.cameras[0] == Camera.from_fov(80, 192, 144)
        seen = before > 0
        scale = 4.5 * Camera.from_fov(80, 192, 144).fx / Camera.from_fov(60, 192, 144).fx
        np.testing.assert_allclose(now[seen], scale * before[seen], rtol=1e-4)
        ctx.item_input_value("##baseline", "")
        wait(ctx, lambda: depth_actions.without_scale(state) != "", "no scale")
        ctx.item_input_value("##baseline", "5")
        wait(ctx, lambda: depth_actions.without_scale(state) == "", "a scale")
        depth_actions.type_baseline(state, "5 mm")
        depth_actions.type_field_of_view(state, " 80°")
        assert state.source.depth_wish is None  # As they are.

    driver.run(drive)
    known = load_clips(places.config)[str(tmp_path / "pair")]
    assert (known.baseline, known.view_angle) == (5.0, 80.0)
    again, channels = opened(places, tmp_path / "pair", Source(known=load_clips(places.config)))
    turn(again, channels)
    assert (again.source.options.baseline, again.source.options.field_of_view) == (5.0, 80.0)
    # As the command line reads it.
    clip = open_clip(tmp_path / "pair", again.source.options)
    shown = again.source.clip
    assert shown is not None
    assert clip.cameras == shown.cameras
    np.testing.assert_array_equal(clip.read_frame(1).depth, shown.read_frame(1).depth)


def test_a_bare_clip_is_that_of_the_files(tmp_path: Path) -> None:
    assert not open_bare(write_video(tmp_path / "video"), ClipOptions(depth="brightness")).has_depth


def test_disparities_beside_the_images_become_depth_by_what_is_typed(tmp_path: Path) -> None:
    for index in range(3):
        Image.fromarray(np.full((48, 64, 3), 90 + index, np.uint8)).save(tmp_path / f"frame_{index}.png")
        Image.fromarray(np.full((48, 64), 5, np.float32)).save(tmp_path / f"frame_{index}_disparity.tiff")
    chosen = ClipOptions(field_of_view=120, baseline=4)
    (clip,) = read_depth(DepthRequest(open_bare(tmp_path), chosen))
    expected = open_clip(tmp_path, chosen)
    assert (clip.unit, clip.cameras) == (expected.unit, expected.cameras)
    np.testing.assert_array_equal(clip.read_frame(1).depth, expected.read_frame(1).depth)
