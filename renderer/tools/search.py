"""Surgical tools in an image of tissue, found by their colour where nobody has masked them: steel and
plastic are grey, white or blue, and tissue is red."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.clip import BoolImage, ByteImage, Frame, within
from renderer.tools.shrinking import SMALLEST, disc, shrunk
from renderer.tools.still import StillArea

GREY: Final = 0.08
"""ln(R / G) of steel, white balanced: no redder."""
MIXED: Final = 0.2
"""ln(R / G) up to which what is next to steel belongs to the tool: it mirrors the tissue."""
MIXED_SHARE: Final = 0.45
"""Of the tissue's own redness: the same where tissue is pale."""
LEAST_REDNESS: Final = 0.2
"""ln(R / G) of tissue; paler tissue, as through amniotic fluid, is not told from steel."""
GREY_SHARE: Final = 0.2
"""Of a tool, reflections left out, that is grey: pale tissue is of mixed colour alone."""
GREY_SHARE_WITHIN: Final = 0.5
"""The same of a piece that does not enter by itself."""
REACH: Final = 0.075
"""Of the longer side: pieces of a tool, as shaft and jaws, are as near to each other, with what is blurred or
mirrors tissue between them."""
STEP: Final = 0.27
"""Of the tissue's redness, from within a tool to what lies beside it; pale tissue fades into red."""
MARGIN: Final = 0.025
"""Of the longer side: edges are blurred, and tools throw shadows."""

_DARK, _SATURATED = 14, 235  # Grey levels without colour.
_FLOOR = 4.0  # Grey levels that keep the ratio of dark pixels small.
_BLUR = 0.8  # px of the small image, standard deviation.
_EDGE = 3  # px of the small image: width of the bands on both sides of an edge.
_RIM = 4  # px of the small image: what ends there comes from beyond the view.
_OPENING = 5  # px of the small image: thinner than that are reflections and vessels.


def find_tools(
    image: ByteImage, seen: BoolImage, still: Iterable[StillArea] = (), reach: float = REACH
) -> BoolImage:
    """(H, W), True = tool and its margin, of an RGB image (H, W, 3).

    `seen` (H, W) is True where the endoscope sees something; what stands `still` over its clip is found
    where it looks the same. Else a tool is a connected area of grey and mixed colour that ends sharply, and
    enters from the edge of what is seen, by itself or by way of others within `reach`. Colour is ln(R / G):
    brightness, and so the distance of the lamp, cancels. Nothing is found where tissue itself is grey.

    The constants were chosen on training frames of the pulling and mesentery clips, whose tools are
    known, and of the wall, which has none: edges step by 0.34 to 1.3 of the tissue's redness where a tool
    ends, and by up to 0.21 where pale tissue does. What it cannot tell: tips that mirror tissue all over,
    and tissue as blue as steel.
    """
    small = shrunk(image)
    return with_margin(with_still(tools_alone(small, seen, reach), small, still), seen.shape)


