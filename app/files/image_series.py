"""What `enhance` and `metrics` work on: an image, a folder of them, a clip or a video, read one by one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Container, Iterator
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path

import numpy as np

from app.errors import UserError
from app.files.image_files import ArrayImage, frames_in, is_still, read_image
from app.files.records import Source
from app.files.timing import Timing
from renderer.clip import Clip
from renderer.evenly import evenly
from renderer.layouts import layout_of
from renderer.readers.clip_files import files_in
from renderer.readers.clip_options import DEFAULTS, ClipOptions
from renderer.readers.dicom.header import holds_stream
from renderer.readers.image_files.file_kinds import is_visible
from renderer.readers.image_files.transparency import SAID, hides_some
from renderer.readers.image_files.used_bits import ALL, holds_deep, said_of_bits, stretched, used_bits
from renderer.readers.image_folders.pages import left_pages
from renderer.readers.image_folders.passed_over import broken_links, passed_over
from renderer.readers.image_folders.picture_kinds import PictureKinds, frame_folder, left_out, map_folders
from renderer.readers.lenses.calibration import LensCalibration
from renderer.readers.lenses.straightening import straightening
from renderer.sources import open_clip

FRAMES_PER_SECOND = 25.0
"""Of folders, which do not say."""
EVENLY = Timing(FRAMES_PER_SECOND)
ROUNDING = 0.002
"""Seconds by which containers round times."""


@dataclass(frozen=True)
class Series:
    """Pictures by number, with the name that each output takes from its input."""

    names: tuple[str, ...]
    """Without suffix, all different."""
    sources: tuple[Path, ...]
    """The file that each picture comes from."""
    read: Callable[[int], ArrayImage]
    images: tuple[Path, ...] = ()
    """The image file of each picture, where sources name the folder of them all."""
    notices: tuple[str, ...] = ()
    """One sentence for each oddity met while opening."""

    is_video: bool = False
    """Whether all pictures are frames of one video file."""
    timing: Timing = EVENLY
    """Of a video made of these pictures."""
    bits: int = ALL
    """That 16-bit values of the files use; they are read over the whole range."""

    def __len__(self) -> int:
        return len(self.names)

    @property
    def files(self) -> tuple[Path, ...]:
        """The file that each picture's numbers lie in."""
        return self.images or self.sources

    def frame(self, index: int) -> int | None:
        """The number of a picture in its source; None where each has a source of its own."""
        return index if self.is_video or (len(self) > 1 and self.sources[0] == self.sources[-1]) else None

    def origins(self) -> Iterator[Source]:
        """Name and digest of each picture's file; that of a video is taken once."""
        for path, pictures in groupby(self.sources):
            origin = Source.of(path)
            yield from (origin for _ in pictures)

    def spread(self, count: int) -> list[int]:
        """Numbers of `count` pictures or fewer, evenly spread, the first and the last among them."""
        return evenly(range(len(self)), count)


def open_series(path: Path, options: ClipOptions = DEFAULTS, apart: Container[Path] = ()) -> Series:
    """What `options` say of a video counts, and a calibration. Of files in a folder that are passed over it
    is told which, but for those that are worked on `apart`.

    Raises:
        UserError, ClipError: nothing there, nothing readable, or two pictures of one name.
    """
    if not path.exists():
        raise UserError(f"expected an image, a folder of images or a video, got no such file: {path}")
    if path.is_dir():
        if options.calibration is not None or not layout_of(path).frames_are_files:
            # Of files that tell more than pictures, as left ones of pairs, or as others than they are stored.
            heeded = replace(DEFAULTS, calibration=options.calibration, bits=options.bits)
            return _of_clip(path, replace(heeded, alpha="ignored"))
        kinds = frames_in(path)
        series = _of_files(kinds.frames, options.bits)
        left = (*kinds.notices(), *_left_out(path), *_passed_over(path, kinds, apart))
        return replace(series, notices=(*left, *series.notices))
    if not is_still(path):
        return _of_clip(path, options)
    still = _of_files((path,), options.bits)
    if options.calibration is None:
        return still
    lens = options.calibration.lens
    return replace(still, read=lambda index: _straight(still.read(index), lens, path))


