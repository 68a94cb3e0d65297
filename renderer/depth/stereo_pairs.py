"""Clips whose every picture has one of the right eye beside it: which belong together, and their depth."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from renderer.budget import OverBudget
from renderer.clip import ByteImage, Clip, ClipError, Frame, numbered
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
from renderer.depth.stereo import disparity, feature_matches, feature_shifts
from renderer.evenly import evenly_floored
from renderer.listing import count, listed
from renderer.readers.clip_files import folders_in
from renderer.readers.image_files.file_kinds import is_picture
from renderer.readers.image_files.pictures import common_size, read_rgb
from renderer.readers.image_files.used_bits import ALL
from renderer.readers.image_folders.frames import is_seen_by_assumption, open_images
from renderer.readers.image_folders.picture_kinds import kind_by_name

Found = TypeVar("Found")

LARGEST_VERTICAL_OFFSET = 1.5
"""Median distance in px between the rows of what both eyes see, beyond which a pair is not rectified; what is
the same in all rows of a clip counts for nothing, as the right images can be moved by it."""

_FEWEST_FEATURES = 20
_SAME = 0.25  # px, below which features of two images are in one place.
_REMEMBERED = 4  # Frames whose depth is kept, for sliders that ask for the same one again.
_REMEMBERED_PAIRS = 32  # Whether they show one scene, which opening a folder asks several times.
_LEFT = re.compile(r"left|(?<=[\d_-])l$|^l(?=$|[\d_-])", re.IGNORECASE)
_RIGHT = {"left": "right", "Left": "Right", "LEFT": "RIGHT", "l": "r", "L": "R"}
_CAMERAS = {"image_02": "image_03", "image_00": "image_01", "cam0": "cam1"}
"""Folders of the left eye and of the right one, as KITTI and EuRoC call them."""


class _UnrectifiedError(ClipError):
    """Rows of a pair are apart by distances that differ."""


@dataclass(frozen=True)
class _Rig:
    """Depth of a rectified pair is focal length * baseline / disparity."""

    baseline: float
    unit: str


@dataclass(frozen=True, eq=False)
class RightEye:
    """The pictures of the right eye, one a frame."""

    read: Callable[[int], ByteImage]
    size: tuple[int, int]
    """Width and height in pixels."""
    names: str
    """What a person calls the first pair."""
    path: Path
    """Of the first picture, or of the file with both eyes."""


def right_name(name: str) -> str | None:
    """What the file or folder of the right eye is called; None when `name` is not one of the left.

    left, Left and LEFT become right; l and L at the end of the stem, after a digit, "_" or "-", or at its
    beginning before one, become r; EndoNeRF's images/ goes with images_right/, KITTI's image_02/ with
    image_03/. What is called a depth map or a mask is of no eye.
    """
    if name in ("images", *_CAMERAS):
        return {"images": "images_right", **_CAMERAS}[name]
    if kind_by_name(Path(name).stem) is not None:
        return None
    stem, suffix = Path(name).stem, Path(name).suffix
    swapped, count = _LEFT.subn(lambda found: _RIGHT.get(found[0], "right"), stem, count=1)
    return swapped + suffix if count else None


def is_stereo_folder(path: Path) -> bool:
    """Whether the folder holds left and right pictures in two folders, or side by side.

    Side by side their names are not enough: single images of a patient's two eyes are called the same.
    """
    if _left_folder(path) is not None:
        return True
    lefts = _paired_names(entry.name for entry in path.iterdir() if is_picture(entry))
    tried = dict.fromkeys((*lefts[:1], *lefts[len(lefts) // 2 :][:1], *lefts[-1:]))
    return any(_may_be_one_scene(path / left, path / (right_name(left) or left)) for left in tried)


def eye_folders(path: Path) -> tuple[Path, ...]:
    """The folders of the left and of the right eye in a folder; none where it has no such two."""
    left = _left_folder(path)
    return (left, left.with_name(right_name(left.name) or "")) if left else ()


def open_stereo_folder(path: Path, field_of_view: float, bits: int = ALL) -> Clip:
    """The left pictures of a folder as a clip; `with_stereo_depth` makes use of the right ones. `bits`: that
    values of 16-bit images use.

    Raises:
        ClipError: nothing that can be read, as `open_images`.
    """
    lefts = _left_folder(path)
    if lefts is None:
        return _left_half(open_images(path, field_of_view, bits))
    return replace(open_images(lefts, field_of_view, bits), path=path, name=path.resolve().name)


def right_pictures(clip: Clip) -> tuple[Path, ...]:
    """The right eye's picture of every frame, found beside the left one's; empty without any.

    Raises:
        ClipError: some frames have a right picture and others none.
    """
    if not clip.path.is_dir():
        return ()
    folder, partners = _first_partners(clip.path, clip.labels)
    found = tuple(path for path in partners if path is not None)
    if found and len(found) < len(partners):
        lacking = [name for name, path in zip(clip.labels, partners, strict=True) if path is None]
        counts = f"{len(found)} right images for {len(partners)} left ones"
        raise ClipError(f"expected stereo pairs, got {counts}, none for {listed(lacking)}: {folder}")
    return found


def right_files(path: Path, names: Sequence[str]) -> tuple[Path, ...]:
    """What `right_pictures` takes for pictures of these names in the folder `path`, as far as it is there."""
    return tuple(found for found in _first_partners(path, names)[1] if found is not None)


def right_eye(clip: Clip) -> RightEye | None:
    """What the right eye saw, in the clip's own file or in the pictures beside it; None: there is nothing.

    Raises:
        ClipError: as `right_pictures`, or pictures of several sizes.
    """
    if clip.read_right is not None:
        return RightEye(clip.read_right, clip.size, "both eyes in its frames", clip.path)
    rights = right_pictures(clip)
    if not rights:
        return None
    names = f"{clip.labels[0]} and {rights[0].name}"
    return RightEye(lambda index: read_rgb(rights[index], clip.bits), common_size(rights), names, rights[0])


def with_stereo_depth(clip: Clip, right: RightEye, baseline: float | None) -> Clip:
    """The clip with depth matched between its pictures and the right ones when a frame is read.

    Depth is focal length * baseline / disparity: without a calibration, as if the eyes looked in parallel,
    with the principal points of both in the middle, which a notice says. The baseline is `baseline` in mm,
    else that of the clip, else 1: then lengths are in units of it. A few pairs are looked at to see that
    its pictures are of one scene and rectified.

    Raises:
        ClipError: sizes that differ, pictures that do not match, that look swapped, or whose rows are
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
    doubt = ", which eyes whose rows lie apart make doubtful" if is_doubtful else ""
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
    """Of eyes that are not so from the first frame on; a part of the clip may still be good."""
    if not swapped:
        return ()
    frames = listed([clip.labels[at] for at in swapped])
    way = "such frames have no depth; --frames trains on a part without them"
    return (f"left and right eye are swapped in {frames}, of a few frames looked at: {way}",)


