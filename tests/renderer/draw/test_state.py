"""Drawing leaves the driver's state as it was, by the driver's own word."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from typing import Any

import moderngl
import pytest

from renderer.camera import Camera
from renderer.draw.splat_view import SplatView
from tests.renderer.scenes import random_splats

pytestmark = pytest.mark.gl

QUERIES = {
    "draw framebuffer": (0x8CA6, 1),
    "read framebuffer": (0x8CAA, 1),
    "viewport": (0x0BA2, 4),
    "scissor test": (0x0C11, 1),
    "scissor box": (0x0C10, 4),
    "blend": (0x0BE2, 1),
    "blend source rgb": (0x80C9, 1),
    "blend destination rgb": (0x80C8, 1),
    "blend source alpha": (0x80CB, 1),
    "blend destination alpha": (0x80CA, 1),
    "blend equation rgb": (0x8009, 1),
    "blend equation alpha": (0x883D, 1),
    "depth test": (0x0B71, 1),
    "cull face": (0x0B44, 1),
    "program point size": (0x8642, 1),
    "sRGB": (0x8DB9, 1),
    "color mask": (0x0C23, 4),
    "depth mask": (0x0B72, 1),
    "clear color": (0x0C22, 4),
}
CAMERA = Camera.from_fov(60, 32, 24)


class Driver:
    """The driver's entry points, asked directly."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._load = ctx.mglo._context.load
        self._get = self.entry("glGetIntegerv", ctypes.c_uint, ctypes.POINTER(ctypes.c_int))

    def entry(self, name: str, *arguments: Any, result: Any = None) -> Any:
        return ctypes.CFUNCTYPE(result, *arguments)(self._load(name))

    def state(self) -> dict[str, list[int]]:
        return {name: self._read(*query) for name, query in QUERIES.items()}

    def _read(self, name: int, count: int) -> list[int]:
        values = (ctypes.c_int * 4)()
        self._get(name, values)
        return values[:count]


@pytest.fixture
def view(ctx: moderngl.Context) -> Iterator[SplatView]:
    view = SplatView(ctx)
    view.upload(random_splats(50, CAMERA))
    yield view
    view.release()


@pytest.fixture
def driver(ctx: moderngl.Context) -> Iterator[Driver]:
    """A driver whose state is set back to OpenGL's defaults after the test, in moderngl's record too."""
    driver = Driver(ctx)
    known = ctx.fbo, ctx.mglo.fbo
    yield driver
    ctx.fbo, ctx.mglo.fbo = known
    driver.entry("glBindFramebuffer", ctypes.c_uint, ctypes.c_uint)(0x8D40, 0)
    ctx.enable_only(moderngl.NOTHING)
    ctx.disable_direct(0x0C11)
    ctx.disable_direct(0x8DB9)
    ctx.blend_equation = moderngl.FUNC_ADD, moderngl.FUNC_ADD
    ctx.blend_func = moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA
    driver.entry("glColorMask", *[ctypes.c_ubyte] * 4)(1, 1, 1, 1)
    driver.entry("glDepthMask", ctypes.c_ubyte)(1)


def set_unusual_state(ctx: moderngl.Context, driver: Driver) -> moderngl.Framebuffer:
    """State of a foreign library: half of it set behind moderngl's back."""
    bound = ctx.simple_framebuffer((20, 10))
    bound.use()
    for name in (0x0BE2, 0x0B71, 0x0B44, 0x0C11, 0x8DB9):
        driver.entry("glEnable", ctypes.c_uint)(name)
    driver.entry("glBlendFuncSeparate", *[ctypes.c_uint] * 4)(0x0306, 0x0300, 0x0001, 0x0303)
    driver.entry("glBlendEquationSeparate", *[ctypes.c_uint] * 2)(0x800A, 0x8006)
    driver.entry("glViewport", *[ctypes.c_int] * 4)(3, 1, 11, 7)
    driver.entry("glScissor", *[ctypes.c_int] * 4)(2, 2, 5, 4)
    driver.entry("glColorMask", *[ctypes.c_ubyte] * 4)(1, 0, 1, 0)
    driver.entry("glDepthMask", ctypes.c_ubyte)(0)
    return bound


def test_every_drawing_restores_unusual_state(ctx: moderngl.Context, view: SplatView, driver: Driver) -> None:
    framebuffer = ctx.simple_framebuffer((40, 30))
    bound = set_unusual_state(ctx, driver)
    before = driver.state()
    assert before["blend"] == before["depth test"] == before["scissor test"] == [1]
    view.draw(CAMERA, framebuffer)
    assert driver.state() == before
    view.read_depth(CAMERA)
    assert driver.state() == before
    view.seek(0.5)
    view.read_color(CAMERA, "ellipsoid")
    assert driver.state() == before
    assert ctx.fbo is bound
    framebuffer.clear()  # moderngl binds again what it believes to be bound
    assert driver.state()["draw framebuffer"] == before["draw framebuffer"]


def test_unusual_state_does_not_reach_the_picture(
    ctx: moderngl.Context, view: SplatView, driver: Driver
) -> None:
    srgb = ctx.texture((40, 30), 4, internal_format=0x8C43)
    framebuffer = ctx.framebuffer([srgb])
    view.draw(CAMERA, framebuffer, background=(0.2, 0.4, 0.6))
    plain = framebuffer.read(components=4)
    framebuffer.clear()
    set_unusual_state(ctx, driver)
    view.draw(CAMERA, framebuffer, background=(0.2, 0.4, 0.6))
    assert framebuffer.read(components=4) == plain


def test_a_failed_drawing_restores_too(ctx: moderngl.Context, view: SplatView, driver: Driver) -> None:
    framebuffer = ctx.simple_framebuffer((40, 30))
    before = driver.state()
    with pytest.raises(Exception, match="not a float"):
        view.draw(CAMERA, framebuffer, background=("red", 0, 0))  # type: ignore[arg-type]
    assert driver.state() == before


def test_release_gives_every_object_back(ctx: moderngl.Context, driver: Driver) -> None:
    kinds = ("glIsTexture", "glIsFramebuffer", "glIsBuffer", "glIsProgram", "glIsVertexArray")
    asks = [driver.entry(kind, ctypes.c_uint, result=ctypes.c_ubyte) for kind in kinds]

    def living() -> list[int]:
        return [sum(ask(name) for name in range(1, 2000)) for ask in asks]

    before = living()
    framebuffer = ctx.simple_framebuffer((40, 30))
    view = SplatView(ctx, precision="half")
    view.upload(random_splats(3000, CAMERA))
    view.draw(CAMERA, framebuffer)
    view.read_depth(CAMERA)
    assert living() > before
    view.release()
    framebuffer.release()
    assert living() == before
