"""Views from beside without pinholes and frayed edges: gaps much narrower than a window are closed by what
lies around them, and what is much narrower than it between gaps is left out.

Gaussians that were trained from one side lie at depths that differ a little from one to the next. From beside
they part, the background shows between them, and the last ones stick out as a fringe. With a the alpha of a
pixel, c its premultiplied colour, A and C their means over a window about it, the image is

    alpha = smoothstep of A from GONE to WHOLE,    colour = alpha (c + (1 - a) C / A),

so that tissue is opaque, what shows through it has the colour of the tissue around, and its edge is as even
as the window is wide. Depth stays as it was measured.

SHARE was chosen on trained models of pulling and mesentery, from 1/160, 1/128, 1/100 and 1/80, in 36 views
of each from 10 to 25 degrees aside. Pixels of pinholes (parts below 64 px) a view: 279 without, then 71, 40,
28 and 12; 276, then 71, 43, 29 and 17. Length of the outline by that of it closed and opened by 5 px: 1.117,
then 1.039, 1.027, 1.018 and 1.008; 1.233, then 1.069, 1.051, 1.037 and 1.022. Wider windows round corners
more. On clips that nothing was chosen on, without and with it: sinus 73 and 0 px, 1.062 and 1.001; wall 369
and 27, 1.138 and 1.025.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from renderer.camera import Camera
from renderer.rasterize.rendered import Rendered

SHARE: Final = 0.01
"""Of the longer side of the clip's images, from the middle of the window to its edge."""
GONE: Final = 0.3
WHOLE: Final = 0.7
"""Mean alpha over the window up to which nothing is left, and from which on tissue is opaque."""


def closing_radius(own: Camera, camera: Camera) -> float:
    """Pixels of `camera` from the middle of the window to its edge, where `own` is the clip's."""
    return SHARE * max(own.width, own.height) * camera.fx / own.fx


def closed(drawn: Rendered, radius: int) -> Rendered:
    """A view over black with gaps closed; windows of 2 radius + 1 pixels a side end at the sides of the
    image. A radius of 0 leaves it as it is.

    Raises:
        ValueError: a negative radius.
    """
    if radius < 0:
        raise ValueError(f"expected a radius of at least 0 pixels, got {radius}")
    if radius == 0:
        return drawn
    # Its kernels take seconds to import on a first start; the window must not wait for them.
    from renderer.rasterize.gaps import close

    height, width = drawn.alpha.shape
    image, alpha = np.empty((height, 3 * width), np.float32), np.empty((height, width), np.float32)
    seen = np.ascontiguousarray(drawn.image).reshape(height, 3 * width)
    close(seen, np.ascontiguousarray(drawn.alpha), radius, np.float32(GONE), np.float32(WHOLE), image, alpha)
    return replace(drawn, image=image.reshape(height, width, 3), alpha=alpha)
