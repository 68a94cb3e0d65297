"""One moment of a model as an image: drawn on the CPU, how near, and its depth in colours."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from app.scenes.backgrounds import Background, ground, laid
from renderer.camera import Camera
from renderer.in_view import InView
from renderer.rasterize.rendered import Rendered, rounded
from renderer.splats import Float32Array, RenderMode, Shape, Splats

ON_CPU = "numba on the CPU"
"""What `draw_on_cpu` is called in provenance."""


@dataclass(frozen=True)
class DrawOptions:
    """How splats are drawn."""

    near: float
    """The near plane, in scene units."""
    mode: RenderMode = "default"
    shape: Shape = "soft"
    within: InView | None = None
    """Soft splats end at its sides."""


_ROWS = 16
"""Of an image at a time: what is worked out on the way stays in the processor's cache."""

Draw = Callable[[Splats, Camera, DrawOptions], Rendered]
"""To a picture over black."""


def over(drawn: Rendered, background: Background) -> NDArray[np.uint8]:
    """(H, W, 3) of what is drawn over black laid over that, rounded to 8 bits."""
    behind = ground(drawn.image, drawn.alpha, background)
    levels = np.empty(drawn.image.shape, np.uint8)
    for top in range(0, len(levels), _ROWS):
        rows = slice(top, top + _ROWS)
        levels[rows] = rounded(laid(drawn.image[rows], drawn.alpha[rows], behind[rows]))
    return levels


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


def draw_on_cpu(splats: Splats, camera: Camera, options: DrawOptions) -> Rendered:
    # Numba's kernels take seconds to import on a first start; the window must not wait for them.
    from renderer.rasterize.cpu import render
    from renderer.rasterize.solids import render_solids

    if options.shape == "soft":
        return render(splats, camera, near=options.near, mode=options.mode, within=options.within)
    return render_solids(splats, camera, options.shape, near=options.near)
