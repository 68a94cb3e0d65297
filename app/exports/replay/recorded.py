"""The provenance of an exported file: inside an image or a PLY file, beside any other."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from app.errors import UserError
from app.exports.gltf import read_glb
from app.exports.html_file import facts_in
from app.exports.meshes.mesh_text import obj_comments
from app.exports.research.npz import PROVENANCE, read_text
from app.exports.usd_file import read_usd
from app.files.dicom.writing import facts_in_dicom
from app.files.embedded import CARRIERS, KEYWORD, carried
from app.files.provenance import facts_of, read_provenance
from renderer.ply_comments import joined
from renderer.ply_elements import PlyError, read_ply
from renderer.readers.dicom.opening import is_dicom
from renderer.regular_files import read_whole, what_else

Facts = dict[str, Any]


def recorded(path: Path) -> Facts:
    """Raises UserError: no such file, or nothing that VesselSplat wrote about it."""
    if not path.is_file():
        what = what_else(path) if path.exists() else "no such file"
        hint = "; name one of its files" if path.is_dir() else ""
        raise UserError(f"expected a file that VesselSplat wrote, got {what}{hint}: {path}")
    suffix = path.suffix.lower()
    if suffix in INSIDE:
        return INSIDE[suffix](path)
    if is_dicom(path):
        return _facts(facts_in_dicom(path), "a DICOM file", path)
    # Before 0.2.0, JPEG and TIFF had it beside them.
    inside = carried(read_whole(path)) if suffix in CARRIERS else None
    return _beside(path) if inside is None else facts_of(inside, path)


def _facts(text: str | None, kind: str, path: Path) -> Facts:
    if text is None:
        raise UserError(f"expected {kind} written by VesselSplat, found no provenance in {path}")
    return facts_of(text, path)


def _in_ply(path: Path) -> Facts:
    try:
        comments = read_ply(read_whole(path)).comments
    except PlyError as error:
        raise UserError(f"{error}: {path}") from error
    return _facts(joined(KEYWORD, comments), "a PLY file", path)


def _in_obj(path: Path) -> Facts:
    return _facts(joined(KEYWORD, obj_comments(read_whole(path))), "an OBJ file", path)


INSIDE: Final[Mapping[str, Callable[[Path], Facts]]] = {
    ".png": read_provenance,
    ".ply": _in_ply,
    ".glb": lambda path: read_glb(path)[0],
    ".usdc": lambda path: read_usd(path)[0],
    ".obj": _in_obj,
    ".npz": lambda path: facts_of(read_text(path, PROVENANCE), path),
    ".html": lambda path: facts_in(read_whole(path).decode(errors="replace")),
}
"""By suffix, how it is read from files that hold it."""


def _beside(path: Path) -> Facts:
    if path.suffix.lower() == ".json" and path.with_suffix("").is_file():
        raise UserError(
            f"expected the export itself, {path.with_suffix('').name}, got its provenance: {path}"
        )
    sidecar = path.with_name(f"{path.name}.json")
    if path.suffix.lower() == ".json" and not sidecar.is_file():
        raise UserError(f"expected an export that tells how it was made, got JSON, as of cameras: {path}")
    if not sidecar.is_file():
        raise UserError(f"expected {sidecar.name} beside {path.name}, which holds its provenance: {path}")
    return facts_of(read_whole(sidecar).decode(errors="replace"), sidecar)
