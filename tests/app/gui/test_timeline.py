"""The strip of frames and the slider below it: one scale for both, read from what is drawn."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import pytest
from imgui_bundle import ImVec4, imgui, imgui_ctx

from app.gui.panels.timeline import draw_timeline
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.views.frame_scale import FrameScale
from tests.app.gui.conftest import make_clip
from tests.app.gui.ui import Shown, Ui

SLACK = 0.75
"""Pixels by which ImGui rounds."""


@dataclass
class Drawn:
    """Left and right of what a frame of the timeline has drawn in a colour."""

    ui: Ui
    state: AppState

    def frame(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The slider's handle, and the marker of the present frame in the strip."""
        found: list[tuple[float, float]] = []

        def draw() -> None:
            draw_timeline(self.state, Shown())
            found.extend((_ends(theme.now().grab, theme.now().lit), _ends(theme.INK)))

        self.ui.frame(draw)
        return found[0], found[1]


def _ends(*colors: ImVec4) -> tuple[float, float]:
    packed = [imgui.get_color_u32(color) for color in colors]
    at = [one.pos.x for one in imgui.get_window_draw_list().vtx_buffer if one.col in packed]
    return min(at), max(at)


@pytest.fixture
def drawn(ui: Ui, opened: AppState) -> Drawn:
    return Drawn(ui, opened)


@pytest.mark.parametrize("count", [2, 7, 24, 41, 400, 5000])
def test_the_marker_stands_on_the_handle_at_every_frame(drawn: Drawn, count: int) -> None:
    drawn.state.source.clip = make_clip(drawn.state.places.runs, count)
    seen = []
    for index in (0, count // 3, count // 2, count - 1):
        drawn.state.timeline.frame_index = index
        handle, marker = drawn.frame()
        assert sum(handle) / 2 == pytest.approx(sum(marker) / 2, abs=SLACK)
        seen.append(sum(handle) / 2)
    assert seen[0] < seen[-1]


@pytest.mark.parametrize("count", [6, 400])
def test_a_click_on_the_strip_brings_the_handle_there(drawn: Drawn, count: int) -> None:
    drawn.state.source.clip = make_clip(drawn.state.places.runs, count)
    drawn.frame()
    for x in (220.0, 404.0, 640.0):
        drawn.ui.drag(lambda: draw_timeline(drawn.state, Shown()), (x, 20), (x, 20))
        handle, _ = drawn.frame()
        assert sum(handle) / 2 == pytest.approx(x, abs=(handle[1] - handle[0]) / 2 + SLACK)


def test_a_drag_along_the_strip_scrubs_from_the_first_to_the_last_frame(drawn: Drawn) -> None:
    draw = lambda: draw_timeline(drawn.state, Shown())  # noqa: E731
    ends = []
    for end in (-50.0, 2000.0):
        drawn.ui.drag(draw, (400, 20), (end, 20))
        ends.append(drawn.state.timeline.frame_index)
    assert ends == [0, 5]


def test_what_a_trim_leaves_out_ends_where_the_handle_of_its_ends_does(drawn: Drawn) -> None:
    state = drawn.state
    state.source.part = replace(state.source.part, trim=(2, 3))
    shades = []
    for index in (2, 3):
        state.timeline.frame_index = index
        shades.append(drawn.frame()[0])
    marks: list[float] = []

    def draw() -> None:
        draw_timeline(state, Shown())
        marks.extend(_ends(imgui.get_color_u32(theme.MARK)))

    drawn.ui.frame(draw)
    assert marks[0] == pytest.approx(shades[0][0], abs=2)
    assert marks[1] == pytest.approx(shades[1][1], abs=2)


def test_a_still_has_no_marker(drawn: Drawn) -> None:
    drawn.state.source.clip = make_clip(drawn.state.places.runs, 1)
    colors: set[int] = set()

    def draw() -> None:
        draw_timeline(drawn.state, Shown())
        colors.update(one.col for one in imgui.get_window_draw_list().vtx_buffer)

    drawn.ui.frame(draw)
    assert colors
    assert imgui.get_color_u32(theme.INK) not in colors


def test_the_frame_of_a_place_is_the_one_whose_handle_is_nearest() -> None:
    scale = FrameScale(100.0, 304.0, 10, 11.0)
    assert [scale.frame_at(scale.middle(frame)) for frame in range(10)] == list(range(10))
    assert (scale.frame_at(-1e6), scale.frame_at(1e6)) == (0, 9)
    assert scale.ends(0, 9) == (102.0, 402.0)
    assert FrameScale(0.0, 100.0, 1, 11.0).frame_at(99.0) == 0


def test_the_handle_leaves_its_label_legible(drawn: Drawn) -> None:
    """Another colour where it is below the label, in the middle."""
    drawn.state.source.clip = make_clip(drawn.state.places.runs, 41)
    found: list[bool] = []

    def draw() -> None:
        draw_timeline(drawn.state, Shown())
        lit = imgui.get_color_u32(theme.now().lit)
        found.append(any(one.col == lit for one in imgui.get_window_draw_list().vtx_buffer))

    for index in (0, 20, 40):
        drawn.state.timeline.frame_index = index
        drawn.ui.frame(draw)
    assert found == [False, True, False]


def test_a_label_too_long_for_the_slider_names_the_frame_alone(
    drawn: Drawn, monkeypatch: pytest.MonkeyPatch
) -> None:
    labels: list[str] = []
    monkeypatch.setattr(imgui, "slider_int", lambda *given: (bool(labels.append(given[4])), 0))
    drawn.state.source.clip = replace(make_clip(drawn.state.places.runs, 41), frames_per_second=25.0)

    def draw(larger: float) -> None:
        with imgui_ctx.push_font(None, larger * imgui.get_style().font_size_base):
            draw_timeline(drawn.state, Shown())

    for larger in (1.0, 4.0):
        drawn.ui.frame(partial(draw, larger))
    assert labels == ["frame %d / 41 · 0:00.0", "frame %d / 41"]
