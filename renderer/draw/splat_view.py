"""Splats on the screen: instanced quads, blended back to front, resolved over a background.

The rules are those of `renderer.rasterize.reference` but for one: blending cannot stop at a
transmittance of 1e-4, so with colours in [0, 1] a channel may differ by up to 1e-4 (0.03 grey levels),
and expected depth by up to 1e-4 of the depth range.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from importlib.resources import files
from typing import Literal, get_args

import moderngl
import numpy as np

from renderer.camera import BoolArray, Camera, FloatArray
from renderer.closing import GONE, WHOLE
from renderer.draw.context import is_software
from renderer.draw.keyframes import Keyframes
from renderer.draw.sorting import DepthKeys, depth_order
from renderer.draw.state import StateGuard
from renderer.draw.storage import Storage
from renderer.in_view import IMAGE_SIDES, MOST_CORNERS, InView
from renderer.projection import ALPHA_CUT
from renderer.splats import Float32Array, RenderMode, Shape, Splats, require_mode
from renderer.unobserved import PERIOD, WIDTH

Precision = Literal["byte", "half", "float"]
"""The target in which colour is blended: 16 bits for the screen, 32 for exports; in 8, levels are
lost with each layer, some 4 over 150."""
_FORMATS: dict[Precision, str] = {"byte": "f1", "half": "f2", "float": "f4"}

_Stage = Literal["sums", "rows"]
"""What a target holds: what blending has summed up, or its means along rows."""

Rgb = tuple[float, float, float]
NO_SIDE = (0.0, 0.0, 0.0, 0.0)
_NO_PIVOT: Rgb = (0.0, 0.0, 0.0)
_OVER = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA, moderngl.ZERO, moderngl.ONE_MINUS_SRC_ALPHA
"""Source and destination of colour, then of transmittance."""
_GUARD_BAND = 0.3
Paint = Literal["color", "depth", "motion"]
"""What splats are painted with: their colours, their depth, or how far they are from where they were at the
first keyframe (as `by_motion` of renderer.paint)."""
_PAINTS: dict[Paint, int] = {"color": 0, "depth": 1, "motion": 2}
_BODIES: dict[Shape, int] = {"soft": 0, "ellipsoid": 1, "point": 2}


@dataclass(frozen=True)
class Cut:
    """Where a splat ends. The default is where the rasterisers end it; others are measured against it."""

    widest: float = 4.0
    """Standard deviations from the middle; an opaque splat falls to 1/255 at 3.33."""
    faintest: float = ALPHA_CUT
    """Alpha below which nothing is drawn."""


EXACT_CUT = Cut()


class SplatView:
    """Draws one set of splats, at one time or over time, into framebuffers of one OpenGL 3.3 context.

    `near` > 0 in scene units: splats at or before it are not drawn. Without a `precision` a GPU blends
    in half floats and a software driver, for which they are no faster and which truncates them, in
    floats. The splats are sorted, by `keys`, only when they, the time or the depth axis of the camera
    changed. Drawing leaves the OpenGL state as it found it.

    Raises:
        ValueError: a `near` that is not above 0, or an unknown `precision`.

    Example:
        >>> import numpy as np
        >>> from renderer import Camera, Splats, SplatView, standalone_context
        >>> splats = Splats(
        ...     means=np.float32([[0, 0, 5]]),
        ...     quats=np.float32([[1, 0, 0, 0]]),
        ...     scales=np.full((1, 3), 0.3, np.float32),
        ...     opacities=np.float32([0.9]),
        ...     colors=np.float32([[0.8, 0.2, 0.2]]),
        ... )
        >>> ctx = standalone_context()
        >>> view = SplatView(ctx)
        >>> view.upload(splats)
        >>> color, depth = (read(Camera.from_fov(60, 64, 48)) for read in (view.read_color, view.read_depth))
        >>> color.shape, round(float(depth[24, 32]), 3)
        ((48, 64, 4), 5.0)
        >>> view.release(), ctx.release()
        (None, None)
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        *,
        precision: Precision | None = None,
        keys: DepthKeys = "float32",
        near: float = 0.01,
        cut: Cut = EXACT_CUT,
    ) -> None:
        if not near > 0:
            raise ValueError(f"near must be > 0, got {near}")
        if precision is not None and precision not in get_args(Precision):
            raise ValueError(f"precision must be {', '.join(get_args(Precision))} or None, got {precision!r}")
        self._ctx = ctx
        self._precision: Precision = precision or ("float" if is_software(ctx) else "half")
        self._keys = keys
        self._near, self._cut = near, cut
        self._state = StateGuard(ctx)
        self._program = ctx.program(_shader("splat.vert"), _shader("splat.frag"))
        self._resolve_program = ctx.program(_shader("screen.vert"), _shader("resolve_color.frag"))
        self._rows_program = ctx.program(_shader("screen.vert"), _shader("mean_rows.frag"))
        self._screen = ctx.vertex_array(self._resolve_program, [])
        self._rows_screen = ctx.vertex_array(self._rows_program, [])
        self._targets: dict[tuple[Precision, _Stage], _Target] = {}
        self._storage: Storage | None = None
        self._keyframes = Keyframes(_NO_SPLATS)
        self._time = 0.0
        self._mean_color = _NO_PIVOT
        self._mode: RenderMode = "default"
        self._sorted_along: FloatArray | None = None
        self._sorted_shown: BoolArray | None = None
        self._visible = 0

    def upload(self, splats: Splats, mode: RenderMode = "default") -> None:
        """Replace what is drawn. Colours may be any display values: motion as well as RGB.

        Raises:
            ValueError: a value that is not finite, naming the field and the first such row, more
                splats than a texture holds, or an unknown `mode`.
        """
        self.upload_keyframes(Keyframes(splats), mode)

    def upload_keyframes(self, keyframes: Keyframes, mode: RenderMode = "default") -> None:
        """Replace what is drawn by splats that move; the time is that of the first keyframe.

        Raises:
            ValueError: as `upload`, or more keyframes than a texture has layers.
        """
        require_mode(mode)
        _require_finite(keyframes)
        storage = Storage(self._ctx, self._program, keyframes)
        if self._storage is not None:
            self._storage.release()
        self._storage, self._keyframes, self._mode = storage, keyframes, mode
        self._time, self._sorted_along = float(keyframes.times[0]), None
        self._mean_color = _mean_color(keyframes.rest)

    def seek(self, time: float) -> None:
        """Draw the splats of `time` in [0, 1] from now on; nothing is uploaded but a new order."""
        if time != self._time and self._keyframes.offsets:
            self._sorted_along = None
        self._time = time

    def forget_order(self) -> None:
        """Sort with the next drawing, whatever it shows; for measuring."""
        self._sorted_along = None

    def draw(
        self,
        camera: Camera,
        framebuffer: moderngl.Framebuffer,
        *,
        background: Rgb = (0.0, 0.0, 0.0),
        lines: Rgb | None = None,
        within: InView | None = None,
        shown: BoolArray | None = None,
        closing: int = 0,
    ) -> None:
        """Fill the framebuffer's viewport with the view of `camera`, resampled to its size, alpha 1.

        The image is stored as OpenGL stores images, bottom row first; background is RGB, and so are the
        lines of the hatching over it, if any. What lies beyond the sides of `within` is not drawn,
        nor are splats that are not `shown` (N,). Gaps are closed with the radius `closing`, see closing.py.
        """
        with self._state.preserved():
            pivot = self._mean_color if self._precision == "half" else _NO_PIVOT
            target = self._accumulate(
                _fitted(camera, framebuffer), self._precision, pivot=pivot, within=within, shown=shown
            )
            if closing:
                self._average_rows(target, closing)
            self._resolve(target, framebuffer, background, lines or background, pivot, closing)

    def read_color(
        self,
        camera: Camera,
        shape: Shape = "soft",
        paint: Paint = "color",
        within: InView | None = None,
        shown: BoolArray | None = None,
    ) -> Float32Array:
        """The splats without a background (H, W, 4): premultiplied RGB and alpha, top row first. Soft ones
        end at the sides of `within`; those that are not `shown` (N,) are not drawn."""
        with self._state.preserved():
            return self._read(camera, shape, paint, within, shown)

    def read_depth(
        self,
        camera: Camera,
        shape: Shape = "soft",
        within: InView | None = None,
        shown: BoolArray | None = None,
    ) -> Float32Array:
        """Expected depth (H, W) along +z in scene units, 0 where nothing is seen; top row first."""
        with self._state.preserved():
            sums = self._read(camera, shape, "depth", within, shown)
        depth = np.zeros((camera.height, camera.width), dtype=np.float32)
        np.divide(sums[..., 0], sums[..., 3], out=depth, where=sums[..., 3] > 0)
        return depth

    def _read(
        self,
        camera: Camera,
        shape: Shape,
        paint: Paint,
        within: InView | None,
        shown: BoolArray | None,
    ) -> Float32Array:
        """Sums of the paint, and alpha."""
        target = self._accumulate(camera, "float", shape, paint, within=within, shown=shown)
        raw = target.framebuffer.read(components=4, dtype="f4")
        sums = np.frombuffer(raw, dtype=np.float32).reshape(camera.height, camera.width, 4).copy()
        np.subtract(1, sums[..., 3], out=sums[..., 3])
        return sums

    def release(self) -> None:
        """Release the OpenGL objects; the view cannot be used afterwards."""
        for target in self._targets.values():
            target.release()
        if self._storage is not None:
            self._storage.release()
        programs = self._program, self._resolve_program, self._rows_program
        for item in (self._screen, self._rows_screen, *programs):
            item.release()

    def _accumulate(
        self,
        camera: Camera,
        precision: Precision,
        shape: Shape = "soft",
        paint: Paint = "color",
        pivot: Rgb = _NO_PIVOT,
        within: InView | None = None,
        shown: BoolArray | None = None,
    ) -> _Target:
        """Blend the splats, their paint from `pivot` times alpha, into the owned target."""
        target = self._target((camera.width, camera.height), precision)
        target.framebuffer.use()
        target.framebuffer.clear(alpha=1.0)
        if self._storage is None:
            return target
        self._sort(camera, shown, self._storage)
        self._ctx.enable_only(moderngl.BLEND)
        self._ctx.blend_equation = moderngl.FUNC_ADD, moderngl.FUNC_ADD
        self._ctx.blend_func = _OVER  # type: ignore[assignment]
        self._aim(camera)
        self._program["painted"], self._program["pivot"] = _PAINTS[paint], pivot
        self._program["compensated"] = self._mode == "mip"
        self._program["body"] = _BODIES[shape]
        self._program["widest"], self._program["faintest"] = self._cut.widest, self._cut.faintest
        self._program["bounded"] = within is not None
        if within is not None:
            self._bound(within)
        self._storage.use()
        if self._visible:
            self._storage.quads.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=self._visible)
        return target

    def _bound(self, within: InView) -> None:
        """Set the planes."""
        sides = [tuple(side) for side in within.sides.tolist()]
        image, field = sides[:IMAGE_SIDES], sides[IMAGE_SIDES:]
        self._program["sides"], self._program["corners"] = image, len(field)
        self._program["field"] = field + [NO_SIDE] * (MOST_CORNERS - len(field))

    def _sort(self, camera: Camera, shown: BoolArray | None, storage: Storage) -> None:
        """Write the indices of the visible splats, farthest first."""
        axis = camera.camera_from_world[2]
        is_same = self._sorted_along is not None and np.array_equal(self._sorted_along, axis)
        if is_same and shown is self._sorted_shown:
            return
        self._sorted_along, self._sorted_shown = axis, shown
        depths = self._keyframes.depths(axis, self._time)
        drawable = self._keyframes.drawable if shown is None else self._keyframes.drawable & shown
        visible = np.flatnonzero((depths > self._near) & drawable).astype(np.uint32)
        self._visible = len(visible)
        storage.write_order(visible[depth_order(depths[visible], self._keys)][::-1])

    def _aim(self, camera: Camera) -> None:
        """Set the camera's uniforms; the slopes are those that the reference clamps to."""
        fx, fy, cx, cy = camera.lens
        band_x = _GUARD_BAND * 0.5 * camera.width / fx
        band_y = _GUARD_BAND * 0.5 * camera.height / fy
        least = (-cx / fx - band_x, -cy / fy - band_y)
        greatest = ((camera.width - cx) / fx + band_x, (camera.height - cy) / fy + band_y)
        pose = camera.camera_from_world
        before, after, share = self._keyframes.between(self._time)
        self._program["layers"], self._program["share"] = (before, after), share
        self._program["eye"] = tuple(camera.position.tolist())
        self._program["rotation"] = tuple(pose[:3, :3].T.ravel().tolist())
        self._program["translation"] = tuple(pose[:3, 3].tolist())
        self._program["lens"] = (fx, fy, cx, cy)
        self._program["slopes"] = (*least, *greatest)
        self._program["size"] = (camera.width, camera.height)

    def _average_rows(self, target: _Target, closing: int) -> None:
        """Leave the means along rows in texture 1."""
        rows = self._target(target.texture.size, self._precision, "rows")
        rows.framebuffer.use()
        self._ctx.enable_only(moderngl.NOTHING)
        self._rows_program["closing"] = closing
        target.texture.use(0)
        self._rows_screen.render(moderngl.TRIANGLES, vertices=3)
        rows.texture.use(1)

    def _resolve(
        self,
        target: _Target,
        framebuffer: moderngl.Framebuffer,
        background: Rgb,
        lines: Rgb,
        pivot: Rgb,
        closing: int,
    ) -> None:
        framebuffer.use()
        self._ctx.enable_only(moderngl.NOTHING)
        self._resolve_program["background"], self._resolve_program["pivot"] = background, pivot
        self._resolve_program["lines"] = lines
        self._resolve_program["period"], self._resolve_program["line_width"] = PERIOD, WIDTH
        self._resolve_program["origin"] = framebuffer.viewport[:2]
        self._resolve_program["rows"], self._resolve_program["closing"] = 1, closing
        self._resolve_program["gone"], self._resolve_program["whole"] = GONE, WHOLE
        target.texture.use(0)
        self._screen.render(moderngl.TRIANGLES, vertices=3)

    def _target(self, size: tuple[int, int], precision: Precision, stage: _Stage = "sums") -> _Target:
        """The owned target of that precision, made anew when the size changed."""
        target = self._targets.get((precision, stage))
        if target is None or target.texture.size != size:
            if target is not None:
                target.release()
            target = self._targets[precision, stage] = _Target(self._ctx, size, precision)
        return target


