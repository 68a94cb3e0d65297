"""Leaves OpenGL's state as it was found, asking the driver because moderngl sets much that it cannot read."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import moderngl

_FRAMEBUFFER, _FRAMEBUFFER_BINDING = 0x8D40, 0x8CA6
_BLEND_FUNC = (0x80C9, 0x80C8, 0x80CB, 0x80CA)  # source and destination of rgb, then of alpha
_BLEND_EQUATION = (0x8009, 0x883D)
_VIEWPORT, _SCISSOR_BOX, _COLOR_MASK, _DEPTH_MASK = 0x0BA2, 0x0C10, 0x0C23, 0x0B72
_SCISSOR_TEST, _FRAMEBUFFER_SRGB = 0x0C11, 0x8DB9
_MODERNGL_FLAGS = {
    moderngl.BLEND: 0x0BE2,
    moderngl.DEPTH_TEST: 0x0B71,
    moderngl.CULL_FACE: 0x0B44,
    moderngl.RASTERIZER_DISCARD: 0x8C89,
    moderngl.PROGRAM_POINT_SIZE: 0x8642,
}


class StateGuard:
    """Entry points of one context's driver, to save what drawing changes and put it back."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._get = self._entry("glGetIntegerv", ctypes.c_uint, ctypes.POINTER(ctypes.c_int))
        self._bind_framebuffer = self._entry("glBindFramebuffer", ctypes.c_uint, ctypes.c_uint)
        self._blend_func = self._entry("glBlendFuncSeparate", *[ctypes.c_uint] * 4)
        self._blend_equation = self._entry("glBlendEquationSeparate", *[ctypes.c_uint] * 2)
        self._viewport = self._entry("glViewport", *[ctypes.c_int] * 4)
        self._scissor = self._entry("glScissor", *[ctypes.c_int] * 4)
        self._color_mask = self._entry("glColorMask", *[ctypes.c_ubyte] * 4)
        self._depth_mask = self._entry("glDepthMask", ctypes.c_ubyte)

    @contextmanager
    def preserved(self) -> Iterator[None]:
        """Within, blending and framebuffers may be set freely; sRGB conversion is off.

        Put back: the framebuffer with its viewport, scissor and masks, the capabilities, and the blend
        function and equation; both in the driver and in moderngl's own record of them. Not put back:
        the program, the vertex array and the bound textures, which everybody binds before use.
        """
        ctx = self._ctx
        binding = self._values(_FRAMEBUFFER_BINDING, 1)[0]
        known = ctx.fbo, ctx.mglo.fbo
        enabled = {flag: self._values(name, 1)[0] for flag, name in _MODERNGL_FLAGS.items()}
        direct = {name: self._values(name, 1)[0] for name in (_SCISSOR_TEST, _FRAMEBUFFER_SRGB)}
        blend_func = [self._values(name, 1)[0] for name in _BLEND_FUNC]
        blend_equation = [self._values(name, 1)[0] for name in _BLEND_EQUATION]
        viewport, scissor = self._values(_VIEWPORT, 4), self._values(_SCISSOR_BOX, 4)
        color_mask, depth_mask = self._values(_COLOR_MASK, 4), self._values(_DEPTH_MASK, 1)
        ctx.disable_direct(_FRAMEBUFFER_SRGB)
        try:
            yield
        finally:
            ctx.fbo, ctx.mglo.fbo = known
            self._bind_framebuffer(_FRAMEBUFFER, binding)
            ctx.enable_only(sum(flag for flag, value in enabled.items() if value))
            for name, value in direct.items():
                (ctx.enable_direct if value else ctx.disable_direct)(name)
            self._blend_func(*blend_func)
            self._blend_equation(*blend_equation)
            self._viewport(*viewport)
            self._scissor(*scissor)
            self._color_mask(*color_mask)
            self._depth_mask(*depth_mask)

    def _entry(self, name: str, *arguments: type) -> Callable[..., None]:
        # moderngl's own loader of a window's context and those of glcontext name the call differently.
        loader = self._ctx.mglo._context
        load = getattr(loader, "load", None) or loader.load_opengl_function
        address = load(name)
        return ctypes.CFUNCTYPE(None, *arguments)(address)

    def _values(self, name: int, count: int) -> list[int]:
        values = (ctypes.c_int * 4)()
        self._get(name, values)
        return list(values[:count])
