"""Tools masked by hand in the window: strokes, what is kept of them, and masks of all other frames."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from imgui_bundle import ImVec2

from app.gui.actions import actions, clip_actions, laid_out, masking_actions
from app.gui.actions.job_actions import start_reconstruction
from app.gui.panels import masking as masking_panel
from app.gui.state.app_state import AppState
from app.gui.state.masking import THICKEST, THINNEST
from app.gui.state.panes import tinted
from app.gui.update.channels import Channels
from app.gui.update.jobs import start_due
from app.gui.update.update import update
from app.gui.views.picture_view import PictureView
from app.gui.work.background import Failure
from app.gui.work.masking import FrameMask
from app.live.picture import LIVE
from renderer.clip import BoolImage
from renderer.tools.brush import Stroke
from renderer.tools.mask_files import own_masks
from tests.app.gui.conftest import SIZE, FakeJob, make_clip
from tests.app.gui.settling import served
from tests.app.gui.ui import Ui


def settle(state: AppState, channels: Channels | None = None) -> Channels:
    channels = channels or Channels()
    for _ in range(8):
        update(state, channels, 1.0)
        for channel in (*served(channels), *channels.of("second")):
            while channel.run_waiting():
                pass
    return channels


@pytest.fixture
def masking(opened: AppState) -> AppState:
    return begun(opened)


def begun(state: AppState) -> AppState:
    """With the frame's mask shown."""
    masking_actions.toggle(state)
    settle(state)
    assert state.masking.shown is not None
    return state


def test_the_images_come_to_the_front_to_be_painted_on(opened: AppState) -> None:
    opened.source.asked = False
    masking_actions.toggle(opened)
    assert opened.source.asked
    laid_out.came(opened.source)
    masking_actions.toggle(opened)
    assert not opened.source.asked


def test_who_masked_a_frame_is_said_before_how_much(
    masking: AppState, monkeypatch: pytest.MonkeyPatch, ui: Ui
) -> None:
    said: list[str] = []
    monkeypatch.setattr(masking_panel, "note", lambda text, *_: said.append(text))
    masking_actions.clear_frame(masking)
    settle(masking)
    ui.frame(lambda: masking_panel.draw_masking(masking))
    assert "Masked by hand: no tool in this frame" in said
    masking_actions.choose_radius(masking, THINNEST)
    stroke(masking, (10.0, 20.0))
    ui.frame(lambda: masking_panel.draw_masking(masking))
    assert "Masked by hand: less than 1 % of this frame" in said


def shown(state: AppState) -> FrameMask:
    assert state.masking.shown is not None
    return state.masking.shown


def stroke(state: AppState, *points: tuple[float, float]) -> None:
    for point in points:
        masking_actions.paint(state, point)
    masking_actions.end_stroke(state)


def on_disk(state: AppState) -> dict[int, BoolImage]:
    files = own_masks(state.masks_folder, state.source.clip.labels if state.source.clip else ())
    return {index: mask for index in files.files if (mask := files.read(index, SIZE)) is not None}


def test_a_stroke_is_kept_and_counts_for_the_next_reconstruction(masking: AppState) -> None:
    assert not shown(masking).mask.any()
    assert masking.source.training_part.tool_masks is None
    masking_actions.choose_radius(masking, 3 / SIZE[0])
    stroke(masking, (10.0, 20.0), (30.0, 20.0))
    channels = settle(masking)
    mask = on_disk(masking)[0]
    assert mask[20, 10:31].all()
    assert not mask[:12].any()
    np.testing.assert_array_equal(tinted(masking), mask)
    assert masking.masking.there is not None
    assert masking.masking.there.frames("by hand") == (0,)
    start_reconstruction(masking)
    (waiting,) = masking.runs.queue
    assert waiting.request.part.tool_masks is not None
    assert waiting.request.part.tool_masks.folder == str(masking.masks_folder)
    actions.seek(masking, 3)
    settle(masking, channels)
    assert not shown(masking).mask.any()
    actions.seek(masking, 0)
    settle(masking, channels)
    np.testing.assert_array_equal(shown(masking).mask, mask)
    assert shown(masking).origin == "by hand"


