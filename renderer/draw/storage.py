"""Textures that hold keyframes of splats as `splat.vert` reads them, and the order of drawing."""

from __future__ import annotations

import moderngl
import numpy as np
from numpy.typing import NDArray

from renderer.draw.keyframes import Keyframes, Offsets
from renderer.draw.records import SLOT, TEXELS, packed
from renderer.splats import Float32Array

ROW = 1024
"""Splats in a row of the records, and of the offsets."""
HARMONICS_ROW = 256
"""Splats in a row of the harmonics, up to 15 texels each."""
RECORDS_UNIT, HARMONICS_UNIT, OFFSETS_UNIT = 0, 1, 2
"""Texture units; each texel of the offsets has one."""
OFFSET_NAMES = ("place_offsets", "turn_offsets", "size_offsets", "paint_offsets")


class Storage:
    """What one upload needs on the graphics card.

    Raises:
        ValueError: more splats, or keyframes, than its textures hold.
    """

    def __init__(self, ctx: moderngl.Context, program: moderngl.Program, keyframes: Keyframes) -> None:
        rest = keyframes.rest
        self._check(ctx, keyframes)
        self._program = program
        records = packed(rest)
        # 0: stands still. float32 counts to 2^24 exactly, which no texture holds.
        records[keyframes.moving, SLOT] = np.arange(1, len(keyframes.moving) + 1)
        self._textures: dict[int, moderngl.Texture | moderngl.TextureArray] = {
            RECORDS_UNIT: _texture(ctx, records.reshape(-1, TEXELS, 4), ROW),
            HARMONICS_UNIT: _texture(ctx, rest.harmonics, HARMONICS_ROW),
        }
        nothing = np.zeros((1, 1, 4), np.float16)
        for texel in range(TEXELS):
            offsets = keyframes.offsets.get(texel, nothing)
            self._textures[OFFSETS_UNIT + texel] = _texture_array(ctx, offsets)
        self._functions = rest.harmonics.shape[1]
        self._moves = tuple(texel in keyframes.offsets for texel in range(TEXELS))
        self.order = ctx.buffer(reserve=4 * max(1, len(rest)), dynamic=True)
        self.quads = ctx.vertex_array(program, [(self.order, "1u4/i", "splat")])

    @staticmethod
    def _check(ctx: moderngl.Context, keyframes: Keyframes) -> None:
        rows, layers = int(ctx.info["GL_MAX_TEXTURE_SIZE"]), int(ctx.info["GL_MAX_ARRAY_TEXTURE_LAYERS"])
        row = HARMONICS_ROW if keyframes.rest.harmonics.size else ROW
        if len(keyframes.rest) > rows * row:
            raise ValueError(f"expected at most {rows * row} splats here, got {len(keyframes.rest)}")
        if keyframes.offsets and len(keyframes) > layers:
            raise ValueError(f"expected at most {layers} keyframes here, got {len(keyframes)}")

    def use(self) -> None:
        """Bind the textures and tell the program about them."""
        for unit, texture in self._textures.items():
            texture.use(unit)
        program = self._program
        program["records"], program["harmonics"] = RECORDS_UNIT, HARMONICS_UNIT
        program["functions"], program["moves"] = self._functions, self._moves
        for texel, name in enumerate(OFFSET_NAMES):
            program[name] = OFFSETS_UNIT + texel

    def write_order(self, order: NDArray[np.uint32]) -> None:
        """In which splats are drawn, the first first."""
        self.order.orphan()
        self.order.write(np.ascontiguousarray(order))

    def release(self) -> None:
        self.quads.release()
        self.order.release()
        for texture in self._textures.values():
            texture.release()


def _texture(ctx: moderngl.Context, values: Float32Array, row: int) -> moderngl.Texture:
    """Texture of (N, T, C) values, `row` splats a row, filled up with zeros; at least one texel."""
    count, texels, components = values.shape
    texels, components = max(texels, 1), max(components, 1)
    rows = max(1, -(-count // row))
    whole = np.zeros((rows * row, texels, components), np.float32)
    if values.size:
        whole[:count] = values
    texture = ctx.texture((row * texels, rows), components, whole, alignment=4, dtype="f4")
    texture.filter = moderngl.NEAREST, moderngl.NEAREST
    return texture


def _texture_array(ctx: moderngl.Context, offsets: Offsets) -> moderngl.TextureArray:
    """A layer for each keyframe of (K, M, 4) offsets."""
    layers, count, _ = offsets.shape
    rows = max(1, -(-count // ROW))
    dtype = "f2" if offsets.dtype == np.float16 else "f4"
    texture = ctx.texture_array((ROW, rows, layers), 4, dtype=dtype)
    texture.filter = moderngl.NEAREST, moderngl.NEAREST
    whole = np.zeros((rows * ROW, 4), offsets.dtype)
    for layer in range(layers):
        whole[:count] = offsets[layer]
        texture.write(whole, viewport=(0, 0, layer, ROW, rows, 1))
    return texture