def _straight(image: ArrayImage, lens: LensCalibration, path: Path) -> ArrayImage:
    try:
        return straightening(lens, (image.shape[1], image.shape[0])).image(image)
    except ValueError as error:
        raise UserError(f"calibration: {error}: {path}") from error


def _left_out(path: Path) -> Iterator[str]:
    """What is said of the folders beside that of the frames, where no layout says what they are."""
    if frame_folder(path) != path and not layout_of(path).is_data_set:
        for folder, kind in map_folders(path).items():
            yield left_out(kind, [f"{folder.name}/"])


def _passed_over(path: Path, kinds: PictureKinds, apart: Container[Path]) -> Iterator[str]:
    told = {*kinds.frames, *kinds.told}
    files = filter(is_visible, files_in(frame_folder(path)))
    yield from passed_over((each for each in files if each not in told), apart)
    yield from broken_links(frame_folder(path).iterdir())


def _of_files(paths: tuple[Path, ...], bits: int | None) -> Series:
    stems = Counter(path.stem for path in paths)
    # As of videos: where names differ by their suffix alone, outputs keep it.
    names = tuple(path.stem if stems[path.stem] == 1 else path.name for path in paths)
    first: dict[str, Path] = {}
    for name, path in zip(names, paths, strict=True):
        other = first.setdefault(name, path)
        if other != path:
            raise UserError(f"{other.name} and {path.name} would share one output name: {path.parent}")
    bits = bits or used_bits(paths)
    hidden = (SAID,) if hides_some(paths) else ()
    notices = *left_pages(paths), *said_of_bits(len(paths), bits), *hidden
    return Series(names, paths, lambda index: _read(paths[index], bits), notices=notices, bits=bits)


def _read(path: Path, bits: int) -> ArrayImage:
    """Raises UserError."""
    image = read_image(path)
    if bits >= ALL or image.dtype != np.uint16 or not holds_deep(path):
        return image
    if image.shape[2:] == (4,):
        return np.dstack((stretched(image[..., :3], bits), image[..., 3]))
    return stretched(image, bits)


def _of_clip(path: Path, options: ClipOptions) -> Series:
    clip, is_video = open_clip(path, options), path.is_file()
    indices = range(len(clip))
    names = [f"frame-{index:06d}" if is_video else Path(clip.labels[index]).stem for index in indices]
    timing, files = timing_of(clip, indices), (path,) * len(clip)
    images = () if is_video else _image_files(path, clip)
    facts = tuple(names), files, clip.read_image, images, clip.notices
    return Series(*facts, is_video=is_video, timing=timing, bits=clip.bits)


def _image_files(path: Path, clip: Clip) -> tuple[Path, ...]:
    """The files of a clip's frames; none where frames are made of other files."""
    if not layout_of(path).frames_are_files:
        return ()
    files = tuple(frame_folder(path) / label for label in clip.labels)
    return files if all(file.is_file() for file in files) else ()


def timing_of(clip: Clip, frames: range) -> Timing:
    """Of a video with one frame for each of these of a clip, one after another."""
    speed = clip.frames_per_second or FRAMES_PER_SECOND
    if clip.format != "video":
        return Timing(speed)
    like = clip.path if holds_stream(clip.path) else None
    times = clip.frame_times and clip.frame_times[frames.start : frames.stop]
    start = times[0] if times else frames.start / speed
    within = times and tuple(time - start for time in times)
    return Timing(speed, _uneven(within, speed), start, like)


def _uneven(times: tuple[float, ...] | None, speed: float) -> tuple[float, ...] | None:
    """The times, where `speed` alone does not tell them."""
    if times is None or all(abs(time - at / speed) < ROUNDING for at, time in enumerate(times)):
        return None
    return times
