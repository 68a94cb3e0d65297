"""A clip walked through frame by frame, in parts that each hold on to what came before."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Final, Protocol, TypeVar

from renderer.camera import Camera
from renderer.clip import Clip
from renderer.poses.lost_frame import LostFrame
from renderer.poses.pictures import Picture, picture_of

MOST_BRIDGED: Final = 5
"""Frames in a row without a pose, as of smoke or a wiped lens, that a part goes on behind."""
SHORTEST: Final = 8
"""Frames of a part that is worth a reconstruction."""
_RESEEN = 0.3
"""Share of its newest features that a part needs to go on behind any number of frames: they may have shown
another place."""


class Lost(Exception):
    """A frame does not follow from those before it: the text says why."""


class Part(Protocol):
    """Frames that follow from each other."""

    @property
    def last(self) -> int:
        """The newest frame."""

    def __len__(self) -> int:
        """How many."""

    def follow(self, picture: Picture, share: float = 0.0) -> None:
        """By at least this share of its newest features. Raises Lost; the next frame may be tried."""


def commonest(why: Sequence[str], otherwise: str = "") -> str:
    """Of reasons why frames are lost, the first of those given most often."""
    return max(why, key=why.count, default=otherwise)


Following = TypeVar("Following", bound=Part)


def pictures_of(clip: Clip, lens: Camera, unit: float, tell: Callable[[int, int], None]) -> Iterator[Picture]:
    """All frames; `tell` is called with how many are done, and of how many. Raises ClipError: one cannot be
    read."""
    for index in range(len(clip)):
        tell(index, len(clip))
        yield picture_of(clip.read_frame(index), lens, unit)


def parts_of(
    pictures: Iterable[Picture], begin: Callable[[Picture], Following]
) -> tuple[list[Following], list[LostFrame]]:
    """Every part that `begin`, which raises Lost, made of a frame; and the frames that are in none.

    Where one ends, the longest goes on if it can: what covered its view is gone.
    """
    parts, lost = list[Following](), list[LostFrame]()
    now: Following | None = None
    for picture in pictures:
        if now is not None and picture.index - now.last > MOST_BRIDGED + 1:
            now = None
        why = "" if now is None else _why_not(now, picture)
        if now is not None and not why:
            continue
        longest = max(parts, key=len, default=None)
        if longest is not None and longest is not now and _is_seen_again(longest, picture):
            now = longest
            continue
        if now is None:
            try:
                now = begin(picture)
                parts.append(now)
                continue
            except Lost as reason:
                why = str(reason)
        lost.append(LostFrame(picture.index, why))
    return parts, lost


def _is_seen_again(part: Part, picture: Picture) -> bool:
    """Whether a part that is worth it goes on."""
    return len(part) >= SHORTEST and not _why_not(part, picture, _RESEEN)


def _why_not(part: Part, picture: Picture, share: float = 0.0) -> str:
    """Why the part does not go on with the picture; empty where it does."""
    try:
        part.follow(picture, share)
    except Lost as reason:
        return str(reason)
    return ""
