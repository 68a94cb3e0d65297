"""Clips with an image of the right eye for every one of the left: which images belong together."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from renderer.clip import ByteImage, Clip, ClipError, Frame, numbered
from renderer.depth.one_scene import may_be_one_scene
from renderer.listing import listed
from renderer.readers.clip_files import folders_in
from renderer.readers.image_files.file_kinds import is_picture
from renderer.readers.image_files.pictures import common_size, read_rgb
from renderer.readers.image_files.used_bits import ALL
from renderer.readers.image_folders.frames import open_images
from renderer.readers.image_folders.picture_kinds import kind_by_name

_LEFT = re.compile(r"left|(?<=[\d_-])l$|^l(?=$|[\d_-])", re.IGNORECASE)
_RIGHT = {"left": "right", "Left": "Right", "LEFT": "RIGHT", "l": "r", "L": "R"}
_CAMERAS = {"image_02": "image_03", "image_00": "image_01", "cam0": "cam1"}
"""Folders of the left eye and of the right one, as KITTI and EuRoC call them."""


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
    return any(may_be_one_scene(path / left, path / (right_name(left) or left)) for left in tried)


def eye_folders(path: Path) -> tuple[Path, ...]:
    """The folders of the left and of the right eye in a folder; none where it has no such two."""
    left = _left_folder(path)
    return (left, left.with_name(right_name(left.name) or "")) if left else ()


def open_stereo_folder(path: Path, field_of_view: float, bits: int | None = None) -> Clip:
    """The left pictures of a folder as a clip; `with_stereo_depth` makes use of the right ones. `bits`: that
    values of 16-bit images use; None: those of both eyes in one folder 10 or 12 where these are enough, those
    in two folders all, as stored.

    Raises:
        ClipError: nothing that can be read, as `open_images`.
    """
    lefts = _left_folder(path)
    if lefts is None:
        return _left_half(open_images(path, field_of_view, bits))
    return replace(open_images(lefts, field_of_view, bits or ALL), path=path, name=path.resolve().name)


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
