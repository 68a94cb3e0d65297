"""First bytes of files that are met under any name, and what can be done about them."""

from __future__ import annotations

from typing import Final

PNG_SIGNATURE: Final = b"\x89PNG\r\n\x1a\n"
ANYWHERE: Final = {
    b"7z\xbc\xaf\x27\x1c": "a 7z archive: unpack it first",
    b"version https://git-lfs": "a Git LFS pointer: fetch the file itself with git lfs pull",
    b"<!DOCTYPE html": "a web page: download the file itself",
    b"<html": "a web page: download the file itself",
}
