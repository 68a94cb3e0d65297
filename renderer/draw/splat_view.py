"""Splats on the screen: instanced quads, blended back to front, resolved over a background.

The rules are those of `renderer.rasterize.reference` but for one: blending cannot stop at a
transmittance of 1e-4, so with colours in [0, 1] a channel may differ by up to 1e-4 (0.03 grey levels),
and expected depth by up to 1e-4 of the depth range.
"""

from __future__ import annotations

from dataclasses import fields
from importlib.resources import files
from typing import Literal

import moderngl
import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera, FloatArray
from renderer.draw.context import is_software
from renderer.draw.sorting import DepthKeys, depth_order
from renderer.draw.state import StateGuard
from renderer.projection import ALPHA_CUT
from renderer.splats import Float32Array, RenderMode, Splats

Precision = Literal["half", "float"]
"""The target in which colour is blended: 16 bits for the screen, 32 for exports."""

_SPLATS_PER_ROW = 1024
_TEXELS_PER_SPLAT = 4
_GUARD_BAND = 0.3


class SplatView:
    """Draws one set of splats into framebuffers of one OpenGL 3.3 context.

    `near` > 0 in scene units: splats at or before it are not drawn. Without a `precision` a GPU blends
    in half floats and a software driver, for which they are no faster and which truncates them, in
    floats. The splats are sorted, by `keys`, only when they or the depth axis of the camera changed, and
    coloured again only when they have harmonics and the camera's centre changed. Drawing leaves the OpenGL
    state as it found it.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        *,
        precision: Precision | None = None,
        keys: DepthKeys = "float32",
        near: float = 0.01,
    ) -> None:
        if not near > 0:
            raise ValueError(f"near must be > 0, got {near}")
        self._ctx = ctx
        self._precision: Precision = precision or ("float" if is_software(ctx) else "half")
        self._keys = keys
        self._near = near
        self._state = StateGuard(ctx)
        self._program = ctx.program(_shader("splat.vert"), _shader("splat.frag"))
        self._resolve_color = ctx.program(_shader("screen.vert"), _shader("resolve_color.frag"))
        self._resolve_depth = ctx.program(_shader("screen.vert"), _shader("resolve_depth.frag"))
        self._color_screen = ctx.vertex_array(self._resolve_color, [])
        self._depth_screen = ctx.vertex_array(self._resolve_depth, [])
        self._targets: dict[Precision, _Target] = {}
        self._storage = _Storage(ctx, self._program, rows=1)
        self._splats: Splats | None = None
        self._mode: RenderMode = "default"
        self._colored_from: FloatArray | None = None
        self._sorted_along: FloatArray | None = None
        self._visible = 0

    def upload(self, splats: Splats, mode: RenderMode = "default") -> None:
        """Replace what is drawn. Colours may be any display values: normals or motion as well as RGB.

        Raises:
            ValueError: a value that is not finite, naming the field and the first such row, or more
                splats than a texture holds.
        """
        _require_finite(splats)
        rows = max(1, -(-len(splats) // _SPLATS_PER_ROW))
        most = int(self._ctx.info["GL_MAX_TEXTURE_SIZE"])
        if rows > most:
            raise ValueError(f"expected at most {most * _SPLATS_PER_ROW} splats here, got {len(splats)}")
        if self._storage.records.height != rows:
            self._storage.release()
            self._storage = _Storage(self._ctx, self._program, rows)
        self._storage.records.write(_packed(splats, rows))
        self._splats = splats
        self._mode = mode
        self._colored_from = self._sorted_along = None

    def draw(
        self,
        camera: Camera,
        framebuffer: moderngl.Framebuffer,
        *,
        background: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> None:
        """Fill the framebuffer's viewport with the view of `camera`, resampled to its size, alpha 1.

        The picture is stored as OpenGL stores images, bottom row first; background is RGB.
        """
        with self._state.preserved():
            self._color(camera.position)
            target = self._accumulate(_fitted(camera, framebuffer), self._precision, depth_as_color=False)
            self._resolve_color["background"] = background
            self._resolve(target, self._color_screen, framebuffer)

    def draw_depth(
        self,
        camera: Camera,
        framebuffer: moderngl.Framebuffer,
        *,
        depth_range: tuple[float, float],
        background: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> None:
        """As `draw`, with expected depth in grey: the first of `depth_range` is white, the second black.

        Raises:
            ValueError: a range that is empty.
        """
        if depth_range[0] == depth_range[1]:
            raise ValueError(f"depth_range needs two different depths, got {depth_range}")
        with self._state.preserved():
            target = self._accumulate(_fitted(camera, framebuffer), "float", depth_as_color=True)
            self._resolve_depth["background"] = background
            self._resolve_depth["depth_range"] = depth_range
            self._resolve(target, self._depth_screen, framebuffer)

    def read_color(self, camera: Camera) -> Float32Array:
        """The splats without a background (H, W, 4): premultiplied RGB and alpha, top row first."""
        with self._state.preserved():
            self._color(camera.position)
            return self._read(camera, depth_as_color=False)

    def read_depth(self, camera: Camera) -> Float32Array:
        """Expected depth (H, W) along +z in scene units, 0 where nothing is seen; top row first."""
        with self._state.preserved():
            sums = self._read(camera, depth_as_color=True)
        depth = np.zeros((camera.height, camera.width), dtype=np.float32)
        np.divide(sums[..., 0], sums[..., 3], out=depth, where=sums[..., 3] > 0)
        return depth

    def _read(self, camera: Camera, *, depth_as_color: bool) -> Float32Array:
        target = self._accumulate(camera, "float", depth_as_color=depth_as_color)
        raw = target.framebuffer.read(components=4, dtype="f4")
        return np.frombuffer(raw, dtype=np.float32).reshape(camera.height, camera.width, 4)

    def release(self) -> None:
        """Give the OpenGL objects back; the view cannot be used afterwards."""
        for target in self._targets.values():
            target.release()
        self._storage.release()
        for screen in (self._color_screen, self._depth_screen):
            screen.release()
        for program in (self._program, self._resolve_color, self._resolve_depth):
            program.release()

    def _accumulate(self, camera: Camera, precision: Precision, *, depth_as_color: bool) -> _Target:
        """Blend the splats, their colour or depth times alpha, into the owned target of that precision."""
        target = self._target((camera.width, camera.height), precision)
        target.framebuffer.use()
        target.framebuffer.clear()
        self._sort(camera)
        self._ctx.enable_only(moderngl.BLEND)
        self._ctx.blend_equation = moderngl.FUNC_ADD, moderngl.FUNC_ADD
        self._ctx.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
        self._aim(camera)
        self._program["depth_as_color"] = depth_as_color
        self._program["compensated"] = self._mode == "mip"
        self._storage.records.use(0)
        if self._visible:
            self._storage.quads.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=self._visible)
        return target

    def _color(self, center: FloatArray) -> None:
        """Write the colours that `center` sees, where that makes a difference."""
        splats, last = self._splats, self._colored_from
        if splats is None or not splats.harmonics.size:
            return
        if last is not None and np.array_equal(last, center):
            return
        self._colored_from = center
        records = self._storage.records
        records.write(_packed(splats.seen_from(center), records.height))

    def _sort(self, camera: Camera) -> None:
        """Write the indices of the visible splats, farthest first."""
        if self._splats is None:
            return
        axis = camera.camera_from_world[2]
        if self._sorted_along is not None and np.array_equal(self._sorted_along, axis):
            return
        self._sorted_along = axis
        depths = self._splats.means @ axis[:3] + axis[3]
        drawn = (depths > self._near) & (self._splats.opacities >= ALPHA_CUT)
        visible = np.flatnonzero(drawn).astype(np.uint32)
        self._visible = len(visible)
        order = visible[depth_order(depths[visible], self._keys)]
        self._storage.order.orphan()
        self._storage.order.write(np.ascontiguousarray(order[::-1]))

    def _aim(self, camera: Camera) -> None:
        """Set the camera's uniforms; the slopes are those that the reference clamps to."""
        fx, fy, cx, cy = camera.fx, camera.fy, camera.cx, camera.cy
        band_x = _GUARD_BAND * 0.5 * camera.width / fx
        band_y = _GUARD_BAND * 0.5 * camera.height / fy
        least = (-cx / fx - band_x, -cy / fy - band_y)
        greatest = ((camera.width - cx) / fx + band_x, (camera.height - cy) / fy + band_y)
        pose = camera.camera_from_world
        self._program["splats_per_row"] = _SPLATS_PER_ROW
        self._program["rotation"] = tuple(pose[:3, :3].T.ravel().tolist())
        self._program["translation"] = tuple(pose[:3, 3].tolist())
        self._program["lens"] = (fx, fy, cx, cy)
        self._program["slopes"] = (*least, *greatest)
        self._program["size"] = (camera.width, camera.height)

    def _resolve(
        self, target: _Target, screen: moderngl.VertexArray, framebuffer: moderngl.Framebuffer
    ) -> None:
        framebuffer.use()
        self._ctx.enable_only(moderngl.NOTHING)
        screen.program["origin"] = framebuffer.viewport[:2]
        target.texture.use(0)
        screen.render(moderngl.TRIANGLES, vertices=3)

    def _target(self, size: tuple[int, int], precision: Precision) -> _Target:
        """The owned target of that precision, made anew when the size changed."""
        target = self._targets.get(precision)
        if target is None or target.texture.size != size:
            if target is not None:
                target.release()
            target = self._targets[precision] = _Target(self._ctx, size, precision)
        return target


