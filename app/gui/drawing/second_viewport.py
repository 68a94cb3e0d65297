"""The second 3D view as a texture: drawn by what draws the first."""

from __future__ import annotations

import moderngl

from app.gui.drawing.chosen_viewport import FAILURES
from app.gui.drawing.textures import Textures
from app.gui.drawing.viewport import SECOND, GraphicsViewport, OnScreen, ProcessorViewport
from app.gui.state.app_state import AppState


class SecondViewport:
    """Follows `state.scene.processor_draws`, which the first view's drawing decides."""

    def __init__(self, ctx: moderngl.Context, textures: Textures) -> None:
        self._graphics = GraphicsViewport(ctx, textures, SECOND)
        self._processor = ProcessorViewport(textures, SECOND)

    def show(self, state: AppState) -> OnScreen | None:
        if state.scene.processor_draws:
            return self._processor.show(state)
        try:
            return self._graphics.show(state)
        except FAILURES:  # The first view fails as well, says so, and leaves drawing to the processor.
            return None

    def release(self) -> None:
        self._graphics.release()
        self._processor.release()
