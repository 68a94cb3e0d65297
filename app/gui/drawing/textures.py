"""Arrays as textures of the window's OpenGL context."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import cv2
import moderngl
import numpy as np
from imgui_bundle import ImVec2, imgui

from app.gui.views.picture_view import Placement
from app.gui.views.resample import striped, tinted, visible
from renderer.clip import BoolImage, ByteImage

Size = tuple[float, float]
Marks = tuple[bool, BoolImage | None]
"""What is painted over a picture: stripes on clipped pixels or not, a tint where this (H, W) is True."""
PLAIN: Marks = (False, None)


@dataclass(frozen=True)
class OnPane:
    """A texture and the rectangle of a pane that it fills, in pixels of the screen."""

    texture: imgui.ImTextureRef
    x: int
    y: int
    width: int
    height: int


class ShowsPictures(Protocol):
    """What panels need of textures; tests of panels put something without OpenGL in its place."""

    def whole(self, slot: str, image: ByteImage) -> imgui.ImTextureRef: ...
    def part(
        self, slot: str, image: ByteImage, place: Placement, pane: Size, marks: Marks = PLAIN
    ) -> OnPane | None: ...
    def lay(self, shown: OnPane, low: ImVec2, high: ImVec2) -> None: ...


class Textures:
    """One texture a slot, such as "original"; written only when what the slot shows has changed."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._textures: dict[str, moderngl.Texture] = {}
        self._images: dict[str, ByteImage] = {}
        self._parts: dict[str, tuple[BoolImage | None, tuple[Placement, Size, bool], OnPane | None]] = {}

    def whole(self, slot: str, image: ByteImage) -> imgui.ImTextureRef:
        """The texture of an (H, W, 3) or (H, W, 4) image, first row first."""
        if self._images.get(slot) is not image:
            self._write(slot, image, moderngl.LINEAR)
            self._images[slot] = image
        return imgui.ImTextureRef(self._textures[slot].glo)

    def part(
        self, slot: str, image: ByteImage, place: Placement, pane: Size, marks: Marks = PLAIN
    ) -> OnPane | None:
        """What a pane of (width, height) screen pixels shows of the image; None when it shows nothing."""
        zebra, left_out = marks
        tint, how, made = self._parts.get(slot, (None, None, None))
        if self._images.get(slot) is image and tint is left_out and how == (place, pane, zebra):
            return made
        patch, shown = (striped if zebra else visible)(image, place, pane), None
        if patch is not None and left_out is not None:
            patch = tinted(patch, left_out, place, pane)
        if patch is not None:
            # Pixel for pixel there is nothing between them, which a driver without a GPU would compute.
            texture = self._write(slot, patch.pixels, moderngl.NEAREST)
            shown = OnPane(imgui.ImTextureRef(texture.glo), patch.x, patch.y, *texture.size)
        self._images[slot], self._parts[slot] = image, (left_out, (place, pane, zebra), shown)
        return shown

    def lay(self, shown: OnPane, low: ImVec2, high: ImVec2) -> None:
        """In the panel that is being drawn."""
        imgui.get_window_draw_list().add_image(shown.texture, low, high)

    def _write(self, slot: str, pixels: ByteImage, sampling: int) -> moderngl.Texture:
        """With an opacity: drivers take pixels of three bytes one by one, several times slower."""
        height, width, channels = pixels.shape
        texture = self._textures.get(slot)
        if texture is not None and texture.size != (width, height):
            texture.release()
            texture = None
        if texture is None:
            texture = self._textures[slot] = self._ctx.texture((width, height), 4)
            texture.repeat_x = texture.repeat_y = False
        opaque = cv2.cvtColor(pixels, cv2.COLOR_RGB2RGBA) if channels == 3 else np.ascontiguousarray(pixels)
        texture.write(opaque)
        texture.filter = (sampling, sampling)
        return texture

    def release(self) -> None:
        for texture in self._textures.values():
            texture.release()
        for slots in (self._textures, self._images, self._parts):
            slots.clear()
