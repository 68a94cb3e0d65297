"""Image files in and out: 8 and 16 bit, float, alpha kept; RGB order inside."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import ExifTags, ImageOps, UnidentifiedImageError

from app.errors import UserError
from app.files.atomic import together, write_bytes
from app.files.embedded import CARRIERS, JPEG_START, carrying
from app.files.netpbm import full_scale
from app.files.provenance import ascii_json, encode_png, write_sidecar
from renderer.budget import OverBudget
from renderer.clip import ClipError
from renderer.layouts import layout_of
from renderer.listing import listed
from renderer.readers.clip_files import folders_in
from renderer.readers.coded_still import open_coded_still
from renderer.readers.dicom.opening import is_dicom
from renderer.readers.image_files.coded_picture import is_coded, is_coded_still
from renderer.readers.image_files.file_kinds import SUFFIXES, is_picture, moves, natural_key
from renderer.readers.image_files.orientation import UPRIGHT, upright
from renderer.readers.image_files.picture_files import BROKEN, opened, read_npy, require_size
from renderer.readers.image_files.tiff_layouts import TiffLayout, tiff_layout
from renderer.readers.image_folders.passed_over import broken_links
from renderer.readers.image_folders.picture_kinds import PictureKinds, frame_folder, kinds_of
from renderer.readers.misnamed import what_it_is
from renderer.regular_files import what_else

ArrayImage = NDArray[Any]

TIFF = frozenset({".tif", ".tiff"})
JPEGS = frozenset({".jpg", ".jpeg"})
WEBP = ".webp"
ONE_OF = "name one of these (enhance --recursive takes all)"
PLAIN_NETPBM = (b"P1", b"P2", b"P3")
"""How images of numbers in ASCII begin."""


def is_image(path: Path) -> bool:
    """Whether the name is one of a picture, or of a numpy array that may hold one."""
    return is_picture(path) or path.suffix.lower() == ".npy"


def is_still(path: Path) -> bool:
    """Whether a file holds one picture: by its name, or of DICOM and of coded stills by its head."""
    return path.suffix.lower() == ".npy" or layout_of(path).name == "image"


def frames_in(folder: Path) -> PictureKinds:
    """Frames of a folder in natural order, and what lies beside them; else those of its images/, or of its
    one folder beside maps and masks; else its arrays.

    Raises:
        UserError: there are none.
    """
    inside = frame_folder(folder)
    files = sorted((path for path in inside.iterdir() if path.is_file()), key=natural_key)
    kinds = kinds_of(files)
    if not kinds.frames:
        kinds = PictureKinds(tuple(path for path in files if path.suffix.lower() == ".npy"))
    if not kinds.frames:
        folders = listed([path.name for path in folders_in(folder)])
        hint = f", which holds the folders {folders}: {ONE_OF}" if folders else ""
        lost = "".join(f"; {said}" for said in broken_links(inside.iterdir()))
        raise UserError(
            f"expected a folder with images, found none in {folder}{hint or _videos(files)}{lost}"
        )
    return kinds


def _videos(files: list[Path]) -> str:
    """What to do with a folder of videos; empty without any."""
    names = [path.name for path in files if moves(path)]
    return f", which holds the videos {listed(names)}: {ONE_OF}" if names else ""


def read_image(path: Path) -> ArrayImage:
    """(H, W) grey, (H, W, 3) RGB or (H, W, 4) RGBA with the values and type that the file stores.

    It is turned as its EXIF orientation says: H and W are those of the picture as it is looked at.

    Raises:
        UserError: missing, truncated, or no picture. The values are for the caller to judge.
    """
    if not path.is_file():
        raise UserError(
            f"expected an image, got {what_else(path) if path.exists() else 'no such file'}: {path}"
        )
    if path.suffix.lower() == ".npy":
        return _read_array(path)
    if is_dicom(path):
        return _read_dicom(path)
    if is_coded(path) or (path.suffix.lower() not in SUFFIXES and is_coded_still(path)):
        return open_coded_still(path).read_image(0)
    _require_size(path)
    layout = _layout(path)
    if layout and layout.misread:
        raise UserError(f"expected grey, RGB or RGBA values, got a TIFF of {layout.misread}: {path}")
    if layout and layout.is_lab:
        return _by_pillow(path, ("LAB",), "RGB", "CIE Lab that is not of 8 bits")
    if layout and layout.has_alpha and layout.bits <= 8:
        return _by_pillow(path, ("LA", "RGBA"), "RGBA", "alpha in a layout that is not known")
    orientation = UPRIGHT if path.suffix.lower() in TIFF else _checked(path)
    stored = _decoded(path)
    if stored is None:
        of_cmyk = layout is not None and layout.is_deep_cmyk
        got = "a TIFF of CMYK of more than 8 bits" if of_cmyk else "a damaged file or another kind"
        raise UserError(f"expected an intact image, got {got}: {path}")
    colored = _swapped(stored)
    colored = layout.meant(colored) if layout else colored
    return upright(colored, orientation)


def _swapped(image: ArrayImage) -> ArrayImage:
    """RGB of BGR and back, alpha and grey kept; OpenCV itself takes no float64 here."""
    return image if image.ndim == 2 else np.ascontiguousarray(image[..., [2, 1, 0, 3][: image.shape[2]]])


def _read_dicom(path: Path) -> ArrayImage:
    from renderer.readers.dicom.pixels import read_still

    try:
        return read_still(path)
    except ClipError as error:
        raise UserError(str(error)) from error


def _layout(path: Path) -> TiffLayout | None:
    """How a TIFF stores its values; None where it cannot be read."""
    try:
        return tiff_layout(path)
    except OSError:
        return None  # Its decoder says what is wrong.


def _by_pillow(path: Path, modes: tuple[str, ...], wanted: str, other: str) -> ArrayImage:
    """OpenCV would take Lab for RGB, and drop alpha or darken the colours by it.

    Raises:
        UserError: it is damaged, or Pillow reads it in none of these modes: it is of `other`.
    """
    try:
        with opened(path) as picture:
            if picture.mode in modes:
                return np.array(ImageOps.exif_transpose(picture).convert(wanted))
    except UnidentifiedImageError:
        pass
    except BROKEN as error:
        raise UserError(f"expected an intact image, got a damaged one ({error}): {path}") from error
    raise UserError(f"expected grey or RGB values, got a TIFF of {other}: {path}")


def _require_size(path: Path) -> None:
    try:
        require_size(path)
    except OverBudget as error:
        raise UserError(f"{error}: {path}") from error
    except BROKEN:
        return  # Its decoder says what is wrong.


def _decoded(path: Path) -> ArrayImage | None:
    """What OpenCV makes of the file, without its own words on stderr: a damaged file is one line of ours.

    It gets the bytes: names that are not ASCII or not UTF-8 fail or crash its own reader.
    """
    content = path.read_bytes()
    if content.startswith(PLAIN_NETPBM):
        content += b"\n"  # OpenCV takes a last number for a broken one where nothing ends it.
    # A JPEG may say by EXIF which way is up, which OpenCV passes over where it keeps an alpha channel.
    wanted = cv2.IMREAD_ANYCOLOR if content.startswith(JPEG_START) else cv2.IMREAD_UNCHANGED
    level = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        stored = cv2.imdecode(np.frombuffer(content, np.uint8), wanted)
    except cv2.error:
        return None
    finally:
        cv2.utils.logging.setLogLevel(level)
    return None if stored is None else full_scale(content, stored)


def _checked(path: Path) -> int:
    """OpenCV fills what a truncated file lacks without a word; Pillow tells. The orientation that is left.

    OpenCV turns JPEG and TIFF itself, and passes over what PNG and WebP say.
    """
    try:
        with opened(path) as picture:
            picture.load()
            told = picture.getexif().get(ExifTags.Base.Orientation, UPRIGHT)
            return UPRIGHT if picture.format == "JPEG" else int(told)
    except PermissionError:
        raise
    except BROKEN as error:
        if isinstance(error, UnidentifiedImageError) and (kind := what_it_is(path)):
            raise UserError(f"expected an image, got {kind}: {path}") from error
        reason = str(error).replace(str(path), path.name)
        raise UserError(f"expected an intact image, got a damaged one ({reason}): {path}") from error


def _read_array(path: Path) -> ArrayImage:
    try:
        return read_npy(path)
    except ValueError as error:
        raise UserError(f"expected one numpy array, {error}") from error


def write_image(
    path: Path, image: ArrayImage, facts: dict[str, Any], quality: int | None = None, profile: bytes = b""
) -> None:
    """Write atomically in the format of the suffix; PNG, JPEG and TIFF carry `facts` and the ICC `profile` of
    the colours, WebP the profile; other files than the first three have the facts beside them.

    `quality` is that of a JPEG, 1 to 100, which then keeps all of its colour's resolution.

    Raises:
        UserError: a suffix that is unknown or cannot hold this type of image.
    """
    suffix = path.suffix.lower()
    if suffix == ".png" and image.dtype in (np.uint8, np.uint16):
        write_bytes(path, encode_png(image, facts, profile))
        return
    content = _encoded(path, image, quality, profile)
    if suffix in CARRIERS:
        write_bytes(path, carrying(suffix, content, ascii_json(facts), profile))
        return
    with together(path) as place:
        write_bytes(place, content)
        write_sidecar(place, facts)


def _encoded(path: Path, image: ArrayImage, quality: int | None, profile: bytes) -> bytes:
    suffix = path.suffix.lower()
    if suffix == ".npy":
        buffer = io.BytesIO()
        np.save(buffer, image)
        return buffer.getvalue()
    if suffix not in SUFFIXES:
        raise UserError(f"expected an output named {', '.join(sorted(SUFFIXES))} or .npy, got {path.name}")
    if image.dtype != np.uint8 and suffix not in TIFF:
        raise UserError(
            f"{suffix} cannot hold {image.dtype} values; name the output {wide_formats(image)}: {path}"
        )
    # OpenCV would make bytes of half floats, which float32 holds exactly.
    storable = image.astype(np.float32) if image.dtype == np.float16 else image
    kinds, carried = list[int](), list[NDArray[np.uint8]]()
    if profile and suffix == WEBP:
        kinds, carried = [cv2.IMAGE_METADATA_ICCP], [np.frombuffer(profile, np.uint8)]
    settings = _settings(suffix, quality)
    done, encoded = cv2.imencodeWithMetadata(suffix, _swapped(storable), kinds, carried, settings)
    if not done:
        raise UserError(f"{suffix} cannot hold an image of shape {image.shape}: {path}")
    return encoded.tobytes()


def wide_formats(image: ArrayImage) -> str:
    """The formats that hold an image of more than 8 bits, in words."""
    return ".png, .tiff or .npy" if image.dtype == np.uint16 else ".tiff or .npy"


def _settings(suffix: str, quality: int | None) -> list[int]:
    """The encoder's settings for a JPEG of this quality; empty for its own defaults."""
    if quality is None or suffix not in JPEGS:
        return []
    whole = cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444
    return [cv2.IMWRITE_JPEG_QUALITY, quality, cv2.IMWRITE_JPEG_SAMPLING_FACTOR, whole]
