"""One moment of a model as an image: drawn on the CPU, how near, and its depth in colours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from app.scenes.backgrounds import Background, laid_over
from renderer.camera import Camera
from renderer.splats import Float32Array, RenderMode, Shape, Splats

ON_CPU = "numba on the CPU"
"""What `draw_on_cpu` is called in provenance."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """image (H, W, 3) RGB over black, not clipped: premultiplied colour; depth (H, W) expected depth in scene
    units, 0 where nothing is; alpha (H, W) in [0, 1]."""

    image: Float32Array
    depth: Float32Array
    alpha: Float32Array

    @property
    def bytes(self) -> NDArray[np.uint8]:
        """(H, W, 3) over black, rounded to 8 bits."""
        return _rounded(self.image)

    def over(self, background: Background) -> NDArray[np.uint8]:
        """(H, W, 3) over that, rounded to 8 bits."""
        return _rounded(laid_over(self.image, self.alpha, background))

    @property
    def straight(self) -> NDArray[np.uint8]:
        """(H, W, 4) RGB not premultiplied and alpha, as PNG stores them, black where nothing is.

        Laid over any background it is within a grey level of the splats drawn over it, where colours are
        in [0, 1]: beyond, straight alpha cannot hold them.
        """
        seen = self.alpha[..., None]
        color = np.divide(self.image, seen, out=np.zeros_like(self.image), where=seen > 0)
        rgba = np.concatenate([color, seen], axis=2)
        return _rounded(rgba)


def _rounded(values: Float32Array) -> NDArray[np.uint8]:
    rounded: NDArray[np.uint8] = np.rint(np.clip(values, 0.0, 1.0) * 255.0).astype(np.uint8)
    return rounded


class Draw(Protocol):
    """Splats, camera, near plane (in scene units), render mode and shape to a picture over black."""

    def __call__(
        self, splats: Splats, camera: Camera, near: float, mode: RenderMode, shape: Shape = ...
    ) -> Drawn: ...


def colored_depth(depth: Float32Array) -> tuple[NDArray[np.uint8], tuple[float, float]]:
    """(H, W, 3) viridis from near (yellow) to far, black where nothing is, and the range it spans.

    The range is the 1st to 99th percentile, so that a few stray splats do not flatten the picture.
    """
    seen = depth > 0
    if not seen.any():
        return np.zeros((*depth.shape, 3), dtype=np.uint8), (0.0, 0.0)
    near, far = (float(value) for value in np.percentile(depth[seen], (1, 99)))
    level = np.clip((far - depth) / max(far - near, 1e-12), 0.0, 1.0)
    colors = cv2.applyColorMap(np.rint(level * 255).astype(np.uint8), cv2.COLORMAP_VIRIDIS)
    picture = cv2.cvtColor(colors, cv2.COLOR_BGR2RGB).astype(np.uint8)
    picture[~seen] = 0
    return picture, (near, far)


def draw_on_cpu(
    splats: Splats, camera: Camera, near: float, mode: RenderMode = "default", shape: Shape = "soft"
) -> Drawn:
    # Numba's kernels take seconds to import on a first start; the window must not wait for them.
    from renderer.rasterize.cpu import render
    from renderer.rasterize.solids import render_solids

    if shape == "soft":
        rendered = render(splats, camera, near=near, mode=mode)
    else:
        rendered = render_solids(splats, camera, shape, near=near)
    return Drawn(rendered.image, rendered.depth, rendered.alpha)
