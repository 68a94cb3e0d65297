"""Which of the two ways draws the 3D view: the graphics card where there is one, else the faster."""

from __future__ import annotations

import moderngl

from app.gui.actions import actions
from app.gui.drawing.textures import Textures
from app.gui.drawing.viewport import SECOND, GraphicsViewport, OnScreen, processor_picture
from app.gui.state.app_state import AppState
from app.scenes.drawer import View
from renderer.draw.context import is_software, renderer_name

VIEWS = 4
"""Pictures by the rasteriser before the two are compared: its kernels load with the first."""
FAILURES = (moderngl.Error, ValueError, MemoryError)


class ChosenViewport:
    """Sets `state.scene.processor_draws`, and says why in `state.scene.drawn_by`.

    On a software driver the numba rasteriser begins; once it has drawn a few pictures of a model, OpenGL
    draws the last of them, too, and takes over if it is faster. A card that fails gives way to the
    rasteriser.
    """

    def __init__(self, ctx: moderngl.Context, textures: Textures, state: AppState) -> None:
        self._ctx, self._textures = ctx, textures
        self._graphics = GraphicsViewport(ctx, textures)
        self._compares = is_software(ctx)
        self._views: list[View] = []
        state.scene.processor_draws = self._compares
        state.scene.drawn_by = f"OpenGL here is {renderer_name(ctx)}."

    def show(self, state: AppState) -> OnScreen | None:
        if self._compares:
            self._compare(state)
        if not state.scene.is_drawn_by_processor:
            try:
                return self._graphics.show(state)
            except FAILURES as error:
                self._give_up(state, error)
        return processor_picture(state, self._textures)

    def _compare(self, state: AppState) -> None:
        """Once, between two frames of the window, as long as one picture takes.

        Of a training there is a picture, with a model of its own, a second: none is kept.
        """
        view = state.scene.view
        if view is None or view.request.kind != "color" or view.request.scene.live:
            return
        if any(view is one for one in self._views):
            return
        self._views.append(view)
        if len(self._views) < VIEWS:
            return
        views, self._views, self._compares = self._views, [], False
        try:
            card = self._graphics.milliseconds(view.request)
        except FAILURES as error:
            self._give_up(state, error)
            return
        alike = [one for one in views if one.request.reduced == view.request.reduced]
        own = min(one.milliseconds for one in alike)
        state.scene.processor_draws = own <= card
        faster = "the numba rasteriser" if state.scene.processor_draws else "OpenGL"
        both = f"numba {own:.0f} ms, {renderer_name(self._ctx)} {card:.0f} ms an image"
        self._say(state, f"{both}: {faster} draws")

    def _give_up(self, state: AppState, error: Exception) -> None:
        state.scene.processor_draws, self._compares = True, False
        self._say(state, f"OpenGL failed ({error}): the numba rasteriser draws")

    def _say(self, state: AppState, why: str) -> None:
        state.scene.drawn_by = f"3D view: {why}"
        actions.say(state, state.scene.drawn_by)

    def release(self) -> None:
        self._graphics.release()


class SecondViewport:
    """Follows `state.scene.processor_draws`, which the first view's drawing decides."""

    def __init__(self, ctx: moderngl.Context, textures: Textures) -> None:
        self._textures, self._graphics = textures, GraphicsViewport(ctx, textures, SECOND)

    def show(self, state: AppState) -> OnScreen | None:
        if state.scene.is_drawn_by_processor:
            return processor_picture(state, self._textures, SECOND)
        try:
            return self._graphics.show(state)
        except FAILURES:  # The first view fails as well, says so, and leaves drawing to the processor.
            return None

    def release(self) -> None:
        self._graphics.release()
