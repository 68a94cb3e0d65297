"""Noise in numbers: how many times larger it is than in the original, where that is flat.

Pixels whose alpha is 0 count in no measure.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, Literal, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from enhance.brightness import BLACK, value
from enhance.image import AnyImage, BoolImage, Float32Image, ImageError
from enhance.measured_pixels import channels, check_sizes, green, kept, seen, unit
from enhance.metrics import SATURATED
from enhance.strips import Strip, strips

FLAT_SIGMA: Final = 2.0
REACH: Final = 9
"""Pixels beside one that its slope depends on: the Gaussian ends at 4 of its sigmas."""
NOISE_KERNEL: Final = np.outer((1, -2, 1), (1, -2, 1)).astype(np.float32)
NOISELESS: Final = 1e-6
"""Of full scale: mean responses below are what the rounding of floats leaves of none; that of 16 bits makes
1e-5."""
SCALES: Final = (1, 2, 4, 8, 16)
"""Pixels of the sides of blocks whose mean colours are compared."""
BLOCKS: Final = 16
"""Along either side of an image, at least, where they are of more than one pixel."""
BEYOND_ROUNDING: Final = 0.02
"""Of full scale: from here on, the mean response times the scale is four times that of R - G to rounding to
8 bits, and gains of 1/2 to 3 are within some tenth."""
NoiseCut = Literal["unclipped", "by rank", "by level"]
"""What noise is without: what has clipped, and the largest quarter of the responses, as many values whatever
ties there are; as before 0.6.0, that quarter alone, and colours pixel by pixel; or, as before 0.4.0, what is
above the third quartile, where rounding decides between ties."""


def noise_gain(
    image: AnyImage,
    original: AnyImage,
    *,
    tissue_mask: BoolImage | None = None,
    cut: NoiseCut = "unclipped",
    flat: BoolImage | None = None,
) -> float:
    """How many times larger the noise of `image` is where `original` is flat; 1 = the same.

    Noise is the mean size of the response to the kernel that is blind to planes (Immerkaer, Computer Vision
    and Image Understanding 64(2), 1996), over all channels, without the largest quarter, which edges make:
    of n values the largest n // 4, by rank. (Their median would step by whole grey levels.) Flat is the half
    of the tissue with the smallest gradient of the blurred green of `original`, without black and highlights.
    Responses to values that are clipped, 0 or full scale, in either image are left out of both, so that a
    method that clips is not the quieter for it. NaN: nothing flat, all clipped, or an original without noise.

    Args:
        tissue_mask: (H, W), True = keep.
        cut: "by rank" and "by level" reproduce values of before 0.6.0 and 0.4.0.
        flat: (H, W), `flat_tissue` of the original, where it is known.

    Raises:
        ImageError: images or a mask of different sizes, or a cut that there is none of.

    Example:
        >>> import numpy as np
        >>> from enhance import noise_gain
        >>> noise = np.random.default_rng(0).normal(0, 0.01, (64, 64))
        >>> round(noise_gain(0.5 + 2 * noise, 0.5 + noise), 2)
        2.0
    """
    return _Pair.of(image, original, tissue_mask, cut, flat).gain(SCALES[:1], of_color=False)


def chroma_noise_gain(
    image: AnyImage,
    original: AnyImage,
    *,
    tissue_mask: BoolImage | None = None,
    cut: NoiseCut = "unclipped",
    flat: BoolImage | None = None,
) -> float:
    """How many times larger the noise of the colours of `image` is where `original` is flat; 1 = the same.

    As `noise_gain`, of R - G and B - G in place of the channels, and of their means over blocks of 1, 2, 4, 8
    or 16 pixels a side: the smallest at which the noise of `original` is well beyond the rounding to 8 bits,
    else where it is most so. Codecs leave little of it at finer scales. Colours that a method makes out of
    noise of brightness count, too. NaN: also of grey images.

    Raises:
        ImageError: images or a mask of different sizes, or a cut that there is none of.

    Example:
        >>> import numpy as np
        >>> from enhance import chroma_noise_gain
        >>> noise = np.random.default_rng(0).normal(0, 0.01, (64, 64, 3))
        >>> round(chroma_noise_gain(0.5 + 2 * noise, 0.5 + noise), 2)
        2.0
    """
    pair = _Pair.of(image, original, tissue_mask, cut, flat)
    if pair.before.ndim == 2:
        return math.nan
    return pair.gain(SCALES if cut == "unclipped" else SCALES[:1], of_color=True)


def flat_tissue(original: AnyImage, tissue_mask: BoolImage | None) -> BoolImage:
    """(H, W), True where noise is measured; see `noise_gain`. Raises ImageError."""
    return _flat(seen(original), kept(original, tissue_mask))


def _flat(pixels: AnyImage, counted: BoolImage) -> BoolImage:
    """(H, W) of what counts, the half with the smallest gradient."""
    keep = counted & (unit(value(pixels)) > np.float32(2 * BLACK))
    keep &= unit(green(pixels)) < np.float32(SATURATED)
    slope = np.empty(keep.shape, np.float32)
    for strip in strips(keep.shape, beside=REACH):
        smooth = cv2.GaussianBlur(unit(green(pixels[strip.rows])), (0, 0), FLAT_SIGMA)
        along_x, along_y = (cv2.Sobel(smooth, cv2.CV_32F, *along) for along in ((1, 0), (0, 1)))
        np.hypot(along_x[strip.inner], along_y[strip.inner], out=slope[strip.own])
    return np.asarray(keep & (slope <= np.median(slope[keep]))) if keep.any() else keep


@dataclass(frozen=True, eq=False)
class _Pair:
    """An original and an image that was made of it, (H, W) or (H, W, 3), as `seen`."""

    before: AnyImage
    after: AnyImage
    keep: BoolImage
    """(H, W), True where both are visible and in the tissue."""
    flat: BoolImage
    """(H, W)"""
    cut: NoiseCut

    @classmethod
    def of(
        cls,
        image: AnyImage,
        original: AnyImage,
        tissue_mask: BoolImage | None,
        cut: NoiseCut,
        flat: BoolImage | None,
    ) -> _Pair:
        """Raises ImageError."""
        if cut not in get_args(NoiseCut):
            raise ImageError(f"expected cut to be {' or '.join(map(repr, get_args(NoiseCut)))}, got {cut!r}")
        before, after = seen(original), seen(image)
        check_sizes(after, before)
        keep = kept(original, tissue_mask) & kept(image)
        return cls(before, after, keep, _flat(before, keep) if flat is None else flat & keep, cut)

    def gain(self, scales: Sequence[int], of_color: bool) -> float:
        """At the smallest of these scales at which what was is beyond rounding, else where it is most so."""
        most, found = 0.0, (math.nan, math.nan)
        for scale in scales:
            if scale == 1 or BLOCKS * scale <= min(self.keep.shape):
                before, after = (_noise(each, self.cut) for each in self._responses(scale, of_color))
                beside = min(scale * before, BEYOND_ROUNDING)
                if math.isnan(found[0]) or beside > most:
                    most, found = beside, (before, after)
                if most == BEYOND_ROUNDING:
                    break
        before, after = found
        return after / before if before > (0 if self.cut == "by level" else NOISELESS) else math.nan

    def _responses(self, scale: int, of_color: bool) -> Iterator[Float32Image]:
        """Of both, the sizes of the responses of blocks in flat tissue to whole ones."""
        height, width = (side // scale for side in self.keep.shape)
        parts = [self._of_strip(strip, width, scale, of_color) for strip in strips((height, width), beside=1)]
        return map(np.concatenate, zip(*parts, strict=True))

    def _of_strip(self, strip: Strip, width: int, scale: int, of_color: bool) -> Iterator[Float32Image]:
        """Channel by channel, where loops are long, until pixels are chosen."""
        pixels = slice(scale * strip.rows.start, scale * strip.rows.stop), slice(scale * width)
        before, after = (
            [unit(plane) for plane in channels(image[pixels])] for image in (self.before, self.after)
        )
        whole = [
            self._whole(was, is_now, self.keep[pixels]) for was, is_now in zip(before, after, strict=True)
        ]
        if of_color:
            before, after = (_beyond_green(colors) for colors in (before, after))
            whole = [whole[0] & whole[1], whole[2] & whole[1]]
        counts = (_blocks(self.flat[pixels], scale) >= 0.5)[strip.inner]
        where = np.asarray(cv2.merge([_beside(plane, scale)[strip.inner] & counts for plane in whole])) > 0
        for planes in (before, after):
            sizes = cv2.merge([_responses(plane, scale)[strip.inner] for plane in planes])
            yield np.asarray(sizes, np.float32)[where]

    def _whole(self, before: Float32Image, after: Float32Image, keep: BoolImage) -> BoolImage:
        """Where values of a channel count and neither is clipped; everywhere, of cuts of before."""
        if self.cut != "unclipped":
            return np.ones(before.shape, bool)
        unclipped = (before > 0) & (before < 1) & (after > 0) & (after < 1)
        return np.asarray(unclipped & keep)


def _beyond_green(colors: Sequence[Float32Image]) -> list[Float32Image]:
    red, green, blue = colors
    return [red - green, blue - green]


def _beside(whole: BoolImage, scale: int) -> NDArray[np.uint8]:
    """1 where a block and all beside it are whole."""
    return np.asarray(cv2.erode((_blocks(whole, scale) == 1).view(np.uint8), np.ones(NOISE_KERNEL.shape)))


def _responses(plane: Float32Image, scale: int) -> Float32Image:
    """Their sizes, of blocks' means."""
    return np.abs(
        cv2.filter2D(_blocks(plane, scale), cv2.CV_32F, NOISE_KERNEL, borderType=cv2.BORDER_REFLECT)
    )


def _blocks(values: Float32Image | BoolImage, scale: int) -> Float32Image:
    """Means over blocks of `scale` pixels a side, of which there are whole ones."""
    single = values.astype(np.float32, copy=False)
    if scale == 1:
        return single
    height, width = (side // scale for side in values.shape[:2])
    return np.asarray(cv2.resize(single, (width, height), interpolation=cv2.INTER_AREA))


def _noise(responses: Float32Image, cut: NoiseCut) -> float:
    if not responses.size:
        return math.nan
    if cut == "by level":
        return float(responses[responses <= np.quantile(responses, 0.75)].mean(dtype=np.float64))
    count = responses.size - responses.size // 4
    responses.partition(count - 1)
    return float(responses[:count].mean(dtype=np.float64))
