"""The window is moved to a screen of another density, and back."""

from __future__ import annotations

from pathlib import Path

import glfw
import pytest
from imgui_bundle import imgui

from app.gui.actions import actions
from app.gui.state.app_state import AppState
from app.gui.work.settings import Places
from assets import phantom_path
from tests.app.gui.driver import is_settled, wait
from tests.app.gui.test_bare import in_front
from tests.app.gui.test_layouts import kept


@pytest.fixture
def densities(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Of the screens that the window has been on, the last one now."""
    on = [1.0]
    monkeypatch.setattr(glfw, "get_window_content_scale", lambda window: (on[-1], on[-1]))
    return on


@pytest.mark.display
def test_text_and_panels_are_as_large_on_every_screen(places: Places, densities: list[float]) -> None:
    """As by text of another size: where there is no room for two panels below each other they are tabs."""

    def move(ctx: imgui.test_engine.TestContext, to: float) -> tuple[float, float]:
        densities.append(to)
        ctx.yield_(12)
        return imgui.get_font_size(), ctx.window_info("//Enhancement").window.size.x

    def drive(ctx: imgui.test_engine.TestContext, state: AppState) -> None:
        path: Path = phantom_path()
        actions.open_path(state, path)
        wait(ctx, lambda: state.source.path == path and is_settled(state), path.name)
        text, width = move(ctx, 1.0)
        assert "Reconstruction" in in_front(ctx)
        dense_text, dense_width = move(ctx, 2.0)
        assert dense_text == 2 * text
        assert dense_width > 1.2 * width
        assert "Reconstruction" not in in_front(ctx)
        assert state.settings.text_percent == 100  # What was chosen stays so.
        assert move(ctx, 1.0) == (text, width)
        assert "Reconstruction" in in_front(ctx)

    kept(places, drive)


@pytest.mark.display
def test_where_the_system_enlarges_nothing_is_enlarged_twice(
    places: Places, monkeypatch: pytest.MonkeyPatch, densities: list[float]
) -> None:
    monkeypatch.setattr("app.gui.frame.density.counts_pixels", lambda: False)

    def drive(ctx: imgui.test_engine.TestContext, state: AppState) -> None:
        ctx.yield_(6)
        text = imgui.get_font_size()
        densities.append(2.0)
        ctx.yield_(12)
        assert imgui.get_font_size() == text

    kept(places, drive)
