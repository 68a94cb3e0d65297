"""Tiles of the tuning grid: how large they are, and of which frame they say they are."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from imgui_bundle import ImVec2, ImVec4, imgui, imgui_ctx

from app.gui.actions import actions, tuning_actions
from app.gui.panels import tuning as panel
from app.gui.panels.tuning import draw_tuning
from app.gui.session_file import Choice
from app.gui.state.app_state import AppState
from app.gui.state.tags import Tag
from app.gui.style import labels, theme
from app.gui.update.channels import Channels
from app.gui.views.picture_view import PictureView
from app.gui.work.thumbnails import shrunk
from app.gui.work.tuning import TILE
from tests.app.gui.test_tuning import finish, turn
from tests.app.gui.ui import Shown, Ui


@pytest.mark.parametrize(
    ("size", "tile"),
    [
        ((48, 40), (48, 40)),
        ((1920, 1080), (TILE[0], 270)),
        ((960, 960), (TILE[0], TILE[0])),
        ((1, 3000), (1, TILE[1])),
        ((4, 400), (4, 400)),
        ((3000, 1), (TILE[0], 1)),
    ],
)
def test_a_tile_is_no_larger_than_its_picture_or_its_room(
    size: tuple[int, int], tile: tuple[int, int]
) -> None:
    """Width and height, also of strips."""
    image = np.full((size[1], size[0], 3), 90, np.uint8)
    made = shrunk(image, *TILE)
    assert made.shape == (tile[1], tile[0], 3)
    assert (made == 90).all()


def test_the_grid_says_which_frame_it_is_of(
    ui: Ui, state: AppState, channels: Channels, monkeypatch: pytest.MonkeyPatch
) -> None:
    written: list[tuple[ImVec4, str]] = []
    text, stack = imgui.text_colored, labels.stack_tags

    def colored(color: ImVec4, said: str) -> None:
        written.append((color, said))
        text(color, said)

    def stacked(tags: list[Tag], *rest: Any) -> Any:
        written.extend((theme.TONES[one.tone], one.text) for one in tags)
        return stack(tags, *rest)

    monkeypatch.setattr(imgui, "text_colored", colored)
    monkeypatch.setattr(panel, "stack_tags", stacked)

    def frames() -> list[tuple[ImVec4, str]]:
        written.clear()
        ui.frame(lambda: draw_tuning(state, Shown()))
        return [(color, said) for color, said in written if said.startswith("Frame")]

    actions.seek(state, 1)
    tuning_actions.start_grid(state)
    finish(state, channels)
    assert frames() == [(theme.now().muted, "Frame 2 / 6")]
    actions.seek(state, 4)
    assert frames() == [(theme.now().warning, "Frame 2 / 6: not the one on screen")]
    tuning_actions.look_at(state, state.tuning.in_order[0])
    for _ in range(2):
        turn(state, channels)
    assert frames() == [(theme.TAG_CAUTION, "Frame 2 / 6: not the one on screen")]


def test_upright_frames_and_what_is_below_them_are_in_sight(
    ui: Ui, state: AppState, channels: Channels
) -> None:
    """As of a phone held upright: the panel itself has nothing to scroll."""
    state.picture.view = PictureView(pixel_aspect=0.2)
    tuning_actions.start_grid(state)
    finish(state, channels)
    below: list[float] = []

    def draw() -> None:
        draw_tuning(state, Shown())
        below.append(imgui.get_scroll_max_y())

    for _ in range(3):
        ui.frame(draw)
    assert below[-1] == 0


def test_values_of_one_parameter_fill_rows_as_long_as_there_is_room(
    ui: Ui, state: AppState, channels: Channels
) -> None:
    state.picture.view = PictureView(pixel_aspect=0.2)  # Upright: narrow tiles.
    state.tuning.choices = (Choice("d_factor", 0.0, 2.0, 4), Choice(""))
    tuning_actions.start_grid(state)
    finish(state, channels)
    for _ in range(3):
        ui.frame(lambda: draw_tuning(state, Shown()))
    assert state.tuning.columns >= 4


@pytest.mark.parametrize("width", range(601, 606))
def test_the_columns_that_tiles_are_sized_for_are_those_laid_out(
    ui: Ui, state: AppState, channels: Channels, width: int
) -> None:
    """Though windows have whole pixels and are scrolled."""
    state.tuning.choices = (Choice("d_factor", 0.0, 2.0, 4), Choice(""))
    tuning_actions.start_grid(state)
    finish(state, channels)

    def draw() -> None:
        with imgui_ctx.begin_child("panel", ImVec2(width, 400)):
            draw_tuning(state, Shown())

    for _ in range(3):
        ui.frame(draw)
    assert state.tuning.columns == 2


def test_no_line_below_a_tile_begins_with_the_number_of_the_line_before(
    ui: Ui, state: AppState, channels: Channels, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    monkeypatch.setattr(panel, "muted", said.append)
    tuning_actions.start_grid(state)
    finish(state, channels)
    ui.frame(lambda: draw_tuning(state, Shown()))
    below = [text for text in said if "DV/BV" in text]
    assert below
    assert all(len(text.split(" ")) == 2 * len(text.split(" · ")) - 1 for text in below)
