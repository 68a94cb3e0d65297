"""Files of splats, of this program and of others: one format a file."""

from __future__ import annotations

from pathlib import Path

from renderer.ply_elements import MAGIC, PlyError, read_ply
from renderer.splat_files import inria_ply, packed_ply
from renderer.splat_files.splat_file import SplatFile, SplatFileError
from renderer.splat_files.splat_records import read_records
from renderer.splat_files.spz import GZIP, read_spz

SUFFIXES = (".ply", ".splat", ".spz")
__all__ = ["SUFFIXES", "SplatFile", "SplatFileError", "read_splats"]


def read_splats(path: Path) -> SplatFile:
    """The Gaussians of a PLY file, plain or packed, or of an .spz or .splat file.

    Raises:
        SplatFileError: the file cannot be read, or is damaged; names it.
    """
    try:
        return _read(path.read_bytes(), path.suffix.lower())
    except OSError as error:
        raise SplatFileError(f"expected a file of splats, got none that can be read: {path}") from error
    except (PlyError, SplatFileError) as error:
        raise SplatFileError(f"{error}: {path}") from error


def _read(content: bytes, suffix: str) -> SplatFile:
    if content.startswith(MAGIC):
        ply = read_ply(content)
        return packed_ply.splats_of(ply) if packed_ply.is_packed(ply) else inria_ply.splats_of(ply)
    if content.startswith(GZIP):
        return read_spz(content)
    if suffix == ".splat":
        return read_records(content)
    raise SplatFileError("expected a PLY, SPZ or .splat file, got another kind")
