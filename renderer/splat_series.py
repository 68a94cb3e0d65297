"""A folder of numbered splat files, one a moment, as exports of moving models are: through time, in bounded
memory."""

from __future__ import annotations

import re
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from renderer.listing import listed
from renderer.raw_gaussians import RawGaussians
from renderer.readers.clip_files import files_in
from renderer.readers.image_files.file_kinds import is_picture
from renderer.splat_files import SUFFIXES, WRITERS, SplatFile, SplatFileError, read_splats

MOST_BYTES: Final = 1 << 30
"""Of Gaussians in memory, about. Beyond it, evenly chosen files are read; the same ones on every computer."""
NUMBER = re.compile(r"(\d+)(?!.*\d)")


@dataclass(frozen=True, eq=False)
class SplatSeries:
    """One a moment, in the order of the files' numbers."""

    files: tuple[SplatFile, ...]
    notices: tuple[str, ...] = ()
    """What was left out or repaired."""

    @property
    def moments(self) -> tuple[RawGaussians, ...]:
        return tuple(file.raw for file in self.files)


def series_files(folder: Path) -> tuple[Path, ...]:
    """Two or more splat files whose names differ by their last number alone, in its order, in a folder
    without images; else none. Of several such series, the longest. No file is read."""
    series: dict[tuple[str, ...], dict[int, Path]] = defaultdict(dict)
    try:
        files = sorted(files_in(folder))
    except OSError:
        return ()
    if any(map(is_picture, files)):
        return ()
    for file in files:
        ending = _ending(file)
        stem = file.name.removesuffix(ending)
        if file.suffix.lower() in SUFFIXES and (found := NUMBER.search(stem)):
            alike = stem[: found.start()], stem[found.end() :], ending
            series[alike].setdefault(int(found[1]), file)
    longest = max(series.values(), key=len, default={})
    return tuple(longest[number] for number in sorted(longest)) if len(longest) > 1 else ()


def _ending(file: Path) -> str:
    """Of its name; what says the kind (.v4.spz) is no number of a moment."""
    known = next((end for end in WRITERS if file.name.lower().endswith(end)), file.suffix)
    return file.name[len(file.name) - len(known) :]


def read_series(folder: Path, most_bytes: int = MOST_BYTES) -> SplatSeries:
    """Raises SplatFileError: a file cannot be read, or is damaged, or there are no two of them."""
    paths = series_files(folder)
    if not paths:
        raise SplatFileError(f"expected two or more numbered splat files, got a folder without: {folder}")
    first = read_splats(paths[0])
    count = _fitting(paths, first.raw, most_bytes)
    kept = sorted({round(place * (len(paths) - 1) / (count - 1)) for place in range(count)})
    files = (first, *(read_splats(paths[place]) for place in kept[1:]))
    return SplatSeries(
        files, (*_left_out(folder, paths, len(kept), most_bytes), *_repairs(paths, kept, files))
    )


def _fitting(paths: tuple[Path, ...], first: RawGaussians, most_bytes: int) -> int:
    """How many of them fit, two at least, judged by the first one and the sizes of all."""
    sizes = [max(path.stat().st_size, 1) for path in paths]
    whole = sum(array.nbytes for array in first.arrays().values()) * sum(sizes) / sizes[0]
    return max(min(len(paths), int(len(paths) * most_bytes / max(whole, 1))), 2)


def _left_out(folder: Path, paths: tuple[Path, ...], kept: int, most_bytes: int) -> list[str]:
    said = []
    if kept < len(paths):
        said.append(f"{kept} of {len(paths)} moments are shown, as many as fit into {most_bytes >> 20} MB")
    others = {file.name for file in files_in(folder) if file.suffix.lower() in SUFFIXES}
    if strays := sorted(others - {path.name for path in paths}):
        said.append(f"left out, not of the numbered splat files: {listed(strays)}")
    return said


def _repairs(paths: tuple[Path, ...], kept: list[int], files: tuple[SplatFile, ...]) -> list[str]:
    """Of each file, what had to be repaired; the first ones."""
    said = [
        f"{paths[place].name}: {notice}"
        for place, file in zip(kept, files, strict=True)
        for notice in file.notices
    ]
    return [listed(said)] if said else []
