"""A rendered view. Apart from the rasterisers, whose kernels take seconds to import on a first start."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from renderer.splats import Float32Array


@dataclass(frozen=True, eq=False)
class Rendered:
    """A rendered view: image (H, W, 3) float32 over the background, not clipped, over black premultiplied
    colour; alpha (H, W) in [0, 1]; depth (H, W) in scene units, the expected depth sum(w z) / sum(w) along
    +z, 0 where alpha is 0.

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
        >>> rendered = render(splats, camera)
        >>> round(float(rendered.depth[24, 32]), 3), float(rendered.depth[0, 0])
        (5.0, 0.0)
    """

    image: Float32Array
    alpha: Float32Array
    depth: Float32Array

    @property
    def bytes(self) -> NDArray[np.uint8]:
        """(H, W, 3), rounded to 8 bits."""
        return rounded(self.image)

    @property
    def straight(self) -> NDArray[np.uint8]:
        """(H, W, 4) RGB not premultiplied and alpha, as PNG stores them, black where nothing is; of a view
        over black.

        Laid over any background it is within a grey level of the splats drawn over it, where colours are
        in [0, 1]: beyond, straight alpha cannot hold them.
        """
        seen = self.alpha[..., None]
        color = np.divide(self.image, seen, out=np.zeros_like(self.image), where=seen > 0)
        return rounded(np.concatenate([color, seen], axis=2))


def rounded(values: Float32Array) -> NDArray[np.uint8]:
    """To 8 bits, of values whose [0, 1] counts."""
    levels: NDArray[np.uint8] = np.rint(np.clip(values, 0.0, 1.0) * 255.0).astype(np.uint8)
    return levels
