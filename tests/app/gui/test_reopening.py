"""Opening another clip is shown at once, and nothing of the earlier clip stands for the new one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from app.gui.actions import actions
from app.gui.panels import enhancement_measured, menus
from app.gui.state.app_state import AppState
from app.gui.state.panes import difference_request, faint_vessels, pane
from app.gui.update import taking
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.views.comparison import SIDES
from app.gui.work.measuring import Measurer
from app.gui.work.opening import Opened, OpenRequest
from tests.app.gui.conftest import make_clip
from tests.app.gui.settling import settle

OPENING = "Opening other.mp4…"


@pytest.fixture
def measured(state: AppState) -> AppState:
    """With the measures and the strip of its clip."""
    channels = Channels()
    state.timeline.strip_count = 3
    for now in (0.0, 5.0, 10.0):
        settle(state, channels, now)
        for channel in (*channels.of("second"), *channels.of("third")):
            while channel.run_waiting():
                pass
    update(state, channels, 11.0)
    assert state.measured is not None
    assert state.timeline.strip is not None
    return state


def texts(monkeypatch: pytest.MonkeyPatch, draw: Callable[[AppState], None], state: AppState) -> list[str]:
    """What a tab says where it draws nothing else."""
    found: list[str] = []
    monkeypatch.setattr(enhancement_measured, "muted", found.append)
    draw(state)
    return found


def test_what_is_on_screen_is_marked_at_once(measured: AppState, monkeypatch: pytest.MonkeyPatch) -> None:
    actions.open_path(measured, Path("/clips/other.mp4"))
    assert measured.picture.pictures is not None
    for side in SIDES:
        tags = [tag.text for tag in pane(measured, measured.picture.pictures, side).tags]
        assert f"{OPENING} earlier clip shown" in tags
    assert menus._facts(measured) == [OPENING]
    assert measured.measured is None
    assert faint_vessels(measured) is None
    for draw in (enhancement_measured.draw_measures, enhancement_measured.draw_curves):
        assert texts(monkeypatch, draw, measured) == [OPENING]


def test_what_joins_the_session_marks_nothing(measured: AppState) -> None:
    actions.open_path(measured, Path("/clips/cameras.json"))
    assert measured.opens == ""
    assert measured.measured is not None


def test_a_clip_that_cannot_be_opened_leaves_all_as_it_was(measured: AppState) -> None:
    actions.open_path(measured, Path("/clips/other.mp4"))
    channels = Channels()
    settle(measured, channels, 12.0)
    assert measured.window.banner is not None
    assert measured.opens == ""
    assert measured.measured is not None


def test_nothing_of_the_earlier_clip_is_left_and_nothing_comes_late(
    measured: AppState, tmp_path: Path
) -> None:
    earlier = measured.picture.pictures
    measured.comparing.chosen = replace(measured.comparing.chosen, mode="difference")
    difference = difference_request(measured)
    assert earlier is not None
    assert difference is not None
    late = next(Measurer().measure(earlier))
    other = make_clip(tmp_path / "other.mp4")
    actions.open_path(measured, other.path)
    request = measured.source.opening
    assert request is not None
    taking.take_opened(measured, OpenRequest(other.path), Opened(make_clip(tmp_path / "third")))
    assert measured.opens  # Nobody waits for that one.
    taking.take_opened(measured, request, Opened(other))
    assert measured.source.clip is other
    shown = (measured.measured, measured.picture.measured, measured.picture.pictures, measured.timeline.strip)
    assert shown == (None,) * 4
    taking.take_measured(measured, earlier, late)
    taking.take_difference(measured, difference, object())  # type: ignore[arg-type]
    assert measured.picture.measured is None
    assert measured.comparing.difference is None
    channels = Channels()
    settle(measured, channels, 12.0)
    assert measured.picture.pictures is not None
    assert measured.picture.pictures.request.clip is other
    assert measured.measured is None or measured.measured.pictures.request.clip is other
