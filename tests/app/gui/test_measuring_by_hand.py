"""Measuring in the 3D view: clicks, the line and its label."""

from __future__ import annotations

from dataclasses import replace

import pytest
from imgui_bundle import ImVec2, ImVec4, imgui

from app.gui.actions import actions, camera_actions
from app.gui.panels import scene_marks
from app.gui.state.app_state import AppState
from app.gui.state.view_words import view_tags
from app.gui.style import theme
from app.gui.style.labels import tag
from app.gui.work.selecting import pick
from renderer.gaussians import DynamicGaussians
from tests.app.gui.conftest import start_live
from tests.app.gui.ui import Draw, Ui, texts, view3d


def test_clicks_measure_and_drags_still_turn(
    ui: Ui, opened: AppState, model: DynamicGaussians, monkeypatch: pytest.MonkeyPatch
) -> None:
    start_live(opened, model)
    draw: Draw = lambda: view3d(opened)  # noqa: E731
    ui.frame(draw)
    ui.drag(draw, (400, 300), (400, 300))
    assert opened.scene.viewer.pick is None
    camera_actions.toggle_measuring(opened)
    assert "click two points" in texts(view_tags(opened, opened.view_request))
    ui.drag(draw, (400, 300), (460, 300))
    assert opened.scene.viewer.pick is None
    assert opened.scene.viewer.free is not None
    camera_actions.reset_view(opened)
    for x in (420, 480):
        ui.drag(draw, (x, 330), (x, 330))
        wish = opened.scene.viewer.pick
        assert wish is not None
        assert wish.purpose == "measure"
        (answer,) = pick(wish)
        camera_actions.take_point(opened, wish, answer)
        ui.frame(draw)
        if x == 420:
            assert "click the second point" in texts(view_tags(opened, opened.view_request))
    request = opened.view_request
    assert request is not None
    assert opened.scene.model is not None
    expected = 60 / request.camera.fx * 50.0  # On the model's sheet, which is 50 before the camera.
    assert opened.scene.viewer.measurement.length == pytest.approx(expected, rel=1e-3)
    assert "mm" in opened.scene.viewer.measurement.text("mm")
    labels: list[tuple[float, float]] = []

    def noted(text: str, position: ImVec2, color: ImVec4) -> float:
        labels.append((position.x, position.y))
        return tag(text, position, color)

    monkeypatch.setattr(scene_marks, "tag", noted)
    ui.frame(draw)
    ((across, _),) = labels
    assert across > 480  # Beside both points, over neither.
    opened.scene.model = replace(opened.scene.model, is_guessed=True)
    shown: list[str] = []
    monkeypatch.setattr(scene_marks, "tag", lambda text, position, color: shown.append(text) or 0.0)
    ui.frame(draw)
    assert shown == ["No distance: depth has no scale"]
    camera_actions.toggle_measuring(opened)
    assert opened.scene.viewer.measurement.points == ()


def test_a_measured_point_ends_playing_at_the_moment_that_was_on_screen(
    opened: AppState, model: DynamicGaussians
) -> None:
    start_live(opened, model)
    opened.scene.size = (64, 48)
    actions.seek(opened, 2)
    seen = opened.view_request
    assert seen is not None
    actions.toggle_play(opened)
    actions.seek(opened, 4)  # The rasteriser is late.
    camera_actions.ask_point(opened, seen, (3, 3), "orbit")
    assert (opened.timeline.playing, opened.moment) == (True, 4)
    camera_actions.ask_point(opened, seen, (3, 3), "measure")
    assert (opened.timeline.playing, opened.moment) == (False, 2)
    assert opened.view_request == seen  # A second point is of the same moment.


def test_shift_goes_on_with_a_line_and_closes_it_on_its_first_point(
    ui: Ui, opened: AppState, model: DynamicGaussians
) -> None:
    start_live(opened, model)
    draw: Draw = lambda: view3d(opened)  # noqa: E731
    ui.frame(draw)
    camera_actions.toggle_measuring(opened)

    def click(*at: float) -> None:
        ui.drag(draw, at, at)
        wish = opened.scene.viewer.pick
        if wish is not None:
            (answer,) = pick(wish)
            camera_actions.take_point(opened, wish, answer)
            opened.scene.viewer.pick = None

    click(420, 330)
    ui.io.add_key_event(imgui.Key.mod_shift, True)
    click(480, 330)
    click(480, 370)
    assert "closes an area" in texts(view_tags(opened, opened.view_request))
    click(422, 331)
    measured, request = opened.scene.viewer.measurement, opened.view_request
    assert request is not None
    assert len(measured.points) == 3
    pixel = 50.0 / request.camera.fx  # In mm, on the model's sheet, which is 50 before the camera.
    assert measured.area == pytest.approx(60 * 40 / 2 * pixel**2, rel=1e-2)
    click(420, 330)
    ui.io.add_key_event(imgui.Key.mod_shift, False)
    assert len(opened.scene.viewer.measurement.points) == 1


def test_ends_of_a_distance_have_a_dark_rim(ui: Ui, monkeypatch: pytest.MonkeyPatch) -> None:
    """On yellow fat they would not be seen without."""
    circles: list[tuple[float, int]] = []

    class Noted:
        def add_line(self, first: ImVec2, last: ImVec2, ink: int, width: float) -> None:
            pass

        def add_circle_filled(self, at: ImVec2, radius: float, ink: int) -> None:
            circles.append((radius, ink))

    monkeypatch.setattr(imgui, "get_window_draw_list", Noted)
    ui.frame(lambda: scene_marks._draw_line([ImVec2(420, 330)], closed=False))
    (rim, dark), (end, mark) = circles
    assert rim > end
    assert dark == imgui.get_color_u32(theme.grey(0.0, 0.7))
    assert mark == imgui.get_color_u32(theme.MARK)
