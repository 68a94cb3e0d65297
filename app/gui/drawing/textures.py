"""Arrays as textures of the window's OpenGL context."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import moderngl
import numpy as np
from imgui_bundle import imgui

from app.gui.views.picture_view import Placement
from app.gui.views.resample import striped, tinted, visible
from renderer.clip import BoolImage, ByteImage

Size = tuple[float, float]


@dataclass(frozen=True)
class OnPane:
    """A texture and the rectangle of a pane that it fills, in pixels of the screen."""

    texture: imgui.ImTextureRef
    x: int
    y: int
    width: int
    height: int


@dataclass(frozen=True, eq=False)
class Marks:
    """What is painted over a picture."""

    zebra: bool = False
    """Stripes on clipped pixels."""
    left_out: BoolImage | None = None
    """(H, W), True = tinted."""

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Marks):
            return NotImplemented
        return self.zebra == other.zebra and self.left_out is other.left_out

    def __hash__(self) -> int:
        return hash((self.zebra, id(self.left_out)))


PLAIN = Marks()


class ShowsPictures(Protocol):
    """What panels need of textures; tests of panels put something without OpenGL in its place."""

    def part(
        self, slot: str, image: ByteImage, place: Placement, pane: Size, marks: Marks = PLAIN
    ) -> OnPane | None: ...


class Textures:
    """One texture a slot, such as "original"; written only when what the slot shows has changed."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._textures: dict[str, moderngl.Texture] = {}
        self._images: dict[str, ByteImage] = {}
        self._parts: dict[str, tuple[Placement, Size, Marks, OnPane | None]] = {}

    def whole(self, slot: str, image: ByteImage) -> imgui.ImTextureRef:
        """The texture of an (H, W, 3) image, first row first."""
        if self._images.get(slot) is not image:
            self._write(slot, image)
            self._images[slot] = image
        return imgui.ImTextureRef(self._textures[slot].glo)

    def part(
        self, slot: str, image: ByteImage, place: Placement, pane: Size, marks: Marks = PLAIN
    ) -> OnPane | None:
        """What a pane of (width, height) screen pixels shows of the image; None when it shows nothing.

        `marks`: what is painted over the picture.
        """
        last = self._parts.get(slot)
        if self._images.get(slot) is image and last is not None and last[:3] == (place, pane, marks):
            return last[3]
        patch, shown = (striped if marks.zebra else visible)(image, place, pane), None
        if patch is not None and marks.left_out is not None:
            patch = tinted(patch, marks.left_out, place, pane)
        if patch is not None:
            texture = self._write(slot, patch.pixels)
            shown = OnPane(imgui.ImTextureRef(texture.glo), patch.x, patch.y, *texture.size)
        self._images[slot], self._parts[slot] = image, (place, pane, marks, shown)
        return shown

    def _write(self, slot: str, pixels: ByteImage) -> moderngl.Texture:
        size = (pixels.shape[1], pixels.shape[0])
        texture = self._textures.get(slot)
        if texture is not None and texture.size != size:
            texture.release()
            texture = None
        if texture is None:
            texture = self._textures[slot] = self._ctx.texture(size, 3, alignment=1)
            texture.repeat_x = texture.repeat_y = False
        texture.write(np.ascontiguousarray(pixels), alignment=1)
        return texture

    def release(self) -> None:
        for texture in self._textures.values():
            texture.release()
        for slots in (self._textures, self._images, self._parts):
            slots.clear()
