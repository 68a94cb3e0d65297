"""Tool masks as a folder of images, one a frame, and a clip whose tools they leave out."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, Literal, get_args

import numpy as np
from PIL import Image, PngImagePlugin

from renderer.atomic_files import written_atomically
from renderer.clip import BoolImage, Clip, ClipError, Frame, numbered, within
from renderer.listing import listed
from renderer.readers.clip_files import files_in
from renderer.readers.image_files.file_kinds import NAMED, natural_key
from renderer.readers.masks.nonzero_masks import read_nonzero
from renderer.readers.number_pairs import NumberPairs, number_pairs, numbers_of

MaskOrigin = Literal["by hand", "from a folder", "learned", "by colour", "by a model"]
"""Who says where tools are; what says nothing of itself is by hand."""

_KEY: Final = "VesselSplat tool mask"


@dataclass(frozen=True)
class MaskFiles:
    """The masks that a folder holds of the frames of a clip."""

    folder: Path
    files: Mapping[int, Path]
    """By frame."""
    notices: tuple[str, ...] = ()
    """How they were paired with the frames, where that is not by equal names or numbers alone; and doubts."""

    def read(self, index: int, size: tuple[int, int]) -> BoolImage | None:
        """(H, W) for `size` (width, height), True = tool; None: the folder holds none of this frame.

        Raises:
            ClipError: the file is no image, or of another shape than the frame.
        """
        path = self.files.get(index)
        return None if path is None else read_nonzero(path, size)


NONE: Final = MaskFiles(Path(), {})


def mask_names(labels: Sequence[str]) -> tuple[str, ...]:
    """What the masks of frames of these labels are called: as the frames, but PNG."""
    return tuple(f"{stem}.png" for stem in _stems(labels))


def _stems(labels: Sequence[str]) -> Sequence[str]:
    """Of the frames' names; these as they are, where two differ by extension alone."""
    stems = [Path(label).stem for label in labels]
    return stems if len(set(stems)) == len(stems) else labels


def masks_in(folder: Path, labels: Sequence[str]) -> MaskFiles:
    """Found by the names of the frames, or by their numbers, as in 00012.png for frame 12 of a video; where
    neither fits any frame, or as many are numbered from another start, in their order if there is one for
    each. What is not found by name, or belongs to no frame, is said.

    Raises:
        ClipError: no such folder, no mask in it that belongs to a frame, or two for one; or numbers of which
            it is not clear which frame they mean, as `number_pairs` says.
    """
    if not folder.is_dir():
        got = "a file" if folder.exists() else "no such folder"
        raise ClipError(f"expected a folder of tool masks, got {got}: {folder}")
    found = sorted((path for path in files_in(folder) if path.suffix.lower() in NAMED), key=natural_key)
    keys, named = {_key(stem) for stem in _stems(labels)}, dict[str | int, Path]()
    for path in found:
        if (other := named.setdefault(key := _key(path.stem), path)) != path and key in keys:
            raise ClipError(f"expected one mask for each frame, got {other.name} and {path.name}: {folder}")
    files = {index: named[key] for index, stem in enumerate(_stems(labels)) if (key := _key(stem)) in named}
    if not files and len(found) == len(labels):
        files = dict(enumerate(found))
        same = numbers_of(labels) == numbers_of([path.name for path in found]) is not None
        return MaskFiles(folder, files, () if same else (_in_order(folder, files, labels),))
    by_number = {} if files else _by_last_number(found, labels)
    if not files and not by_number:
        example, count = mask_names(labels)[0], len(found)
        wanted = f"masks named as the frames, such as {example}, or one for each of {len(labels)} frames"
        raise ClipError(f"expected {wanted}, got {count} images of other names: {folder}")
    said = (_paired("by number", folder, by_number, labels),) if by_number else ()
    return _renumbered(MaskFiles(folder, files or by_number, said), found, labels)


def _by_last_number(found: Sequence[Path], labels: Sequence[str]) -> Mapping[int, Path]:
    """Masks named alike but for their number, as frame-000012.mask.png of frame-000012.color.png; none where
    their numbers do not tell, or fit once, as by chance."""
    frames, files = numbers_of(labels), numbers_of([path.name for path in found])
    if frames is None or files is None or len({_words(path.stem) for path in found}) > 1:
        return {}
    pairs = number_pairs(frames, files)
    if pairs is None or len(pairs.files) < 2:
        return {}
    return {frame: found[file] for frame, file in pairs.files.items()}


