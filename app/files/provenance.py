"""Where a file comes from: JSON inside images and splat files, or beside what carries none.

No absolute path and no user name: a source is named by its base name and its SHA-256.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
import tomllib
from collections.abc import Iterable
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed_version
from pathlib import Path, PurePath
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic_core import to_jsonable_python

from app.errors import UserError
from app.files.atomic import write_bytes
from app.files.embedded import CARRIERS, KEYWORD, carried, carrying
from renderer.json_files import parsed
from renderer.layouts import layout_of
from renderer.ply_comments import split
from renderer.readers.clip_files import files_in
from renderer.regular_files import read_whole, require_regular
from renderer.sog_list import is_unpacked_sog

APP = "VesselSplat"
PACKAGE = "vesselsplat"
SOURCE = Path(__file__).parents[2] / "pyproject.toml"
"""Of a checkout; where the program is installed otherwise there is none, or another program's."""
NOTICE = "Research use only. Not a medical device."
SCHEMA = 1
PIXEL_LIBRARIES = ("numpy", "numba", "opencv-contrib-python-headless", "pillow", "av")

Image = NDArray[np.uint8] | NDArray[np.uint16]


def version() -> str:
    """That of the checkout that it is run from, if any: an editable install has noted that of an earlier day.

    Raises UserError: the program is run from its source without having been installed.
    """
    try:
        noted = installed_version(PACKAGE)
    except PackageNotFoundError as error:
        raise UserError("expected VesselSplat to be installed: pip install -e . in its folder") from error
    return _source_version() or noted


@cache
def _source_version() -> str | None:
    try:
        project = tomllib.loads(SOURCE.read_text(encoding="utf-8"))["project"]
        return str(project["version"]) if project["name"] == PACKAGE else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def strict_json(value: object, *, indent: int | None = None) -> str:
    """JSON text of numbers, arrays, dataclasses and containers of them.

    NaN and infinities become null; what is not UTF-8 in the name of a file becomes a question mark.
    """
    text = json.dumps(plain(value), allow_nan=False, ensure_ascii=False, indent=indent)
    return text.encode(errors="replace").decode()


def plain(value: object) -> Any:
    """The same as JSON has it: dicts, lists, texts, numbers and null."""
    return to_jsonable_python(value, inf_nan_mode="null", fallback=_plain)


def comments(facts: object) -> tuple[str, ...]:
    """Short lines of ASCII for a PLY file, which takes no other text."""
    return split(KEYWORD, ascii_json(facts))


def ascii_json(facts: object) -> str:
    """For formats that take no other text."""
    return json.dumps(parsed(strict_json(facts)))


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"no JSON form for {type(value).__name__}")


