"""Depth of a clip from the images of both its eyes, and whether these are a rectified pair."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from renderer.clip import ByteImage, Clip, ClipError, Frame
from renderer.depth.levelling import level_of
from renderer.depth.row_offset import (
    PAIRS,
    VARYING,
    Rows,
    is_swapped,
    moved_down,
    own_offset,
    own_offsets,
    row_offset,
    scatter,
    unseen,
)
from renderer.depth.stereo import FEWEST_FEATURES, disparity, feature_matches, feature_shifts
from renderer.depth.stereo_pairs import RightEye
from renderer.evenly import evenly_floored
from renderer.listing import count, listed
from renderer.readers.image_files.used_bits import ALL, said_of_unread_bits, used_bits
from renderer.readers.image_folders.frames import is_seen_by_assumption

Found = TypeVar("Found")

LARGEST_VERTICAL_OFFSET = 1.5
"""Median distance in px between the rows of what both eyes see, beyond which a pair is not rectified; what is
the same in all rows of a clip counts for nothing, as the right images can be moved by it."""

_SAME = 0.25  # px, below which features of two images are in one place.
_REMEMBERED = 4  # Frames whose depth is kept, for sliders that ask for the same one again.


class _UnrectifiedError(ClipError):
    """Rows of a pair are apart by distances that differ."""


@dataclass(frozen=True)
class _Rig:
    """Depth of a rectified pair is focal length * baseline / disparity."""

    baseline: float
    unit: str


def with_stereo_depth(clip: Clip, right: RightEye, baseline: float | None) -> Clip:
    """The clip with depth matched between left and right images as each frame is read.

    Depth is focal length * baseline / disparity: without a calibration, as if the eyes looked in parallel,
    with the principal points of both in the middle, which a notice says. The baseline is `baseline` in mm,
    else that of the clip, else 1: then lengths are in units of it. A few pairs are checked: whether they
    show one scene and are rectified.

    Raises:
        ClipError: images of different sizes, that show different scenes, are swapped, or whose rows are
            apart by more than LARGEST_VERTICAL_OFFSET; or a camera that moves by known lengths with a
            baseline that is not known.
    """
    if right.size != clip.size:
        wanted = f"{clip.size[0]}x{clip.size[1]} as the left one"
        came = f"{right.size[0]}x{right.size[1]}"
        raise ClipError(f"expected a right image of {wanted}, got {came}: {right.path}")
    right, levelled, (rows, swapped) = _level(clip, right)
    rig = _rig(clip, baseline)

    @lru_cache(_REMEMBERED)
    def read_frame(index: int) -> Frame:
        frame = clip.read_frame(index)
        other = right.read(index)
        down = rows.usual
        if rows.vary or swapped:
            shifts = feature_shifts(frame.image, other)
            if is_swapped(shifts):
                return replace(frame, depth=np.zeros(other.shape[:2], np.float32))
            down = own_offset(shifts, rows.usual) if rows.vary else down
        found = disparity(frame.image, moved_down(other, down) if down else other)
        found[unseen(down)] = 0
        return replace(frame, depth=_depth(found, frame.camera.fx * rig.baseline))

    told = (*levelled, *rows.said(), *_said_swapped(clip, swapped))
    said = (*clip.notices, *told, _said(rig, _assumed(clip, is_doubtful=bool(levelled) or rows != Rows())))
    return replace(
        clip, read_frame=read_frame, has_depth=True, unit=rig.unit, depth_origin="stereo", notices=said
    )


def _depth(found: NDArray[np.float32], product: float) -> NDArray[np.float32]:
    known = found > 0
    return np.where(known, product / np.where(known, found, 1), 0).astype(np.float32)


def _rig(clip: Clip, baseline: float | None) -> _Rig:
    if baseline is not None:
        return _Rig(baseline, "mm")
    if clip.baseline is not None:
        return _Rig(clip.baseline, clip.unit)
    if not clip.camera_is_fixed:
        hint = "expected a baseline for a camera that moves, got none (--baseline gives it in mm)"
        raise ClipError(f"{hint}: {clip.path}")
    return _Rig(1.0, "scene units")


def _assumed(clip: Clip, *, is_doubtful: bool) -> str:
    """What lengths and shapes rest on where no calibration says it; empty where one does."""
    if not is_seen_by_assumption(clip):
        return ""
    doubt = ", doubtful as their rows are apart" if is_doubtful else ""
    eyes = f"eyes that look in parallel with principal points in the middle{doubt}"
    return f"{eyes}, and on a field of view of {clip.cameras[0].field_of_view:.0f} degrees"


def _said(rig: _Rig, assumed: str) -> str:
    by = "depth is matched between left and right images"
    if rig.unit == "mm":
        rest = f"; lengths in mm rest on {assumed} (--calibration FILE says how the eyes are)"
        return f"{by}, {rig.baseline:.4g} mm apart{rest if assumed else ''}"
    way = "--baseline or --calibration gives one in mm"
    rest = f"; shapes rest on {assumed} (--field-of-view states another)"
    return f"{by} with an unknown baseline: lengths have no scale ({way}){rest if assumed else ''}"


def _said_swapped(clip: Clip, swapped: Sequence[int]) -> tuple[str, ...]:
    """Where only some of the frames looked at are swapped: a part of the clip may still be good."""
    if not swapped:
        return ()
    frames = listed([clip.labels[at] for at in swapped])
    way = "such frames have no depth; --frames trains on a part without them"
    return (f"left and right eye are swapped in {frames}, of a few frames looked at: {way}",)


def _level(clip: Clip, right: RightEye) -> tuple[RightEye, tuple[str, ...], tuple[Rows, list[int]]]:
    """The right eye, turned and stretched to the rows of the left one where only that is wrong and no
    calibration says how they stand; the notice of it; and what `_judged` returns then. Raises ClipError as
    that."""
    try:
        return right, (), _judged(clip, right)
    except _UnrectifiedError as error:
        if not is_seen_by_assumption(clip):
            raise
        level = level_of([found for _, found in _seen_by_both(feature_matches, clip, right)])
        if level is None:
            raise
        turned = replace(right, read=lambda index: level.applied(right.read(index)))
        try:
            return turned, (level.said(),), _judged(clip, turned)
        except _UnrectifiedError:
            raise error from None


def _judged(clip: Clip, right: RightEye) -> tuple[Rows, list[int]]:
    """How far the rows of the eyes are apart, and the frames whose eyes are swapped, by a few pairs.

    The first pair says whether they show one scene, or the pair with most features where the first has few:
    a frame may be blurred or dark.

    Raises ClipError: no rectified pair, or one that is swapped or is one image twice.
    """
    looked_at = dict(_seen_by_both(feature_shifts, clip, right))
    every = list(looked_at.values())
    if len(every[0]) < FEWEST_FEATURES:
        every = sorted(every, key=len, reverse=True)
    shifts = every[0]
    _require_one_scene(shifts, len(every), clip, right)
    rows = _rows_of(every, clip, right)
    if (across := np.median(shifts[:, 0])) <= 0:
        shift = f"the right one shows objects {-across:.0f} px farther right"
        came = f"{right.names} swapped, {shift}"
        raise ClipError(f"expected a left and a right image, got {came}: {clip.path}")
    return rows, [at for at, each in looked_at.items() if is_swapped(each)]


def _require_one_scene(shifts: NDArray[np.float64], pairs: int, clip: Clip, right: RightEye) -> None:
    """Raises ClipError: too few features are in both images of the best of so many pairs, or the two are the
    same image."""
    if len(shifts) < FEWEST_FEATURES:
        found = f"{len(shifts)} features in common in the best of {count(pairs, 'pair')} looked at"
        needed = f"({FEWEST_FEATURES} are needed){_dark(clip, right)}: {clip.path}"
        raise ClipError(f"expected a stereo pair, got images with {found} {needed}")
    if np.median(np.abs(shifts[:, :2])) < _SAME:
        came = f"the same image twice for {right.names}"
        raise ClipError(f"expected a left and a right image, got {came}: {clip.path}")


def _rows_of(every: Sequence[NDArray[np.float64]], clip: Clip, right: RightEye) -> Rows:
    """How far rows are apart by the shifts of a few pairs. Raises _UnrectifiedError: by distances that differ
    within an image."""
    own, first = own_offsets(every), every[0]
    if max([float(np.median(np.abs(first[:, 1]))), *np.abs(own)]) <= LARGEST_VERTICAL_OFFSET:
        return Rows()
    usual, down = row_offset(every)
    rows = Rows(usual, len(own) > 1 and bool(np.ptp(own) > VARYING))
    left = scatter(first) if rows.vary else down
    if left > LARGEST_VERTICAL_OFFSET:
        limit = f"rows at most {LARGEST_VERTICAL_OFFSET} px apart"
        where = f"{right.names}; --calibration FILE rectifies them: {clip.path}"
        raise _UnrectifiedError(f"expected a rectified pair, {limit}, got {left:.1f} px between {where}")
    return rows


def _dark(clip: Clip, right: RightEye) -> str:
    """Why images show so little, and what to do, as the end of a sentence; empty where they are not dark."""
    unread = said_of_unread_bits(len(clip), used_bits((right.path,))) if clip.bits == ALL else ()
    return "".join(f"; {said}" for said in unread)


def _seen_by_both(
    find: Callable[[ByteImage, ByteImage], Found], clip: Clip, right: RightEye
) -> Iterator[tuple[int, Found]]:
    """What is found in a few pairs, by their frame. A later one that cannot be read is passed over: it may be
    outside of the part that is trained on. Raises ClipError: the first cannot be read."""
    indices = evenly_floored(range(len(clip)), PAIRS)
    for at in indices:
        try:
            yield at, find(clip.read_image(at), right.read(at))
        except ClipError:
            if at == indices[0]:
                raise