def _may_be_one_scene(left: Path, right: Path) -> bool:
    """What cannot be read may: its reader says what is wrong."""
    try:
        return _show_one_scene(left, right, (left.stat().st_mtime_ns, right.stat().st_mtime_ns))
    except (ClipError, OverBudget, OSError):
        return True


@lru_cache(_REMEMBERED_PAIRS)
def _show_one_scene(left: Path, right: Path, changed: tuple[int, int]) -> bool:
    """`changed`: when the files were, so that others of the same names are looked at again."""
    return len(feature_shifts(read_rgb(left), read_rgb(right))) >= _FEWEST_FEATURES


def _level(clip: Clip, right: RightEye) -> tuple[RightEye, tuple[str, ...], tuple[Rows, list[int]]]:
    """The right eye, level with the left one where only that is amiss and no calibration says how they are,
    what is said of it, and what `_judged` finds then. Raises ClipError as that."""
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
    """How far rows are apart; not at all where all of a few pairs look rectified. Whether they show one scene
    is judged by the first, or, where that shows too little, by the one that shows most. And those of the
    others whose eyes are swapped.

    Raises ClipError: they look like no rectified pair, or like one that is swapped or is one image twice.
    """
    looked_at = dict(_seen_by_both(feature_shifts, clip, right))
    every = list(looked_at.values())
    if len(every[0]) < _FEWEST_FEATURES:
        # One frame may be blurred or dark; the pair that shows most stands for all.
        every = sorted(every, key=len, reverse=True)
    shifts = every[0]
    if len(shifts) < _FEWEST_FEATURES:
        found = f"{len(shifts)} features in common in the best of {count(len(every), 'pair')} looked at"
        needed = f"({_FEWEST_FEATURES} are needed): {clip.path}"
        raise ClipError(f"expected a stereo pair, got images with {found} {needed}")
    if np.median(np.abs(shifts[:, :2])) < _SAME:
        came = f"the same image twice for {right.names}"
        raise ClipError(f"expected a left and a right image, got {came}: {clip.path}")
    across, rows = np.median(shifts[:, 0]), Rows()
    own = own_offsets(every)
    apart = float(np.median(np.abs(shifts[:, 1])))
    if max([apart, *np.abs(own)]) > LARGEST_VERTICAL_OFFSET:
        usual, down = row_offset(every)
        rows = Rows(usual, len(own) > 1 and bool(np.ptp(own) > VARYING))
        if rows.vary:
            down = scatter(shifts)
        if down > LARGEST_VERTICAL_OFFSET:
            limit = f"rows at most {LARGEST_VERTICAL_OFFSET} px apart"
            way = "--calibration FILE rectifies them"
            where = f"{right.names}; {way}: {clip.path}"
            raise _UnrectifiedError(f"expected a rectified pair, {limit}, got {down:.1f} px between {where}")
    if across <= 0:
        shift = f"the right one shows objects {-across:.0f} px farther right"
        came = f"{right.names} swapped, {shift}"
        raise ClipError(f"expected a left and a right image, got {came}: {clip.path}")
    return rows, [at for at, each in looked_at.items() if is_swapped(each)]


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


