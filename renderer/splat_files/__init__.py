"""Files of splats, of this program and of others: one format a file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final

from renderer import glb
from renderer.atomic_files import written_atomically
from renderer.budget import OverBudget
from renderer.ply_elements import MAGIC, PlyError, read_ply
from renderer.raw_gaussians import RawGaussians
from renderer.regular_files import read_whole
from renderer.sog_list import LIST, is_list, is_sog_list, is_unpacked_sog
from renderer.splat_files import gltf, inria_ply, other_kinds, packed_ply, sog_members
from renderer.splat_files.ksplat import read_ksplat
from renderer.splat_files.packed_writing import packed_ply_bytes
from renderer.splat_files.sog import read_sog
from renderer.splat_files.sog_writing import sog_bytes
from renderer.splat_files.splat_file import SplatFile, SplatFileError, require_drawable
from renderer.splat_files.splat_records import read_records
from renderer.splat_files.spz import GZIP, MAGIC_BYTES, read_spz
from renderer.splat_files.spz_streams import read_spz_streams
from renderer.splat_files.spz_writing import spz_bytes, spz_streams_bytes
from renderer.splats import RenderMode, require_mode

SUFFIXES = (".ply", ".splat", ".spz", ".sog", ".ksplat", ".glb")
WRITERS: Final[Mapping[str, Callable[[RawGaussians, RenderMode], bytes]]] = {
    ".compressed.ply": packed_ply_bytes,
    ".ply": inria_ply.ply_bytes,
    ".v4.spz": spz_streams_bytes,
    ".spz": spz_bytes,
    ".sog": sog_bytes,
}
"""By how names end, of several that fit the first."""
KINDS = "a PLY, SPZ, SOG, .splat, .ksplat or .glb file"
__all__ = [
    "SUFFIXES",
    "WRITERS",
    "SplatFile",
    "SplatFileError",
    "is_named_as_splats",
    "read_splats",
    "whole",
    "write_splats",
]


def read_splats(path: str | Path) -> SplatFile:
    """The Gaussians of a PLY file, plain or packed, of an .spz, .splat, .ksplat, .sog or .glb file, or
    of a SOG's folder.

    Args:
        path: of an unpacked SOG its folder, or the list in it (meta.json).

    Raises:
        SplatFileError: the file cannot be read, or is damaged; names it.

    Example:
        >>> from pathlib import Path
        >>> from tempfile import TemporaryDirectory
        >>> import numpy as np
        >>> from renderer import RawGaussians, read_splats, write_splats
        >>> raw = RawGaussians(
        ...     means=np.float32([[0, 0, 5], [1, 0, 5]]),
        ...     quats=np.float32([[1, 0, 0, 0]] * 2),
        ...     log_scales=np.log(np.full((2, 3), 0.3, np.float32)),
        ...     opacity_logits=np.float32([0, 2]),
        ...     colors=np.float32([[0.8, 0.2, 0.2], [0.2, 0.8, 0.2]]),
        ...     harmonics=np.zeros((2, 0, 3), np.float32),
        ... )
        >>> with TemporaryDirectory() as folder:
        ...     write_splats(Path(folder, "model.ply"), raw)
        ...     file = read_splats(Path(folder, "model.ply"))
        >>> bool((file.raw.means == raw.means).all())
        True
    """
    path = Path(path)
    try:
        file = path / LIST if path.is_dir() and is_named_as_splats(path) else path
        return _read(read_whole(file), file)
    except OSError as error:
        why = f" ({error.strerror})" if error.strerror else ""
        raise SplatFileError(f"expected a splat file, got none that can be read{why}: {path}") from error
    except (PlyError, SplatFileError, OverBudget) as error:
        raise SplatFileError(f"{error}: {path}") from error


def write_splats(path: str | Path, raw: RawGaussians, mode: RenderMode = "default") -> None:
    """A splat file that viewers open; it appears when it is complete.

    A binary PLY file in the layout of 3D Gaussian Splatting (Kerbl et al., 2023), of which `read_splats`
    gives all values back bit for bit, colours to 1e-7; or, of a third of its size or less, an SPZ file of
    version 3 (where it is named .v4.spz, of version 4), or, with the splats in another order, PlayCanvas'
    compressed PLY or SOG of version 2 (`spz_writing.py`, `packed_writing.py` and `sog_writing.py` say
    what is rounded, and `clipped` of the first two what the format does not hold).
    Of a model at a moment: `write_splats(path, model.motion.moved(model.raw, time))`.

    Args:
        path: ends in .compressed.ply, .ply, .spz or .sog; replaced where it exists.
        mode: how the Gaussians are meant to be drawn, see RenderMode.

    Raises:
        TypeError: `raw` is none, such as a model or its splats at a moment.
        ValueError: another ending, an unknown `mode`, a splat with a value that is not finite, too large or
            without a size, or more than the format holds.
        OSError: it cannot be written.

    Example:
        >>> from pathlib import Path
        >>> from tempfile import TemporaryDirectory
        >>> import numpy as np
        >>> from renderer import RawGaussians, read_splats, write_splats
        >>> raw = RawGaussians(
        ...     means=np.float32([[0, 0, 5], [1, 0, 5]]),
        ...     quats=np.float32([[1, 0, 0, 0]] * 2),
        ...     log_scales=np.log(np.full((2, 3), 0.3, np.float32)),
        ...     opacity_logits=np.float32([0, 2]),
        ...     colors=np.float32([[0.8, 0.2, 0.2], [0.2, 0.8, 0.2]]),
        ...     harmonics=np.zeros((2, 0, 3), np.float32),
        ... )
        >>> with TemporaryDirectory() as folder:
        ...     write_splats(Path(folder, "model.ply"), raw)
        ...     file = read_splats(Path(folder, "model.ply"))
        >>> bool((file.raw.means == raw.means).all())
        True
    """
    if not isinstance(raw, RawGaussians):
        raise TypeError(f"expected RawGaussians, as model.raw gives them, got {type(raw).__name__}")
    require_mode(mode)
    path = Path(path)
    name = path.name.lower()
    written = next((write for end, write in WRITERS.items() if name.endswith(end)), None)
    if written is None:
        raise ValueError(f"expected the name of a {', '.join(WRITERS)} file, got {path}")
    require_drawable(raw)
    content = written(raw, mode)
    with written_atomically(path) as partial:
        partial.write_bytes(content)


def is_named_as_splats(path: Path) -> bool:
    """Whether a file, or the folder of an unpacked SOG, is meant as splats."""
    return is_unpacked_sog(path) if path.is_dir() else path.suffix.lower() in SUFFIXES or is_sog_list(path)


def whole(path: Path) -> Path:
    """The folder of an unpacked SOG whose list is named; any other path itself."""
    return path.parent if path.name == LIST and is_sog_list(path) else path


def _read(content: bytes, path: Path) -> SplatFile:
    if content.startswith(MAGIC):
        return _read_ply(content)
    if content.startswith(GZIP):
        return read_spz(content)
    if content.startswith(MAGIC_BYTES):
        return read_spz_streams(content)
    if content.startswith(glb.MAGIC):
        return gltf.read_glb_splats(content)
    if content.startswith(other_kinds.ZIP) and (members := sog_members.archived(content)):
        return read_sog(members)
    if is_list(content, path.name):
        return read_sog(sog_members.beside(path))
    if kind := other_kinds.named_kind(content, path.name):
        raise SplatFileError(f"expected {KINDS}, got {kind}")
    if path.suffix.lower() == ".splat":
        return read_records(content)
    if path.suffix.lower() == ".ksplat":
        return read_ksplat(content)
    raise SplatFileError(f"expected {KINDS}, got another kind")


def _read_ply(content: bytes) -> SplatFile:
    ply = read_ply(content)
    file = packed_ply.splats_of(ply) if packed_ply.is_packed(ply) else inria_ply.splats_of(ply)
    if not ply.surplus:
        return file
    said = f"{ply.surplus} bytes after the last of {len(file.raw)} splats are ignored"
    return replace(file, notices=(*file.notices, said))