def test_what_the_clip_itself_masks_is_shown_and_stays(opened: AppState) -> None:
    clip = opened.source.clip
    assert clip is not None
    kept = np.ones((SIZE[1], SIZE[0]), bool)
    kept[:, 40:] = False
    opened.source.clip = clip.within(kept)
    masking_actions.toggle(opened)
    settle(opened)
    assert opened.picture.pictures is not None
    assert tinted(opened) is not None
    np.testing.assert_array_equal(tinted(opened), ~kept)
    assert tinted(opened) is tinted(opened)
    masking_actions.choose_tool(opened, "erase")
    stroke(opened, (44.0, 20.0), (2.0, 20.0))
    np.testing.assert_array_equal(tinted(opened), ~kept)


def test_an_area_that_cannot_be_grown_leaves_the_frame_as_it_was(masking: AppState) -> None:
    before = shown(masking).mask
    masking_actions.choose_tool(masking, "grow")
    stroke(masking, (12.0, 10.0), (12.0, 30.0))
    request = masking.masking.growing
    assert request is not None
    masking_actions.take_grown(masking, request, Failure(MemoryError("no memory")))
    np.testing.assert_array_equal(shown(masking).mask, before)
    assert masking.masking.before is None


def test_an_area_grows_and_is_dropped_where_the_frame_has_changed(masking: AppState) -> None:
    masking_actions.choose_tool(masking, "grow")
    masking_actions.choose_radius(masking, 1.5 / SIZE[0])
    stroke(masking, (12.0, 10.0), (12.0, 30.0))
    assert masking.masking.growing is not None
    masking_actions.paint(masking, (40.0, 5.0))
    assert masking.masking.line == ()
    settle(masking)
    vessel = np.zeros_like(shown(masking).mask)
    vessel[10:30, 10:14] = True
    assert shown(masking).mask[vessel].mean() > 0.9
    assert np.count_nonzero(shown(masking).mask[10:30] & ~vessel[10:30]) < 0.2 * np.count_nonzero(vessel)
    before = on_disk(masking)
    stroke(masking, (40.0, 5.0), (40.0, 9.0))
    request = masking.masking.growing
    actions.seek(masking, 2)
    masking.masking.shown = None
    assert request is not None
    masking_actions.take_grown(masking, request, ~vessel)
    assert on_disk(masking).keys() == before.keys()


@pytest.mark.parametrize(
    ("text", "classes"),
    [
        ("", ()),
        (" 1 3", (1, 3)),
        ("2,4", (2, 4)),
        ("-1", None),
        ("1.5", None),
        ("tool", None),
        ("9" * 9, None),
    ],
)
def test_classes_of_a_network_are_whole_numbers(
    masking: AppState, text: str, classes: tuple[int, ...] | None
) -> None:
    masking_actions.type_network_tools(masking, text)
    assert masking_actions.network_tools(masking) == classes


def test_making_can_be_stopped(masking: AppState) -> None:
    channels = settle(masking)
    masking_actions.make_all(masking)
    for _ in range(3):
        update(masking, channels, 2.0)
        channels.made_masks.run_waiting()
    masking_actions.stop_making(masking)
    settle(masking, channels)
    assert masking.masking.making is None
    assert 0 < len(on_disk(masking)) < 6


@pytest.mark.parametrize(
    "end", [masking_actions.end_stroke, masking_actions.drop_stroke, masking_actions.toggle]
)
@pytest.mark.parametrize("tool", ["paint", "grow"])
def test_nothing_that_comes_up_during_a_stroke_breaks_it(
    masking: AppState, tool: Stroke, end: Callable[[AppState], None]
) -> None:
    masking_actions.choose_tool(masking, tool)

    def begin() -> None:
        masking_actions.paint(masking, (10.0, 20.0))
        masking_actions.paint(masking, (14.0, 20.0))

    begin()
    masking_actions.undo(masking)
    assert masking.masking.line
    end(masking)
    assert masking.masking.line == ()
    masking.masking.active, masking.masking.growing = True, None
    begin()
    actions.step(masking, 1)
    settle(masking)
    end(masking)
    assert shown(masking).request.index == 1
    masking.masking.active, masking.masking.growing = True, None
    begin()
    masking_actions.stop_making(masking)
    settle(masking)
    end(masking)


