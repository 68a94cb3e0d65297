"""Named views and a camera path as JSON: cameras as `Camera.to_json`, lengths in the clip's unit."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, TypeVar

from renderer.camera import Camera
from renderer.camera_files import CameraFileError, NamedCamera, read_cameras
from renderer.camera_path import CameraPath, Keyframe
from renderer.json_files import read_json

FORMAT: Final = "vesselsplat views"
VERSION: Final = 1
UNITS: Final = {"seconds": "s from the path's beginning", "time": "of the clip, 0 to 1", "lens": "px"}
HEAD: Final = 256
"""Bytes of a file that say whether it is one of ours."""
MOST: Final = 2000
"""Named views, and keyframes."""
LONGEST: Final = 100
"""Characters of a name; the rest is cut off."""
T = TypeVar("T")


@dataclass(frozen=True)
class Views:
    """What a person keeps of where to look from.

    Raises:
        ValueError: more views or keyframes than there may be.
    """

    named: tuple[NamedCamera, ...] = ()
    path: CameraPath = field(default_factory=lambda: CameraPath(()))
    loop: bool = False
    """Played again and again."""
    unit: str = "scene units"
    """Of lengths."""

    def __post_init__(self) -> None:
        for count, what in ((len(self.named), "views"), (len(self.path.keyframes), "keyframes")):
            if count > MOST:
                raise ValueError(f"expected at most {MOST} {what}, got {count}")


def views_json(views: Views) -> bytes:
    """What `read_views` reads, to the last bit of every number."""
    keyframes = [
        {"seconds": key.seconds, "time": key.time, "camera": key.camera.to_json()}
        for key in views.path.keyframes
    ]
    content = {
        "format": FORMAT,
        "version": VERSION,
        "units": {"length": views.unit, **UNITS},
        "views": [{"name": one.name, "camera": one.camera.to_json()} for one in views.named],
        "path": {"loop": views.loop, "keyframes": keyframes},
    }
    return json.dumps(content, indent=1, allow_nan=False).encode()


def read_views(path: Path) -> Views:
    """What `views_json` gave.

    Raises:
        CameraFileError: no such file, or another content: what was expected, what came, and at which place.
    """
    try:
        content = read_json(path)
    except OSError as error:
        raise CameraFileError(f"cannot read the file of views, {error.strerror}: {path}") from error
    except ValueError as error:
        raise CameraFileError(f"expected a file of views in JSON ({error}): {path}") from error
    try:
        return views_of(content)
    except ValueError as error:
        raise CameraFileError(f"{error}: {path}") from error


def may_hold_views(path: Path) -> bool:
    """JSON, or text that lies beside cameras of COLMAP; not a text of another kind."""
    beside = (path.parent / name for name in ("cameras.txt", "images.txt"))
    return path.suffix.lower() == ".json" or any(one.is_file() for one in beside)


def import_views(path: Path) -> Views:
    """Of our file, or the cameras of another program's as named views; of COLMAP its folder or a file in it.

    Raises CameraFileError as `read_views` and `read_cameras` do.
    """
    if path.suffix.lower() == ".txt":
        return _of_others(path.parent)
    try:
        ours = path.is_file() and _begins_as_ours(path)
    except OSError as error:
        raise CameraFileError(f"expected a camera file, {error.strerror}: {path}") from error
    return read_views(path) if ours else _of_others(path)


def _of_others(path: Path) -> Views:
    cameras = read_cameras(path)
    try:
        return Views(tuple(NamedCamera(one.name[:LONGEST], one.camera) for one in cameras))
    except ValueError as error:
        raise CameraFileError(f"{error}: {path}") from error


def _begins_as_ours(path: Path) -> bool:
    with path.open("rb") as file:
        return FORMAT.encode() in file.read(HEAD)


def views_of(content: Any) -> Views:
    """From what the JSON of `views_json` holds. Raises ValueError: something else."""
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise ValueError(f'expected "format": "{FORMAT}" at the top')
    if content.get("version") != VERSION:
        raise ValueError(f"expected version {VERSION}, got {content.get('version')!r}")
    path = _get(content, "path", dict, "at the top")
    keyframes = _each(_get(path, "keyframes", list, "in path"), "path.keyframes", _keyframe)
    return Views(
        named=_each(_get(content, "views", list, "at the top"), "views", _named),
        path=_path(keyframes),
        loop=_get(path, "loop", bool, "in path"),
        unit=_get(_get(content, "units", dict, "at the top"), "length", str, "in units"),
    )


def _path(keyframes: tuple[Keyframe, ...]) -> CameraPath:
    try:
        return CameraPath(keyframes)
    except ValueError as error:
        raise ValueError(f"expected keyframes in order, in path.keyframes {error}") from error


def _each(items: list[Any], place: str, read: Callable[[dict[str, Any]], T]) -> tuple[T, ...]:
    """Every item of a list; what is wrong with one says which."""
    found = []
    for index, item in enumerate(items):
        try:
            if not isinstance(item, dict):
                raise ValueError(f"expected an object, got {type(item).__name__}")
            found.append(read(item))
        except (ValueError, OverflowError) as error:
            raise ValueError(f"{error} (in {place}[{index}])") from error
    return tuple(found)


def _named(item: dict[str, Any]) -> NamedCamera:
    return NamedCamera(_get(item, "name", str)[:LONGEST], Camera.from_json(_get(item, "camera", dict)))


def _keyframe(item: dict[str, Any]) -> Keyframe:
    key = Keyframe(
        float(_get(item, "seconds", (int, float))),
        float(_get(item, "time", (int, float))),
        Camera.from_json(_get(item, "camera", dict)),
    )
    CameraPath((key,))
    return key


def _get(values: dict[str, Any], name: str, kind: Any, place: str = "") -> Any:
    """Raises ValueError when it is missing or of another kind."""
    value = values.get(name)
    is_bool = isinstance(value, bool) and kind is not bool
    if not isinstance(value, kind) or is_bool:
        kinds = kind if isinstance(kind, tuple) else (kind,)
        wanted = " or ".join(one.__name__ for one in kinds)
        got = "nothing" if value is None else repr(value)[:40]
        where = f" {place}" if place else ""
        raise ValueError(f'expected "{name}" ({wanted}){where}, got {got}')
    return value
