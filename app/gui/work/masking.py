"""Masks of the tools in the open clip, in a folder of their own: read, kept, grown and made for all frames,
and what is left out of a frame with them: off the window's thread."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from app.enhancement.image_mask import PictureMask
from app.runs.left_out import found_around
from app.runs.making_masks import MaskReport, make_masks
from app.runs.tool_masks import ToolMasks
from renderer.clip import BoolImage, ByteImage, Clip
from renderer.readers.clip_options import ClipOptions
from renderer.tools.brush import Point, grown
from renderer.tools.mask_files import (
    MaskFiles,
    MaskOrigin,
    mask_names,
    masks_in,
    origin_of,
    own_masks,
    read_all,
    write_mask,
)
from renderer.tools.onnx_model import OnnxTools, Values
from renderer.tools.polarity import with_doubt
from renderer.tools.search import find_tools

BY_HAND: MaskOrigin = "by hand"
FROM_FOLDER: MaskOrigin = "from a folder"


@dataclass(frozen=True)
class DrawnTools:
    """What is masked in the folder of the open clip."""

    masks: ToolMasks
    changes: int
    """Of these masks on disk: others are other tools."""

    def of(self, clip: Clip) -> Clip:
        """See `ToolMasks.of`."""
        return self.masks.of(clip)


@dataclass(frozen=True)
class LeftOutRequest:
    """What of one frame is left out."""

    clip: Clip
    frame_index: int
    mask: PictureMask
    tools: DrawnTools | None = None


@dataclass(frozen=True, eq=False)
class LeftOut:
    """(H, W), True = tool, burned-in text, dark surround, or masked by hand; tools and surround as a
    reconstruction finds them where the clip has no masks."""

    request: LeftOutRequest
    pixels: BoolImage


def left_out(request: LeftOutRequest) -> Iterator[LeftOut]:
    """Raises ClipError."""
    clip = request.clip if request.tools is None else request.tools.of(request.clip)
    found, frame = found_around(clip, request.frame_index)
    tissue = found.cleared(frame).tissue_mask
    yield LeftOut(request, ~(tissue & request.mask.kept(tissue.shape)))


def folder_of(places: Path, clip: Clip, options: ClipOptions) -> Path:
    """Where the masks of a clip lie: by its name and path, and by what says what a frame is."""
    told = f"{clip.path.absolute()}|{options.deinterlacing}|{options.stereo}"
    if options.calibration is not None:
        told += f"|{options.calibration}"
    return places / f"{clip.path.stem}-{hashlib.sha256(told.encode(errors='replace')).hexdigest()[:10]}"


@dataclass(frozen=True)
class MasksRequest:
    """Which masks there are of a clip."""

    clip: Clip
    folder: Path


@dataclass(frozen=True)
class MasksThere:
    request: MasksRequest
    origins: Mapping[int, MaskOrigin]
    """Of each frame that has one."""

    def frames(self, wanted: MaskOrigin) -> tuple[int, ...]:
        """Those whose masks are from there."""
        return tuple(sorted(index for index, origin in self.origins.items() if origin == wanted))

    def with_mask(self, index: int, origin: MaskOrigin | None) -> MasksThere:
        """With another one of a frame, or with none."""
        others = {place: one for place, one in self.origins.items() if place != index}
        return MasksThere(self.request, others if origin is None else {**others, index: origin})


def look_for_masks(request: MasksRequest) -> Iterator[MasksThere]:
    files = own_masks(request.folder, request.clip.labels).files
    yield MasksThere(request, {index: origin_of(path) for index, path in files.items()})


@dataclass(frozen=True)
class MaskRequest:
    """The mask of one frame."""

    clip: Clip
    folder: Path
    index: int

    @property
    def path(self) -> Path:
        return self.folder / mask_names(self.clip.labels)[self.index]


@dataclass(frozen=True, eq=False)
class FrameMask:
    """True = tool; where no file says so, as a reconstruction finds it."""

    request: MaskRequest
    image: ByteImage
    """(H, W, 3) of the frame."""
    mask: BoolImage
    """(H, W)."""
    origin: MaskOrigin | None
    """None: there is no file."""
    own: BoolImage
    """(H, W): left out by the clip's own masks, whatever is drawn."""

    @cached_property
    def left_out(self) -> BoolImage:
        """What either of the two masks marks."""
        return self.mask | self.own