class _Target:
    """Where splats are blended, top row first: premultiplied colours, told from a pivot, and transmittance.

    Half floats, which some drivers cut off instead of rounding, have their finest steps near zero: there are
    the colours about their mean, and what is left of the light where splats cover the picture. Summed up from
    black to alpha, half a step lost at each of a hundred splats comes to a grey level and more.
    """

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int], precision: Precision) -> None:
        self.texture = ctx.texture(size, 4, dtype=_FORMATS[precision])
        self.texture.filter = moderngl.NEAREST, moderngl.NEAREST
        self.framebuffer = ctx.framebuffer([self.texture])

    def release(self) -> None:
        self.framebuffer.release()
        self.texture.release()


def _shader(name: str) -> str:
    return files("renderer.draw").joinpath("shaders", name).read_text(encoding="utf-8")


def _fitted(camera: Camera, framebuffer: moderngl.Framebuffer) -> Camera:
    """The camera with as many pixels as the framebuffer's viewport."""
    width, height = framebuffer.viewport[2:]
    return camera if (camera.width, camera.height) == (width, height) else camera.resized(width, height)


def _require_finite(keyframes: Keyframes) -> None:
    splats = keyframes.rest
    values = {item.name: getattr(splats, item.name) for item in fields(splats)}
    for name, array in values.items():
        finite = np.isfinite(array)
        if not finite.all():
            place = tuple(np.argwhere(~finite)[0])
            raise ValueError(f"Splats.{name} must be finite, got {array[place]} in row {place[0]}")
    for offsets in keyframes.offsets.values():
        if not np.isfinite(offsets).all():
            raise ValueError("expected splats that stay finite at every keyframe, got some that do not")


def _mean_color(splats: Splats) -> Rgb:
    red, green, blue = splats.colors.mean(axis=0).tolist() if len(splats) else _NO_PIVOT
    return red, green, blue


def _no_splats() -> Splats:
    none = np.zeros((0, 3), np.float32)
    return Splats(none, np.zeros((0, 4), np.float32), none, np.zeros(0, np.float32), none)


_NO_SPLATS = _no_splats()
