"""The rim of a field of view and the circle through it, in plain numpy: what kernels are compared with."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from enhance.field_circle import CIRCLE_TOLERANCE, Points
from enhance.field_rim import ALONG, BESIDE_RAYS, BEYOND, DEVIATIONS, DOWN, NEAR, RAYS, REACH, RIM
from enhance.field_shape import AHEAD, LEAST_CUT, LEAST_STRAIGHT, MOST_SLANT, STRAIGHT
from enhance.image import AnyImage, BoolImage, full_scale


def rim_of(
    pixels: AnyImage, outline: Points, threshold: float, most: float, pixel: int
) -> tuple[Points, BoolImage, BoolImage]:
    """As `enhance.field_rim.left_along_rays`: points, which the border of the picture crops, and up to which
    it is lit."""
    height, width = pixels.shape[:2]
    ends = np.array([width, height])
    middle = (outline.max(axis=0) + outline.min(axis=0)) / 2
    angles = np.arange(RAYS) * (2 * np.pi / RAYS)
    along = np.stack((np.cos(angles), np.sin(angles)), axis=1)
    far, reach = distances(middle, along, outline), REACH * pixel
    radii = (np.floor(far - reach) + 0.5)[:, None] + np.arange(int(2 * reach) + 1)
    x, y = (np.floor(middle[axis] + radii * along[:, axis, None]).astype(np.intp) for axis in (0, 1))
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    value = pixels[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)] * (255 / full_scale(pixels.dtype))
    value = value.max(axis=2) if value.ndim == 3 else value
    outer = value[inside.all(axis=1), -int(reach) :]
    if outer.size:
        level, high = np.quantile(outer, (0.5, 0.84))
        threshold = max(threshold, min(float(level + DEVIATIONS * (high - level)), most))
    some, last = last_lit(inside & (value > threshold))
    index = np.arange(RAYS)
    found = np.where(some, radii[index, last] + 0.5, far)
    margin = np.where(some, NEAR, pixel)[:, None]
    at = middle + found[:, None] * along
    beside = ((at < margin) | (at > ends - margin)).any(axis=1)
    cropped = np.where(some, ~inside[index, np.minimum(last + 2, inside.shape[1] - 1)], beside)
    points = middle + np.where(cropped, found, found - RIM)[:, None] * along
    # A corner of the picture that lies between two rays belongs to the field where both reach the border.
    corners = np.array([(x, y) for x in (0, width) for y in (0, height)], dtype=np.float64)
    turns = np.arctan2(*(corners - middle).T[::-1]) * (RAYS / (2 * np.pi))
    reached = corners[cropped[np.floor(turns).astype(int)] & cropped[np.ceil(turns).astype(int) % RAYS]]
    points = np.concatenate((points, reached))
    margin = np.concatenate((margin, np.full((len(reached), 1), NEAR)))
    cropped = np.concatenate((cropped, np.ones(len(reached), bool)))
    beyond = np.where(points < margin, -BEYOND, np.where(points > ends - margin, ends + BEYOND, points))
    lit = np.concatenate((some, np.zeros(len(reached), bool))) & ~cropped
    return np.where(cropped[:, None], beyond, points), cropped, lit


def last_lit(bright: BoolImage) -> tuple[BoolImage, NDArray[np.intp]]:
    """Whether any sample of each ray begins a bright run inwards, and the outermost one that does."""
    lit = bright.copy()
    # Four of five inwards: single ones are noise.
    counts = np.cumsum(bright, axis=1)
    lit[:, 5:] &= counts[:, 5:] - counts[:, :-5] >= 4
    return lit.any(axis=1), lit.shape[1] - 1 - lit[:, ::-1].argmax(axis=1)


def fall_of(values: NDArray[np.float32], threshold: float) -> int:
    """As `enhance.field_rim._fall`."""
    some, last = last_lit(values > threshold)
    count = values.shape[1]
    means = [threshold]
    for away in range(1, count):
        beyond = [
            ray[end + away] for ray, end in zip(values[some], last[some], strict=True) if end + away < count
        ]
        inside = [float(value) for value in beyond if value >= 0]
        means.append(sum(inside) / len(inside) if inside else threshold)
    down = min(means) + DOWN * (threshold - min(means))
    return next((away for away in range(1, count) if means[away] <= down), count)


def distances(middle: Points, along: Points, outline: Points) -> Points:
    """From a point within a convex outline to it, along each direction."""
    starts, ends = outline - middle, np.roll(outline, -1, axis=0) - middle
    sides = ends - starts
    below = along[:, :1] * sides[:, 1] - along[:, 1:] * sides[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (starts[:, 0] * sides[:, 1] - starts[:, 1] * sides[:, 0]) / below
        u = (starts[:, 0] * along[:, 1:] - starts[:, 1] * along[:, :1]) / below
    t[~((t > 0) & (u >= -1e-9) & (u <= 1 + 1e-9))] = 0
    return np.asarray(t.max(axis=1))


def circle_of(points: Points) -> tuple[Points, float]:
    """Middle and radius through most of the points, and the share of points on it."""
    circle, apart = kasa(points, points)
    for _ in range(5):
        tolerance = max(tolerance_of(circle), 2 * float(np.median(apart)))
        circle, apart = kasa(points[apart <= tolerance], points)
    return circle, float(np.mean(apart <= tolerance_of(circle)))


def kasa(kept: Points, points: Points) -> tuple[Points, Points]:
    """The circle through the kept ones by all three normal equations, and how far each point lies off it."""
    center = kept.mean(axis=0)
    about = kept - center
    matrix = np.column_stack((2 * about, np.ones(len(about))))
    x, y, rest = np.linalg.solve(matrix.T @ matrix, matrix.T @ (about**2).sum(axis=1))
    radius = np.sqrt(rest + x**2 + y**2)
    x, y = x + center[0], y + center[1]
    return np.array([x, y, radius]), np.abs(np.hypot(points[:, 0] - x, points[:, 1] - y) - radius)


def straight_levels_of(points: Points, lit: BoolImage, radius: float) -> Points:
    """As `enhance.field_shape._straight_levels`."""
    levels = np.full(8, radius)
    for turn in range(8):
        depth = points @ (np.cos(turn * np.pi / 4), np.sin(turn * np.pi / 4))
        share = depth / np.hypot(*points.T)
        level = np.median(depth[share > AHEAD]) if (share > AHEAD).any() else radius
        nearest = radius - max(LEAST_CUT * radius, 2 * tolerance_of(np.array([0, 0, radius])))
        passing = share > level / radius
        straight = lit & (abs(depth - level) <= tolerance_of(np.array([0, 0, radius])))
        if 0 < level < nearest and straight[passing].mean() >= LEAST_STRAIGHT:
            levels[turn] = level
    return levels


def tolerance_of(circle: Points) -> float:
    return float(max(CIRCLE_TOLERANCE, CIRCLE_TOLERANCE * circle[2] / 1000))


def ring_of(field: NDArray[np.uint8]) -> BoolImage:
    """Pixels of a field one away from its outline; what lies beyond the picture counts as field."""
    padded = np.pad(field > 0, 2, constant_values=True)
    height, width = field.shape

    def eroded(reach: int) -> BoolImage:
        steps = range(2 - reach, 3 + reach)
        shifted = [padded[y : y + height, x : x + width] for y in steps for x in steps]
        return np.asarray(np.all(shifted, axis=0))

    return eroded(1) & ~eroded(2)


def runs_of(corners: Points, width: int, height: int) -> tuple[bool, float]:
    """As `enhance.field_shape._runs_of`, but for the corners to tenths."""
    outside, after = np.hstack((corners < 0, corners > (width, height))), np.roll(corners, -1, axis=0)
    sides = (after - corners)[~(outside & np.roll(outside, -1, axis=0)).any(axis=1)]
    lengths, whole = np.hypot(*sides.T), sides.sum(axis=0)
    is_line = np.hypot(*whole) > STRAIGHT * lengths.sum()
    straight = lengths[are_straight(sides)].sum() / max(lengths.sum(), 1)
    return bool(is_line and not are_straight(whole[None])[0]), float(straight)


def are_straight(sides: Points) -> BoolImage:
    turns = np.degrees(np.arctan2(sides[:, 1], sides[:, 0])) % 45
    return np.asarray(np.minimum(turns, 45 - turns) <= MOST_SLANT)


def dim_beside(
    low: NDArray[np.uint8], factor: int, circle: tuple[float, float, float], most: float
) -> tuple[int, int]:
    """As `enhance.field_rim.dim_beside`."""
    x, y = ((circle[2] * ALONG[::BESIDE_RAYS] + circle[:2]) / factor).astype(int).T
    seen = (x >= 0) & (y >= 0) & (x < low.shape[1]) & (y < low.shape[0])
    return np.count_nonzero(seen), np.count_nonzero(low[y[seen], x[seen]] <= most)
