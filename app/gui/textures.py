"""Arrays as textures of the window's OpenGL context."""

from __future__ import annotations

from typing import Protocol

import moderngl
import numpy as np
from imgui_bundle import imgui

from renderer.clip import ByteImage

SHARP_ZOOM = 3.0
"""From here on single pixels are shown as squares, on both sides alike."""


class ShowsImages(Protocol):
    """What panels need of textures; tests of panels put something without OpenGL in its place."""

    def show(self, slot: str, image: ByteImage, zoom: float = 1.0) -> imgui.ImTextureRef: ...


class Textures:
    """One texture a slot, such as "original"; written only when the slot's image is another object."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._slots: dict[str, tuple[moderngl.Texture, ByteImage]] = {}

    def show(self, slot: str, image: ByteImage, zoom: float = 1.0) -> imgui.ImTextureRef:
        """The texture of an (H, W, 3) image, filtered for `zoom` screen pixels per image pixel."""
        texture, shown = self._slots.get(slot, (None, None))
        if texture is None or shown is not image:
            texture = self._write(texture, image)
            self._slots[slot] = (texture, image)
        enlarge = moderngl.NEAREST if zoom >= SHARP_ZOOM else moderngl.LINEAR
        texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, enlarge)
        return imgui.ImTextureRef(texture.glo)

    def _write(self, texture: moderngl.Texture | None, image: ByteImage) -> moderngl.Texture:
        height, width = image.shape[:2]
        pixels = np.ascontiguousarray(image)
        if texture is not None and texture.size != (width, height):
            texture.release()
            texture = None
        if texture is None:
            texture = self._ctx.texture((width, height), 3, alignment=1)
            texture.repeat_x = texture.repeat_y = False
        texture.write(pixels, alignment=1)
        texture.build_mipmaps()
        return texture

    def release(self) -> None:
        for texture, _ in self._slots.values():
            texture.release()
        self._slots.clear()