def tools_alone(small: ByteImage, seen: BoolImage, reach: float = REACH) -> ByteImage:
    """(h, w), 1 where a tool is, without its margin, else 0: of an image (h, w, 3) as `shrunk` makes it."""
    size = small.shape[1], small.shape[0]
    colors = _Colors.of(small, cv2.resize(seen.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0)
    if colors.tissue < LEAST_REDNESS:
        return np.zeros(small.shape[:2], np.uint8)
    return _entering(colors, round(reach * max(size)))


def with_still(alone: ByteImage, small: ByteImage, still: Iterable[StillArea]) -> ByteImage:
    """The same with what stands still, where the image looks so."""
    for area in still:
        alone = area.added(alone, small)
    return alone


def with_margin(alone: ByteImage, size: tuple[int, ...]) -> BoolImage:
    """(H, W) of that size, True = tool and its margin."""
    if not alone.any():
        return np.zeros(size, bool)
    wide = cv2.dilate(alone, disc(2 * round(MARGIN * max(alone.shape)) + 1))
    return np.asarray(cv2.resize(wide, (size[1], size[0]), interpolation=cv2.INTER_LINEAR) > 0)


def without_tools(frame: Frame, still: Iterable[StillArea], reach: float) -> Frame:
    """The frame where tools, as `find_tools` sees them, are no tissue; as it is where they are known."""
    if frame.tools_are_known:
        return frame
    return within(frame, ~find_tools(frame.image, frame.tissue_mask, still, reach))


def without_still(frame: Frame, still: Iterable[StillArea]) -> Frame:
    """The frame where what stands still, and its margin, is no tissue, be its tools known or not."""
    return within(frame, ~still_pixels(shrunk(frame.image), still, frame.tissue_mask.shape))


def still_pixels(small: ByteImage, still: Iterable[StillArea], size: tuple[int, ...]) -> BoolImage:
    """(H, W) of that size, True = what stands still, where the image (h, w, 3) looks so, and its margin."""
    return with_margin(with_still(np.zeros(small.shape[:2], np.uint8), small, still), size)


@dataclass(frozen=True, eq=False)
class _Colors:
    """Of the small image, (h, w)."""

    red: NDArray[np.float32]
    """ln(R / G)."""
    inside: BoolImage
    usable: BoolImage
    """Neither black nor saturated."""
    tissue: float
    """Its typical redness, also where tools cover nearly half of the image; 0 of nothing."""

    @classmethod
    def of(cls, small: ByteImage, inside: BoolImage) -> _Colors:
        smooth = cv2.GaussianBlur(small, (0, 0), _BLUR).astype(np.float32) + _FLOOR
        red = np.log(smooth[:, :, 0] / smooth[:, :, 1])
        usable = inside & (small.max(axis=2) > _DARK) & (small.min(axis=2) < _SATURATED)
        return cls(red, inside, usable, float(np.percentile(red[usable], 60)) if usable.any() else 0.0)

    @property
    def mixed(self) -> BoolImage:
        return self.inside & (self.red < min(MIXED, MIXED_SHARE * self.tissue))


def _entering(colors: _Colors, reach: int) -> ByteImage:
    """(h, w), 1 on areas of mixed colour that are grey enough and end sharply, and enter from the rim, by
    themselves or by way of others within `reach` px, else 0."""
    opened = cv2.morphologyEx(colors.mixed.astype(np.uint8), cv2.MORPH_OPEN, disc(_OPENING))
    _, labels, facts, _ = cv2.connectedComponentsWithStats(opened)
    count = len(facts)
    clear = _shrunk(colors.inside, _RIM)
    coloured = np.bincount(labels[colors.usable], minlength=count)
    greys = np.bincount(labels[colors.usable & (colors.red < GREY)], minlength=count)
    reaches = np.bincount(labels[~clear], minlength=count) > 0
    large = facts[:, cv2.CC_STAT_AREA] > SMALLEST * labels.size
    pieces = large & (greys > np.where(reaches, GREY_SHARE, GREY_SHARE_WITHIN) * coloured)
    pieces[0] = False  # What is of no mixed colour.
    sharp = pieces.copy()
    for label in np.flatnonzero(pieces):
        sharp[label] = _step(colors, labels == label, clear) > STEP * colors.tissue
    # What is blurred at the rim still says that a tool enters there.
    joined = _joined((sharp | pieces & reaches)[labels], ~clear, reach)
    return np.asarray(sharp[labels] & joined, dtype=np.uint8)


def _joined(areas: BoolImage, rim: BoolImage, reach: int) -> BoolImage:
    """(h, w), True where areas at the rim are, or others that lead there in steps of up to `reach` px."""
    away = cv2.distanceTransform((~areas).astype(np.uint8), cv2.DIST_L2, 5)
    _, groups = cv2.connectedComponents((away <= reach / 2).astype(np.uint8))
    enters = np.zeros(groups.max() + 1, bool)
    enters[groups[areas & rim]] = True
    return np.asarray(areas & enters[groups])


def _step(colors: _Colors, area: BoolImage, clear: BoolImage) -> float:
    """By how much ln(R / G) just outside an area is above that just within; its ends at the rim left out."""
    within_it = area & ~_shrunk(area, _EDGE) & clear & colors.usable
    around = _grown(area, _EDGE + 2) & ~_grown(area, 2) & clear & colors.usable
    if not within_it.any() or not around.any():
        return 0.0
    return float(np.median(colors.red[around]) - np.median(colors.red[within_it]))


def _grown(mask: BoolImage, radius: int) -> BoolImage:
    return np.asarray(cv2.dilate(mask.astype(np.uint8), disc(2 * radius + 1)) > 0)


def _shrunk(mask: BoolImage, radius: int) -> BoolImage:
    """What lies beyond the image is none of it."""
    bare = cv2.erode(
        mask.astype(np.uint8), disc(2 * radius + 1), borderType=cv2.BORDER_CONSTANT, borderValue=0
    )
    return np.asarray(bare > 0)
