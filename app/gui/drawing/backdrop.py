"""Images behind all panels, drawn without blending, which halves their cost for a driver without a GPU."""

from __future__ import annotations

import moderngl
from imgui_bundle import ImVec2, imgui

from app.gui.drawing.quads import Quad, QuadView
from app.gui.drawing.textures import PLAIN, Marks, OnPane, ShowsPictures, Size
from app.gui.views.picture_view import Placement
from renderer.clip import ByteImage


class Backdrop:
    """The window's textures for a panel without a ground of its own: what it lays is behind it."""

    def __init__(self, ctx: moderngl.Context, textures: ShowsPictures) -> None:
        self._view, self._textures = QuadView(ctx), textures

    def whole(self, slot: str, image: ByteImage) -> imgui.ImTextureRef:
        return self._textures.whole(slot, image)

    def part(
        self, slot: str, image: ByteImage, place: Placement, pane: Size, marks: Marks = PLAIN
    ) -> OnPane | None:
        return self._textures.part(slot, image, place, pane, marks)

    def lay(self, shown: OnPane, low: ImVec2, high: ImVec2) -> None:
        """At once: the screen is cleared before panels say what they draw, and they are drawn afterwards."""
        io = imgui.get_io()
        size, scale = io.display_size, io.display_framebuffer_scale
        box = low.x * scale.x, low.y * scale.y, high.x * scale.x, high.y * scale.y
        self._view.lay(Quad(shown.texture, box, None), (round(size.x * scale.x), round(size.y * scale.y)))

    def release(self) -> None:
        self._view.release()
