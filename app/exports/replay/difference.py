"""How far two files of one kind differ: images, arrays, videos, splat files, tables, value by value."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from io import StringIO
from itertools import zip_longest
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.lib.recfunctions import structured_to_unstructured
from numpy.typing import NDArray

from app.errors import UserError
from app.exports.browser.page import read_page
from app.exports.gltf import read_glb
from app.exports.html_file import PROVENANCE, facts_in, found
from app.exports.meshes.mesh_text import obj_rows
from app.exports.records import CaseSummary
from app.exports.research.npz import read_members
from app.exports.splats import fourdgs
from app.exports.usd_file import read_usd
from app.files.image_files import read_image
from renderer.json_files import read_json
from renderer.ply_elements import read_ply
from renderer.readers.image_files.file_kinds import moves
from renderer.readers.video import open_video
from renderer.regular_files import read_whole
from renderer.splat_files import read_splats

Array = NDArray[Any]
END = b"end_header\n"


@dataclass(frozen=True)
class Difference:
    """Over all values of both files."""

    largest: float = 0.0
    """Absolute, in the file's own units: grey levels of a picture or a video."""
    share: float = 0.0
    """Of the values that are not the same, in [0, 1]."""
    scale: float | None = None
    """The largest value that the type holds; None for floats."""
    unlike: str = ""
    """How they cannot be compared: another size, type or number of frames."""

    @property
    def is_none(self) -> bool:
        return not self.unlike and self.share == 0

    @property
    def text(self) -> str:
        """In words."""
        if self.unlike:
            return f"differs, {self.unlike}"
        most = f"{self.largest:.4g}" + (f" of {self.scale:.0f}" if self.scale else "")
        return f"differs in {100 * self.share:.3g} % of its values, by at most {most}"


def difference(first: Path, second: Path) -> Difference:
    """Of two files with the same suffix."""
    largest, changed, count, scale = 0.0, 0, 0, None
    for place, (one, other) in enumerate(zip_longest(arrays(first), arrays(second))):
        if one is None or other is None:
            return Difference(unlike=f"one of the two ends after {place} frames")
        if (one.shape, one.dtype) != (other.shape, other.dtype):
            return Difference(
                unlike=f"{one.dtype} of shape {one.shape} became {other.dtype} of shape {other.shape}"
            )
        scale = float(np.iinfo(one.dtype).max) if one.dtype.kind == "u" else None
        apart = one.astype(np.float64) - other
        unequal = (one != other) & ~(np.isnan(one) & np.isnan(other))
        largest = max(largest, float(np.nanmax(np.abs(apart), initial=0.0)))
        changed, count = changed + int(unequal.sum()), count + one.size
    return Difference(largest, changed / max(count, 1), scale)


def arrays(path: Path) -> Iterator[Array]:
    """All that a file holds: one array of a picture, one a frame of a video, one a column of a table."""
    read = ARRAYS.get(path.suffix.lower())
    if read is not None:
        return read(path)
    return _frames(path) if moves(path) else iter((read_image(path),))


def _elements(path: Path) -> Iterator[Array]:
    """Of a PLY file; what has lists, as the faces of a mesh, as bytes."""
    content = read_whole(path)
    ply = read_ply(content)
    yield from (structured_to_unstructured(element.rows) for element in ply.elements)
    rows = sum(element.rows.nbytes for element in ply.elements)
    if lists := content[content.find(END) + len(END) + rows :]:
        yield np.frombuffer(lists, np.uint8)


def _of_splats(path: Path) -> Iterator[Array]:
    return iter(read_splats(path).raw.arrays().values())


def _of_obj(path: Path) -> Iterator[Array]:
    """Raises UserError: rows of other kinds than ours."""
    try:
        yield from obj_rows(read_whole(path))
    except ValueError as error:
        raise UserError(f"expected an OBJ mesh written by VesselSplat ({error}): {path}") from error


def _of_page(path: Path) -> Iterator[Array]:
    """Of a model, or of a summary: all of it but how it was made."""
    text = read_whole(path).decode(errors="replace")
    if facts_in(text).get("kind") == CaseSummary.kind:
        yield np.frombuffer(text.replace(found(text, "application/json", PROVENANCE), "").encode(), np.uint8)
    else:
        yield from _tracks(text)


def _tracks(text: str) -> Iterator[Array]:
    """Of a page for browsers: bounds and values, window by window; one without a list of them has one."""
    _, scene, content = read_page(text)
    for window in scene.get("windows", [scene]):
        for track in window["tracks"]:
            yield np.array([*track["low"], *track["high"]])
            shape = track["count"], track["moments"], track["channels"]
            kind = {1: np.uint8, 2: np.uint16, 4: np.float32}[track["bytes"]]
            yield np.frombuffer(content.tobytes(), kind, math.prod(shape), track["start"]).reshape(shape)
        yield np.array([scene["near"], scene["seconds"], scene["frames"], window["degree"]], np.float64)
    if "poses" in scene:
        yield np.array(scene["poses"], np.float64)


def _columns(path: Path) -> Iterator[Array]:
    """Of a table, then of the same in the JSON beside it where that has it: names, then each column as
    numbers or as text."""
    sidecar = path.with_name(f"{path.name}.json")
    rows = _rows(path)
    told = read_json(sidecar)
    for table in (rows, told["frames"]) if "frames" in told else (rows,):
        names = list(table[0]) if table else []
        yield _text(names)
        for name in names:
            values = ["" if row[name] is None else str(row[name]) for row in table]
            try:
                yield np.array([float(value or "nan") for value in values])
            except ValueError:
                yield _text(values)


def _rows(path: Path) -> list[dict[str, Any]]:
    """Raises UserError: it is no table whose rows are all as long as the first."""
    try:
        head, *lines = csv.reader(StringIO(read_whole(path).decode(), newline=""), strict=True)
        return [dict(zip(head, line, strict=True)) for line in lines]
    except (ValueError, csv.Error) as error:
        raise UserError(f"expected a table written by VesselSplat ({error}): {path}") from error


def _text(words: list[str]) -> Array:
    return np.frombuffer("\n".join(words).encode(), np.uint8)


def _frames(path: Path) -> Iterator[Array]:
    video = open_video(path)
    yield from (video.read_image(number) for number in range(len(video)))


ARRAYS: Final[Mapping[str, Callable[[Path], Iterator[Array]]]] = {
    ".ply": _elements,
    ".glb": lambda path: iter(read_glb(path)[1]),
    ".usdc": lambda path: iter(read_usd(path)[1]),
    fourdgs.SUFFIX: fourdgs.read_fourdgs,
    ".obj": _of_obj,
    ".spz": _of_splats,
    ".sog": _of_splats,
    ".npz": read_members,
    ".html": _of_page,
    ".csv": _columns,
}
"""By suffix; of all others, they are images."""
