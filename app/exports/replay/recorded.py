"""The provenance of an exported file: inside an image or a PLY file, beside any other."""

from __future__ import annotations

from pathlib import Path
from typing import Any

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
from renderer.regular_files import read_whole

Facts = dict[str, Any]


def recorded(path: Path) -> Facts:
    """Raises UserError: no such file, or nothing that VesselSplat wrote about it."""
    if not path.is_file():
        what = "a folder; name one of its files" if path.is_dir() else "no such file"
        raise UserError(f"expected a file that VesselSplat wrote, got {what}: {path}")
    suffix = path.suffix.lower()
    if suffix == ".png":
        return read_provenance(path)
    if suffix == ".ply":
        return _in_comment(path)
    if suffix == ".glb":
        return read_glb(path)[0]
    if suffix == ".usdc":
        return read_usd(path)[0]
    if suffix == ".obj":
        text = joined(KEYWORD, obj_comments(read_whole(path)))
        if text is None:
            raise UserError(f"expected an OBJ file written by VesselSplat, found no provenance in {path}")
        return facts_of(text, path)
    if suffix == ".npz":
        return facts_of(read_text(path, PROVENANCE), path)
    if is_dicom(path):
        return _in_dicom(path)
    if suffix == ".html":
        return facts_in(read_whole(path).decode(errors="replace"))
    # Before 0.2.0, JPEG and TIFF had it beside them.
    inside = carried(read_whole(path)) if suffix in CARRIERS else None
    return _beside(path) if inside is None else facts_of(inside, path)


def _in_dicom(path: Path) -> Facts:
    text = facts_in_dicom(path)
    if text is None:
        raise UserError(f"expected a DICOM file written by VesselSplat, found no provenance in {path}")
    return facts_of(text, path)


def _in_comment(path: Path) -> Facts:
    try:
        comments = read_ply(read_whole(path)).comments
    except PlyError as error:
        raise UserError(f"{error}: {path}") from error
    text = joined(KEYWORD, comments)
    if text is None:
        raise UserError(f"expected a PLY file written by VesselSplat, found no provenance in {path}")
    return facts_of(text, path)


def _beside(path: Path) -> Facts:
    if path.suffix.lower() == ".json" and path.with_suffix("").is_file():
        raise UserError(
            f"expected the export itself, {path.with_suffix('').name}, got its provenance: {path}"
        )
    sidecar = path.with_name(f"{path.name}.json")
    if not sidecar.is_file():
        raise UserError(f"expected {sidecar.name} beside {path.name}, which holds its provenance: {path}")
    return facts_of(read_whole(sidecar).decode(errors="replace"), sidecar)
