"""One history of all that is set: each step comes back as it was, by its name, and looking is none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from app.enhancement.image_mask import PictureMask
from app.errors import UserError
from app.gui.actions import (
    actions,
    arriving,
    clip_actions,
    comparing,
    depth_actions,
    enhancement_actions,
    history_actions,
    job_actions,
    path_actions,
    preset_actions,
    session_actions,
    summary_actions,
)
from app.gui.state.app_state import AppState
from app.gui.state.enhancement import SettingsSnapshot
from app.gui.views.picture_view import PictureView
from app.gui.work.background import Failure
from app.gui.work.opening import Opened
from app.gui.work.settings import Places, load_clips
from app.runs.clip_selection import ClipPart
from enhance import EnhanceParams
from enhance.vessel import VesselParams
from renderer.camera import Camera
from renderer.camera_files import NamedCamera
from renderer.view_files import Views
from tests.app.gui.conftest import make_clip
from tests.app.gui.settling import keep_all

Set = Callable[[AppState], None]


def iterations(state: AppState) -> None:
    run = state.runs.reconstruction
    run.config = replace(run.config, iterations=7, leave_out=("deformation",))


def wishes(state: AppState) -> None:
    state.runs.reconstruction.input = "both in turn"
    job_actions.link_settings(state, linked=False)


def trim(state: AppState) -> None:
    actions.seek(state, 2)
    clip_actions.trim_here(state, start=True)


def pooled(state: AppState) -> None:
    state.enhancement.scope, state.enhancement.pixels = "clip", "tissue"


SETTINGS: dict[str, Set] = {
    "colour": lambda s: enhancement_actions.set_params(s, EnhanceParams(d_factor=2.0)),
    "enhancement": lambda s: (
        preset_actions.choose(s, "Paper, colour 0.67 (3D)")
        or enhancement_actions.set_params(s, EnhanceParams(z=0.5, d_factor=0.1))
    ),
    "method": lambda s: enhancement_actions.choose_method(s, VesselParams),
    "statistics": pooled,
    "trim": trim,
    "mask": lambda s: clip_actions.set_mask(s, PictureMask(text=(1, 2, 3, 4))),
    "comparison": lambda s: comparing.choose_source(s, "left", "clahe"),
    "reconstruction settings": iterations,
    "reconstruction settings ": wishes,
    "depth": lambda s: depth_actions.type_baseline(s, "4.2"),
    "depth ": lambda s: depth_actions.type_field_of_view(s, "80"),
    "saved views and path": lambda s: path_actions.set_loop(s, loop=True),
    "case summary": lambda s: summary_actions.add_file(s, Path("saved.png")),
}  # fmt: skip


def test_every_setting_is_undone_and_redone_in_its_turn(state: AppState) -> None:
    state.source.bare = state.source.clip
    seen: list[SettingsSnapshot] = [state.chosen]
    for name, act in SETTINGS.items():
        act(state)
        enhancement_actions.settle_params(state)
        enhancement_actions.settle_params(state)  # Frames in which nothing changes are no steps.
        seen.append(state.chosen)
        assert seen[-1] != seen[-2]
        if name != "enhancement":  # Choosing a preset and then another value are two steps.
            assert history_actions.undo_name(state) == f"Undo {name.strip()}"
    settled = list(state.enhancement.past)
    while len(state.enhancement.past) > 1:
        history_actions.undo(state)
        assert state.chosen == state.enhancement.past[-1]
    assert state.chosen == seen[0]
    assert history_actions.undo_name(state) == "Undo"
    while state.enhancement.future:
        history_actions.redo(state)
    assert (state.enhancement.past, state.chosen) == (settled, seen[-1])


def test_a_drag_is_one_step(state: AppState) -> None:
    for width in range(1, 20):
        clip_actions.set_mask(state, PictureMask(text=(0, 0, width, 5)))
    enhancement_actions.settle_params(state)
    assert len(state.enhancement.past) == 2
    history_actions.undo(state)
    assert state.source.part.mask == PictureMask()


def test_looking_is_no_step_and_is_left_as_it_is(state: AppState) -> None:
    comparing.choose_mode(state, "wipe")
    enhancement_actions.settle_params(state)
    state.comparing.chosen = state.comparing.chosen.wiped(0.2)
    state.picture.view, state.timeline.playing = PictureView(3.0, (0.1, 0.2)), True
    actions.seek(state, 4)
    enhancement_actions.toggle_enhancement(state)
    enhancement_actions.settle_params(state)
    assert len(state.enhancement.past) == 2
    history_actions.undo(state)
    assert (state.comparing.chosen.mode, state.comparing.chosen.wipe) == ("side by side", 0.2)
    assert (state.timeline.frame_index, state.picture.view.zoom, state.enhancement.active) == (4, 3.0, False)


def test_what_was_deleted_comes_back_and_that_is_said(state: AppState) -> None:
    views = Views((NamedCamera("from the left", Camera(fx=9, fy=9, cx=4, cy=4, width=8, height=8)),))
    state.scene.cameras.views = views
    summary_actions.add_file(state, Path("saved.png"))
    summary_actions.type_note(state, 0, "a long note")
    enhancement_actions.settle_params(state)
    images = state.summary.items
    path_actions.delete_view(state, 0)
    enhancement_actions.settle_params(state)
    summary_actions.remove(state, 0)
    assert (state.scene.cameras.views.named, state.summary.items) == ((), ())
    history_actions.undo(state)
    history_actions.undo(state)
    assert (state.scene.cameras.views.named, state.summary.items) == (views.named, images)
    assert list(state.window.log)[-2:] == ["images in the case summary: 1", "saved views: 1, keyframes: 0"]


def test_a_new_case_is_not_undone(state: AppState) -> None:
    summary_actions.add_file(state, Path("saved.png"))
    enhancement_actions.settle_params(state)
    session_actions.answer_new_case(state, agreed=True)
    while len(state.enhancement.past) > 1:
        history_actions.undo(state)
    history_actions.redo(state)
    assert state.summary.items == ()


def test_something_new_ends_what_could_be_redone(state: AppState) -> None:
    trim(state)
    enhancement_actions.settle_params(state)
    history_actions.undo(state)
    pooled(state)
    enhancement_actions.settle_params(state)
    history_actions.redo(state)
    assert state.source.part == ClipPart()


def test_an_undone_trim_is_undone_for_the_next_time_too(state: AppState, places: Places) -> None:
    trim(state)
    enhancement_actions.settle_params(state)
    keep_all(state)
    assert load_clips(places.config)
    history_actions.undo(state)
    keep_all(state)
    assert not load_clips(places.config)


@pytest.mark.parametrize("trimmed", [True, False])
def test_no_step_leads_into_another_clip(state: AppState, places: Places, *, trimmed: bool) -> None:
    if trimmed:
        trim(state)
    enhancement_actions.set_params(state, EnhanceParams(d_factor=2.0))
    enhancement_actions.settle_params(state)
    other = make_clip(places.config.parent / "other", 3)
    arriving.show_opened(state, other.path, Opened(other))
    enhancement_actions.settle_params(state)
    while len(state.enhancement.past) > 1:
        history_actions.undo(state)
    assert state.source.part == ClipPart()
    assert state.enhancement.params == EnhanceParams()


def test_undo_gets_past_depth_that_cannot_be_read(state: AppState) -> None:
    def fails() -> None:
        wish = state.source.depth_wish
        if wish is not None:
            depth_actions.take_depth(state, wish, Failure(UserError("the drive is gone")))
        enhancement_actions.settle_params(state)

    state.source.bare = state.source.clip
    enhancement_actions.set_params(state, EnhanceParams(d_factor=2.0))
    enhancement_actions.settle_params(state)
    depth_actions.choose_source(state, "brightness")
    enhancement_actions.settle_params(state)
    fails()
    assert [step.depth for step in state.enhancement.past] == ["auto", "auto"]
    history_actions.undo(state)
    fails()
    assert state.enhancement.params == EnhanceParams()
    history_actions.redo(state)
    fails()
    assert state.enhancement.params == EnhanceParams(d_factor=2.0)
