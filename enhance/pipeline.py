"""The 2D vascular enhancement of an image, and the statistics of a clip."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import zip_longest
from typing import Final

import numpy as np

from enhance.enhancer import Enhancer
from enhance.field import FieldOfView, typical
from enhance.image import AnyImage, ImageError
from enhance.params import DEFAULTS, EnhanceParams
from enhance.result import EnhanceResult
from enhance.shown import Pixels
from enhance.statistics import Statistics, Tally, require_classes

MOST_IDLE: Final = 1 << 25
"""Bytes of working memory that a thread keeps from one image to the next."""


class _Idle(threading.local):
    """Of each thread: what enhanced its last image, without that image. To get its memory anew, page by page,
    takes a third of the time of an image."""

    enhancer: Enhancer | None = None


_IDLE: Final = _Idle()


def enhance(
    image: AnyImage,
    params: EnhanceParams = DEFAULTS,
    *,
    tissue_mask: AnyImage | None = None,
    statistics: Statistics | None = None,
    pixels: Pixels = "automatic",
) -> EnhanceResult:
    """Make vessels visible: brightness, local detail and saturation (section 3.1 of the paper, Eqs 1-12).

    For many images, or many parameters of one, an `Enhancer` is faster. Working memory of up to 32 MB stays
    with the thread for its next image.

    Args:
        image: (H, W), (H, W, 3) or (H, W, 4) with alpha last; uint8, uint16 or float in [0, 1]. Any order
            of the colours. Grey images have no saturation stage; alpha passes through; pixels of alpha 0
            stay as they are and out of the statistics, and have no part in those beside them.
        params: z and P given there win over those of `statistics`.
        tissue_mask: (H, W), non-zero = keep: the statistics are those of the kept pixels. All pixels are
            enhanced.
        statistics: of a clip (`measure`), so that colours agree between its frames; None: of this image.
        pixels: what is enhanced and counts in the statistics. "automatic": the field of view, where it is
            that of `statistics` if these are given, else found in the image (`find_field`); a surround
            stays bit for bit as it is. "all": every pixel, as the paper has it. Or a known field of view.

    Returns:
        image of the same shape and type, the statistics that were used and the stages left out.

    Raises:
        ImageError: an image, mask or statistics that cannot be used; the text says why.
        TypeError: `params` or `statistics` of another class.

    Example:
        >>> import numpy as np
        >>> from enhance import EnhanceParams, enhance
        >>> image = np.random.default_rng(0).integers(0, 90, (48, 64, 3), dtype=np.uint8)
        >>> result = enhance(image, EnhanceParams(z=0.0))
        >>> result.image.shape, result.image.dtype, bool(result.image.mean() > image.mean())
        ((48, 64, 3), dtype('uint8'), True)
    """
    # Taken away while it is in use: a signal's handler may enhance an image, too.
    enhancer, _IDLE.enhancer = _IDLE.enhancer or Enhancer(), None
    enhancer.show(image, tissue_mask, pixels=pixels)
    result = enhancer.enhance(params, statistics=statistics)
    if enhancer.memory <= MOST_IDLE:
        enhancer.forget()
        _IDLE.enhancer = enhancer
    return result


def measure(
    images: Iterable[AnyImage],
    params: EnhanceParams = DEFAULTS,
    tissue_masks: Iterable[AnyImage | None] | None = None,
    *,
    pixels: Pixels = "automatic",
) -> Statistics:
    """Statistics of a whole clip for Eqs 2, 9 and 12: histograms, saturations and variances pooled over all
    kept pixels, so that the colours of its frames agree.

    Args:
        images: as `enhance` takes them; sizes may differ. Read one at a time.
        tissue_masks: one an image.
        pixels: as of `enhance`. "automatic": each image counts within its own field of view; that of the
            clip is the one that agrees best with the others.

    Raises:
        ImageError: as `enhance`, with the position in the clip; no image, or one that is not in a list;
            fewer or more masks than images.
        TypeError: `params` of another class.

    Example:
        >>> import numpy as np
        >>> from enhance import enhance, measure
        >>> frames = np.random.default_rng(0).integers(0, 200, (3, 48, 64, 3), dtype=np.uint8)
        >>> statistics = measure(frames)
        >>> {enhance(frame, statistics=statistics).statistics.scope for frame in frames}
        {'clip'}
    """
    if isinstance(images, np.ndarray) and (
        images.ndim == 2 or (images.ndim == 3 and images.shape[2] in (3, 4))
    ):
        raise ImageError(f"expected several images, got one of shape {images.shape}: put it into a list")
    pool = Pool(params, pixels)
    for index, (image, mask) in enumerate(_pairs(images, tissue_masks)):
        try:
            pool.add(image, mask)
        except ImageError as error:
            raise ImageError(f"image {index} of the clip: {error}") from error
    return pool.statistics()


class Pool:
    """Statistics of a clip whose images come one by one; see `measure`.

    Example:
        >>> import numpy as np
        >>> from enhance import Pool
        >>> pool = Pool()
        >>> for level in (50, 150):
        ...     pool.add(np.full((32, 32, 3), level, np.uint8))
        >>> pool.statistics().scope
        'clip'
    """

    def __init__(self, params: EnhanceParams = DEFAULTS, pixels: Pixels = "automatic") -> None:
        """Raises TypeError: `params` of another class."""
        require_classes(params, EnhanceParams)
        self._params, self._pixels, self._enhancer = params, pixels, Enhancer()
        self._total: Tally | None = None
        self._fields: list[FieldOfView] = []

    def add(self, image: AnyImage, tissue_mask: AnyImage | None = None) -> None:
        """One more image, as `enhance` takes it. Raises ImageError: one that cannot be used is left out."""
        self._enhancer.show(image, tissue_mask, pixels=self._pixels)
        one = self._enhancer.tally(self._params)
        self._total = one if self._total is None else self._total + one
        if self._enhancer.field is not None:
            self._fields.append(self._enhancer.field)

    def statistics(self) -> Statistics:
        """Of all images so far. Raises ImageError: there is none, or no pixel counts."""
        if self._total is None:
            raise ImageError("expected at least one image to measure, got none")
        field = typical(self._fields) if self._fields else None
        return replace(self._total.statistics(self._params, "clip"), field=field)


def _pairs(
    images: Iterable[AnyImage], masks: Iterable[AnyImage | None] | None
) -> Iterator[tuple[AnyImage, AnyImage | None]]:
    if masks is None:
        yield from ((image, None) for image in images)
        return
    for image, mask in zip_longest(images, masks, fillvalue=...):
        if image is ... or mask is ...:
            raise ImageError("expected as many tissue_masks as images, got more of one than of the other")
        yield image, mask
