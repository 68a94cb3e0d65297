"""The image that an enhancer works on: as the kernels read it, and as it is given back."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Final, Literal, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance.color_noise import NO_OPPOSITES, Opposites, opposites
from enhance.field import EVERYWHERE, FieldOfView, Spans, whole_field
from enhance.field_search import find_field
from enhance.image import BYTES, AnyImage, BoolImage, ImageError, Picture, full_scale, read_mask, read_picture
from enhance.redness import NO_REDS, Reds, reds
from enhance.statistics import Statistics

Named = Literal["automatic", "all"]
Pixels = Named | FieldOfView
"""What is enhanced and counts in the statistics: the field of view as found in the image, every pixel as the
paper has it, or a known field of view. What lies outside stays as it is."""
NAMED: Final = get_args(Named)
SPARSE: Final = 128
"""Pixels a step, down and across, of those that nearly always tell that an image has colours."""
ALL_KEPT: NDArray[np.uint8] = np.empty((0, 0), np.uint8)


class _Search:
    """The field of view of a picture, looked for once, when it is first asked for."""

    def __init__(self, picture: Picture) -> None:
        self._picture = picture

    @cached_property
    def field(self) -> FieldOfView:
        return found_in(self._picture)


@dataclass(frozen=True, eq=False)
class Shown:
    """One image, read."""

    given: Picture
    """As it came."""
    picture: Picture
    """Filled, so that what is stored where alpha is 0 does not reach pixels beside it."""
    search: _Search
    pixels: NDArray[Any]
    """(H, W, 3), C-contiguous, uint8 or float32; grey three times."""
    tissue: NDArray[np.uint8]
    """(H, W), 1 = counts in the statistics if it lies in the field; empty: all that do."""
    wanted: Pixels
    field: FieldOfView | None = None
    """None: all pixels."""

    @classmethod
    def of(cls, image: AnyImage, tissue_mask: AnyImage | None, wanted: Pixels) -> Shown:
        """Seen whole, so far.

        Raises:
            ImageError: an image or mask that cannot be used, a field of another size, or other `pixels`.
        """
        _check(wanted)
        given = read_picture(image)
        picture = given.filled
        height, width = picture.pixels.shape[:2]
        if isinstance(wanted, FieldOfView) and not wanted.fits(picture.pixels):
            raise ImageError(
                f"expected a field of view of {width} x {height} pixels, got {wanted.width} x {wanted.height}"
            )
        tissue = ALL_KEPT
        if tissue_mask is not None or picture.alpha is not None:
            tissue = np.ascontiguousarray(read_mask(tissue_mask, picture)).view(np.uint8)
        pixels = picture.pixels if picture.dtype == BYTES else picture.colors
        pixels = np.ascontiguousarray(pixels)
        if pixels.ndim == 2:
            pixels = np.asarray(cv2.cvtColor(pixels, cv2.COLOR_GRAY2RGB))
        return cls(given, picture, _Search(picture), pixels, tissue, wanted)

    def within(self, statistics: Statistics | None) -> Shown:
        """Itself, or the same image within the field of view that is wanted, or that of given statistics."""
        field = self._field(statistics)
        return self if field == self.field else replace(self, field=field)

    def _field(self, statistics: Statistics | None) -> FieldOfView | None:
        if not isinstance(self.wanted, str):
            return self.wanted
        if self.wanted == "all":
            return None
        if statistics is not None and (statistics.field is None or statistics.field.fits(self.pixels)):
            return statistics.field
        return self.search.field

    @property
    def full(self) -> int:
        """What 1.0 is in `pixels`."""
        return full_scale(self.pixels.dtype)

    @cached_property
    def is_grey(self) -> bool:
        """The image has no colours: one channel, or three that are equal."""
        if self.picture.pixels.ndim == 2:
            return True
        height, width = self.pixels.shape[:2]
        if len(set(self.pixels[height // 2, width // 2].tolist())) > 1:
            return False
        return _is_grey(self.pixels[::SPARSE, ::SPARSE]) and _is_grey(self.pixels)

    @cached_property
    def reds(self) -> Reds:
        """Of the pixels that count; of none of a grey image."""
        return NO_REDS if self.is_grey else reds(self.pixels, self.keep, self.spans, self.full)

    @cached_property
    def opposites(self) -> Opposites:
        """Of the pixels that count; of none of a grey image."""
        return NO_OPPOSITES if self.is_grey else opposites(self.pixels, self.keep, self.spans, self.full)

    @cached_property
    def spans(self) -> Spans:
        """Of the field; see `FieldOfView.spans`."""
        return EVERYWHERE if self.field is None else self.field.spans()

    @cached_property
    def keep(self) -> NDArray[np.uint8]:
        """(H, W), 1 = counts in the statistics if it lies in the spans; empty: all that do."""
        if not self._is_apart:
            return self.tissue
        inside = self._inside().view(np.uint8)
        return inside & self.tissue if len(self.tissue) > 0 else inside

    @property
    def _is_apart(self) -> bool:
        """The field has parts, so that the spans hold some of the surround."""
        return self.field is not None and self.field.parts is not None

    @property
    def counts_all(self) -> bool:
        """Every pixel counts in the statistics."""
        return len(self.keep) == 0 and len(self.spans) == 0

    def finished(self, out: NDArray[Any]) -> AnyImage:
        """`out`, shaped as `pixels`, in the input's shape and type; alpha, what it hides, and what lies
        outside the field as they came."""
        if self._is_apart:
            cv2.copyTo(self.pixels, (~self._inside()).view(np.uint8), out)
        whole = self._whole(out)
        if self.given.alpha is not None:
            hidden = ~self.given.visible
            whole[hidden, :3] = self.given.pixels[hidden]
        return whole

    def _whole(self, out: NDArray[Any]) -> AnyImage:
        picture = self.picture
        colors = out if picture.pixels.ndim == 3 else np.ascontiguousarray(out[..., 0])
        if picture.dtype == out.dtype:
            return colors if picture.alpha is None else np.dstack((colors, picture.alpha))
        scaled = colors if self.full == 1 else colors.astype(np.float32) / np.float32(self.full)
        whole = picture.with_colors(scaled)
        if len(self.spans) > 0:
            target = whole if picture.alpha is None else whole[..., :3]
            outside = ~self._inside()
            target[outside] = picture.pixels[outside]
        return whole

    def _inside(self) -> BoolImage:
        return self.field.mask() if self.field else np.ones(self.pixels.shape[:2], bool)


def _check(wanted: object) -> None:
    if isinstance(wanted, FieldOfView) or (isinstance(wanted, str) and wanted in NAMED):
        return
    got = repr(wanted) if isinstance(wanted, str) else type(wanted).__name__
    raise ImageError(f"expected pixels to be 'automatic', 'all' or a FieldOfView, got {got}")


def _is_grey(pixels: NDArray[Any]) -> bool:
    red, green, blue = (pixels[..., channel] for channel in range(3))
    return bool((red == green).all() and (green == blue).all())


def found_in(picture: Picture) -> FieldOfView:
    """The field of view of a picture; all of it where it has no surround, or is too dark to tell."""
    height, width = picture.pixels.shape[:2]
    return find_field(picture) or whole_field(width, height)
