"""What the endoscope sees of a picture: the field of view inside a dark surround, found by itself.

The field of view of an endoscope is convex: round, octagonal, or either of these cropped by the picture. It
is looked for in a small copy of the picture and then measured along rays at full size.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Final

import cv2
import numpy as np
from annotated_types import Interval, Len
from numpy.typing import NDArray

from enhance.image import AnyImage, BoolImage, Picture, full_scale, read_picture

LOW_SIDE: Final = 160
"""Longer side of the small copy, in pixels."""
BRIGHTEST: Final = 64.0
"""Grey levels of V: a brighter corner is no surround."""
NOISIEST: Final = 12.0
"""Deviation of V in a corner, in grey levels: more is structure, not noise."""
STEP, DEVIATIONS, STRAY = 10.0, 5.0, 0.2
"""Above the surround's V by so many grey levels, so many deviations of its noise, and by this share of what
lies between it and the middle of the lit picture, it is field: stray light beside the rim is less."""
LEAST_SIDE: Final = 16
"""Pixels: smaller pictures are too small for a surround with a rim."""
LEAST_SURROUND: Final = 0.01
"""Of the picture: smaller dark corners are shadow."""
LEAST_FIELD: Final = 0.05
"""Of the picture: with less the picture is too dark to tell."""
MOST_SWALLOWED: Final = 0.12
"""Of what is dark and touches the border: a shadow on tissue lies within the convex outline, a surround
hardly at all."""
LEAST_DARK: Final = 0.75
"""Of what lies outside the outline; text and boxes are the rest."""
LEAST_SHARP: Final = 0.5
"""Of the outline: there the picture rises by another STEP within two small pixels; a shadow fades."""
RIM: Final = 2.0
"""Pixels within the outline that are half dark."""
RAYS: Final = 240
LEAST_ON_CIRCLE: Final = 0.7
"""Of the rays: with fewer the outline is no circle."""
CIRCLE_TOLERANCE: Final = 1.5
"""Pixels, or so many thousandths of the radius where that is more, that a point may lie off a circle."""

MOST_COMPARED: Final = 32
"""Fields of one clip."""
MOST_CORNERS: Final = RAYS

Points = NDArray[np.float64]
Spans = NDArray[np.int32]
EVERYWHERE: Final = np.empty((0, 2), np.int32)
"""The spans of a picture that is all field."""
Side = Annotated[int, Interval(ge=1, le=2**31 - 1)]
Coordinate = Annotated[float, Interval(ge=-1e6, le=1e6)]
Radius = Annotated[float, Interval(ge=0, le=1e6)]
Corner = tuple[Coordinate, Coordinate]


@dataclass(frozen=True)
class FieldOfView:
    """A convex part of a picture, in pixels from its upper left corner; pixel centres at +0.5.

    Example:
        >>> from enhance.field import FieldOfView
        >>> field = FieldOfView(width=8, height=4, circle=(4.0, 2.0, 2.0))
        >>> field.spans().tolist()
        [[3, 5], [2, 6], [2, 6], [3, 5]]
    """

    width: Side
    """Of the picture."""
    height: Side
    circle: tuple[Coordinate, Coordinate, Radius] | None = None
    """Middle, x and y, and radius; it may reach beyond the picture."""
    polygon: Annotated[tuple[Corner, ...], Len(3, MOST_CORNERS)] | None = None
    """Corners of a convex outline. Neither circle nor polygon: the whole picture."""

    @property
    def is_whole(self) -> bool:
        """There is no surround."""
        return self.circle is None and self.polygon is None

    def fits(self, image: AnyImage) -> bool:
        """It is of images of this size."""
        return image.shape[:2] == (self.height, self.width)

    def spans(self) -> Spans:
        """(H, 2) first column of each row that belongs to the field and the first after; empty: all do."""
        if self.is_whole:
            return EVERYWHERE
        rows = np.arange(self.height, dtype=np.float64) + 0.5
        left, right = self._chords(rows)
        spans = np.empty((self.height, 2), np.int32)
        spans[:, 0] = np.minimum(np.maximum(np.ceil(left - 0.5), 0), self.width)
        spans[:, 1] = np.minimum(np.maximum(np.ceil(right - 0.5), spans[:, 0]), self.width)
        return spans

    def mask(self) -> BoolImage:
        """(H, W), True = field."""
        if self.is_whole:
            return np.ones((self.height, self.width), bool)
        columns, spans = np.arange(self.width), self.spans()
        return np.asarray((columns >= spans[:, :1]) & (columns < spans[:, 1:]))

    def _chords(self, rows: Points) -> tuple[Points, Points]:
        """Left and right end of the outline at these heights; left beyond right where it has none."""
        if self.circle is not None:
            x, y, radius = self.circle
            square = radius**2 - (rows - y) ** 2
            half = np.where(square > 0, np.sqrt(np.maximum(square, 0)), -1.0)
            return x - half, x + half
        corners = np.array(self.polygon)
        starts, ends = corners, np.roll(corners, -1, axis=0)
        left, right = np.full(len(rows), np.inf), np.full(len(rows), -np.inf)
        for (x, y), (to_x, to_y) in zip(starts, ends, strict=True):
            if y == to_y:
                continue
            crossed = (rows >= min(y, to_y)) & (rows <= max(y, to_y))
            at = x + (rows[crossed] - y) * ((to_x - x) / (to_y - y))
            left[crossed], right[crossed] = np.minimum(left[crossed], at), np.maximum(right[crossed], at)
        return np.where(left > right, 0.0, left), np.where(left > right, 0.0, right)


def overlap(one: FieldOfView, other: FieldOfView) -> float:
    """Intersection over union of two fields of one picture size, in [0, 1]."""
    bounds = [np.array([(0, one.width)] * one.height) if x.is_whole else x.spans() for x in (one, other)]
    common = np.minimum(bounds[0][:, 1], bounds[1][:, 1]) - np.maximum(bounds[0][:, 0], bounds[1][:, 0])
    shared = int(np.maximum(common, 0).sum())
    total = sum(int((bound[:, 1] - bound[:, 0]).sum()) for bound in bounds) - shared
    return shared / total if total else 1.0


def typical(fields: Sequence[FieldOfView]) -> FieldOfView:
    """The field of the most frequent size that overlaps most with the others, of up to MOST_COMPARED that are
    evenly spread: a flash or a dark moment does not move it."""
    size, _ = Counter((one.width, one.height) for one in fields).most_common(1)[0]
    alike = [one for one in fields if (one.width, one.height) == size]
    places: list[int] = np.linspace(0, len(alike) - 1, min(len(alike), MOST_COMPARED)).astype(int).tolist()
    counts = Counter(alike[place] for place in places)

    def agreement(one: FieldOfView) -> float:
        return sum(overlap(one, other) * count for other, count in counts.items())

    return max(counts, key=agreement)


def find_field(image: AnyImage | Picture) -> FieldOfView | None:
    """The field of view of a picture; the whole picture where there is no surround, None where it is too dark
    to tell.

    A surround is dark, even but for noise and text, reaches a corner of the picture, and the convex rest of
    the picture rises sharply from it.

    Raises:
        ImageError: an image that cannot be used.

    Example:
        >>> import numpy as np
        >>> from enhance.field import find_field
        >>> y, x = np.mgrid[:240, :320] + 0.5
        >>> image = np.where(np.hypot(x - 160, y - 120) < 100, 180, 5).astype(np.uint8)
        >>> [round(value) for value in find_field(image).circle]
        [160, 120, 98]
    """
    picture = image if isinstance(image, Picture) else read_picture(image)
    pixels = picture.pixels
    height, width = pixels.shape[:2]
    whole = FieldOfView(width, height)
    if min(height, width) < LEAST_SIDE:
        return whole
    factor = -(-max(height, width) // LOW_SIDE)
    low = _small(pixels, factor)
    threshold = _threshold(low)
    if threshold is None:
        return whole
    outline = _outline(low, threshold)
    if outline is None or len(outline) == 0:
        return whole if outline is not None else None
    scale = np.array([width / low.shape[1], height / low.shape[0]])
    points, cropped = _measured(pixels, (outline + 0.5) * scale, threshold, 2.5 * factor)
    return _fitted(points, cropped, whole)


def _small(pixels: AnyImage, factor: int) -> NDArray[np.uint8]:
    """(h, w) V in grey levels, each pixel from four of the picture, without specks."""
    height, width = pixels.shape[:2]
    size = max(1, width // factor), max(1, height // factor)
    if pixels.dtype == np.float16:
        pixels = pixels.astype(np.float32)
    small = cv2.resize(pixels, size, interpolation=cv2.INTER_LINEAR)
    if small.ndim == 3:
        small = cv2.max(cv2.max(small[..., 0], small[..., 1]), small[..., 2])
    return np.asarray(cv2.medianBlur(_in_levels(np.asarray(small)), 3))


def _in_levels(values: AnyImage) -> NDArray[np.uint8]:
    if values.dtype == np.uint8:
        return values
    return np.rint(values * (255.0 / full_scale(values.dtype))).astype(np.uint8)


def _threshold(low: NDArray[np.uint8]) -> float | None:
    """V above which a pixel is no surround, from the darkest corner; None: no corner can be one."""
    side = max(2, min(low.shape) // 24)
    corners = [np.sort(low[y, x].ravel()) for y in _ends(side) for x in _ends(side)]
    middle = len(corners[0]) // 2
    darkest = min(corners, key=lambda values: (values[middle], values[-1]))
    level = float(darkest[middle])
    noise = 0.74 * float(int(darkest[3 * len(darkest) // 4]) - int(darkest[len(darkest) // 4]))
    if level > BRIGHTEST or noise > NOISIEST:
        return None
    lit = low[low > level + STEP]
    stray = STRAY * (float(np.median(lit)) - level) if len(lit) else 0.0
    return level + max(STEP, DEVIATIONS * noise, stray)


def _ends(side: int) -> tuple[slice, slice]:
    return slice(None, side), slice(-side, None)


def _outline(low: NDArray[np.uint8], threshold: float) -> Points | None:
    """Corners of the convex field in the small copy; none: it has no surround. None: too dark to tell."""
    lit = (low > threshold).astype(np.uint8)
    _, labels, facts, _ = cv2.connectedComponentsWithStats(
        cv2.morphologyEx(lit, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)), connectivity=4
    )
    areas = facts[1:, cv2.CC_STAT_AREA]
    if not len(areas) or areas.max() < LEAST_FIELD * low.size:
        return None
    largest = (labels == 1 + int(areas.argmax())).astype(np.uint8)
    contours, _ = cv2.findContours(largest, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    hull = cv2.convexHull(contours[0])
    field = np.zeros_like(lit)
    cv2.fillConvexPoly(field, hull, 1)
    return hull[:, 0].astype(np.float64) if _is_framed(low, lit, field, threshold) else np.empty((0, 2))


def _is_framed(
    low: NDArray[np.uint8], lit: NDArray[np.uint8], field: NDArray[np.uint8], threshold: float
) -> bool:
    """Whether what lies outside the convex field is a surround, not shadow on tissue."""
    outside = field == 0
    if outside.mean() < LEAST_SURROUND or np.mean(lit[outside] == 0) < LEAST_DARK:
        return False
    _, labels = cv2.connectedComponents(1 - lit, connectivity=4)
    sides = np.concatenate((labels[0], labels[-1], labels[:, 0], labels[:, -1]))
    reaches = np.zeros(int(labels.max()) + 1, bool)
    reaches[sides] = True
    reaches[0] = False
    dark = reaches[labels]
    if np.mean(~outside[dark]) > MOST_SWALLOWED:
        return False
    kernel = np.ones((3, 3), np.uint8)
    once = cv2.erode(field, kernel, borderType=cv2.BORDER_CONSTANT, borderValue=1)
    twice = cv2.erode(once, kernel, borderType=cv2.BORDER_CONSTANT, borderValue=1)
    within = low[(once > 0) & (twice == 0)]
    return bool(len(within)) and float(np.mean(within > threshold + STEP)) >= LEAST_SHARP


def _measured(pixels: AnyImage, outline: Points, threshold: float, reach: float) -> tuple[Points, BoolImage]:
    """Where rays from the middle of an outline leave the field, less its half-dark rim, and corners of the
    picture that belong to it, (N, 2); and which of them lie at the border of the picture."""
    middle = (outline.max(axis=0) + outline.min(axis=0)) / 2
    angles = np.arange(RAYS) * (2 * np.pi / RAYS)
    along = np.stack((np.cos(angles), np.sin(angles)), axis=1)
    far = _distances(middle, along, outline)
    radii = (np.floor(far - reach) + 0.5)[:, None] + np.arange(int(2 * reach) + 1)
    x, y = (np.floor(middle[axis] + radii * along[:, axis, None]).astype(np.intp) for axis in (0, 1))
    height, width = pixels.shape[:2]
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    value = _value_at(pixels, x, y) * (255.0 / full_scale(pixels.dtype))
    outer = value[inside.all(axis=1), -int(reach) :]
    if outer.size:
        level, high = np.quantile(outer, (0.5, 0.84))
        threshold = max(threshold, float(level + DEVIATIONS * (high - level)))
    lit = inside & (value > threshold)
    # Four of five inwards: single ones are noise.
    counts = np.cumsum(lit, axis=1)
    lit[:, 5:] &= counts[:, 5:] - counts[:, :-5] >= 4
    last = lit.shape[1] - 1 - lit[:, ::-1].argmax(axis=1)
    some = lit.any(axis=1)
    index = np.arange(RAYS)
    cropped = some & ~inside[index, np.minimum(last + 2, lit.shape[1] - 1)]
    found = np.where(some, radii[index, last] + 0.5, far)
    points = middle + np.where(cropped, found, found - RIM)[:, None] * along
    # A corner of the picture that lies between two rays belongs to the field where both reach the border.
    corners = np.array([(x, y) for x in (0, width) for y in (0, height)], dtype=np.float64)
    turns = np.arctan2(*(corners - middle).T[::-1]) * (RAYS / (2 * np.pi))
    lit_corners = corners[cropped[np.floor(turns).astype(int)] & cropped[np.ceil(turns).astype(int) % RAYS]]
    points = np.concatenate((points, lit_corners))
    cropped = np.concatenate((cropped, np.ones(len(lit_corners), bool)))
    return np.where(cropped[:, None], _beyond(points, width, height), points), cropped


def _value_at(pixels: AnyImage, x: NDArray[np.intp], y: NDArray[np.intp]) -> NDArray[Any]:
    """V at these places, or at the nearest pixel of the border."""
    height, width = pixels.shape[:2]
    x, y = (np.minimum(np.maximum(at, 0), size - 1) for at, size in ((x, width), (y, height)))
    if pixels.ndim == 2:
        return np.asarray(pixels[y, x])
    if not pixels.flags.c_contiguous:
        return np.asarray(pixels[y, x].max(axis=2))
    seen = pixels.reshape(height * width, -1).take(y * width + x, axis=0)
    return np.asarray(np.maximum(np.maximum(seen[..., 0], seen[..., 1]), seen[..., 2]))


def _beyond(points: Points, width: int, height: int) -> Points:
    """Points at the border of a picture, moved out of it so that no pixel of the border is left out."""
    ends = np.array([width, height], dtype=np.float64)
    return np.where(points < 2, -4.0, np.where(points > ends - 2, ends + 4, points))


def _distances(middle: Points, along: Points, outline: Points) -> Points:
    """From a point within a convex outline to it, along each direction."""
    starts, ends = outline - middle, np.roll(outline, -1, axis=0) - middle
    sides = ends - starts
    # middle + t along = start + u side; cross products by Cramer's rule.
    below = along[:, :1] * sides[:, 1] - along[:, 1:] * sides[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (starts[:, 0] * sides[:, 1] - starts[:, 1] * sides[:, 0]) / below
        u = (starts[:, 0] * along[:, 1:] - starts[:, 1] * along[:, :1]) / below
    t[~((t > 0) & (u >= -1e-9) & (u <= 1 + 1e-9))] = 0
    return np.asarray(t.max(axis=1))


def _fitted(points: Points, cropped: BoolImage, whole: FieldOfView) -> FieldOfView:
    """A circle where most points lie on one, else the convex hull of all."""
    free = points[~cropped]
    if len(free) >= RAYS // 6:
        circle, share = _circle(free)
        x, y, radius = (round(float(value), 2) for value in circle)
        across, down = (points.max(axis=0) + points.min(axis=0)) / 2
        # Points on a straight line lie on a circle, too: a large one, on either side.
        is_round = radius < max(whole.width, whole.height) and np.hypot(across - x, down - y) < radius
        if share >= LEAST_ON_CIRCLE and is_round:
            return FieldOfView(whole.width, whole.height, circle=(x, y, radius))
    hull = cv2.convexHull(points.astype(np.float32))
    corners = cv2.approxPolyDP(hull, 0.7, closed=True)[:, 0]
    polygon = tuple((round(float(x), 1), round(float(y), 1)) for x, y in corners)
    return FieldOfView(whole.width, whole.height, polygon=polygon)


def _circle(points: Points) -> tuple[Points, float]:
    """Middle and radius through most of the points (Kasa, IEEE Trans. Instrum. Meas. 25, 1976; the worst are
    left out again and again), and the share of points on it."""
    circle, apart = _kasa(points, points)
    for _ in range(5):
        tolerance = max(_tolerance(circle), 2 * float(np.median(apart)))
        circle, apart = _kasa(points[apart <= tolerance], points)
    return circle, float(np.mean(apart <= _tolerance(circle)))


def _kasa(kept: Points, points: Points) -> tuple[Points, Points]:
    """The circle through the kept ones, and how far each point lies off it."""
    center = kept.mean(axis=0)
    about = kept - center
    matrix = np.empty((len(about), 3))
    matrix[:, :2], matrix[:, 2] = 2 * about, 1
    normal, right = matrix.T @ matrix, matrix.T @ (about**2).sum(axis=1)
    if np.linalg.det(normal) == 0:
        return np.array([*center, 0.0]), np.hypot(*(points - center).T)
    x, y, rest = np.linalg.solve(normal, right)
    radius = float(np.sqrt(max(rest + x**2 + y**2, 0.0)))
    x, y = x + center[0], y + center[1]
    return np.array([x, y, radius]), np.abs(np.hypot(points[:, 0] - x, points[:, 1] - y) - radius)


def _tolerance(circle: Points) -> float:
    return float(max(CIRCLE_TOLERANCE, CIRCLE_TOLERANCE * circle[2] / 1000))
