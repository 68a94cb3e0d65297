"""What a file is that its name does not tell: of use in a refusal, which then says what to do."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from renderer.file_signatures import ANYWHERE
from renderer.readers.dicom.opening import SUFFIXES
from renderer.regular_files import require_regular

HEAD: Final = 256
"""Bytes that tell."""
VIDEO: Final = "a video: rename it to its own suffix, such as .mp4"
DICOM: Final = "a DICOM file"
JPEG_XL: Final = "a JPEG XL image: convert it to PNG or JPEG first"
UNMARKED: Final = "a file without the mark of DICOM: dcmconv of DCMTK writes it with one"
HEIC: Final = "a HEIC image"
CONVERT: Final = "convert it to PNG or TIFF first"
BRANDS: Final = {b"heic": HEIC, b"heix": HEIC, b"mif1": HEIC, b"avif": "an AVIF image"}
"""Of ISO media files that are pictures."""
STARTS: Final = {
    **ANYWHERE,
    b"\xff\x0a": JPEG_XL,
    b"\x00\x00\x00\x0cJXL ": JPEG_XL,
    b"\x1a\x45\xdf\xa3": VIDEO,
    b"\x00\x00\x01\xba": VIDEO,
    b"\x00\x00\x01\xb3": VIDEO,
    b"\x30\x26\xb2\x75\x8e\x66\xcf\x11": VIDEO,
    b"\x76\x2f\x31\x01": f"an OpenEXR image: {CONVERT}",
    b"#?RADIANCE": f"a Radiance HDR image: {CONVERT}",
    b"%PDF": "a PDF document: export its images first",
    b"PK\x03\x04": "a zip archive: unpack it first",
    b"Rar!": "a RAR archive: unpack it first",
    b"\x1f\x8b": "a gzip file: unzip it first",
}
"""First bytes of what is met under names of pictures and videos."""


def what_it_is(path: Path) -> str | None:
    """The kind of a file by its first bytes, and what can be done about it; None where nothing tells."""
    try:
        require_regular(path)
        with path.open("rb") as file:
            head = file.read(HEAD)
    except OSError:
        return None
    if not head:
        return "an empty file"
    if head[128:132] == b"DICM":
        return DICOM
    if head[4:8] == b"ftyp":
        picture = BRANDS.get(head[8:12])
        return VIDEO if picture is None else f"{picture}: convert it to PNG or JPEG first"
    if head[:4] == b"RIFF" and head[8:12] == b"AVI ":
        return VIDEO
    found = next((kind for start, kind in STARTS.items() if head.startswith(start)), None)
    return UNMARKED if found is None and path.suffix.lower() in SUFFIXES else found


def barred(error: PermissionError) -> str:
    """What a file is that the system does not let us read."""
    return f"a file that may not be read ({error.strerror})"


def neither(path: Path) -> str:
    """The refusal of a file that is neither a picture nor a video, or that nobody lets us look into."""
    try:
        require_regular(path)
        path.open("rb").close()
    except PermissionError as error:
        return f"expected an image or a video, got {barred(error)}: {path}"
    except OSError:
        pass
    kind = what_it_is(path) or "a file that is neither, or a damaged one"
    if kind == DICOM:
        return f"expected a DICOM file with an image or a video, got one whose video is damaged: {path}"
    got = "a damaged video, or one that was cut off" if kind == VIDEO else kind
    return f"expected an image or a video, got {got}: {path}"
