"""What is said of the files in a folder of images that are none of its frames."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator
from pathlib import Path

from renderer.listing import listed
from renderer.pyav_presence import has_pyav
from renderer.readers.image_files.coded_picture import CODED
from renderer.readers.image_files.file_kinds import is_visible

NOT_READABLE = "left out, not readable"


def passed_over(files: Iterable[Path], told: Container[Path], wanted: str = "images") -> Iterator[str]:
    """Sentences about those that are not among the `told`, frames and what is told otherwise; frames are
    `wanted`. A record that lies beside the file that it tells of goes without a word."""
    strays = (path for path in files if path not in told and not _is_record(path))
    left = sorted(strays, key=lambda path: path.name)
    coded = [path.name for path in left if path.suffix.lower() in CODED and not has_pyav()]
    others = [path.name for path in left if path.name not in coded]
    if coded:
        yield f"{NOT_READABLE} without PyAV: {listed(coded)}"
    if others:
        yield f"left out, not {wanted}: {listed(others)}"


def broken_links(entries: Iterable[Path]) -> Iterator[str]:
    """A sentence about those of a folder that are links to nothing, which may have been frames."""
    if lost := sorted(entry.name for entry in entries if is_visible(entry) and not entry.exists()):
        yield f"left out, broken links: {listed(lost)}"


def _is_record(path: Path) -> bool:
    return path.suffix == ".json" and path.with_suffix("").is_file()
