"""Strokes on tool masks that are undone, and brought back."""

from __future__ import annotations

import numpy as np
import pytest

from app.gui.actions import actions, masking_actions
from app.gui.state.app_state import AppState
from app.gui.state.masking import THICKEST
from renderer.tools.mask_files import origin_of, write_mask
from tests.app.gui.test_masking import begun, on_disk, settle, shown, stroke


@pytest.fixture
def masking(opened: AppState) -> AppState:
    return begun(opened)


def test_erasing_undoing_and_clearing(masking: AppState) -> None:
    stroke(masking, (10.0, 20.0))
    dot = shown(masking).mask
    masking_actions.choose_tool(masking, "erase")
    masking_actions.choose_radius(masking, THICKEST)
    stroke(masking, (10.0, 20.0))
    assert not shown(masking).mask.any()
    masking_actions.undo(masking)
    np.testing.assert_array_equal(shown(masking).mask, dot)
    masking_actions.undo(masking)
    assert not shown(masking).mask.any()
    masking_actions.undo(masking)
    masking_actions.choose_tool(masking, "paint")
    stroke(masking, (10.0, 20.0))
    masking_actions.clear_frame(masking)
    settle(masking)
    assert not on_disk(masking)[0].any()
    masking_actions.forget_frame(masking)
    settle(masking)
    assert on_disk(masking) == {}
    assert shown(masking).origin is None
    assert masking.source.tool_masks is None


def test_an_undone_stroke_leaves_the_frame_as_nobody_had_touched_it(masking: AppState) -> None:
    before = shown(masking)
    assert before.origin is None
    stroke(masking, (10.0, 20.0))
    settle(masking)
    assert set(on_disk(masking)) == {0}
    masking_actions.undo(masking)
    settle(masking)
    assert on_disk(masking) == {}
    assert shown(masking).origin is None
    assert shown(masking).mask is before.mask
    assert masking.masking.there is not None
    assert masking.masking.there.frames("by hand") == ()
    write_mask(before.request.path, before.mask, "learned")
    masking.masking.shown, masking.masking.past = None, ()
    settle(masking)
    stroke(masking, (10.0, 20.0))
    masking_actions.undo(masking)
    settle(masking)
    assert origin_of(before.request.path) == "learned"
    assert masking.masking.there.frames("by hand") == ()


def test_an_undone_stroke_comes_back_unless_another_took_its_place(masking: AppState) -> None:
    stroke(masking, (10.0, 20.0))
    stroke(masking, (40.0, 20.0))
    both = shown(masking).mask
    for _ in range(2):
        masking_actions.undo(masking)
    for _ in range(3):  # One more than there are.
        masking_actions.redo(masking)
    settle(masking)
    np.testing.assert_array_equal(on_disk(masking)[0], both)
    masking_actions.undo(masking)
    one = shown(masking).mask
    masking_actions.redo(masking)
    masking_actions.undo(masking)
    np.testing.assert_array_equal(shown(masking).mask, one)
    masking_actions.clear_frame(masking)
    masking_actions.redo(masking)
    settle(masking)
    assert not on_disk(masking)[0].any()


def test_strokes_are_undone_and_brought_back_after_a_look_at_other_frames(masking: AppState) -> None:
    channels = settle(masking)

    def go(index: int) -> None:
        actions.seek(masking, index)
        settle(masking, channels)

    first = shown(masking).mask
    stroke(masking, (10.0, 20.0))
    one = shown(masking).mask
    stroke(masking, (40.0, 20.0))
    both = shown(masking).mask
    go(3)
    masking_actions.undo(masking)  # Nothing was drawn here.
    stroke(masking, (20.0, 10.0))
    go(0)
    np.testing.assert_array_equal(on_disk(masking)[0], both)
    for wanted in (one, first, first):
        masking_actions.undo(masking)
        np.testing.assert_array_equal(shown(masking).mask, wanted)
    settle(masking, channels)
    assert set(on_disk(masking)) == {3}
    go(3)
    masking_actions.redo(masking)
    go(0)
    for _ in range(2):
        masking_actions.redo(masking)
    settle(masking, channels)
    np.testing.assert_array_equal(on_disk(masking)[0], both)
    go(3)
    masking_actions.forget_frame(masking)
    settle(masking, channels)
    masking_actions.undo(masking)
    settle(masking, channels)
    assert set(on_disk(masking)) == {0}
