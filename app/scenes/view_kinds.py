"""What an image of splats can show: their colours, or a quantity in the colours of a scale."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from app.scenes.backgrounds import Background
from app.scenes.cpu_rendering import over
from renderer.camera import Camera
from renderer.clip import ByteImage
from renderer.gaussians import DynamicGaussians
from renderer.model_windows import first_at
from renderer.normals import surface_normals
from renderer.paint import by_motion
from renderer.rasterize.rendered import Rendered
from renderer.splats import Float32Array, Shape, Splats
from renderer.unobserved import BLACK

ViewKind = Literal[
    "color", "depth", "normals", "opacity", "ellipsoids", "points", "motion", "difference", "surface"
]
SHAPES: Final[Mapping[ViewKind, Shape]] = {
    "color": "soft", "depth": "soft", "normals": "soft", "opacity": "soft", "motion": "soft",
    "difference": "soft", "surface": "soft", "ellipsoids": "ellipsoid", "points": "point",
}  # fmt: skip
EXPLAINED: Final[Mapping[ViewKind, str]] = {
    "color": "The reconstruction as it looks.",
    "depth": "Distance along the optical axis, averaged over the Gaussians seen in a pixel.",
    "normals": "Orientation of the surface: red right, green up, blue towards the camera.",
    "opacity": "How much of the background the Gaussians hide.",
    "ellipsoids": "Every Gaussian of 10 % opacity or more as a solid of 1.5 standard deviations.",
    "points": "The centre of every Gaussian.",
    "motion": "How far each point has moved since the start of the clip, in a long clip of its window.",
    "difference": "Difference to the frame, averaged over the channels, in grey levels of 255.",
    "surface": "The tissue as one mesh that moves, as it is exported; lit from the camera.",
}
BY_PROCESSOR: Final[tuple[ViewKind, ...]] = ("surface",)
"""Views that the numba rasteriser draws, whatever graphics card there is."""
SCENE_UNITS = "scene units"
ColorMap = Literal["viridis", "inferno", "grey"]
_MAPS = {"viridis": cv2.COLORMAP_VIRIDIS, "inferno": cv2.COLORMAP_INFERNO}
LEAST_DIFFERENCE = 8.0
"""Grey levels at the end of the scale, at least. It ends at the 90th percentile: tools, which are not
reconstructed, do not flatten it."""
LOOKED_AT = 8
"""Moments of a video, evenly spread, whose values its scale holds."""
NO_EXTENT = 2e-9
"""Scales that are shorter are of values all alike, as motion is at the start."""


@dataclass(frozen=True)
class Scale:
    """The colours of a quantity between two values; beyond, the end's own."""

    low: float
    high: float
    unit: str
    colors: ColorMap = "viridis"
    reversed: bool = False
    """The low end has the bright colours."""

    @property
    def table(self) -> ByteImage:
        """(256, 3) RGB from low to high."""
        levels = np.arange(256, dtype=np.uint8)
        if self.colors == "grey":
            rgb = np.repeat(levels[:, None], 3, axis=1)
        else:
            rgb = cv2.applyColorMap(levels[:, None], _MAPS[self.colors])[:, 0, ::-1].astype(np.uint8)
        return np.ascontiguousarray(rgb[::-1] if self.reversed else rgb)

    @property
    def ticks(self) -> tuple[float, ...]:
        """Round values inside, ends included; of one without any extent, its one value."""
        if self.high - self.low < NO_EXTENT:
            return (self.low,)
        step = nice_step((self.high - self.low) / 4)
        first, last = math.ceil(self.low / step - 1e-6), math.floor(self.high / step + 1e-6)
        return tuple(step * index for index in range(first, last + 1))

    def text(self, value: float) -> str:
        """A value as the colour bar is labelled with it, with the digits of the bar's steps."""
        if self.high - self.low < NO_EXTENT:
            return f"{value:.3g}"
        step = nice_step((self.high - self.low) / 4)
        return f"{value:.{max(0, -math.floor(math.log10(step) + 1e-9))}f}"

    def colored(self, values: Float32Array, seen: NDArray[np.bool_]) -> ByteImage:
        """(H, W, 3) of values (H, W), black where nothing is seen."""
        share = (values - self.low) * np.float32(255 / (self.high - self.low))
        picture: ByteImage = self.table[np.rint(np.clip(share, 0, 255)).astype(np.uint8)]
        picture[~seen] = 0
        return picture


@dataclass(frozen=True, eq=False)
class Composed:
    """A finished picture (H, W, 3), and what its colours mean where they are values."""

    image: ByteImage
    scale: Scale | None = None


def has_scale(kind: ViewKind) -> bool:
    """Whether the colours of this view stand for values."""
    return kind in ("depth", "opacity", "motion", "difference")


