from __future__ import annotations

from dataclasses import replace

import moderngl
import numpy as np
import pytest

from app.gui.actions import actions, camera_actions
from app.gui.drawing.textures import Textures
from app.gui.drawing.viewport import GraphicsViewport, processor_picture
from app.gui.state.app_state import AppState
from app.scenes.backgrounds import BACKGROUNDS, BackgroundName
from app.scenes.drawer import draw_view
from app.scenes.view_kinds import BY_PROCESSOR, EXPLAINED, ViewKind, has_scale
from app.scenes.view_request import ViewRequest, read_frame
from renderer.deformation.frame_by_frame import FrameByFrame
from renderer.gaussians import DynamicGaussians
from renderer.raw_gaussians import RawGaussians
from renderer.splats import Splats
from tests.app.gui.conftest import start_live
from tests.renderer.scenes import random_splats

SIZE = (64, 48)


@pytest.fixture
def live(state: AppState, model: DynamicGaussians) -> AppState:
    start_live(state, model)
    state.scene.size = SIZE
    camera_actions.turn(state, 0.3, 0.2)
    return state


def read(ctx: moderngl.Context, name: int, channels: int) -> np.ndarray:
    texture = ctx.external_texture(name, SIZE, channels, 0, "f1")
    return np.frombuffer(texture.read(alignment=1), np.uint8).reshape(SIZE[1], SIZE[0], channels)[..., :3]


@pytest.mark.gl
@pytest.mark.parametrize("background", BACKGROUNDS)
def test_both_ways_of_drawing_show_the_same_picture(
    ctx: moderngl.Context, live: AppState, background: BackgroundName
) -> None:
    actions.choose_background(live, background)
    graphics, textures = GraphicsViewport(ctx, Textures(ctx)), Textures(ctx)
    assert live.view_request is not None
    (live.scene.view,) = draw_view(live.view_request)
    drawn, made = graphics.show(live), processor_picture(live, textures)
    assert drawn is not None
    assert made is not None
    assert drawn.request == made.request == live.view_request
    smooth = background == "smooth"  # Laid over on the processor, in either way.
    upside_down = read(ctx, drawn.texture.get_tex_id(), 3 if smooth else 4).astype(int)
    upside_down = upside_down[::-1] if smooth else upside_down
    upright = read(ctx, made.texture.get_tex_id(), 3).astype(int)
    assert upright.max() > 60
    assert np.abs(upside_down[::-1] - upright).max() <= 3
    assert (drawn.uv0, drawn.uv1) == (((0, 0), (1, 1)) if smooth else ((0, 1), (1, 0)))
    graphics.release()
    textures.release()


@pytest.mark.gl
def test_a_tiny_scene_is_seen_as_a_large_one_is(ctx: moderngl.Context, live: AppState) -> None:
    """In metres, or in no units at all: what counts is the near plane's share of the scene."""
    assert live.scene.model is not None
    large = ViewRequest.fitted(live.scene.model, 0.0, None, SIZE)
    share = 1e-4
    raw = live.scene.model.model.raw
    smaller = replace(
        raw, means=raw.means * np.float32(share), log_scales=raw.log_scales + np.float32(np.log(share))
    )
    model = replace(live.scene.model.model, raw=smaller)
    smaller_scene = replace(live.scene.model, model=model, distance=live.scene.model.distance * share)
    tiny = ViewRequest.fitted(smaller_scene, 0.0, None, SIZE)
    assert large.near / live.scene.model.distance == pytest.approx(tiny.near / tiny.scene.distance)
    (wanted,), (seen,) = draw_view(large), draw_view(tiny)
    assert wanted.image.max() > 60
    assert np.abs(wanted.image.astype(int) - seen.image).max() <= 1
    graphics = GraphicsViewport(ctx, Textures(ctx))
    for request in (large, tiny):  # One after the other: the near plane goes with the model.
        graphics._draw(request, None)
    assert graphics._texture is not None
    picture = read(ctx, graphics._texture.glo, 4)[::-1].astype(int)
    assert np.abs(picture - wanted.image).max() <= 3
    graphics.release()


