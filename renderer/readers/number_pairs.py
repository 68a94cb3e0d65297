"""Which file belongs to which frame, by numbers that one of the two may count from another start."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from renderer.readers.numbered_files import number_of


@dataclass(frozen=True)
class NumberPairs:
    """Frames and their files."""

    files: dict[int, int]
    """The place of the file, by the place of the frame."""
    shift: int = 0
    """What a file's number is less than that of its frame."""


def numbers_of(names: Sequence[str]) -> list[int] | None:
    """The last one of each, without its suffix; None: one has none, or two the same."""
    numbers = [number for name in names if (number := number_of(Path(name))) is not None]
    return numbers if len(set(numbers)) == len(names) else None


def number_pairs(frames: Sequence[int], files: Sequence[int]) -> NumberPairs | None:
    """By equal numbers, where each frame has a file or each file a frame.

    Where some of both are left over, the two may be numbered from different starts, and equal numbers mean
    different frames. As many files as frames whose numbers differ by one constant, and begin with 0 or 1 on
    one side, are paired in their order. Other numbers count as equal only if they fit better so than shifted.

    Args:
        frames: numbers of the frames, each once.
        files: of the files, each once.

    Returns:
        None: the numbers do not tell which file belongs to which frame.
    """
    if not frames or not files:
        return None
    equal = _shifted(frames, files, 0)
    if len(equal.files) in (len(frames), len(files)):
        return equal
    starts = min(frames), min(files)
    first = starts[0] - starts[1]
    if min(starts) <= 1 and {number - first for number in frames} == set(files):
        return _shifted(frames, files, first)
    others = {-1, 1, first, max(frames) - max(files)} - {0}
    best = max(len(_shifted(frames, files, shift).files) for shift in others)
    return equal if len(equal.files) > best else None


def _shifted(frames: Sequence[int], files: Sequence[int], shift: int) -> NumberPairs:
    places = {number + shift: place for place, number in enumerate(files)}
    return NumberPairs(
        {place: places[number] for place, number in enumerate(frames) if number in places}, shift
    )
