"""The 3D view as a texture: drawn by the graphics card, or by the numba rasteriser where there is none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Final, Protocol

import moderngl
from imgui_bundle import imgui

from app.gui.drawing.textures import Textures
from app.gui.state.app_state import AppState
from app.gui.state.scene import Viewed
from app.scenes.view_kinds import SHAPES, Composed, Scale, ViewKind, splats_for
from app.scenes.view_request import ViewRequest
from renderer.camera import BoolArray
from renderer.closing import closed
from renderer.deformation.motion import Still
from renderer.draw.keyframes import Keyframes
from renderer.draw.offscreen import read_layers
from renderer.draw.splat_view import Paint, SplatView
from renderer.unobserved import GREY, LINES

WITH_DEPTH: Final = ("depth", "normals")
"""Views that are made of how far it is."""


@dataclass(frozen=True)
class OnScreen:
    """A drawn 3D view, first row at the top of `uv0`."""

    texture: imgui.ImTextureRef
    uv0: tuple[float, float]
    uv1: tuple[float, float]
    request: ViewRequest
    """What it was drawn from."""
    scale: Scale | None = None
    """What its colours mean, where they are values."""


@dataclass(frozen=True)
class Watch:
    """Which of the two 3D views a viewport shows: its texture, what is wanted of it, what is there for it."""

    slot: str
    request: Callable[[AppState], ViewRequest | None]
    viewed: Callable[[AppState], Viewed]


FIRST = Watch("view", lambda state: state.view_request, lambda state: state.scene)
SECOND = Watch("second view", lambda state: state.second_request, lambda state: state.scene.second)


class Viewport(Protocol):
    def show(self, state: AppState) -> OnScreen | None: ...
    def release(self) -> None: ...


def processor_picture(state: AppState, textures: Textures, watch: Watch = FIRST) -> OnScreen | None:
    """The newest one that background work has drawn."""
    view = watch.viewed(state).view
    if view is None or state.scene.model is None:
        return None
    return OnScreen(textures.whole(watch.slot, view.image), (0, 0), (1, 1), view.request, view.scale)


class GraphicsViewport:
    """Draws when the request differs from the one on screen; views other than colour by way of arrays."""

    def __init__(self, ctx: moderngl.Context, textures: Textures, watch: Watch = FIRST) -> None:
        self._ctx, self._textures, self._watch = ctx, textures, watch
        self._composed: Composed | None = None
        self._splats: SplatView | None = None
        self._near = 0.0
        self._target: moderngl.Framebuffer | None = None
        self._texture: moderngl.Texture | None = None
        self._uploaded: object = None
        """The keyframes, or the model and the time, that are on the card."""
        self._drawn: ViewRequest | None = None
        self._shown: BoolArray | None = None
        """Of `_drawn`, what is not left out of it."""

    def show(self, state: AppState) -> OnScreen | None:
        request = self._watch.request(state)
        if request is None:
            return None
        if request != self._drawn or _shown(request) is not self._shown:
            self._draw(request, self._watch.viewed(state).keyframes_of(request.scene))
        if self._composed is not None:
            texture = self._textures.whole(self._watch.slot, self._composed.image)
            return OnScreen(texture, (0, 0), (1, 1), request, self._composed.scale)
        assert self._texture is not None
        # OpenGL stores the bottom row first.
        return OnScreen(imgui.ImTextureRef(self._texture.glo), (0, 1), (1, 0), request)

    def milliseconds(self, request: ViewRequest) -> float:
        """Of drawing it as after a move of the camera, its splats being there already."""
        # Shaders are compiled and splats uploaded with a small picture, so that the window waits less.
        self._draw(request.scaled(0.1), None)
        assert self._splats is not None
        self._splats.forget_order()
        self._ctx.finish()
        began = perf_counter()
        self._draw(request, None)
        self._ctx.finish()
        return 1000 * (perf_counter() - began)

    def _draw(self, request: ViewRequest, keyframes: Keyframes | None) -> None:
        """Raises moderngl.Error for a context that is lost, or has run out of memory."""
        _forget_errors(self._ctx)
        splats, size = self._upload(request, keyframes), (request.camera.width, request.camera.height)
        shown = _shown(request)
        if request.kind != "color" or request.background == "smooth":
            paint, with_depth = _paint(request.kind, keyframes), request.kind in WITH_DEPTH
            shape = SHAPES[request.kind]
            drawn = read_layers(
                splats,
                request.camera,
                shape,
                paint=paint,
                within=request.within,
                shown=shown,
                with_depth=with_depth,
            )
            self._composed = request.composed(closed(drawn, request.closing))
        else:
            self._composed = None
            if self._target is None or self._target.size != size:
                self._release_target()
                self._texture = self._ctx.texture(size, 4)
                self._target = self._ctx.framebuffer([self._texture])
            lines = LINES if request.background == "hatched" else None
            ground = GREY if request.background == "hatched" else request.background
            splats.draw(
                request.camera,
                self._target,
                background=ground,
                lines=lines,
                within=request.within,
                shown=shown,
                closing=request.closing,
            )
        if (error := self._ctx.error) != "GL_NO_ERROR":
            raise moderngl.Error(error)
        self._drawn, self._shown = request, shown

    def _upload(self, request: ViewRequest, keyframes: Keyframes | None) -> SplatView:
        """What draws, with the splats of the request's moment."""
        if self._splats is None or self._near != request.near:
            self._release_splats()
            self._splats, self._near = SplatView(self._ctx, near=request.near), request.near
        scene = request.scene
        time = 0.0 if isinstance(scene.model.motion, Still) else request.time
        kind: ViewKind = "motion" if request.kind == "motion" else "color"
        wanted = (scene, time, kind) if keyframes is None else keyframes
        if self._uploaded != wanted and keyframes is not None:
            self._splats.upload_keyframes(keyframes, scene.mode)
        elif self._uploaded != wanted:
            self._splats.upload(splats_for(kind, scene.model, time), scene.mode)
        self._uploaded = wanted
        self._splats.seek(time)
        return self._splats

    def _release_target(self) -> None:
        for item in (self._target, self._texture):
            if item is not None:
                item.release()

    def _release_splats(self) -> None:
        if self._splats is not None:
            self._splats.release()
        self._splats, self._uploaded = None, None

    def release(self) -> None:
        self._release_target()
        self._release_splats()


def _shown(request: ViewRequest) -> BoolArray | None:
    """Of its Gaussians, those that are not left out; None: all."""
    return request.scene.shown_so_far if request.leaves_out else None


def _paint(kind: ViewKind, keyframes: Keyframes | None) -> Paint:
    """What the card finds by itself. Where a splat was at the start it knows from keyframes alone."""
    return "motion" if kind == "motion" and keyframes is not None else "color"


def _forget_errors(ctx: moderngl.Context) -> None:
    """Of others; a lost context reports its loss for ever."""
    for _ in range(8):
        if ctx.error == "GL_NO_ERROR":
            return
