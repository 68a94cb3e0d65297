"""Error against run time of the CPU rasteriser: what fewer Gaussians, pixels and contributions cost."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.measuring.drawing_row import Row
from renderer.measuring.interleaved_timing import laps
from renderer.projection import ALPHA_CUT, HALF_HEIGHT, HALF_WIDTH, LOG2_OPACITY
from renderer.rasterize.cpu import BLACK, Rasterizer
from renderer.splats import Float32Array, Splats

CUTS: Final = (2, 4, 8, 16)
"""In 255ths of alpha."""
DEVIATIONS: Final = (3.0, 2.5, 2.0)
FAINT: Final = (0.1, 0.2, 0.4)
SHARES: Final = (0.75, 0.5, 0.25)
DIVISORS: Final = (2, 4)


@dataclass(frozen=True, eq=False)
class _Work:
    group: str
    setting: str
    rasterizer: Rasterizer
    splats: Splats
    camera: Camera
    near: float

    def draw(self) -> int:
        return self.rasterizer.forward(self.splats, self.camera, self.near)

    def picture(self, size: tuple[int, int]) -> Float32Array:
        image = self.rasterizer.rendered(self.camera.width, self.camera.height, BLACK).image
        return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_LINEAR))


def accuracy(
    splats: Splats, camera: Camera, near: float, truth: NDArray[np.float64], repeats: int = 41
) -> Iterator[Row]:
    """Rows for one view, against the float64 picture `truth` of `exact`; pictures take turns.

    "whole": as the product draws. "extent": a Gaussian reaches no farther than some alpha, or number of
    standard deviations. "faint": those of little opacity are left out. "fewer": those that weigh most on the
    picture alone. "pixels": drawn smaller and resampled.
    """
    seen = splats.seen_from(camera.position)
    size = camera.width, camera.height
    works = list(_works(seen, camera, near))
    entries = [work.draw() for work in works]
    taken = laps([work.draw for work in works], repeats)
    for work, count, each in zip(works, entries, taken, strict=True):
        row = Row.of(work.group, work.setting, 255 * np.abs(work.picture(size) - truth), each)
        yield replace(row, entries=count)


def exact(splats: Splats, camera: Camera, near: float) -> NDArray[np.float64]:
    """The float64 image (H, W, 3) over black."""
    import torch

    from renderer.rasterize.reference import rasterize_reference

    seen = splats.seen_from(camera.position)
    means, quats, scales, opacities, colors = (
        torch.from_numpy(value.astype(np.float64))
        for value in (seen.means, seen.quats, seen.scales, seen.opacities, seen.colors)
    )
    with torch.no_grad():
        drawn = rasterize_reference(means, quats, scales, opacities, colors, camera, near=near)
    return np.asarray(drawn.image.numpy())


def _works(splats: Splats, camera: Camera, near: float) -> Iterator[_Work]:
    size = camera.width, camera.height
    yield _Work("whole", "unchanged", Rasterizer(*size), splats, camera, near)
    for cut in CUTS:
        trimmed = _Trimmed(*size, cut=cut / 255)
        yield _Work("extent", f"to alpha {cut}/255", trimmed, splats, camera, near)
    for deviations in DEVIATIONS:
        trimmed = _Trimmed(*size, deviations=deviations)
        yield _Work("extent", f"to {deviations:g} sigma", trimmed, splats, camera, near)
    for floor in FAINT:
        kept = _chosen(splats, splats.opacities >= floor)
        yield _Work("faint", f"opacity from {floor:g}", Rasterizer(*size), kept, camera, near)
    weight = _weights(splats, camera)
    for share in SHARES:
        kept = _chosen(splats, weight >= np.quantile(weight, 1 - share))
        yield _Work("fewer", f"{share:.0%} of the Gaussians", Rasterizer(*size), kept, camera, near)
    for divisor in DIVISORS:
        small = camera.resized(camera.width // divisor, camera.height // divisor)
        drawn = Rasterizer(small.width, small.height)
        yield _Work("pixels", f"1/{divisor} along each side", drawn, splats, small, near)


def _chosen(splats: Splats, rows: NDArray[np.bool_]) -> Splats:
    return Splats(**{item.name: getattr(splats, item.name)[rows] for item in fields(splats)})


def _weights(splats: Splats, camera: Camera) -> NDArray[np.float64]:
    """About the light that each Gaussian adds: opacity times its area on the picture."""
    _, depth = camera.project(splats.means.astype(np.float64))
    axes = np.sort(splats.scales.astype(np.float64), axis=1)
    return np.asarray(splats.opacities * axes[:, 1] * axes[:, 2] / np.maximum(depth, 1e-9) ** 2)


class _Trimmed(Rasterizer):
    """Whose Gaussians reach no farther than an alpha, or than so many standard deviations."""

    def __init__(self, width: int, height: int, cut: float = ALPHA_CUT, deviations: float = np.inf) -> None:
        super().__init__(width, height)
        self._cut, self._deviations = cut, deviations

    def blend_records(self) -> int:
        """See Rasterizer; half widths are those of the cut 1/255, sqrt(2 ln(opacity / cut)) deviations."""
        log_opacity = self.records[:, LOG2_OPACITY].astype(np.float64) * np.log(2)
        usual = np.sqrt(np.maximum(2 * (log_opacity - np.log(ALPHA_CUT)), 1e-12))
        wanted = np.sqrt(np.maximum(2 * (log_opacity - np.log(self._cut)), 0.0))
        factor = np.minimum(np.minimum(wanted, self._deviations) / usual, 1.0).astype(np.float32)
        self.records[:, HALF_WIDTH] *= factor
        self.records[:, HALF_HEIGHT] *= factor
        return super().blend_records()
