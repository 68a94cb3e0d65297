"""Keyframes for the graphics card: made in the background, then scrubbed without the model."""

from __future__ import annotations

from dataclasses import dataclass, replace

import moderngl
import numpy as np
import pytest

from app.gui.actions import actions, camera_actions
from app.gui.drawing.textures import Textures
from app.gui.drawing.viewport import FIRST, SECOND, GraphicsViewport, Watch
from app.gui.state.app_state import AppState
from app.gui.update.channels import Channels
from app.gui.update.update import update
from app.scenes.drawer import draw_view
from app.scenes.view_kinds import BY_PROCESSOR, EXPLAINED, ViewKind
from renderer.draw import splat_view
from renderer.draw.offscreen import read_image
from renderer.draw.storage import Storage
from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians
from tests.app.gui.scenes import scene_of


@dataclass(frozen=True)
class Drift:
    """Everything goes right by 9 units over the clip."""

    def moved(self, raw: RawGaussians, time: float) -> RawGaussians:
        return replace(raw, means=raw.means + np.float32([9 * time, 0, 0]))


@pytest.fixture
def drifting(state: AppState, model: DynamicGaussians) -> AppState:
    assert state.source.clip is not None
    moving = DynamicGaussians(model.raw, Drift())  # type: ignore[arg-type]
    state.scene.model = scene_of(moving, state.source.clip.cameras)
    state.scene.size, state.scene.processor_draws = (64, 48), False
    return state


def settle(state: AppState, channels: Channels) -> None:
    for _ in range(20):
        update(state, channels, 0.0)
        while any(channel.run_waiting() for channel in (channels.bakes, channels.second_bakes)):
            pass


def test_a_moving_model_is_baked_at_the_times_of_its_frames(drifting: AppState) -> None:
    settle(drifting, Channels())
    keyframes = drifting.scene.keyframes_of(drifting.scene.model)
    assert keyframes is not None
    np.testing.assert_allclose(keyframes.times, np.arange(6) / 6)
    assert drifting.scene.model is not None
    for time in keyframes.times:
        away = keyframes.at(time).means - drifting.scene.model.model.at(time).means
        assert np.abs(away).max() <= 0.02 * 50 / drifting.scene.model.cameras[0].fx
    drifting.scene.model = replace(drifting.scene.model)
    assert drifting.scene.keyframes_of(drifting.scene.model) is None
    assert not drifting.window.log


def test_selected_gaussians_are_drawn_in_colour_without_keyframes(drifting: AppState) -> None:
    settle(drifting, Channels())
    assert drifting.scene.model is not None
    drifting.editing.tinted = replace(drifting.scene.model)
    request = drifting.view_request
    assert request is not None
    assert drifting.scene.keyframes_of(request.scene) is None
    drifting.editing.tinted = None
    request = drifting.view_request
    assert request is not None
    assert drifting.scene.keyframes_of(request.scene) is not None


@pytest.mark.parametrize("why", ["live", "still", "processor"])
def test_what_needs_no_keyframes_gets_none(drifting: AppState, model: DynamicGaussians, why: str) -> None:
    assert drifting.scene.model is not None
    drifting.scene.processor_draws = why == "processor"
    shown = model if why == "still" else drifting.scene.model.model
    drifting.scene.model = replace(drifting.scene.model, model=shown, live=why == "live")
    channels = Channels()
    settle(drifting, channels)
    assert channels.bakes.asked is None


def test_a_model_that_cannot_be_baked_is_drawn_without(
    drifting: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> None:
        raise MemoryError("no room")

    monkeypatch.setattr("app.gui.work.baking.Baker", broken)
    settle(drifting, Channels())
    assert drifting.scene.keyframes_of(drifting.scene.model) is None
    assert [line for line in drifting.window.log if "no room" in line] == [*drifting.window.log]
    assert len(drifting.window.log) == 1


@pytest.mark.gl
@pytest.mark.parametrize("watch", [FIRST, SECOND], ids=lambda watch: watch.slot)
@pytest.mark.parametrize("kind", [kind for kind in EXPLAINED if kind not in ("difference", *BY_PROCESSOR)])
def test_scrubbing_and_turning_upload_an_order_and_no_more(
    ctx: moderngl.Context, drifting: AppState, monkeypatch: pytest.MonkeyPatch, watch: Watch, kind: ViewKind
) -> None:
    """In both 3D views and all kinds of view, and they show what the rasteriser shows of the model."""
    assert drifting.scene.model is not None
    drifting.scene.second.model = replace(drifting.scene.model)
    camera_actions.choose_view(drifting, kind)
    graphics, requests = GraphicsViewport(ctx, Textures(ctx), watch), []
    for index, angle in ((2, 0.0), (5, 0.0), (5, 0.2)):
        actions.seek(drifting, index)
        camera_actions.turn(drifting, angle, 0.0)
        requests.append(watch.request(drifting))
    settle(drifting, Channels())
    graphics.show(drifting)
    wanted = [next(draw_view(request)).image.astype(int) for request in requests if request is not None]
    assert len(wanted) == 3

    uploaded: list[int] = []
    write_order = Storage.write_order
    monkeypatch.setattr(
        Storage, "write_order", lambda *given: (uploaded.append(given[1].nbytes), write_order(*given))[1]
    )
    monkeypatch.setattr(splat_view, "Storage", None)
    monkeypatch.setattr(DynamicGaussians, "at", None)
    for request, image in zip(requests, wanted, strict=True):
        monkeypatch.setattr(graphics, "_watch", replace(watch, request=lambda _, asked=request: asked))
        shown = graphics.show(drifting)
        assert shown is not None
        assert graphics._target is not None or kind != "color"
        picture = graphics._composed.image if graphics._composed else read_image(graphics._target) * 255
        away = np.abs(np.rint(picture).astype(int) - image).max(axis=2)
        assert np.mean(away > 3) < 0.01
    assert 0 < len(uploaded) <= 3
    assert max(uploaded) <= 4 * len(drifting.scene.model.model)
    graphics.release()


@pytest.mark.gl
def test_a_model_that_stands_still_is_uploaded_once(
    ctx: moderngl.Context, drifting: AppState, model: DynamicGaussians, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert drifting.scene.model is not None
    drifting.scene.model = replace(drifting.scene.model, model=model)
    graphics = GraphicsViewport(ctx, Textures(ctx))
    graphics.show(drifting)
    monkeypatch.setattr(splat_view, "Storage", None)
    for index, kind in ((1, "color"), (2, "normals"), (3, "depth")):
        camera_actions.choose_view(drifting, kind)
        actions.seek(drifting, index)
        assert graphics.show(drifting) is not None
    graphics.release()


@pytest.mark.gl
def test_scrubbing_draws_what_the_model_would_without_asking_it(
    ctx: moderngl.Context, drifting: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    graphics, wanted = GraphicsViewport(ctx, Textures(ctx)), {}
    actions.choose_background(drifting, "black")
    for index in (0, 2, 5):
        actions.seek(drifting, index)
        assert drifting.view_request is not None
        (view,) = draw_view(drifting.view_request)
        wanted[index] = view.image.astype(int)
    graphics.show(drifting)
    settle(drifting, Channels())
    monkeypatch.setattr(DynamicGaussians, "at", None)
    for index, image in wanted.items():
        actions.seek(drifting, index)
        graphics.show(drifting)
        assert graphics._target is not None
        shown = np.rint(read_image(graphics._target) * 255)
        assert np.abs(shown - image).max() <= 3
    assert np.abs(wanted[0] - wanted[5]).max() > 60
    graphics.release()