def _renumbered(masks: MaskFiles, found: Sequence[Path], labels: Sequence[str]) -> MaskFiles:
    """Those found by name; in order, where the others show that masks are numbered from another start.

    Raises ClipError: the others show that equal numbers do not mean equal frames.
    """
    loose = [path for path in found if path not in set(masks.files.values())]
    words = {_words(path.stem) for path in masks.files.values()}
    numbered = [path for path in found if _words(path.stem) in words]
    frames, files = numbers_of(labels), numbers_of([path.name for path in numbered])
    pairs: NumberPairs | None = NumberPairs({})
    if frames is not None and files is not None and set(loose) & set(numbered):
        pairs = number_pairs(frames, files)
    names = listed([path.name for path in loose])
    if pairs is None:
        wanted = f"masks numbered as the frames, {labels[0]} to {labels[-1]}"
        raise ClipError(f"expected {wanted}, got some that belong to none of them, {names}: {masks.folder}")
    if pairs.shift:
        shifted = {frame: numbered[file] for frame, file in pairs.files.items()}
        return replace(masks, files=shifted, notices=(_in_order(masks.folder, shifted, labels),))
    said = f"masks in {masks.folder.name}/ that belong to no frame: {names}"
    return replace(masks, notices=(*masks.notices, said)) if loose else masks


def _in_order(folder: Path, files: Mapping[int, Path], labels: Sequence[str]) -> str:
    return _paired("in order", folder, files, labels)


def _paired(how: str, folder: Path, files: Mapping[int, Path], labels: Sequence[str]) -> str:
    first = min(files)
    said = f"tool masks in {folder.name}/ are paired with the frames {how}, not by name"
    return f"{said}: {files[first].name} with {labels[first]}"


def _words(stem: str) -> str:
    """Without its last number."""
    return re.sub(r"\d+(?=\D*$)", "", stem)


def own_masks(folder: Path, labels: Sequence[str]) -> MaskFiles:
    """Those that were written as `mask_names` says; none without a folder."""
    paths = (folder / name for name in mask_names(labels))
    return MaskFiles(folder, {index: path for index, path in enumerate(paths) if path.is_file()})


def _key(stem: str) -> str | int:
    return int(stem) if stem.isdecimal() else stem


def with_tool_masks(clip: Clip, masks: Callable[[], MaskFiles]) -> Clip:
    """The clip where what is masked is no tissue, and not evaluated. Reading a frame raises ClipError: there
    are no masks, or its own cannot be read."""

    def read_frame(index: int) -> Frame:
        index = numbered(index, len(clip))
        frame = clip.read_frame(index)
        mask = masks().read(index, (frame.image.shape[1], frame.image.shape[0]))
        return frame if mask is None else replace(within(frame, ~mask), tools_are_known=True)

    return replace(clip, read_frame=read_frame)


def read_all(masks: MaskFiles, clip: Clip) -> Iterator[tuple[int, BoolImage]]:
    """Frames and their masks (H, W), in order, one read at a time. Raises ClipError."""
    for index in sorted(masks.files):
        camera = clip.cameras[index]
        mask = masks.read(index, (camera.width, camera.height))
        assert mask is not None
        yield index, mask


def save_mask(path: Path, mask: BoolImage, origin: MaskOrigin = "by hand") -> None:
    """An image of one bit a pixel, white = tool, that says where it is from. Raises OSError."""
    text = PngImagePlugin.PngInfo()
    text.add_text(_KEY, origin)
    Image.fromarray(mask).save(path, "PNG", pnginfo=text)


def write_mask(path: Path, mask: BoolImage, origin: MaskOrigin) -> None:
    """The same, whole or not at all. Raises OSError."""
    with written_atomically(path) as partial:
        save_mask(partial, mask, origin)


def origin_of(path: Path) -> MaskOrigin:
    """Where a mask is from, by its header; a file that says nothing is by hand, whoever drew it."""
    try:
        with Image.open(path) as picture:
            told = picture.info.get(_KEY)
    except OSError:
        return "by hand"
    return next((origin for origin in get_args(MaskOrigin) if origin == told), "by hand")


def digest_of(masks: Iterable[tuple[int, BoolImage]]) -> str:
    """SHA-256 of what is masked in frames that come in order, however it is stored."""
    manifest = hashlib.sha256()
    for index, mask in masks:
        manifest.update(f"{index} {mask.shape}\n".encode())
        manifest.update(np.packbits(mask).tobytes())
    return manifest.hexdigest()
