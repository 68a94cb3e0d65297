"""Whether the frames of a clip contradict it when it says that its camera is fixed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera, FloatArray
from renderer.clip import BoolImage, ByteImage, Clip, Frame
from renderer.evenly import evenly
from renderer.poses.pictures import trackable
from renderer.rigid import rigid_fit

PICTURE_SHIFT = 0.05
"""Of the width: a background that moves farther across the picture shows other tissue."""
RIGID_SHIFT = 0.035
"""Of its distance: tissue that moves farther as one rigid body is seen by a camera that moves."""
RIGID_MISFIT = 0.015
"""Of the distance: misfit up to which a point belongs to the rigid body."""

_WIDTH = 320  # px of the pictures that are looked at
_MOMENTS = 13
_FEATURES = 300
_KEPT = 0.25  # Of the features, or the tracks say nothing.
# Most frames between two moments, for a camera that goes away and comes back meanwhile; the more where
# features are lost through the fewer.
_GLIMPSES = (3, 24)
_FEWEST = 20
# Of a frame's features in the next: where fewer are found, one does not follow from the other.
_FOLLOWED = 0.4
# Of the width, by which the median of those few moves at most where the rest of the view is covered: 0.018
# on phantoms that are covered by 70 to 80 %, and at least 0.039, by chance, where the view jumps.
_STAYED = 0.025
_REFUTING = 0.25  # Share of features that stay: the others are no three in four.
_AROUND = 4  # Features side by side that stay where they are, as by chance none do where the view jumps.
_CLOSING = 1.0  # px between a feature and where tracking it there and back ends.


POSES_MISSING = "camera poses are missing"


def contradicted(moves: str) -> str:
    """The sentence that says so of a clip with one camera; `moves`: by `camera_motion`."""
    return f"the clip has a fixed camera, but {moves}: {POSES_MISSING}"


def camera_motion(clip: Clip) -> str | None:
    """In words, how the background of a clip with one camera moves as if the camera did; else None.

    Features on the tissue are tracked (Lucas and Kanade, 1981; there and back) through 13 training
    frames, from the first and from the middle one. Between two of these frames, three in four tracks
    move by more than PICTURE_SHIFT; or, where depth is known in mm, four in five fit one rigid motion to
    RIGID_MISFIT while three in four move by more than RIGID_SHIFT. Tissue that is pulled or breathes
    deforms and stays below both.

    The bounds were chosen on phantoms of seeds 0 to 3 and on training frames of the pulling clip, which
    reach 0.032 and, as rigid bodies, 0.027 where the camera stands still; rigid bodies reach at least
    0.041 where it moves. Seeds 4 to 7 give 0.034, 0.029 and 0.062. A sinus, a laparoscopy and a
    fetoscopy with moving cameras reach 0.07 to 0.09 of the width. A small motion of a camera is not
    noticed without depth, or with depth noisier than RIGID_MISFIT. Frames that show nothing to track are
    passed over; and where few of a frame's features are found in the next one, though the frames on either
    side follow from each other, the view jumps: 0.3 of them by chance, and 0.6 where a camera stands still
    and tissue is pulled. If those few hardly move, or one place of the view stays and the rest comes back,
    the rest is covered, and nothing jumps. Where nothing else tells, what lies between two of the frames is
    looked at: a camera may have gone and come back. That goes by what is where it was in both of them, which
    what sweeps through is not. Reads 13 frames, and of a camera that stands still 36 images, or up to 324
    where views are covered: for the start of a training, not for opening a clip.

    Raises:
        ClipError: a frame cannot be read.
    """
    if not clip.camera_is_fixed or len(clip.train_indices) < 2:
        return None
    taken = evenly(clip.train_indices, _MOMENTS)
    # Depth without a unit may be a guess, which is no witness.
    has_scale = clip.unit == "mm"
    looked_at = (_moment(clip.read_frame(index), has_scale) for index in taken)
    moments = [moment for moment in looked_at if len(_features(moment)) >= _FEWEST]
    if len(moments) < 2:
        return None
    starts = sorted({0, len(moments) // 2})
    runs = [(moments[start:], _tracks(moments[start:], _features(moments[start]))) for start in starts]
    across = max((_picture_shift(tracks) for _, tracks in runs), default=0.0)
    rigid = max((_rigid_shift(seen, tracks) for seen, tracks in runs), default=0.0)
    if across > PICTURE_SHIFT:
        return f"the background moves by {100 * across:.0f} % of the image width"
    if rigid > RIGID_SHIFT:
        return f"the tissue moves as one rigid body, by {100 * rigid:.0f} % of its distance"
    if any(_breaks(seen, tracks) for seen, tracks in runs) and (jump := _jump(moments)) is not None:
        before, after = (clip.labels[moment.index] for moment in jump)
        return f"the view jumps between the frames {before} and {after}"
    for pair in pairwise(moments):
        if (meanwhile := _shift_between(clip, *pair)) > PICTURE_SHIFT:
            return f"the background moves by {100 * meanwhile:.0f} % of the image width and comes back"
    return None


@dataclass(frozen=True, eq=False)
class _Moment:
    """A frame made small."""

    index: int
    """Of the frame."""
    grey: ByteImage
    """(h, _WIDTH), of even brightness and contrast."""
    usable: BoolImage
    """(h, _WIDTH), True on lit tissue away from its border."""
    camera: Camera
    depth: NDArray[np.float32] | None
    """As in the frame, at full size; None where it says nothing."""


def _moment(frame: Frame, has_scale: bool) -> _Moment:
    size = _WIDTH, max(1, round(frame.camera.height * _WIDTH / frame.camera.width))
    depth = frame.depth if has_scale else None
    return _Moment(frame.index, *trackable(frame, size), frame.camera.resized(*size), depth)


def _shift_between(clip: Clip, before: _Moment, after: _Moment) -> float:
    """As `_picture_shift`, of what is in one place at two moments, through what lies between them: images,
    without masks and depth."""
    places = _features(before)
    places = places[_stay(before, after, places)]
    if len(places) < _FEWEST:
        return 0.0
    inside = [index for index in clip.train_indices if before.index <= index <= after.index]
    shift = 0.0
    for most in _GLIMPSES:
        number = min(most, (len(inside) - 1) // 2)  # Every other frame is enough.
        glimpses = [_glimpse(clip, index) for index in evenly(inside, number + 2)[1:-1]]
        if all(_stay(before, glimpse, places).mean() > _REFUTING for glimpse in glimpses):
            break
        tracks = _tracks([before, *glimpses], places, _FOLLOWED)
        shift = max(shift, _picture_shift(tracks))
        if len(tracks) > len(glimpses):
            break
    return shift


def _glimpse(clip: Clip, index: int) -> _Moment:
    image = clip.read_image(index)
    every = np.ones(image.shape[:2], dtype=bool)
    return _moment(Frame(index, clip.times[index], image, clip.cameras[index], every, every), False)


def _tracks(moments: list[_Moment], first: FloatArray, least: float = _KEPT) -> FloatArray:
    """(M, F, 2) column and row of features (F, 2) of the first moment, NaN once lost; M ends with too few:
    less than this share of them."""
    places = [first]
    for before, after in pairwise(moments):
        moved = _followed(before.grey, after.grey, places[-1])
        if np.isfinite(moved[:, 0]).sum() < max(_FEWEST, least * len(moved)):
            break
        places.append(moved)
    return np.stack(places)


def _features(moment: _Moment) -> FloatArray:
    """(F, 2) column and row of what can be tracked."""
    usable = moment.usable.astype(np.uint8)
    found: Any = cv2.goodFeaturesToTrack(moment.grey, _FEATURES, 0.01, 5, mask=usable)
    return np.zeros((0, 2)) if found is None else found[:, 0].astype(np.float64)


def _breaks(moments: list[_Moment], tracks: FloatArray) -> bool:
    """Whether many of the tracks end from one moment to the next."""
    known = np.isfinite(tracks[:, :, 0]).sum(axis=1)
    return len(tracks) < len(moments) or bool((known[1:] < _FOLLOWED * known[:-1]).any())


def _follows(before: _Moment, after: _Moment) -> bool:
    places = _features(before)
    moved = _followed(before.grey, after.grey, places)
    found = np.isfinite(moved[:, 0])
    if found.mean() >= _FOLLOWED:
        return True
    apart = np.linalg.norm((moved - places)[found], axis=1)
    return len(apart) >= _FEWEST and bool(np.median(apart) < _STAYED * _WIDTH)


def _jump(moments: list[_Moment]) -> tuple[_Moment, _Moment] | None:
    """The first two moments of which the second does not follow from the first, while those beside them
    follow from each other: else it is noise, or smoke. Nor is it where the view is covered."""
    pairs = list(pairwise(moments))
    follows = [_follows(*pair) for pair in pairs]
    before_cover = 0
    for place, pair in enumerate(pairs[:-1]):
        breaks = not follows[place] and follows[place + 1] and all(follows[max(place - 1, 0) : place])
        if breaks and not _is_seen_in(moments[:before_cover], pair[1:]):
            before_cover = place + 1
            sides = moments[:before_cover], moments[before_cover:]
            if not (_keeps_a_place(*pair) and _is_seen_in(*sides)):
                return pair
    return None


def _keeps_a_place(before: _Moment, after: _Moment) -> bool:
    """Whether some features side by side are where they were."""
    places = _features(before)
    # From coarser levels, what covers the rest would lead them astray.
    stays = _stay(before, after, places, levels=0)
    between = np.linalg.norm(places[:, None] - places, axis=2)
    nearest = np.argsort(between, axis=1)[:, :_AROUND]
    return bool(stays[nearest].all(axis=1).any())


def _stay(before: _Moment, after: _Moment, places: FloatArray, levels: int = 3) -> BoolImage:
    """(F,) which features (F, 2) of the first moment are where they were."""
    apart = np.linalg.norm(_followed(before.grey, after.grey, places, levels) - places, axis=1)
    return np.asarray(apart < _STAYED * _WIDTH)


def _is_seen_in(moments: Sequence[_Moment], others: Sequence[_Moment]) -> bool:
    """Whether one of the others shows what one of the moments did."""
    return any(_follows(one, other) for one in moments for other in others)


def _followed(before: ByteImage, after: ByteImage, places: FloatArray, levels: int = 3) -> FloatArray:
    """Where the features (F, 2) of one picture are in the next, NaN where that is not certain."""
    known = np.isfinite(places[:, 0])
    start = places[known].astype(np.float32)[:, None]
    reach: dict[str, Any] = {"winSize": (15, 15), "maxLevel": levels}
    there, found, _ = cv2.calcOpticalFlowPyrLK(before, after, start, start.copy(), **reach)
    back, found_back, _ = cv2.calcOpticalFlowPyrLK(after, before, there, start.copy(), **reach)
    apart = np.linalg.norm((back - start)[:, 0], axis=1)
    certain = (found[:, 0] > 0) & (found_back[:, 0] > 0) & (apart < _CLOSING)
    moved = np.full_like(places, np.nan)
    moved[np.flatnonzero(known)[certain]] = there[certain, 0]
    return moved


def _pairs(series: FloatArray) -> Iterator[tuple[FloatArray, FloatArray]]:
    """The points (N, D) known at two of the moments of a series (M, F, D), for every two."""
    for one, other in combinations(series, 2):
        both = np.isfinite(one[:, 0]) & np.isfinite(other[:, 0])
        if both.sum() >= _FEWEST:
            yield one[both], other[both]


def _picture_shift(tracks: FloatArray) -> float:
    """What three in four tracks move by at least between two moments, in widths of the picture."""
    return max((_most_move(one, other) for one, other in _pairs(tracks)), default=0.0) / _WIDTH


def _rigid_shift(moments: list[_Moment], tracks: FloatArray) -> float:
    """The same in space, in distances of the tissue, between moments at which it moved as one body."""
    if moments[0].depth is None or not len(tracks):
        return 0.0
    points = np.stack([_lifted(moment, places) for moment, places in zip(moments, tracks, strict=False)])
    largest = 0.0
    for one, other in _pairs(points):
        distance = float(np.median(one[:, 2]))
        rotation, shift = rigid_fit(one, other)
        misfit = np.linalg.norm(one @ rotation.T + shift - other, axis=1)
        if np.quantile(misfit, 0.8) < RIGID_MISFIT * distance:
            largest = max(largest, _most_move(one, other) / distance)
    return largest


def _lifted(moment: _Moment, places: FloatArray) -> FloatArray:
    """(F, 3) in camera axes behind the features (F, 2), NaN where lost or without depth."""
    assert moment.depth is not None
    camera, depth = moment.camera, moment.depth
    points = np.full((len(places), 3), np.nan)
    known = np.flatnonzero(np.isfinite(places[:, 0]))
    x, y = places[known].T + 0.5
    scale = depth.shape[1] / camera.width
    columns = np.clip(x * scale, 0, depth.shape[1] - 1).astype(np.int64)
    rows = np.clip(y * scale, 0, depth.shape[0] - 1).astype(np.int64)
    z = depth[rows, columns].astype(np.float64)
    lifted = np.stack([(x - camera.cx) / camera.fx * z, (y - camera.cy) / camera.fy * z, z], axis=1)
    points[known[z > 0]] = lifted[z > 0]
    return points


def _most_move(one: FloatArray, other: FloatArray) -> float:
    """The distance that three in four points exceed."""
    return float(np.quantile(np.linalg.norm(other - one, axis=1), 0.25))