def provenance(**facts: object) -> dict[str, Any]:
    """The given facts below what every export says: app, version, libraries, schema, UTC time, notice."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    head = {"app": APP, "version": version(), "schema": SCHEMA, "utc": now, "notice": NOTICE}
    return head | {"libraries": dict(libraries())} | facts


def stamp() -> str:
    """Local time to the millisecond, for names: they sort as made, and two in a second differ."""
    return datetime.now().astimezone().strftime("%Y%m%d-%H%M%S-%f")[:-3]


def repeatable(**facts: object) -> dict[str, Any]:
    """As `provenance`, without the hour: what is drawn of a model at exact moments and poses is the same file
    every time."""
    return {name: value for name, value in provenance(**facts).items() if name != "utc"}


@cache
def libraries() -> tuple[tuple[str, str], ...]:
    """Names and versions of what pixels pass through, and the kind of processor."""
    versions = ((name, installed(name) or "none") for name in PIXEL_LIBRARIES)
    return *versions, ("processor", f"{platform.machine()} {_processor_kind()}".rstrip())


def _processor_kind() -> str:
    """As compilers call it: kernels made for one kind round some last bits otherwise than for another."""
    try:
        from llvmlite.binding import get_host_cpu_name
    except ImportError:
        return ""
    return str(get_host_cpu_name())


def installed(name: str) -> str | None:
    """Version of a package; None: it is not there."""
    try:
        return installed_version(name)
    except PackageNotFoundError:
        return None


def digest(path: Path) -> str:
    """SHA-256 in hex of a file's bytes, or of the manifest (relative name, SHA-256) of a folder's files.

    Of a clip the manifest holds what its reader uses, so that a run kept inside it, or what a file manager
    leaves there, is no change; of another folder, its visible files.

    Raises OSError: there is no such file or folder, or it is something else.
    """
    if not path.is_dir():
        return _sha256(path)
    return _manifest(path, digested_files(path))


def digested_files(path: Path) -> tuple[Path, ...]:
    """Those that the digest of a file or folder is of."""
    if path.is_file():
        return (path,)
    # The list of an unpacked SOG counts as its images do.
    used = () if is_unpacked_sog(path) else layout_of(path).files(path)
    return used or tuple(files_in(path))


def _sha256(path: Path) -> str:
    require_regular(path)
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _manifest(folder: Path, files: Iterable[Path]) -> str:
    whole = folder.resolve()
    # By name: a reader may come upon one file by two ways.
    named = {_name_in(path, folder, whole): path for path in files}
    manifest = hashlib.sha256()
    # As Linux orders paths; those of Windows compare without case, and would give a digest of their own.
    for name in sorted(named, key=lambda name: name.parts):
        manifest.update(os.fsencode(name.as_posix()) + f"\0{_sha256(named[name])}\n".encode())
    return manifest.hexdigest()


def _name_in(path: Path, folder: Path, whole: Path) -> PurePath:
    """Relative to the folder; of a file beside it, such as a right picture, the same wherever both lie."""
    for place in (folder, whole):
        if path.is_relative_to(place):
            return PurePath(path.relative_to(place))
    return PurePath("..", path.parent.name, path.name)


def write_png(path: Path, image: Image, facts: dict[str, Any], profile: bytes = b"") -> None:
    """Write atomically an (H, W), (H, W, 3) RGB or (H, W, 4) RGBA image with its provenance, and its ICC
    `profile` or the tag of sRGB."""
    write_bytes(path, encode_png(image, facts, profile))


def write_sidecar(path: Path, facts: dict[str, Any]) -> None:
    """Write the provenance of a file whose format carries none beside it, as NAME.json."""
    write_bytes(path.with_name(f"{path.name}.json"), strict_json(facts, indent=2).encode())


def encode_png(image: Image, facts: dict[str, Any], profile: bytes) -> bytes:
    """The bytes of a PNG that carries `facts`; 8 or 16 bits a channel as the image has. Without an ICC
    `profile`, its colours are those of sRGB."""
    order = {3: cv2.COLOR_RGB2BGR, 4: cv2.COLOR_RGBA2BGRA}
    stored = cv2.cvtColor(image, order[image.shape[2]]) if image.ndim == 3 else image
    done, encoded = cv2.imencode(".png", stored)
    assert done
    return carrying(".png", encoded.tobytes(), strict_json(facts), profile)


def read_provenance(path: Path) -> dict[str, Any]:
    """The facts inside an image of ours. Raises UserError when there are none."""
    text = carried(read_whole(path))
    if text is None:
        raise UserError(f"expected an image written by VesselSplat, found no provenance in {path.name}")
    return facts_of(text, path)


def is_ours(path: Path) -> bool:
    """Whether a file says that this program made it, or, where it says nothing, the JSON beside it."""
    beside = path.with_name(f"{path.name}.json")
    try:
        inside = carried(read_whole(path)) if path.suffix.lower() in CARRIERS else None
        return facts_of(read_whole(beside) if inside is None else inside, path).get("app") == APP
    except (UserError, OSError):
        return False


def facts_of(text: str | bytes, path: Path) -> dict[str, Any]:
    """Of the JSON that `path` holds. Raises UserError: it is none, or no object."""
    try:
        facts = parsed(text)
    except ValueError as error:
        raise UserError(f"expected the JSON of a provenance ({error}): {path}") from error
    if not isinstance(facts, dict):
        raise UserError(f"expected a JSON object, got {type(facts).__name__}: {path}")
    return facts
