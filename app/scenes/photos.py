"""A clip's frame to lay over the 3D view, read off the window's thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from renderer.clip import ByteImage, Clip


@dataclass(frozen=True)
class PhotoRequest:
    clip: Clip
    frame: int

    @property
    def image(self) -> ByteImage:
        """(H, W, 3), read each time: a clip's photos fill the memory. Raises ClipError."""
        return self.clip.read_image(self.frame)


@dataclass(frozen=True, eq=False)
class Photo:
    """With the request that it answers."""

    request: PhotoRequest
    image: ByteImage
    """(H, W, 3)."""


def read_photo(request: PhotoRequest) -> Iterator[Photo]:
    """Raises ClipError: the file is gone or damaged."""
    yield Photo(request, request.image)
