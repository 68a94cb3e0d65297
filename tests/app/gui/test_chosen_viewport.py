"""Which of the two ways draws: by measurement on a software driver, and never a card that fails."""

from __future__ import annotations

import gc
import weakref
from dataclasses import replace

import moderngl
import pytest

from app.gui.actions import actions
from app.gui.drawing import chosen_viewport
from app.gui.drawing.chosen_viewport import VIEWS, ChosenViewport
from app.gui.drawing.textures import Textures
from app.gui.drawing.viewport import GraphicsViewport
from app.gui.state.app_state import AppState
from app.scenes.drawer import draw_view
from renderer.draw.context import renderer_name
from renderer.gaussians import DynamicGaussians
from tests.app.gui.scenes import scene_of

pytestmark = pytest.mark.gl


@pytest.fixture
def looking(state: AppState, model: DynamicGaussians) -> AppState:
    assert state.source.clip is not None
    state.scene.model = scene_of(model, state.source.clip.cameras)
    state.scene.size = (64, 48)
    return state


def look_around(state: AppState, viewport: ChosenViewport, milliseconds: float, count: int = VIEWS) -> None:
    """The processor draws `count` pictures, each said to have taken so long."""
    for index in range(count):
        actions.seek(state, index)
        assert state.view_request is not None
        (view,) = draw_view(state.view_request)
        state.scene.view = replace(view, milliseconds=milliseconds)
        viewport.show(state)


@pytest.mark.parametrize(
    ("own", "card", "winner"), [(50.0, 10.0, "OpenGL"), (10.0, 50.0, "the numba rasteriser")]
)
def test_a_software_driver_draws_where_it_is_faster(
    ctx: moderngl.Context,
    looking: AppState,
    monkeypatch: pytest.MonkeyPatch,
    own: float,
    card: float,
    winner: str,
) -> None:
    monkeypatch.setattr(chosen_viewport, "is_software", lambda _: True)
    monkeypatch.setattr(GraphicsViewport, "milliseconds", lambda *_: card)
    viewport = ChosenViewport(ctx, Textures(ctx), looking)
    look_around(looking, viewport, own, VIEWS - 1)
    assert looking.scene.processor_draws
    assert not looking.window.log
    look_around(looking, viewport, own)
    assert looking.scene.processor_draws == (winner != "OpenGL")
    (said,) = looking.window.log
    assert looking.scene.drawn_by == said
    assert said == f"3D view: numba {own:.0f} ms, {renderer_name(ctx)} {card:.0f} ms an image: {winner} draws"
    assert viewport.show(looking) is not None
    viewport.release()


def test_the_comparison_is_of_drawing_itself(ctx: moderngl.Context, looking: AppState) -> None:
    graphics = GraphicsViewport(ctx, Textures(ctx))
    assert looking.view_request is not None
    assert 0 < graphics.milliseconds(looking.view_request) < 5000
    graphics.release()


def test_previews_of_a_training_decide_nothing(
    ctx: moderngl.Context, looking: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(chosen_viewport, "is_software", lambda _: True)
    assert looking.scene.model is not None
    looking.scene.model = replace(looking.scene.model, live=True)
    viewport = ChosenViewport(ctx, Textures(ctx), looking)
    look_around(looking, viewport, 50.0, 2 * VIEWS)
    assert looking.scene.processor_draws
    assert not looking.window.log
    viewport.release()


@pytest.mark.parametrize("live", [True, False])
def test_nothing_of_a_model_stays_that_is_no_longer_shown(
    ctx: moderngl.Context, looking: AppState, monkeypatch: pytest.MonkeyPatch, live: bool
) -> None:
    """Each preview of a training is a model of its own, of ten megabytes and more."""
    monkeypatch.setattr(chosen_viewport, "is_software", lambda _: True)
    monkeypatch.setattr(GraphicsViewport, "milliseconds", lambda *_: 1000.0)
    viewport, gone = ChosenViewport(ctx, Textures(ctx), looking), []
    for _ in range(2 * VIEWS):
        assert looking.scene.model is not None
        looking.scene.model = replace(looking.scene.model, live=live)
        gone.append(weakref.ref(looking.scene.model))
        look_around(looking, viewport, 50.0, 1)
    gc.collect()
    assert [model() is None for model in gone] == [True] * (2 * VIEWS - 1) + [False]
    viewport.release()


@pytest.mark.parametrize("error", [moderngl.Error("GL_OUT_OF_MEMORY"), ValueError("too many splats")])
def test_a_card_that_fails_gives_way_to_the_rasteriser(
    ctx: moderngl.Context, looking: AppState, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr(chosen_viewport, "is_software", lambda _: False)
    viewport = ChosenViewport(ctx, Textures(ctx), looking)
    assert not looking.scene.processor_draws
    assert viewport.show(looking) is not None
    monkeypatch.setattr(GraphicsViewport, "_upload", fail)
    actions.seek(looking, 3)
    assert viewport.show(looking) is None  # Until the rasteriser has drawn the first picture.
    assert looking.scene.processor_draws
    assert [str(error) in line for line in looking.window.log] == [True]
    look_around(looking, viewport, 10.0, 1)
    assert viewport.show(looking) is not None
    assert len(looking.window.log) == 1
    viewport.release()


def test_a_lost_context_is_noticed_and_the_errors_of_others_are_not_taken_for_one(
    ctx: moderngl.Context, looking: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(chosen_viewport, "is_software", lambda _: False)
    viewport = ChosenViewport(ctx, Textures(ctx), looking)
    ctx.enable_direct(0xFFFF)  # An invalid name: GL_INVALID_ENUM waits.
    assert viewport.show(looking) is not None
    assert not looking.scene.processor_draws
    monkeypatch.setattr(
        GraphicsViewport, "_upload", lambda self, *_: (self._ctx.enable_direct(0xFFFF), self._splats)[1]
    )
    actions.seek(looking, 3)
    viewport.show(looking)
    assert looking.scene.processor_draws
    assert "GL_INVALID_ENUM" in looking.scene.drawn_by
    viewport.release()