def test_a_stroke_stays_on_the_frame_that_it_was_begun_on(masking: AppState) -> None:
    masking_actions.choose_radius(masking, 1.5 / SIZE[0])
    masking_actions.paint(masking, (5.0, 5.0))
    masking_actions.paint(masking, (10.0, 5.0))
    actions.step(masking, 1)
    masking_actions.paint(masking, (20.0, 30.0))
    channels = settle(masking)
    assert shown(masking).request.index == 1
    masking_actions.paint(masking, (25.0, 30.0))
    masking_actions.end_stroke(masking)
    settle(masking, channels)
    masks = on_disk(masking)
    assert set(masks) == {0}
    assert masks[0][5, 5:11].all()
    assert not masks[0][25:].any()
    stroke(masking, (20.0, 30.0))
    settle(masking, channels)
    assert set(on_disk(masking)) == {0, 1}


def test_the_last_stroke_is_kept_when_the_window_closes(masking: AppState) -> None:
    stroke(masking, (10.0, 20.0))
    Channels().finish(masking)
    assert on_disk(masking)[0].any()


def test_a_stroke_that_is_still_held_is_kept_when_the_window_closes(masking: AppState) -> None:
    masking_actions.paint(masking, (10.0, 20.0))
    Channels().finish(masking)
    assert on_disk(masking)[0].any()


def test_masks_that_are_gone_when_a_run_begins_are_for_the_run_to_tell(masking: AppState) -> None:
    stroke(masking, (10.0, 20.0))
    settle(masking)
    start_reconstruction(masking)
    shutil.rmtree(masking.masks_folder)
    start_due(masking, FakeJob)
    assert masking.runs.reconstruction.status == "starting"


def test_a_folder_that_cannot_be_written_is_told(masking: AppState) -> None:
    masking.places.tool_masks.parent.mkdir(parents=True, exist_ok=True)
    masking.places.tool_masks.write_text("a file")
    stroke(masking, (10.0, 20.0))
    settle(masking)
    assert masking.window.banner is not None
    assert masking.window.banner.message.startswith("the tool mask cannot be saved")
    assert masking.window.banner.message.endswith(f" in {masking.places.tool_masks}")
    assert masking.masking.keeping == ()
    assert shown(masking).mask.any()


def test_another_clip_begins_anew_with_its_own_masks(masking: AppState, tmp_path: Path) -> None:
    stroke(masking, (10.0, 20.0))
    settle(masking)
    first = masking.masks_folder
    masking.source.clip = make_clip(tmp_path / "elsewhere" / "clip")
    assert masking.masks_folder != first


def test_a_live_frame_cannot_be_masked(opened: AppState) -> None:
    assert opened.source.clip is not None
    opened.source.clip = replace(opened.source.clip, format=LIVE)
    assert clip_actions.why_no_clip(opened)
    masking_actions.toggle(opened)
    assert not opened.masking.active
    opened.source.clip = None
    masking_actions.toggle(opened)
    assert not opened.masking.active


def test_playing_stops_and_the_brush_keeps_its_bounds(opened: AppState) -> None:
    actions.toggle_play(opened)
    masking_actions.toggle(opened)
    assert not opened.timeline.playing
    masking_actions.scale_radius(opened, 50)
    assert opened.masking.radius == THICKEST
    masking_actions.scale_radius(opened, -99)
    assert opened.masking.radius == THINNEST


def test_the_brush_shows_what_it_paints_where_pixels_are_not_square(
    masking: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = PictureView(pixel_aspect=1.42).place(SIZE, (960.0, 800.0))
    radii: list[ImVec2] = []
    pointed = SimpleNamespace(corner=ImVec2(0, 0), mouse=lambda: ImVec2(480, 400))
    draw = SimpleNamespace(add_ellipse=lambda at, radius, *rest: radii.append(radius))
    seen = SimpleNamespace(
        is_item_hovered=lambda: True, get_window_draw_list=lambda: draw, get_color_u32=lambda color: 0
    )
    monkeypatch.setattr(masking_panel, "imgui", seen)
    masking_panel.draw_brush(masking, place, pointed)  # type: ignore[arg-type]
    stroke(masking, (24.0, 20.0))
    rows, columns = np.nonzero(shown(masking).mask)
    painted = (np.ptp(columns) + 1) * place.zoom_x / 2, (np.ptp(rows) + 1) * place.zoom / 2
    assert (radii[0].x, radii[0].y) == pytest.approx(painted, abs=place.zoom_x)
    assert radii[0].x == pytest.approx(1.42 * radii[0].y)
