"""What the pictures of a folder are: frames, or depth maps and masks that lie beside them.

The one rule for all that takes the pictures of a folder, so that what is enhanced is what is trained on.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final, Literal, get_args

import numpy as np

from renderer.listing import listed
from renderer.readers.clip_files import folders_in
from renderer.readers.image_files.coded_picture import CODED
from renderer.readers.image_files.file_kinds import SUFFIXES, is_array, is_frame, is_unnamed, opens
from renderer.readers.image_files.picture_files import BROKEN, opened
from renderer.readers.image_files.pictures import read_stored
from renderer.readers.image_folders.passed_over import NOT_READABLE

Kind = Literal["depth", "disparity", "mask", "map"]
"""A "map" is a picture of numbers that nothing tells more about."""

WORDS: Final[Mapping[str, Kind]] = {
    **dict.fromkeys(("depth", "depths", "depthmap", "depthmaps", "zmap"), "depth"),
    **dict.fromkeys(("disp", "disparity", "disparities", "disparitymap"), "disparity"),
    **dict.fromkeys(("mask", "masks", "seg", "segm", "segmentation", "segmentations"), "mask"),
    **dict.fromkeys(("label", "labels", "labelmap", "annotation", "annotations", "occ", "occlusion"), "mask"),
    **dict.fromkeys(("normals", "flow", "heatmap", "overlay"), "map"),
}
PLURAL: Final[Mapping[Kind, str]] = {
    "depth": "depth maps",
    "disparity": "disparity maps",
    "mask": "masks",
    "map": "maps of numbers",
}
KINDS: Final[tuple[Kind, ...]] = get_args(Kind)
TWINS: Final = "left out, beside an image of the same name"
FEW_VALUES = 16
"""Of a mask of several labels."""


def kind_by_name(stem: str) -> Kind | None:
    """What the words of a name without suffix say; None: a frame, or nothing."""
    for words in (_words(stem), _words(re.sub(r"(?<=[a-z])(?=[A-Z])", " ", stem))):
        found = next((WORDS[word] for word in words if word in WORDS), None)
        if found:
            return found
    return None


def is_named_array(path: Path) -> bool:
    """Whether it is a visible numpy array whose name says what it is."""
    return is_array(path) and kind_by_name(path.stem) is not None


@dataclass(frozen=True)
class PictureKinds:
    """The pictures of a folder."""

    frames: tuple[Path, ...]
    others: dict[Path, Kind] = field(default_factory=dict)
    """What lies beside the frames."""
    unreadable: tuple[Path, ...] = ()
    """Of CODED, beside frames."""
    twins: tuple[Path, ...] = ()
    """Of CODED or without a suffix, beside a frame of the same name with a plainer one."""

    @property
    def told(self) -> frozenset[Path]:
        """Those that `notices` name."""
        return frozenset((*self.others, *self.unreadable, *self.twins))

    def notices(self) -> tuple[str, ...]:
        """One sentence for each kind that is not a frame."""
        of_kinds = (
            left_out(kind, [path.name for path in paths])
            for kind in KINDS
            if (paths := [path for path, own in self.others.items() if own == kind])
        )
        return (*of_kinds, *self.notices_of_pictures())

    def notices_of_pictures(self) -> tuple[str, ...]:
        """The same of what is neither a frame nor a map or mask."""
        further = ((NOT_READABLE, self.unreadable), (TWINS, self.twins))
        return tuple(f"{why}: {listed([path.name for path in paths])}" for why, paths in further if paths)


def left_out(kind: Kind, names: Sequence[str], why: str = "") -> str:
    """The sentence about files that are no frames; `why`, and what would help, where that is known."""
    return f"left out, {PLURAL[kind]} beside the images: {listed(names)}" + (f" ({why})" if why else "")


def kinds_of(files: Iterable[Path]) -> PictureKinds:
    """Frames and others among the pictures and named arrays of the files of one folder, in their order.

    A name says it by a whole word of the stem (WORDS). Where names do not, the content does, but only beside
    frames in colour: 16 bits or floats in one channel are a map of numbers, two values a mask; and so
    are a few grey levels where the name goes on from that of a frame. Files whose names differ in
    numbers alone are of one kind: the header of the first tells. Where no frame would be left, all are.
    Beside others, those of CODED whose header does not open are passed over, and so is a frame of CODED or
    without a suffix where one has the same name and a plainer suffix: a camera keeps both of one moment.
    """
    pictures = tuple(file for file in files if is_frame(file) or is_named_array(file))
    unreadable = {path: None for path in pictures if path.suffix.lower() in CODED and not opens(path)}
    others = tuple(path for path in pictures if path not in unreadable)
    if unreadable and any(map(is_frame, others)):
        return replace(_without_twins(_readable_kinds(others)), unreadable=tuple(unreadable))
    return _without_twins(_readable_kinds(pictures))


def _without_twins(kinds: PictureKinds) -> PictureKinds:
    named = {path.stem for path in kinds.frames if path.suffix.lower() in SUFFIXES}
    twins = {path: None for path in kinds.frames if path.stem in named and _may_be_twin(path)}
    frames = tuple(path for path in kinds.frames if path not in twins)
    return replace(kinds, frames=frames, twins=tuple(twins))


def _may_be_twin(path: Path) -> bool:
    return path.suffix.lower() in CODED or is_unnamed(path)


def _readable_kinds(pictures: tuple[Path, ...]) -> PictureKinds:
    groups: dict[str, list[Path]] = defaultdict(list)
    for path in pictures:
        groups[re.sub(r"\d+", "#", path.stem) + path.suffix.lower()].append(path)
    others: dict[Path, Kind] = {}
    modes: dict[str, str] = {}
    for name, paths in groups.items():
        kind = kind_by_name(paths[0].stem)
        if kind is not None:
            others |= dict.fromkeys(paths, kind)
        elif len(groups) > 1:
            modes[name] = _mode(paths[0])
    if any(mode in ("RGB", "RGBA", "CMYK", "YCbCr") for mode in modes.values()):
        colour = {path.stem for name, mode in modes.items() if mode[0] in "RCY" for path in groups[name]}
        for name, mode in modes.items():
            kind = _kind_by_content(groups[name][0], mode, colour)
            others |= dict.fromkeys(groups[name], kind) if kind else {}
    frames = tuple(path for path in pictures if path not in others)
    if not frames:
        return PictureKinds(tuple(path for path in pictures if is_frame(path)))
    return PictureKinds(frames, {path: others[path] for path in pictures if path in others})


def frame_folder(path: Path) -> Path:
    """Where the frames of a folder lie: in itself, in images/, or in the one folder beside maps and masks."""
    if not path.is_dir() or _holds_pictures(path):
        return path
    if (path / "images").is_dir():
        return path / "images"
    folders = folders_in(path)
    frames = [entry for entry in folders if kind_by_name(entry.name) is None and _holds_pictures(entry)]
    beside = [entry for entry in folders if kind_by_name(entry.name) is not None]
    return frames[0] if len(frames) == 1 and beside else path


def map_folders(path: Path) -> dict[Path, Kind]:
    """The folders in a folder whose names say that they hold no frames."""
    return {entry: kind for entry in folders_in(path) if (kind := kind_by_name(entry.name)) is not None}


def _words(stem: str) -> list[str]:
    return [word.casefold() for word in re.findall(r"[^\W\d_]+", stem)]


def _holds_pictures(folder: Path) -> bool:
    return any(is_frame(entry) and entry.is_file() for entry in folder.iterdir())


def _mode(path: Path) -> str:
    """As Pillow calls it, by the header; of a file that is none, that of a frame, whose reader says so."""
    try:
        with opened(path) as picture:
            return picture.mode
    except BROKEN:
        return "?"


def _kind_by_content(path: Path, mode: str, colour: set[str]) -> Kind | None:
    if mode.startswith(("I", "F")):
        return "map"
    if mode == "1":
        return "mask"
    goes_on = any(path.stem != stem and path.stem.startswith(stem) for stem in colour)
    if mode in ("L", "P") and goes_on and len(np.unique(read_stored(path))) <= FEW_VALUES:
        return "mask"
    return None
