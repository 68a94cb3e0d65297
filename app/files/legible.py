"""Names as the screen can show them, and those that nothing but the file system can spell."""

from __future__ import annotations

import re
import unicodedata
from datetime import datetime
from pathlib import Path
from typing import Final

from app.errors import UserError
from renderer.utf8_paths import not_utf8

NAMES: Final = {
    "clahe": "CLAHE",
    "msrcr": "MSRCR",
    "aindane": "AINDANE",
    "aindane-green": "AINDANE, green",
    "wang2020": "Wang 2020",
    "jiang2019": "Jiang 2019",
    "vesselsplat": "VesselSplat",
    "deform3dgs": "Deform3DGS",
    "endogaussian": "EndoGaussian",
}
"""Methods as their authors write them."""


def in_utf8(text: str) -> str:
    """`text` with a question mark for what UTF-8 cannot say: bytes of a file name in another encoding."""
    return text.encode("utf-8", "replace").decode("utf-8")


def legible(text: str) -> str:
    """The same with accents on their letters, as fonts have them: some systems name files with them apart."""
    return unicodedata.normalize("NFC", in_utf8(text))


def in_one_line(name: str) -> str:
    """The name of a file, which may hold line breaks, for a place that has one line."""
    return re.sub(r"[\x00-\x1f\x7f]+", " ", legible(name))


def as_label(name: str) -> str:
    """`name` for a control of the window, all of which is shown.

    ImGui hides what begins with two hashes. They are parted here, by what has no width.
    """
    return re.sub("#(?=#|$)", "#\N{ZERO WIDTH SPACE}", in_one_line(name))


def require_utf8(path: Path) -> None:
    """Video decoders crash on other paths, and run.json cannot name them. Raises UserError."""
    if said := not_utf8(path):
        raise UserError(said)


def located(folder: Path) -> str:
    """Where a folder is: from the home folder on, so that no user is named, else its whole path."""
    try:
        inside = folder.relative_to(Path.home())
        return f"{inside.as_posix()}/" if inside.parts else "the home folder"
    except (ValueError, RuntimeError):
        return str(folder)


def named(method: str) -> str:
    """A method of enhancement or reconstruction, or a word of the command line, as a person writes it."""
    return NAMES.get(method, method.capitalize())


def grouped(number: int) -> str:
    """Thousands apart: 28,310."""
    return f"{number:,}"


def to_minute(moment: datetime) -> str:
    """In the hours of this place, ISO 8601: 2026-02-14 09:30."""
    return moment.astimezone().strftime("%Y-%m-%d %H:%M")


def without_flags(text: str) -> str:
    """Without hints at flags in brackets, which only the command line has."""
    return re.sub(r" \(--[^()]*\)", "", text)


def capital(text: str) -> str:
    """As a sentence begins; a file's name at the start stays as it is."""
    first = text.split(" ", 1)[0].rstrip(":,;")
    return text[:1].upper() + text[1:] if first.isalpha() else text
