from __future__ import annotations

from dataclasses import replace

import moderngl
import numpy as np
import pytest

from app.gui import actions, camera_actions
from app.gui.state import AppState
from app.gui.textures import Textures
from app.gui.viewing import draw_view
from app.gui.viewport import GraphicsViewport, ProcessorViewport, make_viewport
from renderer.draw.context import is_software
from renderer.gaussians import DynamicGaussians
from tests.app.gui.conftest import FakeJob

SIZE = (64, 48)


@pytest.fixture
def live(state: AppState, model: DynamicGaussians) -> AppState:
    actions.start_reconstruction(state, FakeJob)
    actions.show_live_model(state, model)
    state.view_size = SIZE
    camera_actions.turn(state, 0.3, 0.2)
    return state


def read(ctx: moderngl.Context, name: int, channels: int) -> np.ndarray:
    texture = ctx.external_texture(name, SIZE, channels, 0, "f1")
    return np.frombuffer(texture.read(alignment=1), np.uint8).reshape(SIZE[1], SIZE[0], channels)[..., :3]


@pytest.mark.gl
def test_both_ways_of_drawing_show_the_same_picture(ctx: moderngl.Context, live: AppState) -> None:
    graphics, textures = GraphicsViewport(ctx), Textures(ctx)
    processor = ProcessorViewport(textures)
    assert live.view_request is not None
    (live.view,) = draw_view(live.view_request)
    drawn, made = graphics.show(live), processor.show(live)
    assert drawn is not None
    assert made is not None
    assert drawn.request == made.request == live.view_request
    upside_down = read(ctx, drawn.texture.get_tex_id(), 4).astype(int)
    upright = read(ctx, made.texture.get_tex_id(), 3).astype(int)
    assert upright.max() > 60
    assert np.abs(upside_down[::-1] - upright).max() <= 3
    assert (drawn.uv0, drawn.uv1) == ((0, 1), (1, 0))
    graphics.release()
    textures.release()


@pytest.mark.gl
def test_a_tiny_scene_is_seen_as_a_large_one_is(ctx: moderngl.Context, live: AppState) -> None:
    """In metres, or in no units at all: what counts is the near plane's share of the scene."""
    assert live.model is not None
    large = live.model.view(0.0, None, SIZE)
    share = 1e-4
    raw = live.model.model.raw
    smaller = replace(
        raw, means=raw.means * np.float32(share), log_scales=raw.log_scales + np.float32(np.log(share))
    )
    model = replace(live.model.model, raw=smaller)
    tiny = replace(live.model, model=model, distance=live.model.distance * share).view(0.0, None, SIZE)
    assert large.near / live.model.distance == pytest.approx(tiny.near / tiny.shown.distance)
    (wanted,), (seen,) = draw_view(large), draw_view(tiny)
    assert wanted.image.max() > 60
    assert np.abs(wanted.image.astype(int) - seen.image).max() <= 1
    graphics = GraphicsViewport(ctx)
    for request in (large, tiny):  # One after the other: the near plane goes with the model.
        graphics._draw(request, None)
    assert graphics._texture is not None
    picture = read(ctx, graphics._texture.glo, 4)[::-1].astype(int)
    assert np.abs(picture - wanted.image).max() <= 3
    graphics.release()


@pytest.mark.gl
def test_the_graphics_card_draws_only_what_changed(
    ctx: moderngl.Context, live: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    graphics = GraphicsViewport(ctx)
    drawn: list[object] = []
    draw = graphics._draw
    monkeypatch.setattr(graphics, "_draw", lambda *asked: (drawn.append(asked), draw(*asked)))
    for _ in range(3):
        graphics.show(live)
    assert len(drawn) == 1
    live.view_size = (32, 24)
    graphics.show(live)
    actions.seek(live, 3)
    graphics.show(live)
    assert len(drawn) == 3
    live.view_size = (0, 0)
    assert graphics.show(live) is None
    graphics.release()


@pytest.mark.gl
def test_the_processor_draws_where_there_is_no_graphics_card(ctx: moderngl.Context) -> None:
    viewport = make_viewport(ctx, Textures(ctx))
    assert isinstance(viewport, ProcessorViewport) == is_software(ctx)
    viewport.release()