def raw(splats: Splats) -> RawGaussians:
    """Those that are drawn as `splats`."""
    return RawGaussians(
        splats.means,
        splats.quats,
        np.log(splats.scales),
        np.log(splats.opacities / (1 - splats.opacities)),
        splats.colors,
        np.zeros((len(splats), 0, 3), np.float32),
    )


@pytest.mark.gl
def test_of_a_series_each_moment_has_its_own_gaussians(ctx: moderngl.Context, live: AppState) -> None:
    """Fewer of them, more, and fewer again."""
    scene = live.scene.model
    assert scene is not None
    moments = tuple(raw(random_splats(n, scene.cameras[0], n)) for n in (150, 400))
    series = replace(scene, model=DynamicGaussians(moments[0], FrameByFrame(moments)))
    graphics = GraphicsViewport(ctx, Textures(ctx))
    pictures = []
    for time in (0.0, 0.5, 0.0):
        request = ViewRequest.fitted(series, time, None, SIZE)
        graphics._draw(request, None)
        assert graphics._texture is not None
        pictures.append(read(ctx, graphics._texture.glo, 4)[::-1].astype(int))
        (wanted,) = draw_view(request)
        assert np.abs(pictures[-1] - wanted.image).max() <= 3
    assert np.abs(pictures[0] - pictures[1]).max() > 60
    graphics.release()


@pytest.mark.gl
def test_the_graphics_card_draws_only_what_changed(
    ctx: moderngl.Context, live: AppState, monkeypatch: pytest.MonkeyPatch
) -> None:
    graphics = GraphicsViewport(ctx, Textures(ctx))
    drawn: list[object] = []
    draw = graphics._draw
    monkeypatch.setattr(graphics, "_draw", lambda *asked: (drawn.append(asked), draw(*asked)))
    for _ in range(3):
        graphics.show(live)
    assert len(drawn) == 1
    live.scene.size = (32, 24)
    graphics.show(live)
    actions.seek(live, 3)
    graphics.show(live)
    assert len(drawn) == 3
    live.scene.size = (0, 0)
    assert graphics.show(live) is None
    graphics.release()


@pytest.mark.gl
@pytest.mark.parametrize("kind", [kind for kind in EXPLAINED if kind not in BY_PROCESSOR])
def test_both_ways_of_drawing_show_the_same_views(
    ctx: moderngl.Context, live: AppState, kind: ViewKind
) -> None:
    """But for pixels on the edge of a body, and what float32 makes of a colour between two."""
    textures = Textures(ctx)
    graphics, others = GraphicsViewport(ctx, textures), Textures(ctx)
    camera_actions.reset_view(live)
    camera_actions.choose_view(live, kind)
    assert live.frame_request is not None or kind != "difference"
    if live.frame_request is not None:
        (live.scene.viewer.frame_image,) = read_frame(live.frame_request)
    request = live.view_request
    assert request is not None
    assert request.kind == kind
    (live.scene.view,) = draw_view(request)
    drawn, made = graphics.show(live), processor_picture(live, others)
    assert drawn is not None
    assert made is not None
    assert drawn.scale == made.scale == live.scene.view.scale
    assert (made.scale is not None) == has_scale(kind)
    if kind != "color":
        assert graphics._composed is not None
        away = np.abs(graphics._composed.image.astype(int) - live.scene.view.image).max(axis=2)
        assert np.mean(away > 3) < 0.01
        assert live.scene.view.image.std() > 1
    graphics.release()


def test_a_difference_needs_the_clips_camera_and_its_frame(live: AppState) -> None:
    camera_actions.choose_view(live, "difference")
    assert live.scene.viewer.snapped
    assert live.view_request is not None
    assert live.view_request.kind == "color"
    assert live.frame_request is not None
    (live.scene.viewer.frame_image,) = read_frame(live.frame_request)
    assert live.view_request.kind == "difference"
    camera_actions.turn(live, 0.1, 0.0)
    assert live.view_request.kind == "color"
    live.source.clip = None
    assert "difference" not in camera_actions.choices(live)


def test_the_key_goes_through_all_views_and_back(live: AppState) -> None:
    seen = []
    for _ in EXPLAINED:
        seen.append(live.scene.kind)
        camera_actions.next_view(live)
    assert (tuple(seen), live.scene.kind) == (tuple(EXPLAINED), "color")
