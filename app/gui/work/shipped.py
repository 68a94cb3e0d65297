"""What ships with the program to be looked at: the images of the first page, and the pages of the guide."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from app.errors import UserError
from renderer.clip import ByteImage
from renderer.readers.image_files.pictures import read_rgb

Role = Literal["text", "point", "image"]


@dataclass(frozen=True)
class Block:
    """A paragraph, a point of a list, or an image with its name and what is to be seen in it."""

    role: Role
    text: str
    name: str = ""


@dataclass(frozen=True)
class Page:
    """One of the guide."""

    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True, eq=False)
class Guide:
    """All pages, in order, and their images by name."""

    pages: tuple[Page, ...]
    images: Mapping[str, ByteImage]


def read_guide(folder: Path) -> Iterator[Guide]:
    """Raises OSError, UserError or ClipError."""
    pages = tuple(parsed(file.read_text(encoding="utf-8")) for file in sorted(folder.glob("*.md")))
    if not pages:
        raise UserError(f"expected the pages of the guide, found none in {folder}")
    yield Guide(pages, _images(folder))


def read_welcome(folder: Path) -> Iterator[Mapping[str, ByteImage]]:
    """The images of the first page by name. Raises ClipError."""
    yield _images(folder)


def parsed(text: str) -> Page:
    """Of the little of Markdown that the pages need: a title, paragraphs, points and images, between empty
    lines."""
    title, *parts = [part.strip() for part in text.split("\n\n") if part.strip()]
    return Page(title.removeprefix("# "), tuple(block for part in parts for block in _blocks(part)))


def _blocks(part: str) -> Iterator[Block]:
    if part.startswith("!["):
        text, _, name = part.removeprefix("![").rstrip(")").partition("](")
        yield Block("image", text, name)
    elif part.startswith("- "):
        for point in part.removeprefix("- ").split("\n- "):
            yield Block("point", " ".join(point.split()))
    else:
        yield Block("text", " ".join(part.split()))


def _images(folder: Path) -> Mapping[str, ByteImage]:
    return {file.name: read_rgb(file) for file in sorted(folder.glob("*.jpg"))}
