"""Depth maps and masks beside the pictures of a folder whose layout does not say what they hold."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from renderer.clip import Clip, Frame
from renderer.depth.monocular import FOLDERS as MONOCULAR
from renderer.listing import listed
from renderer.readers.clip_files import files_in
from renderer.readers.clip_options import ClipOptions
from renderer.readers.geometry.depth_maps import DepthMap, is_map, plausible, read_map
from renderer.readers.image_files.file_kinds import natural_key
from renderer.readers.image_files.pictures import stored_kind
from renderer.readers.image_folders.picture_kinds import (
    PLURAL,
    WORDS,
    Kind,
    kinds_of,
    left_out,
    map_folders,
)
from renderer.readers.masks.nonzero_masks import read_nonzero, require_shapes
from renderer.readers.number_pairs import number_pairs, numbers_of

USES_MASKS: Final = "--mask-polarity tool or tissue says what they mark, and uses them"
USES_BYTES: Final = "8-bit maps may be inverse or stretched: --depth measured reads them as distances"
USES_NAMES: Final = "name them _depth or _disparity to have them read as such"
_FACTOR: Final = re.compile(r"(?<![^\W_])x(\d+)(?![^\W_])")
"""In names of disparities, x64: they are stored times this."""


@dataclass(frozen=True)
class _Offer:
    """Files of one kind, and the frames that they belong to."""

    kind: Kind
    name: str
    """Of the first file, or of their folder."""
    files: dict[int, Path]
    """By the place of the frame; empty: of none."""
    paths: Sequence[Path]
    """All of them, of any frame or none."""
    is_counted_anew: bool = False
    """Whether their numbers start elsewhere than those of the frames, so that they are paired in order."""

    @property
    def told(self) -> str:
        return (
            self.name
            if self.name.endswith("/") or len(self.paths) == 1
            else f"{self.name} and {len(self.paths) - 1} more"
        )

    def pairing(self, labels: Sequence[str]) -> list[str]:
        """What is said of files that are paired in order, or belong to no frame."""
        if self.is_counted_anew:
            one, first = self.files[0].name, labels[0]
            return [f"{self.told}: numbered from another start than the images, so paired in order: {one} "
                    f"with {first}"]  # fmt: skip
        strays = sorted(set(self.paths) - set(self.files.values()), key=natural_key)
        names = listed([path.name for path in strays])
        of_all = f"{len(strays)} of {len(self.paths)} {PLURAL[self.kind]}"
        return [f"{of_all} belong to none of the images: {names}"] if strays else []


def with_maps(clip: Clip, frames: Path, options: ClipOptions) -> Clip:
    """The clip with what lies beside its pictures in `frames`, or in folders of the clip of such names.

    A map belongs to the picture of its name without the word that says its kind, else of its last number, as
    `number_pairs` says.
    Maps called depth hold distances along the axis, those called disparity the inverse, where they are of
    16 bits or floats; 8 bits are taken when `options.depth` is "measured". Disparities are in pixels of
    their map, which may be smaller than the picture. Their unit is not known, but for
    the word mm in a name, and a factor such as x64 of disparities, with `options.baseline`: else lengths
    are in scene units. Masks are used when `options.mask_polarity` says what they mark. What is left out,
    and what was assumed, is said in notices.

    Raises:
        ClipError: masks of another shape than the pictures; or, when its frame is read, a map or mask that
            cannot be.
    """
    offers = list(_offers(clip.path, frames, clip.labels))
    if not offers:
        return clip
    depth, used = _chosen(offers, clip, options) if options.depth in ("auto", "measured") else (None, [])
    masks = _chosen_masks(offers, clip) if options.mask_polarity != "auto" else None
    others = [offer for offer in offers if offer not in (depth, masks)]
    said = tuple(left_out(offer.kind, [offer.told], _way(offer, clip, options)) for offer in others)
    clip = replace(clip, notices=(*clip.notices, *used, *said))
    clip = clip if depth is None else _with_depth(clip, depth, options)
    return (
        clip
        if masks is None
        else _with_masks(clip, masks, marked_is_tissue=options.mask_polarity == "tissue")
    )


def map_files(path: Path, frames: Path, labels: Sequence[str]) -> list[Path]:
    """What `with_maps` may take for a clip in the folder `path` whose pictures in `frames` are called so, and
    all maps in folders of such names.

    Raises:
        ClipError: a picture that cannot be read.
    """
    used = [
        each
        for offer in (_offers(path, frames, labels) if labels else ())
        if offer.kind != "map"
        for each in offer.files.values()
    ]
    return [*used, *(each for place in map_folders(path) for each in files_in(place) if is_map(each))]


def _offers(path: Path, frames: Path, labels: Sequence[str]) -> Iterator[_Offer]:
    kinds = kinds_of(sorted(files_in(frames), key=natural_key))
    groups: dict[tuple[str, Kind], list[Path]] = defaultdict(list)
    for each, kind in kinds.others.items():
        groups[re.sub(r"\d+", "#", each.name), kind].append(each)
    for (_, kind), paths in groups.items():
        yield _offer(labels, kind, paths[0].name, paths)
    for place, kind in map_folders(path).items():
        inside = [entry for entry in sorted(place.iterdir(), key=natural_key) if is_map(entry)]
        if inside and place.name not in MONOCULAR and place != frames:
            yield _offer(labels, kind, f"{place.name}/", inside)


def _offer(labels: Sequence[str], kind: Kind, name: str, paths: Sequence[Path]) -> _Offer:
    """The files, each with the frame that it belongs to; those of the other eye belong to none."""
    of_right = "right" in _parts(name) and "right" not in _parts(labels[0])
    files, shift = ({}, 0) if of_right else _paired(labels, paths, _stems(paths, kind))
    if kind == "mask" and not files and len(paths) == 1 and not of_right:
        files = dict.fromkeys(range(len(labels)), paths[0])
    return _Offer(kind, name, files, paths, shift != 0)


def _stems(paths: Sequence[Path], kind: Kind) -> list[str]:
    """Names, of disparities without their factor, whose number is none of a frame."""
    stems = [path.stem for path in paths]
    return [_FACTOR.sub("", stem) for stem in stems] if kind == "disparity" and _factor(stems) else stems


def _paired(
    labels: Sequence[str], paths: Sequence[Path], stems: Sequence[str]
) -> tuple[dict[int, Path], int]:
    """By name where each picture or each file has its own so, else by number; and how far numbers differ."""
    by_stem = _by_stem(labels, dict(zip(stems, paths, strict=True)))
    frames, files = numbers_of(labels), numbers_of([f"{stem}.png" for stem in stems])
    if len(by_stem) in (len(labels), len(paths)) or frames is None or files is None:
        return by_stem, 0
    pairs = number_pairs(frames, files)
    return (
        ({}, 0) if pairs is None else ({one: paths[file] for one, file in pairs.files.items()}, pairs.shift)
    )


def _by_stem(labels: Sequence[str], paths: Mapping[str, Path]) -> dict[int, Path]:
    found = {"_".join(_parts(stem)): path for stem, path in paths.items()}
    names = ["_".join(_parts(Path(label).stem)) for label in labels]
    return {place: found[name] for place, name in enumerate(names) if name and name in found}


def _parts(stem: str) -> list[str]:
    """Words and numbers of a name, without those that say its kind."""
    return [part for part in re.findall(r"[^\W\d_]+|\d+", stem.casefold()) if part not in WORDS]


def _chosen(offers: list[_Offer], clip: Clip, options: ClipOptions) -> tuple[_Offer | None, list[str]]:
    """The depth that is clearly meant, and what it was taken for."""
    usable = [
        offer
        for offer in offers
        if offer.kind in ("depth", "disparity") and offer.files and not _way(offer, clip, options)
    ]
    usable.sort(key=lambda offer: (-len(offer.files), offer.kind))
    if not usable:
        return None, []
    first = usable[0]
    if len(usable) > 1 and (len(usable[1].files), usable[1].kind) == (len(first.files), first.kind):
        return None, [
            f"{first.told} and {usable[1].told} are both {first.kind} of the images: neither is used"
        ]
    return first, _assumed(first, clip, options)


def _assumed(offer: _Offer, clip: Clip, options: ClipOptions) -> list[str]:
    lacking = [label for place, label in enumerate(clip.labels) if place not in offer.files]
    some = offer.pairing(clip.labels)
    if lacking:
        some.insert(0, f"{len(lacking)} of {len(clip)} images have no depth map, such as {lacking[0]}")
    if offer.kind == "depth":
        unit = "read as mm" if _unit(offer, options) == "mm" else "of unknown unit: lengths have no scale"
        return [f"depth is read from {offer.told}, {unit}", *some]
    step = _steps(offer)
    some += _counted(offer, clip.size)
    pixels = f"1/{step:g} px" if step != 1 else "px"
    if _unit(offer, options) == "mm":
        return [
            f"depth is computed from the disparity in {offer.told}, read in {pixels}, with a "
            f"baseline of {options.baseline:g} mm",
            *some,
        ]
    scale = "lengths have no scale (--baseline gives it in mm where they are pixels)"
    return [f"depth is computed from the disparity in {offer.told}, read in {pixels}: {scale}", *some]


def _counted(offer: _Offer, size: tuple[int, int]) -> list[str]:
    """In which pixels disparities are, where the maps have others than the images of `size`."""
    sizes = {stored_kind(path)[1] for path in offer.files.values()} - {size}
    if not sizes:
        return []
    (width, height), *_ = sorted(sizes)
    theirs = f"{width}x{height}" + (f" and {len(sizes) - 1} other sizes" if len(sizes) > 1 else "")
    own = f"disparities are read in pixels of the maps, {theirs}, not of the images, {size[0]}x{size[1]}"
    return [f"{own}; maps of the images' size are read in its pixels"]


def _way(offer: _Offer, clip: Clip, options: ClipOptions) -> str:
    """Why it cannot be used as it stands, and what would help; empty: it can, or nothing helps."""
    if not offer.files:
        return "names and numbers do not say which of the images they belong to"
    if offer.kind == "mask":
        return USES_MASKS if options.mask_polarity == "auto" else ""
    if offer.kind == "map":
        return USES_NAMES
    bytes_of = ""
    for path in offer.files.values():
        kind, (width, height) = stored_kind(path)
        if kind == "colour":
            return f"{path.name} holds colours, not distances"
        if abs(width * clip.size[1] - height * clip.size[0]) > 0.01 * width * clip.size[1]:
            pictures = f"the images of {clip.size[0]}x{clip.size[1]}"
            return f"{path.name} is {width}x{height}, another shape than {pictures}"
        bytes_of = USES_BYTES if kind == "bytes" else bytes_of
    return bytes_of if options.depth != "measured" else ""


def _chosen_masks(offers: list[_Offer], clip: Clip) -> _Offer | None:
    """Those of all pictures, if there is one such."""
    whole = [offer for offer in offers if offer.kind == "mask" and len(offer.files) == len(clip)]
    if len(whole) != 1:
        return None
    require_shapes(set(whole[0].files.values()), clip.size)
    return whole[0]


def _unit(offer: _Offer, options: ClipOptions) -> str:
    known = "mm" in _parts(offer.name) if offer.kind == "depth" else options.baseline is not None
    return "mm" if known else "scene units"


def _factor(names: Sequence[str]) -> str:
    """The factor that all of the names have alike, such as x64; empty: none."""
    found = {tuple(match[0] for match in _FACTOR.finditer(name)) for name in names}
    return next(iter(found))[0] if len(found) == 1 and () not in found else ""


def _steps(offer: _Offer) -> float:
    """Per pixel of disparity, where the name of the folder or of every file says it."""
    factor = _factor([offer.name]) if offer.name.endswith("/") else ""
    factor = factor or _factor([path.stem for path in offer.paths])
    return float(factor[1:]) if factor else 1.0


def _with_depth(clip: Clip, offer: _Offer, options: ClipOptions) -> Clip:
    baseline = options.baseline or 1.0
    factor = clip.cameras[0].fx * baseline * _steps(offer)

    def read_frame(index: int) -> Frame:
        frame = clip.read_frame(index)
        path = offer.files.get(frame.index)
        if path is None:
            return replace(frame, depth=np.zeros(frame.tissue_mask.shape, np.float32))
        values = read_map(path)
        if offer.kind == "disparity":
            shrunk = values.shape[1] / clip.size[0]
            depth = factor * shrunk / np.where(values > 0, values, 1)
            values = np.where(values > 0, depth, 0).astype(np.float32)
        return replace(frame, depth=plausible(_resized(values, clip.size)))

    return replace(
        clip, read_frame=read_frame, has_depth=True, unit=_unit(offer, options), depth_origin="beside"
    )


def _resized(values: DepthMap, size: tuple[int, int]) -> DepthMap:
    """(H, W) of `size` (width, height), each pixel the nearest of the given ones."""
    if values.shape == (size[1], size[0]):
        return values
    return np.asarray(cv2.resize(values, size, interpolation=cv2.INTER_NEAREST_EXACT), np.float32)


def _with_masks(clip: Clip, offer: _Offer, *, marked_is_tissue: bool) -> Clip:
    def read_frame(index: int) -> Frame:
        frame = clip.read_frame(index)
        tissue = np.equal(read_nonzero(offer.files[frame.index], clip.size), marked_is_tissue)
        return replace(frame, tissue_mask=tissue, evaluation_mask=tissue.copy())

    marks = "tissue" if marked_is_tissue else "tool"
    said = f"{offer.told} is assumed to mark {marks}", *offer.pairing(clip.labels)
    return replace(clip, read_frame=read_frame, notices=(*clip.notices, *said))