class Moments(Protocol):
    """Splats at every time in [0, 1]: a model, or keyframes of one."""

    def at(self, time: float) -> Splats: ...


def splats_for(kind: ViewKind, model: Moments, time: float) -> Splats:
    """The splats at `time` in the colours that the view needs."""
    splats = model.at(time)
    if kind == "motion":
        first = first_at(model, time) if isinstance(model, DynamicGaussians) else model.at(0.0)
        return by_motion(splats, first)
    return splats


def facing(drawn: Rendered, camera: Camera) -> Rendered:
    """In the colours of where its surface faces: red right, green up, blue to the camera; 0.5 is 0."""
    normals = surface_normals(drawn.depth, camera)
    known = normals.any(axis=2, keepdims=True)
    colors = known * (0.5 + 0.5 * normals * np.array([1, -1, -1], np.float32))
    return replace(drawn, image=(drawn.alpha[..., None] * colors).astype(np.float32))


def composed(
    kind: ViewKind,
    drawn: Rendered,
    unit: str,
    reference: ByteImage | None = None,
    scale: Scale | None = None,
    background: Background = BLACK,
    since: str = "the start",
) -> Composed:
    """The view of splats drawn in its shape and colours; `reference` (H', W', 3) is what a difference is to.

    What has no scale is laid over the background. Without a `scale`, values have that which holds those of
    this picture. Motion is told `since` a moment.
    """
    if kind == "depth":
        scale = scale or _scale_of(drawn.depth[drawn.depth > 0], unit)
        return Composed(scale.colored(drawn.depth, drawn.depth > 0), scale)
    if kind == "opacity":
        scale = scale or Scale(0.0, 1.0, "opacity", "grey")
        return Composed(scale.colored(drawn.alpha, drawn.alpha > 0), scale)
    if kind == "motion":
        seen = drawn.alpha > 0
        way = np.divide(drawn.image[..., 0], drawn.alpha, out=np.zeros_like(drawn.alpha), where=seen)
        scale = scale or Scale(0.0, _nice_end(way[seen], 99.5), f"{unit} since {since}")
        return Composed(scale.colored(way, seen), scale)
    if kind == "difference":
        assert reference is not None
        away = difference(drawn.bytes, reference)
        end = max(_nice_end(away, 90), LEAST_DIFFERENCE)
        scale = scale or Scale(0.0, end, "grey levels", "inferno")
        return Composed(scale.colored(away, np.ones(away.shape, bool)), scale)
    return Composed(over(drawn, background))


def holding(scales: Sequence[Scale]) -> Scale:
    """The narrowest scale that holds all of these, which are of one quantity."""
    return replace(scales[0], low=min(one.low for one in scales), high=max(one.high for one in scales))


def difference(picture: ByteImage, reference: ByteImage) -> Float32Array:
    """(H, W) mean over the channels of the distance in grey levels, `reference` resampled to the picture."""
    away: Float32Array = cv2.absdiff(picture, _resampled(reference, picture)).mean(axis=2, dtype=np.float32)
    return away


def laid_over(picture: ByteImage, frame: ByteImage, share: float) -> ByteImage:
    """(H, W, 3): so much of the frame, in [0, 1], resampled to the picture, and the rest of the picture."""
    return cv2.addWeighted(_resampled(frame, picture), share, picture, 1 - share, 0).astype(np.uint8)


def _resampled(image: ByteImage, picture: ByteImage) -> ByteImage:
    """In the size of the picture."""
    if image.shape == picture.shape:
        return image
    return cv2.resize(image, picture.shape[1::-1], interpolation=cv2.INTER_AREA).astype(np.uint8)


def nice_step(least: float) -> float:
    """The smallest of 1, 2, 5 times a power of ten that is no less."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(factor * power for factor in (1, 2, 5, 10) if factor * power >= least * (1 - 1e-9))


def _scale_of(depths: Float32Array, unit: str) -> Scale:
    """Round numbers around the 1st to 99th percentile: stray splats do not flatten it. Near is bright."""
    if not depths.size:
        return Scale(0.0, 1.0, unit, reversed=True)
    near, far = (float(value) for value in np.percentile(depths[:: max(1, depths.size // 50_000)], (1, 99)))
    step = nice_step(max((far - near) / 4, 1e-3 * far, 1e-12))
    low = step * math.floor(near / step)
    return Scale(low, max(step * math.ceil(far / step), low + step), unit, reversed=True)


def _nice_end(values: Float32Array, percentile: float) -> float:
    """A round number that so many values do not exceed."""
    sample = values.ravel()[:: max(1, values.size // 50_000)]
    most = float(np.percentile(sample, percentile)) if sample.size else 0.0
    step = nice_step(max(most / 4, 1e-9))
    return step * max(1, math.ceil(most / step))
