"""The frames of a DICOM object that holds them one by one."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from renderer.clip import ClipError
from renderer.readers.dicom.header import DicomHeader, read_header
from renderer.readers.dicom.lossless import decoded_frame, is_lossless
from renderer.readers.dicom.opening import opened_dicom
from renderer.readers.dicom.stream import EXPLICIT, fragments
from renderer.regular_files import require_regular

RLE: Final = "1.2.840.10008.1.2.5"
ROOM: Final = 1.1
"""Beyond its pixels, what run lengths may take where they find no runs."""
END_OF_IMAGE: Final = b"\xff\xd9"
"""Of JPEG, JPEG-LS and JPEG 2000."""
PADDED: Final = 10
"""Last bytes of a fragment in which pydicom looks for it."""


def read_pixels(path: Path, header: DicomHeader, index: int) -> NDArray[Any]:
    """(H, W) grey or (H, W, 3) RGB of a frame: uint8, or uint16 over its whole range where it has more bits.

    Raises:
        ClipError: the frame is damaged, of a kind that no picture of an endoscope has, or of a compression
            that nothing here decodes.
    """
    _require_kind(path, header)
    with opened_dicom(path) as file:
        stored = _stored(file, path, header, index)
        if header.photometric == "PALETTE COLOR":
            stored = _looked_up(path, stored)
        if stored.shape[:2] != header.size[::-1] or stored.shape[2:] not in ((), (3,)):
            got = f"one of the shape {stored.shape}"
            raise ClipError(f"expected a frame of {header.size[0]}x{header.size[1]}, got {got}: {path}")
        return _whole_range(stored, header)


def _stored(file: io.BufferedReader, path: Path, header: DicomHeader, index: int) -> NDArray[Any]:
    """RGB of YBR; else as stored. Raises ClipError, or what pydicom and FFmpeg raise."""
    from pydicom.encaps import get_frame
    from pydicom.pixels.utils import pixel_array

    frame = b""
    if header.is_encapsulated:
        file.seek(header.pixels_at + EXPLICIT)
        frame = get_frame(file, index, number_of_frames=header.frames)
    if is_lossless(header):
        return decoded_frame(frame, header)
    _require_decoder(path, header)
    if header.is_encapsulated:
        _require_fit(frame, path, header, index)
    file.seek(0)
    return np.asarray(pixel_array(file, index=index))


def read_still(path: Path) -> NDArray[Any]:
    """The only frame, or the first. Raises ClipError as `read_header` and `read_pixels`."""
    header = read_header(path)
    if header.is_stream:
        raise ClipError(f"expected a DICOM file with one image, got a video: open it on its own: {path}")
    return read_pixels(path, header, 0)


def whole_frames(path: Path, header: DicomHeader) -> int:
    """How many of the frames announced lie in the file as a whole. Raises ClipError, OSError."""
    if header.is_encapsulated:
        return min(header.frames, _whole_compressed(path, header))
    width, height = header.size
    bits = width * height * header.samples * header.bits_allocated
    if header.photometric == "YBR_FULL_422":
        bits = bits * 2 // 3
    return min(header.frames, (require_regular(path) - header.pixels_at - EXPLICIT + 4) * 8 // max(bits, 1))


def _whole_compressed(path: Path, header: DicomHeader) -> int:
    """Of fragments that end before the file does, where a frame has one; else of those that end a frame."""
    from pydicom.encaps import parse_basic_offsets

    parts, end = list(fragments(path, header)), require_regular(path)
    whole = [(start, size) for start, size in parts if start + size < end]
    if not whole:
        return 0
    with opened_dicom(path) as file:
        file.seek(header.pixels_at + EXPLICIT)
        begins = {parts[0][0] + offset for offset in parse_basic_offsets(file)}
        has_several = bool(begins) and any(start not in begins for start, _ in parts)
        if len(parts) <= header.frames and not has_several:
            return len(whole)
        return sum(_ends_a_frame(file, start + size) for start, size in whole) or len(whole)


def _ends_a_frame(file: io.BufferedReader, at: int) -> bool:
    """Whether the end of an image stands before this place, and perhaps some padding."""
    file.seek(at - PADDED)
    return END_OF_IMAGE in file.read(PADDED)


def _require_kind(path: Path, header: DicomHeader) -> None:
    if header.is_signed or header.bits_allocated not in (1, 8, 16) or header.samples not in (1, 3):
        signed = "signed " if header.is_signed else ""
        got = f"{header.samples} of {signed}{header.bits_allocated} bits"
        raise ClipError(f"expected a DICOM image of 1 or 3 values of 8 or 16 bits a pixel, got {got}: {path}")
    if not 0 < header.bits_stored <= header.bits_allocated:
        got = f"{header.bits_stored} of {header.bits_allocated} bits"
        raise ClipError(f"expected a DICOM image that stores some of its bits, got {got}: {path}")


def _require_decoder(path: Path, header: DicomHeader) -> None:
    """Raises ClipError, naming what decodes it."""
    from pydicom.pixels.decoders.base import get_decoder
    from pydicom.uid import UID

    syntax = UID(header.transfer_syntax)
    try:
        decoder = get_decoder(syntax)
    except NotImplementedError as error:
        raise ClipError(
            f"expected a DICOM image of a known compression, got {syntax.name}: {path}"
        ) from error
    if not decoder.is_available:
        lacking = "; or ".join(decoder.missing_dependencies)
        raise ClipError(f"a DICOM image of {syntax.name} needs a decoder ({lacking}): {path}")


def _require_fit(frame: bytes, path: Path, header: DicomHeader, index: int) -> None:
    """Raises ClipError: the compressed frame is damaged, or unpacks to more than the header announces."""
    width, height = header.size
    if header.transfer_syntax == RLE:
        most = ROOM * width * height * header.samples * header.bits_allocated / 8 + 1024
        if len(frame) > most:
            raise ClipError(f"expected at most {most:.0f} bytes a frame, got {len(frame)}: {path}")
        return
    try:
        with Image.open(io.BytesIO(frame)) as picture:
            size = picture.size
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        wanted = f"expected an intact frame {index + 1} of {header.frames}"
        raise ClipError(f"{wanted}, got a damaged one: {path}") from error
    if size != header.size:
        raise ClipError(f"expected a frame of {width}x{height}, got {size[0]}x{size[1]}: {path}")


def _looked_up(path: Path, stored: NDArray[Any]) -> NDArray[Any]:
    from pydicom.pixels.processing import apply_color_lut

    from renderer.readers.dicom.header import read_dataset

    with opened_dicom(path) as file:
        return np.asarray(apply_color_lut(stored, read_dataset(file, path)))[..., :3]


def _whole_range(stored: NDArray[Any], header: DicomHeader) -> NDArray[Any]:
    """The values such that the brightest that can be stored is white."""
    wide = stored.dtype.itemsize > 1
    kind, white = (np.uint16, 65535) if wide else (np.uint8, 255)
    most = white if header.photometric == "PALETTE COLOR" else (1 << header.bits_stored) - 1
    if header.photometric == "MONOCHROME1":
        stored = most - (stored & most)
    if most != white:
        # Bits above those stored may hold an overlay.
        stored = ((stored & most).astype(np.uint32) * white + most // 2) // most
    return np.ascontiguousarray(stored, dtype=kind)
