"""The renderer of choice. Apart from `cpu_rendering`, since the window never loads torch, and this may."""

from __future__ import annotations

from typing import Literal

import numpy as np

from app.errors import UserError
from app.scenes.cpu_rendering import DrawOptions
from app.scenes.drawer import Drawer
from renderer.camera import Camera
from renderer.rasterize.rendered import Rendered
from renderer.splats import Splats
from renderer.torch_presence import NO_TORCH, has_torch

Renderer = Literal["gl", "cpu", "reference"]


def drawer(renderer: Renderer) -> Drawer:
    """Raises UserError when it cannot work here."""
    if renderer == "gl":
        return _gl()
    if renderer == "reference":
        if not has_torch():
            raise UserError(f"the float64 reference needs torch: {NO_TORCH}. Or use --with cpu.")
        return Drawer(_reference, "float64 reference")
    return Drawer()


def _reference(splats: Splats, camera: Camera, options: DrawOptions) -> Rendered:
    if options.shape != "soft":
        raise UserError(f"--with: expected cpu or gl for {options.shape}s, got reference")
    import torch

    from renderer.rasterize.reference import rasterize_reference

    splats = splats.seen_from(camera.position)
    with torch.no_grad():
        rendered = rasterize_reference(
            torch.from_numpy(splats.means),
            torch.from_numpy(splats.quats),
            torch.from_numpy(splats.scales),
            torch.from_numpy(splats.opacities),
            torch.from_numpy(splats.colors),
            camera,
            near=options.near,
            mode=options.mode,
            within=options.within,
        )
    layers = (rendered.image, rendered.alpha, rendered.depth)
    return Rendered(*(layer.numpy().astype(np.float32) for layer in layers))


def _gl() -> Drawer:
    from moderngl import Error

    from renderer.draw.context import OpenGLUnavailable, renderer_name, standalone_context
    from renderer.draw.offscreen import Offscreen

    try:
        context = standalone_context()
    except OpenGLUnavailable as error:
        raise UserError(f"{error} Or use --with cpu.") from error
    offscreen = Offscreen(context)

    def draw(splats: Splats, camera: Camera, options: DrawOptions) -> Rendered:
        try:
            return offscreen.layers(splats, camera, options.near, options.mode, options.shape, options.within)
        except Error as error:
            size = f"{camera.width}x{camera.height}"
            raise UserError(f"OpenGL cannot render {size} here ({error}): choose a smaller --size") from error

    return Drawer(draw, f"OpenGL, {renderer_name(context)}")
