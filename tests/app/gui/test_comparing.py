"""Two pictures against each other: what each side shows and says, and the pictures made for it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import cast
from weakref import ref

import moderngl
import numpy as np
import pytest

from app.enhancement.clip_statistics import ClipStatistics
from app.enhancement.image_mask import PictureMask
from app.enhancement.settable import SOURCES
from app.exports.comparison_images import DifferenceRequest, OtherMaker, OtherRequest, heat_map
from app.files.legible import named
from app.gui.actions import actions, clip_actions, comparing, enhancement_actions, history_actions
from app.gui.drawing.viewport import Viewport
from app.gui.frame.second_content import SecondContent
from app.gui.state.app_state import AppState
from app.gui.state.panes import Pane, difference_pane, other_request, pane, pixel, shown_mode, tinted, why_not
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.gui.views.comparison import SIDES, Comparison
from app.scenes.scene import Scene
from enhance import EnhanceParams, enhance, measure
from enhance.baselines import clahe
from enhance.vessel import VesselParams, enhance_vessels
from renderer.gaussians import DynamicGaussians
from renderer.rasterize.cpu import render
from renderer.unobserved import GREY
from tests.app.gui.conftest import image_of, make_clip, start_live
from tests.app.gui.scenes import scene_of
from tests.app.gui.settling import settle
from tests.app.gui.ui import Shown, StillViewport, Ui, compare


def image(state: AppState, side: str = "right") -> np.ndarray:
    assert state.picture.pictures is not None
    return pane(state, state.picture.pictures, side).image  # type: ignore[arg-type]


def said(state: AppState, side: str = "right") -> str:
    assert state.picture.pictures is not None
    return " | ".join(one.text for one in pane(state, state.picture.pictures, side).tags)  # type: ignore[arg-type]


def shown_model(state: AppState, model: DynamicGaussians) -> Scene:
    assert state.source.clip is not None
    return scene_of(model, state.source.clip.cameras, steps=10)


def test_every_source_shows_what_its_name_says(
    state: AppState, channels: Channels, model: DynamicGaussians
) -> None:
    assert state.source.clip is not None
    state.scene.model = shown_model(state, model)
    state.enhancement.stored = {"A": EnhanceParams(z=0.2), "B": VesselParams(strength=3.0)}
    state.enhancement.params, state.enhancement.scope = EnhanceParams(z=0.7), "image"
    actions.seek(state, 2)
    rendered = render(model.at(2 / 6), state.source.clip.cameras[2], GREY, near=0.05).image
    expected = {
        "original": image_of(2),
        "enhanced": enhance(image_of(2), EnhanceParams(z=0.7)).image,
        "A": enhance(image_of(2), EnhanceParams(z=0.2)).image,
        "B": enhance_vessels(image_of(2), VesselParams(strength=3.0)).image,
        "render": np.rint(np.clip(rendered, 0, 1) * 255).astype(np.uint8),
        "paper": enhance(image_of(2)).image,
        "vessel": enhance_vessels(image_of(2)).image,
        "clahe": clahe(image_of(2)),
    }
    for source in SOURCES:
        comparing.choose_source(state, "right", source)
        settle(state, channels)
        assert not state.comparing.waits
        assert source in expected or said(state).startswith(f"METHOD {named(source)}")
        if source in expected:
            np.testing.assert_array_equal(image(state), expected[source], source)
        np.testing.assert_array_equal(image(state, "left"), image_of(2))


def test_a_source_that_is_missing_says_so_and_shows_the_original(state: AppState, channels: Channels) -> None:
    for source in ("A", "render"):
        comparing.choose_source(state, "right", source)
        settle(state, channels)
        assert why_not(state, source) in said(state)
        assert "ORIGINAL" in said(state)
        np.testing.assert_array_equal(image(state), image_of(0))


def test_what_has_no_statistics_is_not_made_again_when_they_come(state: AppState) -> None:
    state.enhancement.stored = {"A": EnhanceParams(z=0.2)}
    asked = {}
    for source in ("clahe", "A"):
        comparing.choose_source(state, "left", source)
        before = other_request(state, "left")
        picture = state.picture_request
        assert picture is not None
        assert picture.params is not None
        known = picture.statistics_request(picture.params)
        state.picture.of_clip = ClipStatistics(known, measure([image_of(0)]))
        asked[source] = before == other_request(state, "left")
        state.picture.of_clip = None
    assert asked == {"clahe": True, "A": False}


def test_a_model_of_another_clip_is_no_render_of_this_one(state: AppState, model: DynamicGaussians) -> None:
    shown = shown_model(state, model)
    state.scene.model = replace(shown, cameras=2 * shown.cameras)
    assert why_not(state, "render")
    camera = shown.cameras[0]
    other = camera.resized(2 * camera.width, 2 * camera.height)
    state.scene.model = replace(shown, cameras=(other,) * 6)
    assert why_not(state, "render")
    state.scene.model = shown
    assert not why_not(state, "render")


def test_peek_and_white_light_show_the_frame_whatever_is_compared(
    state: AppState, channels: Channels
) -> None:
    comparing.store(state, "A")
    state.comparing.chosen = Comparison(mode="difference", left="A", right="clahe")
    settle(state, channels)
    state.enhancement.peeking = True
    for side in ("left", "right"):
        assert image(state, side) is state.picture.pictures.original  # type: ignore[union-attr]
        assert "peek" in said(state, side)
    enhancement_actions.white_light(state)
    settle(state, channels)
    for side in ("left", "right"):
        np.testing.assert_array_equal(image(state, side), image_of(0))
    assert "WHITE LIGHT · enhancement off: no difference" in said(state)
    assert shown_mode(state) == "side by side"


def test_another_frame_is_stale_until_its_picture_is_there(state: AppState, channels: Channels) -> None:
    comparing.choose_source(state, "right", "clahe")
    settle(state, channels)
    assert state.picture.pictures is not None
    assert not pane(state, state.picture.pictures, "right").stale
    actions.seek(state, 3)
    update(state, channels, 1.0)
    assert state.comparing.waits
    assert pane(state, state.picture.pictures, "right").stale
    assert state.is_busy
    settle(state, channels, 1.0)
    np.testing.assert_array_equal(image(state), clahe(image_of(3)))


def test_playing_waits_for_both_panes(state: AppState, channels: Channels) -> None:
    comparing.choose_source(state, "right", "clahe")
    settle(state, channels)
    actions.toggle_play(state)
    update(state, channels, 0.12)
    assert state.timeline.frame_index == 1
    update(state, channels, 0.24)
    assert state.timeline.frame_index == 1
    settle(state, channels, 0.24)
    update(state, channels, 0.36)
    assert state.timeline.frame_index == 2


def test_a_failing_source_is_told_once(state: AppState, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(maker: OtherMaker, request: OtherRequest) -> None:
        raise ValueError("no such thing")

    monkeypatch.setattr(OtherMaker, "make", fails)
    channels = Channels()
    comparing.choose_source(state, "right", "clahe")
    settle(state, channels)
    assert state.window.banner is not None
    state.window.banner = None
    settle(state, channels)
    assert state.window.banner is None


def test_pictures_are_remembered_and_let_go(state: AppState, monkeypatch: pytest.MonkeyPatch) -> None:
    maker = OtherMaker()
    comparing.choose_source(state, "right", "clahe")
    request = other_request(state, "right")
    assert request is not None
    (first,) = maker.make(request)
    (again,) = maker.make(request)
    assert again is first
    monkeypatch.setattr("app.exports.comparison_images.KEPT_BYTES", 2 * image_of(0).nbytes)
    for index in range(1, 4):
        list(maker.make(replace(request, original=replace(request.original, frame_index=index))))
    (renewed,) = maker.make(request)
    assert renewed is not first
    np.testing.assert_array_equal(renewed.image, first.image)


def test_pictures_of_a_clip_that_was_left_are_let_go(state: AppState, tmp_path: Path) -> None:
    maker = OtherMaker()
    comparing.choose_source(state, "right", "clahe")
    request = other_request(state, "right")
    assert request is not None
    first = ref(next(maker.make(request)))
    list(maker.make(replace(request, original=replace(request.original, clip=make_clip(tmp_path / "next")))))
    assert first() is None


def test_models_count_among_what_is_kept(
    state: AppState, model: DynamicGaussians, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Previews of a run in training come one after the other, each a model of its own."""
    start_live(state, model)
    assert state.scene.model is not None
    comparing.choose_source(state, "right", "clahe")
    request = other_request(state, "right")
    assert request is not None
    monkeypatch.setattr("app.exports.comparison_images.KEPT_BYTES", 2 * image_of(0).nbytes)
    maker = OtherMaker()
    first = ref(next(maker.make(replace(request, by=state.scene.model))))
    list(maker.make(replace(request, by=replace(state.scene.model, iteration=9))))
    assert first() is None


