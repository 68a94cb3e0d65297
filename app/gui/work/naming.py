"""Which name a file will have: a look at the folder that it goes into, off the window's thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from app.exports.exporting import free_name
from app.files.video_encoder import VideoEncoder, video_encoder


@dataclass(frozen=True)
class NameRequest:
    """A name as wished for; `written` grows with every file, after which it may be taken."""

    folder: Path
    stem: str
    suffix: str
    written: int

    @property
    def name(self) -> str:
        return f"{self.stem}{self.suffix}"


def name_of(request: NameRequest) -> Iterator[str]:
    """Answers a NameRequest."""
    yield free_name(request.folder, request.stem, request.suffix)


def encoder_of(request: object) -> Iterator[VideoEncoder]:
    """What writes videos on this machine."""
    yield video_encoder()
