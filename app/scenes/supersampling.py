"""Images drawn with more pixels than they have, and averaged down."""

from __future__ import annotations

import numpy as np

from app.scenes.cpu_rendering import Draw, DrawOptions
from renderer.camera import Camera
from renderer.rasterize.rendered import Rendered
from renderer.splats import Float32Array, Splats

FACTORS = (1, 2, 4)


def supersampled(draw: Draw, factor: int) -> Draw:
    """The same drawing with `factor` times as many pixels each way, averaged down to the camera's size.

    The filter of 0.3 square pixels that every splat is drawn with is then that of the small pixels: the
    picture is sharper than the one a model was trained by, and as a rule a little further from its frame.
    """
    if factor == 1:
        return draw

    def drawing(splats: Splats, camera: Camera, options: DrawOptions) -> Rendered:
        fine = camera.resized(factor * camera.width, factor * camera.height)
        return averaged(draw(splats, fine, options), factor)

    return drawing


def averaged(drawn: Rendered, factor: int) -> Rendered:
    """The mean over squares of `factor` by `factor` pixels, in float, before anything is clipped.

    What is averaged are the sums that blending has made: premultiplied colour, alpha, and depth times alpha.
    They are linear in what each splat adds, so the mean is what the area of the pixel shows: a straight
    colour or depth would count alike where much and where little is seen, and draw seams along edges. Colours
    stay in the values in which they are blended, trained and compared with frames, those of a screen: to
    average light instead would brighten every edge against the same model drawn without.
    """
    alpha = _mean(drawn.alpha, factor)
    weighed = _mean(drawn.depth * drawn.alpha, factor)
    depth = np.divide(weighed, alpha, out=np.zeros_like(alpha), where=alpha > 0)
    return Rendered(_mean(drawn.image, factor), alpha, depth)


def _mean(values: Float32Array, factor: int) -> Float32Array:
    """(H, W, ...) of (factor H, factor W, ...)."""
    height, width = values.shape[0] // factor, values.shape[1] // factor
    squares = values.reshape(height, factor, width, factor, *values.shape[2:])
    mean: Float32Array = squares.mean(axis=(1, 3), dtype=np.float32)
    return mean
