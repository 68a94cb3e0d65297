"""The 3D view beside what it is not of: another clip than the open one, a tap that comes from afar, a run
that has shown nothing yet."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from app.exports.records import PanesPicture
from app.gui.actions import actions, export_actions, job_actions
from app.gui.panels import view3d as view3d_panel
from app.gui.state.app_state import AppState
from app.gui.state.tags import Tag
from app.gui.state.view_words import view_tags
from app.gui.views.measurement import Located, Measurement
from app.scenes.records import ClipSource
from renderer.clip import Clip
from renderer.gaussians import DynamicGaussians
from renderer.train.events import Preparing
from tests.app.gui.conftest import start_live
from tests.app.gui.ui import Draw, Ui, view3d


def test_a_tap_from_afar_turns_nothing(ui: Ui, opened: AppState, model: DynamicGaussians) -> None:
    start_live(opened, model)
    draw: Draw = lambda: view3d(opened)  # noqa: E731
    ui.io.add_mouse_pos_event(820, 60)
    ui.frame(draw)
    before = opened.view_request
    assert before is not None
    # A pen or a finger comes down without having been above the place.
    ui.io.config_input_trickle_event_queue = False
    ui.io.add_mouse_pos_event(400, 300)
    ui.io.add_mouse_button_event(0, True)
    ui.frame(draw)
    ui.frame(draw)
    ui.io.add_mouse_button_event(0, False)
    ui.frame(draw)
    after = opened.view_request
    assert after is not None
    assert after.camera == before.camera


def test_what_was_measured_on_a_preview_goes_with_it(opened: AppState, model: DynamicGaussians) -> None:
    start_live(opened, model)
    preview = opened.scene.model
    assert preview is not None
    viewer, point = opened.scene.viewer, Located((1.0, 2.0, 50.0))
    viewer.measurement = Measurement().with_point(point, 0.0, preview.identity)
    job_actions.show_finished_model(opened, model)
    wish = opened.runs.model_wish
    assert wish is not None
    job_actions.take_model(opened, wish, replace(preview, iteration=80))
    assert viewer.measurement.points == (point.point,)
    job_actions.take_model(opened, wish, replace(preview, live=False))
    assert viewer.measurement.points == ()
    assert opened.window.toast is not None
    assert "measure again" in opened.window.toast.message


def test_another_clip_than_the_open_one_is_named_and_keeps_its_own_time(
    ui: Ui, opened: AppState, model: DynamicGaussians, clip: Clip
) -> None:
    start_live(opened, model)
    scene = opened.scene.model
    assert scene is not None
    whole = ClipSource(name=clip.name, sha256="")
    opened.scene.model = replace(scene, record=replace(scene.record, clip=whole))
    assert not opened.shows_other_clip
    assert opened.has_frames
    actions.seek(opened, 3)
    assert opened.time == pytest.approx(0.5)
    other = replace(clip, name="another patient", path=Path("another patient"))
    opened.source.clip = other
    assert opened.shows_other_clip
    assert not opened.has_frames
    assert opened.time == opened.scene.own_time == 0.0
    actions.seek_view(opened, 0.25)
    assert (opened.time, opened.timeline.frame_index) == (0.25, 3)
    # Folders of two patients may have one name.
    opened.source.clip = replace(clip, path=Path("patient 2") / clip.name)
    opened.scene.model = replace(opened.scene.model, clip_path=Path("patient 1") / clip.name)
    assert opened.shows_other_clip
    assert not opened.has_frames
    opened.scene.model = replace(opened.scene.model, clip_path=Path("patient 2").absolute() / clip.name)
    assert opened.has_frames
    opened.source.clip, opened.scene.model = other, replace(opened.scene.model, clip_path=None)
    opened.scene.size = (96, 80)
    assert view_tags(opened, opened.view_request)[0] == Tag(f"OF ANOTHER CLIP · {clip.name}", "caution")
    request = export_actions.shown_request(opened)
    assert request is not None
    assert isinstance(request.record, PanesPicture)
    assert [str(view.caption).split("\n")[0] for view in request.record.views] == [
        f"OF ANOTHER CLIP: {clip.name}"
    ]


def test_an_empty_view_says_what_it_waits_for(
    ui: Ui, opened: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The panel that says so, too, is small and at the side."""
    run, said = opened.runs.reconstruction, list[str]()
    run.status, run.preparing = "starting", Preparing("reading frames", 12, 54, 3.0, None)
    monkeypatch.setattr(view3d_panel, "centered", said.append)
    ui.frame(lambda: view3d(opened))
    assert said[-1] == "Reading frames · 12 of 54"
