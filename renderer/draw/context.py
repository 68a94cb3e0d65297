"""An OpenGL context without a window."""

from __future__ import annotations

import sys
from typing import Any

import moderngl


class OpenGLUnavailable(RuntimeError):
    """No OpenGL 3.3 here; the message says what to install.

    Example:
        >>> from renderer import OpenGLUnavailable, standalone_context
        >>> try:
        ...     ctx = standalone_context()
        ... except OpenGLUnavailable as error:
        ...     print(error)
        ... else:
        ...     ctx.release()
    """


def standalone_context() -> moderngl.Context:
    """OpenGL 3.3 core or later without a window: by EGL on Linux, by the platform's own way elsewhere.

    Raises:
        OpenGLUnavailable: no driver, or one too old, in one sentence.

    Example:
        >>> from renderer import standalone_context
        >>> ctx = standalone_context()
        >>> ctx.version_code >= 330
        True
        >>> ctx.release()
    """
    settings: dict[str, Any] = {"backend": "egl"} if sys.platform.startswith("linux") else {}
    try:
        return moderngl.create_context(require=330, standalone=True, **settings)
    except Exception as error:  # moderngl and its backends raise plain Exception
        raise OpenGLUnavailable(
            f"expected OpenGL 3.3 or later for rendering, got: {error}. "
            "On Debian or Ubuntu install libegl1, libgl1 and libgl1-mesa-dri."
        ) from error


def renderer_name(ctx: moderngl.Context) -> str:
    """The driver's own name of what draws, such as "llvmpipe (LLVM 15.0.6, 256 bits)"."""
    return str(ctx.info["GL_RENDERER"])


def is_software(ctx: moderngl.Context) -> bool:
    """Whether the processor draws: Mesa's llvmpipe and softpipe, SwiftShader, or Microsoft's renderers."""
    name = renderer_name(ctx).lower()
    return any(
        word in name
        for word in ("llvmpipe", "softpipe", "swiftshader", "microsoft basic render", "gdi generic")
    )