class _Target:
    """Premultiplied RGBA in which the splats are blended, top row first."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int], precision: Precision) -> None:
        self.texture = ctx.texture(size, 4, dtype="f2" if precision == "half" else "f4")
        self.texture.filter = moderngl.NEAREST, moderngl.NEAREST
        self.framebuffer = ctx.framebuffer([self.texture])

    def release(self) -> None:
        self.framebuffer.release()
        self.texture.release()


class _Storage:
    """Room for `rows` * 1024 splats: a texture of records, and the order in which they are drawn."""

    def __init__(self, ctx: moderngl.Context, program: moderngl.Program, rows: int) -> None:
        self.records = ctx.texture((_SPLATS_PER_ROW * _TEXELS_PER_SPLAT, rows), 4, dtype="f4")
        self.records.filter = moderngl.NEAREST, moderngl.NEAREST
        self.order = ctx.buffer(reserve=4 * _SPLATS_PER_ROW * rows, dynamic=True)
        self.quads = ctx.vertex_array(program, [(self.order, "1u4/i", "splat")])

    def release(self) -> None:
        self.quads.release()
        self.order.release()
        self.records.release()


def _shader(name: str) -> str:
    return files("renderer.draw").joinpath("shaders", name).read_text(encoding="utf-8")


def _fitted(camera: Camera, framebuffer: moderngl.Framebuffer) -> Camera:
    """The camera with as many pixels as the framebuffer's viewport."""
    width, height = framebuffer.viewport[2:]
    return camera if (camera.width, camera.height) == (width, height) else camera.resized(width, height)


def _require_finite(splats: Splats) -> None:
    for item in fields(splats):
        values = getattr(splats, item.name)
        finite = np.isfinite(values)
        if not finite.all():
            place = tuple(np.argwhere(~finite)[0])
            raise ValueError(f"Splats.{item.name} must be finite, got {values[place]} in row {place[0]}")


def _packed(splats: Splats, rows: int) -> NDArray[np.float32]:
    """The records as `splat.vert` reads them: (rows * 1024, 16)."""
    records = np.zeros((rows * _SPLATS_PER_ROW, 4 * _TEXELS_PER_SPLAT), dtype=np.float32)
    count = len(splats)
    records[:count, 0:3] = splats.means
    records[:count, 3] = splats.opacities
    records[:count, 4:8] = splats.quats
    records[:count, 8:11] = splats.scales
    records[:count, 12:15] = splats.colors
    return records
