"""A long text in the comments of a PLY file, over as many lines as it takes.

Readers hold a line in a buffer: RPly, which is in Open3D and CloudCompare, aborts on one of 1024 bytes, and
MeshLab refuses it. The first line begins with a word, those that go on with the same and a plus sign.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

LONGEST: Final = 240
"""Bytes of a line, with `comment`: some programs have a buffer of 256."""
START: Final = "comment "


def split(word: str, text: str) -> tuple[str, ...]:
    """Comments that `joined` makes `text` of again.

    `text` is JSON in ASCII: programs that write a file again may take several spaces for one, so that all but
    the first of a row become escapes, and none is at the end of a line.
    """
    return tuple(_lines(word, text.replace("  ", " \\u0020")))


def _lines(word: str, text: str) -> Iterator[str]:
    start, head = 0, word
    while start < len(text):
        end = min(start + LONGEST - len(START) - len(head) - 1, len(text))
        while end < len(text) and " " in text[end - 1 : end + 1]:
            end -= 1
        yield f"{head} {text[start:end]}"
        start, head = end, f"{word}+"


def joined(word: str, comments: Sequence[str]) -> str | None:
    """The text after `word`, of one line as files of old have it or of several; None where there is none."""
    parts = [comment.partition(" ") for comment in comments]
    starts = [place for place, (first, _, _) in enumerate(parts) if first == word]
    if not starts:
        return None
    text = parts[starts[0]][2]
    for first, _, more in parts[starts[0] + 1 :]:
        if first != f"{word}+":
            break
        text += more
    return text