def _left_folder(path: Path) -> Path | None:
    folders = {entry.name: entry for entry in folders_in(path)}
    paired = _paired_names(name for name in folders if name != "images")
    return folders[paired[0]] if paired else None


def _paired_names(names: Iterable[str]) -> list[str]:
    """Those of the left eye whose right ones are there too, sorted."""
    known = set(names)
    return sorted(name for name in known if right_name(name) in known)


def _left_half(clip: Clip) -> Clip:
    """The clip with the left pictures alone."""
    lefts = set(_paired_names(clip.labels))
    places = [place for place, name in enumerate(clip.labels) if name in lefts]
    strays = sorted({*clip.labels} - lefts - {right_name(name) for name in lefts})
    said = (f"left out, not part of a stereo pair: {listed(strays)}",) if strays else ()

    def read_frame(index: int) -> Frame:
        index = numbered(index, len(places))
        return replace(clip.read_frame(places[index]), index=index, time=index / len(places))

    return replace(
        clip,
        cameras=tuple(clip.cameras[place] for place in places),
        labels=tuple(clip.labels[place] for place in places),
        read_frame=read_frame,
        read_image=lambda index: clip.read_image(places[numbered(index, len(places))]),
        notices=(*clip.notices, *said),
    )


def _first_partners(path: Path, names: Sequence[str]) -> tuple[Path, list[Path | None]]:
    """The first folder of these pictures that has a right one for any of them, and the right ones there."""
    for folder in _picture_folders(path, names[0]) if names else ():
        partners = _partners(folder, names)
        if any(partners):
            return folder, partners
    return path, []


def _picture_folders(path: Path, label: str) -> Iterator[Path]:
    """`path` and the folders in it, or in its data/, that hold the picture called `label`."""
    folders = (path, *folders_in(path), *folders_in(path / "data"))
    return (folder for folder in folders if (folder / label).is_file())


def _partners(folder: Path, labels: Sequence[str]) -> list[Path | None]:
    """The right pictures: beside the left ones, or by either name in the folder of the right eye.

    A frame of its own is no other frame's right picture.
    """
    whole = folder.resolve()
    here = {entry.name for entry in whole.iterdir() if is_picture(entry)} - set(labels)
    beside = whole.with_name(right_name(whole.name) or whole.name)
    there = {entry.name for entry in beside.iterdir() if is_picture(entry)} if beside.is_dir() else set[str]()
    found: list[Path | None] = []
    for name in labels:
        other = right_name(name)
        places = [whole / other] if other in here and other else []
        if beside != whole:
            places += [beside / each for each in (name, other) if each and each in there]
        found.append(next((path for path in places if path.is_file()), None))
    return found
