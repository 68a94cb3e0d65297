"""Everything of the window that lives in its OpenGL context."""

from __future__ import annotations

from dataclasses import dataclass

import moderngl

from app.gui.drawing.backdrop import Backdrop
from app.gui.drawing.chosen_viewport import ChosenViewport, SecondViewport
from app.gui.drawing.textures import Textures
from app.gui.drawing.viewport import Viewport
from app.gui.frame import starting
from app.gui.frame.second_content import SecondContent
from app.gui.frame.second_window import SecondWindow
from app.gui.state.app_state import AppState


@dataclass(frozen=True, eq=False)
class Canvas:
    """Made once the context is there, and given back while it still is."""

    ctx: moderngl.Context
    textures: Textures
    backdrop: Backdrop
    viewport: Viewport
    second_viewport: Viewport
    second_window: SecondWindow

    @classmethod
    def of(cls, state: AppState) -> Canvas:
        """Raises RuntimeError or moderngl.Error: no OpenGL 3.3."""
        ctx = starting.attach()
        textures = Textures(ctx)
        viewport = ChosenViewport(ctx, textures, state)
        return cls(
            ctx,
            textures,
            Backdrop(ctx, textures),
            viewport,
            SecondViewport(ctx, textures),
            SecondWindow(SecondContent(ctx, textures, viewport)),
        )

    def release(self) -> None:
        """Give the OpenGL objects back."""
        self.second_window.close()
        for item in (self.viewport, self.second_viewport, self.backdrop, self.textures):
            item.release()
