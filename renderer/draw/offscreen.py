"""Pictures of splats without a window, as arrays."""

from __future__ import annotations

import moderngl
import numpy as np

from renderer.camera import BoolArray, Camera
from renderer.draw.splat_view import Paint, Precision, SplatView
from renderer.in_view import InView
from renderer.rasterize.rendered import Rendered
from renderer.splats import Float32Array, RenderMode, Shape, Splats


class Offscreen:
    """Draws pictures one after another, with the shaders and targets of the first."""

    def __init__(self, ctx: moderngl.Context) -> None:
        self._ctx = ctx
        self._view: SplatView | None = None
        self._near = 0.0

    def layers(
        self,
        splats: Splats,
        camera: Camera,
        near: float,
        mode: RenderMode = "default",
        shape: Shape = "soft",
        within: InView | None = None,
    ) -> Rendered:
        """Colour, alpha and depth in float32, from one upload and one sort; soft splats end at the sides of
        `within`.

        Raises:
            ValueError: as `SplatView.upload`.
        """
        if self._view is None or near != self._near:
            self.release()
            self._view, self._near = SplatView(self._ctx, precision="float", near=near), near
        self._view.upload(splats, mode)
        return read_layers(self._view, camera, shape, within=within)

    def release(self) -> None:
        """Give the OpenGL objects back; the next picture makes them anew."""
        if self._view is not None:
            self._view.release()
            self._view = None


def read_layers(
    view: SplatView,
    camera: Camera,
    shape: Shape,
    *,
    paint: Paint = "color",
    within: InView | None,
    shown: BoolArray | None = None,
    with_depth: bool = True,
) -> Rendered:
    """What a view holds, over black. Depth is a second drawing: 0 without `with_depth`."""
    color = view.read_color(camera, shape, paint, within, shown)
    depth = np.zeros(color.shape[:2], np.float32)
    if with_depth:
        depth = view.read_depth(camera, shape, within, shown)
    return Rendered(np.ascontiguousarray(color[..., :3]), color[..., 3].copy(), depth)


def render_offscreen(
    ctx: moderngl.Context,
    splats: Splats,
    camera: Camera,
    background: tuple[float, float, float] = (0.0, 0.0, 0.0),
    precision: Precision = "float",
    *,
    near: float = 0.01,
    mode: RenderMode = "default",
) -> Float32Array:
    """The view of `camera` over an RGB background: image (H, W, 3), top row first, not clipped to [0, 1].

    Raises:
        ValueError: as `SplatView` and its `upload`.

    Example:
        >>> import numpy as np
        >>> from renderer import Camera, Splats, render_offscreen, standalone_context
        >>> splats = Splats(
        ...     means=np.float32([[0, 0, 5]]),
        ...     quats=np.float32([[1, 0, 0, 0]]),
        ...     scales=np.full((1, 3), 0.3, np.float32),
        ...     opacities=np.float32([0.9]),
        ...     colors=np.float32([[0.8, 0.2, 0.2]]),
        ... )
        >>> ctx = standalone_context()
        >>> render_offscreen(ctx, splats, Camera.from_fov(60, 64, 48)).shape
        (48, 64, 3)
        >>> ctx.release()
    """
    view = SplatView(ctx, precision=precision, keys="float32", near=near)
    framebuffer = ctx.simple_framebuffer((camera.width, camera.height), 4, dtype="f4")
    try:
        view.upload(splats, mode)
        view.draw(camera, framebuffer, background=background)
        return read_image(framebuffer)
    finally:
        framebuffer.release()
        view.release()


def read_image(framebuffer: moderngl.Framebuffer) -> Float32Array:
    """The RGB (H, W, 3) of a framebuffer, top row first; 8-bit colours become [0, 1]."""
    raw = framebuffer.read(components=3, dtype="f4", alignment=1)
    image = np.frombuffer(raw, dtype=np.float32).reshape(framebuffer.height, framebuffer.width, 3)
    return np.ascontiguousarray(image[::-1])