def read_frame_mask(request: MaskRequest) -> Iterator[FrameMask]:
    """Raises ClipError: the frame or its mask cannot be read."""
    clip, index, path = request.clip, request.index, request.path
    if path.is_file():
        frame = clip.read_frame(index)
        own = ~frame.tissue_mask
        mask = MaskFiles(request.folder, {index: path}).read(index, (own.shape[1], own.shape[0]))
        assert mask is not None
        yield FrameMask(request, frame.image, mask, origin_of(path), own)
        return
    found, frame = found_around(clip, index)
    own = ~frame.tissue_mask
    seen = ~own if found.field_of_view is None else ~own & found.field_of_view.mask()
    tools = (
        seen & ~found.cleared(frame).tissue_mask
        if found.tools is None
        else find_tools(frame.image, seen, found.tools.still)
    )
    yield FrameMask(request, frame.image, tools, None, own)


@dataclass(frozen=True, eq=False)
class KeepMask:
    """A mask that was mended; None: drop it, so that the frame is as nobody had mended it."""

    request: MaskRequest
    mask: BoolImage | None
    origin: MaskOrigin = BY_HAND
    """Who says so: undone, it is as it was before."""


def keep_mask(wanted: KeepMask) -> Iterator[KeepMask]:
    """Raises OSError."""
    path = wanted.request.path
    if wanted.mask is None:
        path.unlink(missing_ok=True)
    else:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_mask(path, wanted.mask, wanted.origin)
    yield wanted


@dataclass(frozen=True, eq=False)
class GrowRequest:
    """What belongs to a line that was drawn, up to the edges in the frame."""

    frame: FrameMask
    line: tuple[Point, ...]
    radius: float
    """px."""


def grow(request: GrowRequest) -> Iterator[BoolImage]:
    frame = request.frame
    yield grown(frame.image, frame.mask, request.line, request.radius)


@dataclass(frozen=True, eq=False)
class MakingRequest:
    """Masks of all frames that nobody has masked by hand: learned from those and from masks of a folder,
    found by a network in a file, or taken from another folder."""

    clip: Clip
    folder: Path
    source: Path | None = None
    """The file or the folder."""
    values: Values = "imagenet"
    """Of the pixels that the network takes."""
    tools: tuple[int, ...] = ()
    """Classes of the network that are tools; empty: all but the first."""


def make_all(request: MakingRequest) -> Iterator[MaskReport]:
    """Raises ClipError, OnnxError or OSError."""
    clip, folder, source = request.clip, request.folder, request.source
    if source is not None and source.is_dir():
        yield from _taken(request, with_doubt(masks_in(source, clip.labels), clip))
        return
    model = None if source is None else OnnxTools.open(source, request.values, request.tools)
    folder.mkdir(parents=True, exist_ok=True)
    files = own_masks(folder, clip.labels).files
    mended = {index: path for index, path in files.items() if origin_of(path) in (BY_HAND, FROM_FOLDER)}
    yield from make_masks(clip, folder, MaskFiles(folder, mended), model)


def _taken(request: MakingRequest, files: MaskFiles) -> Iterator[MaskReport]:
    """Copies, but of frames that are masked by hand."""
    clip, names, shares = request.clip, mask_names(request.clip.labels), list[float]()
    request.folder.mkdir(parents=True, exist_ok=True)
    for index, mask in read_all(files, clip):
        path = request.folder / names[index]
        if not path.is_file() or origin_of(path) != BY_HAND:
            write_mask(path, mask, FROM_FOLDER)
        shares.append(float(mask.mean()))
        yield MaskReport(min(len(shares), len(clip) - 1), len(shares), None, notices=files.notices)
    share = sum(shares) / len(shares)
    found = sum(each > 0 for each in shares)
    yield MaskReport(len(clip), len(shares), None, found, share, notices=files.notices)
