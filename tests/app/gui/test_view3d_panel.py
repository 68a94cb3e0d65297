"""The 3D view: turned, measured and compared by hand."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import ImVec2, imgui

from app.enhancement.setting_words import worded
from app.exports.records import PanesPicture
from app.gui.actions import (
    actions,
    camera_actions,
    comparing,
    enhancement_actions,
    export_actions,
    path_actions,
)
from app.gui.drawing.viewport import OnScreen
from app.gui.panels.scene_marks import Sight
from app.gui.panels.view3d import draw_view3d
from app.gui.state.app_state import AppState
from app.gui.state.panes import pane
from app.gui.state.tags import cautions
from app.gui.state.view_words import frame_over, view_tags
from app.gui.style.widgets import Area
from app.gui.work.settings import Places
from app.kernels.progress import Preparation, tasks
from app.runs.run_folder import RunFolder
from app.scenes.backgrounds import BackgroundName
from app.scenes.drawer import draw_view
from app.scenes.records import ClipSource
from app.scenes.view_request import read_frame
from renderer.clip import ByteImage
from renderer.gaussians import DynamicGaussians
from renderer.readers.lenses.calibration import Calibration, FoundLens, LensCalibration
from renderer.unobserved import GREY
from tests.app.gui.conftest import start_live
from tests.app.gui.exporting import Exporter
from tests.app.gui.settling import show_finished
from tests.app.gui.ui import (
    Draw,
    Shown,
    StillViewport,
    Ui,
    texts,
    view3d,
)


class Laid(Shown):
    """Remembers every frame that was laid over a view."""

    def __init__(self) -> None:
        super().__init__()
        self.laid: list[ByteImage] = []

    def whole(self, slot: str, image: ByteImage) -> imgui.ImTextureRef:
        self.laid.append(image)
        return super().whole(slot, image)


def test_the_3d_view_turns_moves_and_zooms(ui: Ui, opened: AppState, model: DynamicGaussians) -> None:
    start_live(opened, model)
    draw: Draw = lambda: view3d(opened)  # noqa: E731
    ui.frame(draw)
    middle = np.array([[0.0, 0.0, 50.0]])

    def seen(point: np.ndarray) -> tuple[np.ndarray, float]:
        assert opened.view_request is not None
        at, depth = opened.view_request.camera.project(point)
        return at[0], float(depth[0])

    start, _ = seen(middle)
    ui.drag(draw, (400, 300), (500, 340))
    assert seen(middle)[0] == pytest.approx(start)
    assert seen(middle * 0.9)[0][0] > start[0] + 1  # The near side follows the hand.
    assert seen(middle * 0.9)[0][1] > start[1] + 1
    ui.drag(draw, (400, 300), (450, 320), button=1)
    assert seen(middle)[0] == pytest.approx(start + np.array((50, 20)))
    ui.scroll(draw, (400, 300), 2.0)
    assert seen(middle)[1] < 45
    assert not opened.scene.dragged


def test_a_double_click_asks_for_the_point_under_the_pointer(
    ui: Ui, opened: AppState, model: DynamicGaussians
) -> None:
    start_live(opened, model)
    draw: Draw = lambda: view3d(opened)  # noqa: E731
    ui.frame(draw)
    for _ in range(2):
        ui.drag(draw, (400, 300), (400, 300))
    assert opened.scene.viewer.pick is not None
    assert opened.scene.viewer.free is None
    width, height = opened.scene.size
    left, top = (900 - width) // 2, 700 - imgui.get_style().window_padding.y - height
    assert opened.scene.viewer.pick.pixel == (400 - left, 300 - top)


def test_the_frame_lies_pixel_for_pixel_over_the_snapped_view(
    ui: Ui, opened: AppState, model: DynamicGaussians
) -> None:
    start_live(opened, model)
    assert opened.source.clip is not None
    actions.seek(opened, 4)
    camera_actions.toggle_snap(opened)
    wish = opened.frame_request
    assert wish is not None
    (opened.scene.viewer.frame_image,) = read_frame(wish)
    laid = Laid()

    def draw() -> None:
        view3d(opened, laid)

    ui.frame(draw)
    request = opened.view_request
    assert request is not None
    assert request.camera == opened.source.clip.cameras[4]
    (view,) = draw_view(request)
    assert view.image.shape == laid.laid[0].shape
    np.testing.assert_array_equal(laid.laid[0], opened.source.clip.read_image(4))
    corner, size = ImVec2(10, 20), ImVec2(300, 200)
    (low, high), zoom = Sight(request.camera, Area(corner, size)).bounds, 200 / 40
    assert (high.x - low.x, high.y - low.y) == (zoom * 48, zoom * 40)  # Square pixels, all of them.
    # Also in a presentation without labels.
    assert "FRAME 50 %" in texts(cautions(view_tags(opened, opened.view_request)))
    ui.drag(draw, (400, 300), (420, 300))
    assert not opened.scene.viewer.snapped
    assert frame_over(opened, request) is None


def test_a_selection_is_no_difference_to_the_frame(opened: AppState, model: DynamicGaussians) -> None:
    start_live(opened, model)
    opened.scene.size = (300, 100)
    camera_actions.toggle_snap(opened)
    wish = opened.frame_request
    assert wish is not None
    (opened.scene.viewer.frame_image,) = read_frame(wish)
    assert opened.scene.model is not None
    opened.editing.tinted = replace(opened.scene.model, name="with a selection in colour")
    assert opened.view_request is not None
    assert opened.view_request.scene is opened.editing.tinted
    camera_actions.choose_view(opened, "difference")
    assert opened.view_request is not None
    assert opened.view_request.kind == "difference"
    assert opened.view_request == opened.plain_view_request


def test_a_frame_is_never_mixed_with_a_view_of_another_kind_or_camera(
    opened: AppState, model: DynamicGaussians
) -> None:
    start_live(opened, model)
    opened.scene.size = (300, 100)
    free = opened.view_request
    camera_actions.toggle_snap(opened)
    wish, snapped = opened.frame_request, opened.view_request
    assert wish is not None
    assert free is not None
    assert snapped is not None
    (frame,) = read_frame(wish)
    opened.scene.viewer.frame_image = frame
    assert frame_over(opened, free) is None
    assert frame_over(opened, snapped.of_kind("difference", frame)) is None
    assert frame_over(opened, snapped) is frame
    assert frame_over(opened, snapped.scaled(0.5)) is frame


def test_white_light_never_shows_an_enhanced_model_unnoticed(
    ui: Ui, opened: AppState, model: DynamicGaussians
) -> None:
    start_live(opened, model)
    assert opened.scene.model is not None

    def said() -> str:
        return texts(view_tags(opened, opened.view_request))

    ui.frame(lambda: view3d(opened))
    enhancement_actions.white_light(opened)
    assert "ENHANCED" not in said()  # Trained on the frames as recorded.
    opened.scene.model = replace(
        opened.scene.model, record=replace(opened.scene.model.record, input="enhanced")
    )
    assert "OF ENHANCED FRAMES · not white light" in said()
    enhancement_actions.toggle_enhancement(opened)
    assert "white light" not in said()
    enhancement_actions.peek(opened, True)
    assert "not white light" in said()
    camera_actions.toggle_snap(opened)
    assert opened.frame_request is not None
    (opened.scene.viewer.frame_image,) = read_frame(opened.frame_request)
    assert "FRAME 100 %" in said()
    assert "white light" not in said()
    enhancement_actions.peek(opened, False)
    assert "FRAME 50 %" in said()


def test_the_camera_path_is_drawn_over_the_view(ui: Ui, opened: AppState, model: DynamicGaussians) -> None:
    """A line, a small camera at each keyframe and one at the playhead; gone with its switch."""
    start_live(opened, model)
    draw: Draw = lambda: view3d(opened)  # noqa: E731
    ui.frame(draw)

    def vertices() -> int:
        ui.frame(draw)
        return imgui.get_draw_data().total_vtx_count

    counts = []
    for _ in range(3):
        camera_actions.turn(opened, 0.2, 0.1)
        path_actions.add_keyframe(opened)
        path_actions.seek_path(opened, 0.0)
        camera_actions.turn(opened, 0.0, -0.4)
        camera_actions.zoom(opened, 0.7)
        path_actions.toggle_path_shown(opened)
        without = vertices()
        path_actions.toggle_path_shown(opened)
        counts.append(vertices() - without)
    assert 0 < counts[0] < counts[1] < counts[2]


def test_two_reconstructions_share_camera_time_and_hand(
    ui: Ui, opened: AppState, model: DynamicGaussians
) -> None:
    start_live(opened, model)
    assert opened.scene.model is not None
    opened.scene.second.model = replace(opened.scene.model, name="another run", live=False)
    draw: Draw = lambda: view3d(opened)  # noqa: E731
    ui.frame(draw)
    ui.frame(draw)
    width = opened.scene.size[0]
    assert width == pytest.approx((900 - 20) / 2, abs=5)
    for x in (200, 700):  # On either of them.
        before = opened.view_request
        ui.drag(draw, (x, 300), (x + 40, 320))
        first, second = opened.view_request, opened.second_request
        assert first is not None
        assert second is not None
        assert first != before
        assert second == replace(first, scene=opened.scene.second.model)
        assert not opened.scene.dragged
    actions.seek(opened, 4)
    assert opened.second_request is not None
    assert opened.second_request.time == opened.time
    said = [texts(view_tags(opened, one)) for one in (opened.view_request, opened.second_request)]
    assert "another run" not in said[0]
    assert "another run" in said[1]
    assert "FREE VIEW" in said[0]
    camera_actions.toggle_snap(opened)
    assert opened.second_request.camera == opened.scene.model.cameras[4]
    wish = opened.frame_request
    assert wish is not None
    (opened.scene.viewer.frame_image,) = read_frame(wish)
    laid = Laid()
    ui.frame(lambda: view3d(opened, laid))
    assert len(laid.laid) == 2


def test_a_moment_is_told_by_the_clip_s_own_frames(opened: AppState, model: DynamicGaussians) -> None:
    start_live(opened, model)
    shown = opened.scene.model
    assert shown is not None
    count = len(shown.cameras)
    assert [shown.moment(index / count) for index in range(count)] == [
        f"frame {index + 1}" for index in range(count)
    ]
    assert shown.moment(1.5 / count) == "frame 2.5"
    assert replace(shown, first=4).moment(0.0) == "frame 5"
    for time in (0.0, 0.31, 0.5, 0.9):
        assert shown.time_of(shown.number_at(time)) == pytest.approx(time, abs=0.005 / count)
    actions.seek(opened, 2)
    opened.scene.size = (64, 48)
    assert "RECONSTRUCTION · frame 3" in texts(view_tags(opened, opened.view_request))


def test_a_still_model_has_no_time_and_the_same_room(
    ui: Ui, opened: AppState, model: DynamicGaussians
) -> None:
    start_live(opened, model)
    shown, opened.source.clip = opened.scene.model, None
    assert shown is not None
    rooms, times = [], []
    for cameras in (shown.cameras, shown.cameras[:1]):
        opened.scene.model = replace(shown, cameras=cameras)
        ui.frame(lambda: view3d(opened))
        rooms.append(opened.scene.size)
        ui.drag(lambda: view3d(opened), (700, 20), (823, 20))  # Where the slider is.
        times.append(opened.scene.own_time)
        opened.scene.own_time = 0.0
    assert rooms[0] == rooms[1]
    frames = times[0] * len(shown.cameras)
    assert 0 < frames < len(shown.cameras) - 1
    assert abs(frames - round(frames)) > 0.01  # Between two of them.
    assert times[1] == 0.0


def test_the_live_preview_and_reduced_views_are_tagged(opened: AppState, model: DynamicGaussians) -> None:
    start_live(opened, model)
    opened.scene.size = (64, 48)
    request = opened.view_request
    assert request is not None
    text = texts(view_tags(opened, request.scaled(0.5)))
    assert "LIVE PREVIEW · iteration 0 / 3,000" in text
    assert "REDUCED RESOLUTION" in text
    show_finished(opened, model)
    assert opened.view_request is not None
    text = texts(view_tags(opened, opened.view_request))
    assert "LIVE" not in text
    assert "REDUCED" not in text


def test_what_nobody_measured_is_said(opened: AppState, model: DynamicGaussians) -> None:
    start_live(opened, model)
    opened.scene.size = (64, 48)
    shown = opened.view_request
    assert shown is not None
    assert "ESTIMATED" not in texts(view_tags(opened, shown))
    scene = shown.scene
    lens = LensCalibration(fx=60, fy=60, cx=31.5, cy=23.5, distortion=(-0.2, 0, 0, 0))
    found = Calibration(lens=lens, found=FoundLens(deviation=0.01))
    for depth, poses, calibration, said in (
        (True, False, None, "ESTIMATED depth"),
        (False, True, None, "ESTIMATED camera poses"),
        (True, True, Calibration(lens=lens), "ESTIMATED depth and camera poses"),
        (True, True, found, "ESTIMATED depth, camera poses and lens"),
    ):
        clip = ClipSource(name="clip", sha256="", calibration=calibration)
        record = replace(scene.record, clip=clip)
        guess = replace(scene, is_guessed=depth, poses_are_estimated=poses, record=record)
        of_guess = replace(shown, scene=guess)
        assert said in texts(view_tags(opened, of_guess)).split(" | ")


class EmptyViewport(StillViewport):
    """Has no picture yet."""

    def show(self, state: AppState) -> OnScreen | None:
        return None


@pytest.mark.parametrize("name", ["grey", "hatched", "smooth", "black"])
def test_before_the_first_picture_the_pane_has_its_background(
    ui: Ui, opened: AppState, model: DynamicGaussians, name: BackgroundName
) -> None:
    start_live(opened, model)
    actions.choose_background(opened, name)
    waiting = EmptyViewport()
    ui.frame(lambda: draw_view3d(opened, waiting, waiting, Shown()))
    level = 0 if name == "black" else round(255 * GREY[0])
    filled = imgui.IM_COL32(level, level, level, 255)
    drawn = {vertex.col for part in imgui.get_draw_data().cmd_lists for vertex in part.vtx_buffer}
    assert filled in drawn
    assert (imgui.IM_COL32(0, 0, 0, 255) in drawn) == (name == "black")


def test_before_the_first_picture_the_pane_says_what_it_waits_for(
    opened: AppState, model: DynamicGaussians
) -> None:
    start_live(opened, model)
    assert texts(view_tags(opened, None)) == "DRAWING…"
    todo = tasks()
    opened.window.preparation = Preparation(todo, 2)
    told = texts(view_tags(opened, None))
    assert told == "PREPARING… | One-time preparation of the 3D view: about 30 s left"
    opened.window.preparation = Preparation(todo, 4)
    assert texts(view_tags(opened, None)) == "DRAWING…"


@pytest.mark.parametrize("name", ["original", "enhanced"])
def test_a_reconstruction_says_from_which_frames(places: Places, runs: dict[str, Path], name: str) -> None:
    """On screen, in a pane and above it on a page."""
    record = RunFolder(runs[name]).record()
    settings = record.enhancement.params if record.enhancement else None
    frames = "original frames" if settings is None else f"frames enhanced by {worded(settings)}"
    run = Exporter(places, runs[name])
    assert f"from {frames}" in texts(view_tags(run.state, run.state.view_request))
    comparing.choose_source(run.state, "left", "render")
    run.turn(6)
    assert run.state.picture.pictures is not None
    (first, *_) = pane(run.state, run.state.picture.pictures, "left").tags
    assert first.text.endswith(f"from {frames}")
    request = export_actions.export_request(run.state, "panes and 3D view")
    assert request is not None
    assert isinstance(request.record, PanesPicture)
    assert (request.record.views[0].caption or "").endswith(f"from {frames}")
    assert request.record.panes[0].title.endswith(f"from {frames}")
