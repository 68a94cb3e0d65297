"""The CPU rasteriser: numpy arrays in, numpy arrays out, forward and backward. No torch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import get_num_threads
from numpy.typing import NDArray

from renderer.camera import BoolArray, Camera
from renderer.harmonics import harmonics_backward
from renderer.in_view import InView
from renderer.projection import (
    NEAR,
    RECORD_SIZE,
    SUM_BLUE,
    SUM_RED,
    SUM_SIZE,
    camera_vector,
    center_gradients,
    project,
    project_backward,
)
from renderer.rasterize.binning import (
    TILE,
    balanced_order,
    count_entries,
    depth_order,
    fill_entries,
    find_rectangles,
)
from renderer.rasterize.picture import adjoint_of, compose
from renderer.rasterize.rendered import Rendered
from renderer.rasterize.tiles import (
    ADJOINT_PLANES,
    BY_RED,
    PLANES,
    blend,
    blend_backward,
    reduce_sums,
)
from renderer.rasterize.within import Bounds
from renderer.splats import Float32Array, RenderMode, Splats, require_drawable

Floats = NDArray[np.floating]
Background = tuple[float, float, float]
BLACK: Background = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Gradients:
    """Gradients by the activated values of N splats, float32, shaped as they are in Splats."""

    means: Float32Array
    quats: Float32Array
    scales: Float32Array
    opacities: Float32Array
    colors: Float32Array
    harmonics: Float32Array


class Rasterizer:
    """Renders images of one size and reuses its working arrays.

    `forward` blends the splats into `planes` (see tiles.py), padded to whole tiles; `backward` turns an
    adjoint of the same padding into gradients. The values between the two calls are kept here.

    Example:
        >>> import numpy as np
        >>> from renderer import Camera, Rasterizer, Splats
        >>> splats = Splats(
        ...     means=np.float32([[0, 0, 5]]),
        ...     quats=np.float32([[1, 0, 0, 0]]),
        ...     scales=np.full((1, 3), 0.3, np.float32),
        ...     opacities=np.float32([0.9]),
        ...     colors=np.float32([[0.8, 0.2, 0.2]]),
        ... )
        >>> camera = Camera.from_fov(60, 64, 48)
        >>> rasterizer = Rasterizer(camera.width, camera.height)
        >>> entries = rasterizer.forward(splats, camera)
        >>> rendered = rasterizer.rendered(camera.width, camera.height, background=(0.0, 0.0, 0.0))
        >>> by_image = np.ones(rendered.image.shape)  # of the loss that is the sum of the picture
        >>> nothing = np.zeros(rendered.alpha.shape)
        >>> rasterizer.set_adjoint(by_image, nothing, nothing, (0.0, 0.0, 0.0))
        >>> bool((rasterizer.backward(splats).colors > 0).all())
        True
    """

    def __init__(self, width: int, height: int) -> None:
        self.rows, self.columns = -(-height // TILE), -(-width // TILE)
        padded = (self.rows * TILE, self.columns * TILE)
        self.planes = np.zeros((PLANES, *padded), np.float32)
        self.adjoint = np.zeros((ADJOINT_PLANES, *padded), np.float32)
        self._tile_starts = np.zeros(self.rows * self.columns + 1, np.int64)
        self._tile_ends = np.zeros(self.rows * self.columns, np.int64)
        self._all_tiles = np.ones((self.rows, self.columns), bool)
        self.wanted = self._all_tiles
        self._reserve_splats(0)
        self._reserve_entries(0)

    def _reserve_splats(self, count: int) -> None:
        self.records = np.zeros((count, RECORD_SIZE), np.float32)
        self.visible = np.zeros(count, bool)
        self.sums = np.zeros((count, SUM_SIZE), np.float32)
        self._rectangles = np.zeros((count, 4), np.int16)
        self._slot_starts = np.zeros(count + 1, np.int64)

    def _reserve_entries(self, count: int) -> None:
        self._entry_splats = np.zeros(count, np.int32)
        self._slot_entries = np.zeros(count, np.int32)
        self._entry_sums = np.zeros((count, SUM_SIZE), np.float32)

    def forward(
        self,
        splats: Splats,
        camera: Camera,
        near: float = NEAR,
        tile_wanted: BoolArray | None = None,
        mode: RenderMode = "default",
    ) -> int:
        """Blend into `planes`; tiles that are not wanted stay empty. Returns the number of tile entries.

        Raises:
            ValueError: `near` that is not above 0, an unknown `mode`, or `tile_wanted` of another shape.
        """
        wanted = self._all_tiles if tile_wanted is None else tile_wanted
        _require_shape("tile_wanted", wanted, self._all_tiles.shape)
        self.wanted = wanted
        self._place(splats, camera, near, mode)
        return self.blend_records()

    def draw(
        self, splats: Splats, camera: Camera, near: float, mode: RenderMode, within: InView | None
    ) -> None:
        """Blend into `planes` what lies within those sides; there is no way back to gradients.

        Raises:
            ValueError: as `forward`.
        """
        self._place(splats, camera, near, mode)
        bounds = None if within is None else Bounds(splats, camera, within, self.visible)
        self._bin()
        tiles = self._tile_order
        if bounds is not None:
            is_cut = bounds.tiles(self._tile_starts, self._entry_splats)[tiles]
            bounds.blend(
                self.records, self._tile_starts, tiles[is_cut], self._entry_splats, self.columns, self.planes
            )
            tiles = tiles[~is_cut]
        self._blend(tiles)

    def _place(self, splats: Splats, camera: Camera, near: float, mode: RenderMode) -> None:
        """Fill the records."""
        require_drawable(near, mode)
        if len(self.visible) != len(splats):
            self._reserve_splats(len(splats))
        self._view, self._center = camera_vector(camera, near), camera.position
        self._compensated = mode == "mip"
        colors = splats.seen_from(self._center).colors
        project(
            splats.means, splats.quats, splats.scales, splats.opacities, colors,
            self._view, self._compensated, self.records, self.visible,
        )  # fmt: skip

    @property
    def reaches_wanted(self) -> BoolArray:
        """(N,) True: the splat touches a wanted tile in the last `forward`."""
        reaches: BoolArray = np.diff(self._slot_starts) > 0
        return reaches

    def blend_records(self) -> int:
        """Sort, bin and blend the records as they stand."""
        entries = self._bin()
        self._blend(self._tile_order)
        return entries

    def _bin(self) -> int:
        """The list of every tile, front to back. Returns how many entries they have."""
        find_rectangles(self.records, self.visible, self.rows, self.columns, self._rectangles)
        entries = count_entries(self._rectangles, self.wanted, self._slot_starts, self._tile_starts)
        if entries > len(self._entry_splats):
            self._reserve_entries(entries + entries // 4)
        order = depth_order(self.records, self.visible)
        fill_entries(
            order, self.wanted, self._rectangles, self._slot_starts, self._tile_starts, get_num_threads(),
            self._entry_splats, self._slot_entries,
        )  # fmt: skip
        self._tile_order = balanced_order(self._tile_starts, get_num_threads())
        return entries

    def _blend(self, tiles: NDArray[np.int32]) -> None:
        blend(
            self.records, self._tile_starts, tiles, self._entry_splats, self.columns,
            self.planes, self._tile_ends,
        )  # fmt: skip

    def backward_sums(self) -> None:
        """From `adjoint` to the gradient sums of each splat; `visible` then says which have any."""
        blend_backward(
            self.records, self._tile_starts, self._tile_ends, self._tile_order,
            self._entry_splats, self.columns, self.adjoint, self._entry_sums,
        )  # fmt: skip
        reduce_sums(self._entry_sums, self._slot_entries, self._slot_starts, self.visible, self.sums)

    def blending_weights(self, *shares: NDArray[np.bool_] | Float32Array) -> Float32Array:
        """(K, N) of each splat of the last `forward`, summed over the pixels by K <= 3 shares (H, W) of them;
        to be read before the next call. The adjoint is lost."""
        self.adjoint[:] = 0.0
        for plane, share in enumerate(shares, start=BY_RED):
            height, width = share.shape
            self.adjoint[plane, :height, :width] = share
        self.backward_sums()
        weights: Float32Array = self.sums[:, SUM_RED : SUM_RED + len(shares)].T
        return weights

    def backward(self, splats: Splats) -> Gradients:
        """Gradients of the loss described by `adjoint`, for the splats of the last `forward`.

        Raises:
            ValueError: another number of splats.
        """
        _require_shape("means", splats.means, (len(self.visible), 3))
        self.backward_sums()
        count = len(splats)
        means, quats = np.empty((count, 3), np.float32), np.empty((count, 4), np.float32)
        scales, opacities = np.empty((count, 3), np.float32), np.empty(count, np.float32)
        project_backward(
            splats.means, splats.quats, splats.scales, splats.opacities,
            self._view, self._compensated, self.visible, self.sums, means, quats, scales, opacities,
        )  # fmt: skip
        colors = self.sums[:, SUM_RED : SUM_BLUE + 1].copy()
        harmonics = np.empty_like(splats.harmonics)
        if harmonics.size:
            harmonics_backward(
                splats.means, splats.harmonics, self._center, self.visible, colors, harmonics, means
            )
        return Gradients(means, quats, scales, opacities, colors, harmonics)

    def by_centers(self) -> Float32Array:
        """(N, 2) gradient by the centres on screen, in pixels, of the last `backward`."""
        by = np.empty((len(self.visible), 2), np.float32)
        center_gradients(self.records, self.sums, self.visible, by)
        return by

    def rendered(self, width: int, height: int, background: Background) -> Rendered:
        """The blended planes as an image over the background.

        Raises:
            ValueError: more pixels than it is for, or a background that is not three numbers.
        """
        self._require_room(height, width)
        image = np.empty((height, width, 3), np.float32)
        alpha, depth = np.empty((2, height, width), np.float32)
        compose(self.planes, _rgb(background), image, alpha, depth)
        return Rendered(image, alpha, depth)

    def set_adjoint(
        self, by_image: Floats, by_alpha: Floats, by_depth: Floats, background: Background
    ) -> None:
        """Adjoint from gradients by image (H, W, 3), alpha (H, W) and expected depth (H, W).

        Raises:
            ValueError: as `rendered`, or shapes that do not agree.
        """
        image, alpha, depth = (np.ascontiguousarray(by, np.float32) for by in (by_image, by_alpha, by_depth))
        _require_shape("by_image", image, (*alpha.shape, 3))
        _require_shape("by_depth", depth, alpha.shape)
        self._require_room(*alpha.shape)
        adjoint_of(self.planes, _rgb(background), image, alpha, depth, self.adjoint)

    def _require_room(self, height: int, width: int) -> None:
        rows, columns = self.planes.shape[1:]
        if not (0 <= height <= rows and 0 <= width <= columns):
            raise ValueError(f"expected at most {columns}x{rows} pixels, got {width}x{height}")


def _require_shape(name: str, array: NDArray[np.generic], shape: tuple[int, ...]) -> None:
    """Before a kernel, which checks no bounds, meets it."""
    if array.shape != shape:
        raise ValueError(f"expected {name} of shape {shape}, got {array.shape}")


def _rgb(background: Background) -> Float32Array:
    color = np.array(background, np.float32)
    if color.shape != (3,):
        raise ValueError(f"expected a background of three numbers, got {background}")
    return color


def render(
    splats: Splats,
    camera: Camera,
    background: Background = BLACK,
    *,
    near: float = NEAR,
    mode: RenderMode = "default",
    within: InView | None = None,
) -> Rendered:
    """Draw `splats` as `camera` sees them over `background` (RGB in [0, 1]); z <= near is left out.

    Gaussians are projected and blended front to back (Eqs 13-16; Kerbl et al., 3D Gaussian Splatting, ACM
    TOG 42(4), 2023), in float32. `near` in scene units; `mode` "mip" compensates for the low-pass filter.
    What lies beyond the sides of `within`, those of the image of a camera or of a field, is not drawn.

    Raises:
        ValueError: `near` that is not above 0, an unknown `mode`, or a background that is not three numbers.
        TypeError: `splats` or `camera` of another class.

    Example:
        >>> import numpy as np
        >>> from renderer import Camera, Splats, render
        >>> splats = Splats(
        ...     means=np.float32([[0, 0, 5]]),
        ...     quats=np.float32([[1, 0, 0, 0]]),
        ...     scales=np.full((1, 3), 0.3, np.float32),
        ...     opacities=np.float32([0.9]),
        ...     colors=np.float32([[0.8, 0.2, 0.2]]),
        ... )
        >>> camera = Camera.from_fov(60, 64, 48)
        >>> rendered = render(splats, camera, background=(0.0, 0.0, 1.0))
        >>> rendered.image.shape, rendered.image[0, 0].tolist()
        ((48, 64, 3), [0.0, 0.0, 1.0])
    """
    if not (isinstance(splats, Splats) and isinstance(camera, Camera)):
        got = f"{type(splats).__name__} and {type(camera).__name__}"
        raise TypeError(f"expected Splats and a Camera, got {got}")
    rasterizer = Rasterizer(camera.width, camera.height)
    rasterizer.draw(splats, camera, near, mode, within)
    return rasterizer.rendered(camera.width, camera.height, background)