def test_storing_and_recalling_are_steps_of_undo(state: AppState) -> None:
    enhancement_actions.set_params(state, EnhanceParams(z=0.2))
    comparing.store(state, "B")
    enhancement_actions.set_params(state, EnhanceParams(z=0.9))
    comparing.recall(state, "B")
    assert state.enhancement.params == EnhanceParams(z=0.2)
    history_actions.undo(state)
    assert state.enhancement.params == EnhanceParams(z=0.9)
    comparing.recall(state, "A")
    assert state.enhancement.params == EnhanceParams(z=0.9)


def test_modes_go_back_to_side_by_side_and_flip_stays(state: AppState) -> None:
    comparing.choose_mode(state, "wipe")
    comparing.move_wipe(state, 5.0)
    assert state.comparing.chosen.wipe == 0.98
    comparing.choose_mode(state, "wipe")
    assert state.comparing.chosen.mode == "side by side"
    comparing.flip(state)
    assert (state.comparing.chosen.mode, state.comparing.chosen.flipped) == ("flip", True)
    comparing.flip(state)
    assert (state.comparing.chosen.mode, state.comparing.chosen.flipped) == ("flip", False)
    comparing.swap(state)
    assert (state.comparing.chosen.left, state.comparing.chosen.right) == ("enhanced", "original")


