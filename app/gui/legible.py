"""Names as the screen can show them."""

from __future__ import annotations


def legible(text: str) -> str:
    """`text` with a question mark for what UTF-8 cannot say: bytes of a file name in another encoding."""
    return text.encode("utf-8", "replace").decode("utf-8")
