"""Small files that a person's clicks leave behind, written off the window's thread in their order."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from app.files.atomic import write_bytes


@dataclass(frozen=True, eq=False)
class WriteRequest:
    """A file with its whole content."""

    path: Path
    content: bytes
    trouble: str
    """What it means that it cannot be written, as the beginning of a sentence."""
    announced: bool = False
    """A person has asked for the very file: what becomes of it is shown, else only trouble is noted."""


def write_file(request: WriteRequest) -> Iterator[Path]:
    """Answers a WriteRequest; folders above the file are made. Raises OSError or UserError."""
    write_bytes(request.path, request.content)
    yield request.path