@pytest.mark.parametrize(("level", "top"), [(0, 8), (8, 8), (9, 16), (100, 128), (255, 255)])
def test_the_heat_map_s_scale_holds_the_differences(level: int, top: int) -> None:
    left = np.zeros((8, 8, 3), np.uint8)
    right = left.copy()
    right[:, 4:, 1] = level
    (made,) = heat_map(DifferenceRequest(left, right))
    assert made.top == top
    assert made.mean == level / 2
    assert (made.heat[:, :4] == made.heat[0, 0]).all()
    assert made.heat[0, 0].max() <= 4  # No difference is black.
    if level:
        assert made.heat[0, 7].astype(int).sum() > made.heat[0, 0].astype(int).sum()


def test_the_difference_is_of_the_two_panes(state: AppState, channels: Channels) -> None:
    comparing.choose_mode(state, "difference")
    settle(state, channels)
    difference, pictures = state.comparing.difference, state.picture.pictures
    assert difference is not None
    assert pictures is not None
    assert pictures.enhanced is not None
    apart = np.abs(pictures.original.astype(int) - pictures.enhanced).max(axis=2)
    assert difference.mean == pytest.approx(apart.mean())

    def pane_now() -> Pane:
        left, right = (pane(state, pictures, side) for side in SIDES)
        return difference_pane(left, right, difference)

    shown = pane_now()
    assert not shown.stale
    assert "ORIGINAL − ENHANCED" in shown.tags[0].text
    enhancement_actions.set_params(state, EnhanceParams(z=0.0))
    assert pane_now().stale


def test_stripes_and_tint_are_on_both_windows_and_on_no_heat_map(
    ui: Ui, state: AppState, channels: Channels
) -> None:
    comparing.toggle_zebra(state)
    clip_actions.set_mask(state, PictureMask(text=(0, 0, 10, 40)))
    clip_actions.toggle_overlay(state)
    settle(state, channels)
    channels.left_out.run_waiting()
    settle(state, channels)
    tint, shown = tinted(state), Shown()
    assert tint is not None
    second = SecondContent(cast(moderngl.Context, None), shown, cast(Viewport, StillViewport()))
    second.of(state, (64, 48))
    ui.frame(compare(state, shown))
    slots = ("second window", "left", "right")
    assert {slot: shown.marks[slot] for slot in slots} == dict.fromkeys(slots, (True, tint))
    comparing.choose_mode(state, "difference")
    settle(state, channels)
    ui.frame(compare(state, shown))
    assert state.comparing.difference is not None
    assert shown.images["single"] is state.comparing.difference.heat
    assert shown.marks["single"] == (False, None)
    assert state.picture.pictures is not None
    left, right = (pane(state, state.picture.pictures, side) for side in SIDES)
    tags = difference_pane(left, right, state.comparing.difference).tags
    assert not any("TINTED" in tag.text for tag in tags)


def test_requests_of_the_same_two_pictures_are_one() -> None:
    first, second = image_of(0), image_of(0)
    assert DifferenceRequest(first, second) == DifferenceRequest(first, second)
    assert DifferenceRequest(first, second) != DifferenceRequest(second, first)


def test_a_pixel_in_grey_levels_and_hsv() -> None:
    picture = np.zeros((4, 6, 3), np.uint8)
    picture[1, 2] = (200, 50, 100)
    one = pixel(picture, (2, 1))
    assert one is not None
    assert (one.rgb, one.value, one.saturation) == ((200, 50, 100), 200, 0.75)
    black = pixel(picture, (0, 0))
    assert black is not None
    assert black.saturation == 0
    assert pixel(picture, (6, 0)) is None
    assert pixel(picture, (0, -1)) is None
