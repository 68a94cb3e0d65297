"""The images beside the one that is open, in its folder: off the window's thread, and none of them read."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from renderer.readers.image_folders.stills import images_in


@dataclass(frozen=True)
class NeighboursRequest:
    image: Path


@dataclass(frozen=True)
class Neighbours:
    images: tuple[Path, ...] = ()
    """In natural order, the one that is open among them."""

    def place(self, image: Path | None) -> int | None:
        """Of an image, from 0; None where it is none of them."""
        return None if image is None else self._places.get(image)

    @cached_property
    def _places(self) -> dict[Path, int]:
        """Asked for several times in each frame of the window, of a folder that may hold thousands."""
        return {image: place for place, image in enumerate(self.images)}

    def onward(self, image: Path | None, by: int) -> tuple[Path, ...]:
        """From the one that is `by` on or back, as far as they go, to the last one in that direction."""
        place = self.place(image)
        if place is None or by == 0:
            return ()
        if by > 0:
            return self.images[max(min(place + by, len(self.images) - 1), place + 1) :]
        return tuple(reversed(self.images[: max(place + by, 0) + 1])) if place else ()

    def from_end(self, image: Path | None, *, last: bool) -> tuple[Path, ...]:
        """From the last one, or the first, as far as those beside the one that is open."""
        place = self.place(image)
        if place is None:
            return ()
        return tuple(reversed(self.images[place + 1 :])) if last else self.images[:place]


def find_neighbours(request: NeighboursRequest) -> Iterator[Neighbours]:
    """Raises OSError: the folder cannot be listed."""
    yield Neighbours(images_in(request.image.parent))
