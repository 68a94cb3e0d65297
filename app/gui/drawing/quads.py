"""Textures of the first window's context, drawn as rectangles by it or by that of another window."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import moderngl
from imgui_bundle import imgui

Box = tuple[float, float, float, float]
"""Left, top, right and bottom."""
WHOLE: Final[Box] = (0.0, 0.0, 1.0, 1.0)
VERTEX: Final = """
#version 330
uniform vec4 place;
uniform vec4 part;
out vec2 at;
void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    at = mix(part.xy, part.zw, corner);
    gl_Position = vec4(mix(place.xy, place.zw, corner), 0.0, 1.0);
}
"""
FRAGMENT: Final = """
#version 330
uniform sampler2D image;
uniform float share;
in vec2 at;
out vec4 color;
void main() { vec4 seen = texture(image, at); color = vec4(seen.rgb, seen.a * share); }
"""


@dataclass(frozen=True)
class Quad:
    """A texture in a rectangle of the window, whose pixels count from its upper left corner."""

    texture: imgui.ImTextureRef
    box: Box
    of: object
    """What it shows: another one is to be drawn."""
    part: Box = WHOLE
    """Of the texture."""
    share: float = 1.0
    """1: it hides what is below."""

    @property
    def identity(self) -> tuple[object, ...]:
        """Two that are equal in it look alike."""
        return self.box, self.of, self.part, self.share


class QuadView:
    """To be made, used and released while its own context is the current one."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._program = ctx.program(VERTEX, FRAGMENT)
        self._corners = ctx.vertex_array(self._program, [])

    def draw(self, quads: Sequence[Quad], size: tuple[int, int]) -> None:
        """One over the other on black, over the whole window of `size` pixels."""
        self._screen(size).clear()
        self._ctx.enable_only(moderngl.BLEND)
        self._ctx.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
        for quad in quads:
            self._draw(quad, size)

    def lay(self, quad: Quad, size: tuple[int, int]) -> None:
        """In place of what is there, as if it were opaque."""
        self._screen(size)
        self._ctx.enable_only(moderngl.NOTHING)
        self._draw(quad, size)

    def _screen(self, size: tuple[int, int]) -> moderngl.Framebuffer:
        screen = self._ctx.detect_framebuffer(0)
        screen.use()
        screen.viewport = (0, 0, *size)
        return screen

    def _draw(self, quad: Quad, size: tuple[int, int]) -> None:
        left, top, right, bottom = quad.box
        x, y = 2 / size[0], 2 / size[1]
        self._program["place"] = (x * left - 1, 1 - y * top, x * right - 1, 1 - y * bottom)
        self._program["part"], self._program["share"] = quad.part, quad.share
        # Its size and format count for writing and reading only.
        texture = self._ctx.external_texture(quad.texture.get_tex_id(), (1, 1), 4, 0, "f1")
        texture.use(0)
        self._corners.render(moderngl.TRIANGLE_STRIP, vertices=4)
        texture.release()

    def release(self) -> None:
        self._corners.release()
        self._program.release()
