"""Writes the file of a Splats or MovingSplats record, in the format of its suffix."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final, Literal

from app.errors import UserError
from app.exports.records import MovingSplats, Splats
from app.exports.splats import fourdgs, usd
from app.exports.splats.glb import splats_glb
from app.files.atomic import together, write_bytes
from app.files.provenance import comments, write_sidecar
from app.scenes.scene import Scene
from renderer.raw_gaussians import RawGaussians
from renderer.splat_files import packed_writing, spz_writing, write_splats
from renderer.splat_files.inria_ply import ply_bytes
from renderer.splat_files.packed_writing import packed_ply_bytes
from renderer.splat_files.splat_file import require_drawable

SPZ: Final = ".spz"
COMPRESSED: Final = ".compressed.ply"
CLIPPED: Final[Mapping[str, Callable[[RawGaussians], tuple[str, ...]]]] = {
    SPZ: spz_writing.clipped,
    COMPRESSED: packed_writing.clipped,
}
"""Of files whose names end so, what they do not hold."""
Moving = Callable[[MovingSplats, Scene, Path], Generator[int, None, None]]
MOVING: Final[Mapping[str, tuple[Callable[[], None], Moving]]] = {
    ".usdc": (usd.require_splats_in_usd, usd.write_usd),
    fourdgs.SUFFIX: (fourdgs.require_fourdgs, fourdgs.write_fourdgs),
}
"""Of files that hold the whole clip: what raises UserError where a package is lacking, and the writer."""


def layout_of(ending: str) -> Literal["compressed"] | None:
    """What the record of a file whose name ends so says."""
    return "compressed" if ending == COMPRESSED else None


def clipped(ending: str, raw: RawGaussians) -> tuple[str, ...]:
    """What a file whose name ends so does not hold of the Gaussians, in words."""
    told = (tell for end, tell in CLIPPED.items() if ending.endswith(end))
    return next((tell(raw) for tell in told), ())


def write_moment(record: Splats, scene: Scene, target: Path) -> None:
    """The Gaussians where they are at the time of the record, which is in a PLY file and beside any other;
    their spherical harmonics are filled up with zeros to its degree.

    Raises:
        UserError: one that would lose colours, splats that cannot be drawn, or more than the format holds.
    """
    degree = record.sh_degree
    moved = scene.model.motion.moved(scene.model.raw, record.time)
    try:
        moved = moved if degree is None else moved.of_degree(degree)
    except ValueError as error:
        got = f"{degree} for {error}"
        raise UserError(f"--sh-degree: expected one that holds the whole model, got {got}") from error
    try:
        require_drawable(moved)
    except ValueError as error:
        raise UserError(f"{error}: {target}") from error
    ending = COMPRESSED if record.layout == "compressed" else target.suffix.lower()
    record = replace(record, clipped=clipped(ending, moved) or None)
    if target.suffix.lower() == ".ply":
        written = packed_ply_bytes if record.layout == "compressed" else ply_bytes
        write_bytes(target, written(moved, scene.mode, comments(record.signed)))
        return
    if target.suffix.lower() == ".glb":
        name = record.clip.name if record.clip else scene.name
        write_bytes(target, splats_glb(moved, scene.mode, scene.unit, name, record.signed))
        return
    with together(target) as place:
        try:
            write_splats(place, moved, scene.mode)
        except ValueError as error:
            raise UserError(f"{error}: {target}") from error
        write_sidecar(place, record.signed)


def write_moving(record: MovingSplats, scene: Scene, target: Path) -> Generator[int, None, None]:
    """The whole clip; yields frames done.

    Raises:
        UserError: no such format, no package for it, or Gaussians that are others at every moment.
    """
    suffix = target.suffix.lower()
    if suffix not in MOVING:
        raise UserError(f"expected a clip as {', '.join(MOVING)}, got {target.name}")
    _, write = MOVING[suffix]
    yield from write(record, scene, target)
