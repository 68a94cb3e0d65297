"""PlayCanvas' compressed PLY: four 32-bit words a splat, within the bounds of its chunk of 256.

Words, from the top bit down: position and log-scale of 11, 10 and 11 bits; rotation of 2 bits that say which
of w, x, y, z is largest and left out, and 10 for each of the others over sqrt(2); colour of 8 bits each, and
opacity. Harmonics, where there are any, are bytes of 8 / 256 about 0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from renderer.ply_elements import Element, Ply
from renderer.raw_gaussians import RawGaussians, logits
from renderer.splat_files.inria_ply import columns, degree_of, harmonics_of, mode_of
from renderer.splat_files.splat_file import SplatFile, SplatFileError, repaired

CHUNK = 256
WORDS = ("packed_position", "packed_rotation", "packed_scale", "packed_color")
UNSIGNED = np.uint32


def is_packed(ply: Ply) -> bool:
    """Of this format, in part at least."""
    return any(name in WORDS for element in ply.elements for name in element.fields)


def splats_of(ply: Ply) -> SplatFile:
    """The Gaussians, unpacked.

    Raises:
        SplatFileError: elements or fields are missing, or there are too few chunks.
    """
    elements = {element.name: element for element in ply.elements}
    if not {"chunk", "vertex"} <= elements.keys():
        raise SplatFileError(f"expected packed splats with chunks, got {' '.join(elements) or 'nothing'}")
    chunks, vertices = elements["chunk"], elements["vertex"]
    words = _words(vertices)
    count = len(vertices.rows)
    if len(chunks.rows) * CHUNK < count:
        raise SplatFileError(f"expected a chunk for each {CHUNK} of {count} splats, got {len(chunks.rows)}")
    of_chunk = np.arange(count) // CHUNK
    color = _bits(words["packed_color"], (8, 8, 8, 8))
    has_colors = "min_r" in chunks.fields
    raw = RawGaussians(
        means=_within(_bits(words["packed_position"], (11, 10, 11)), chunks, ("x", "y", "z"), of_chunk),
        quats=_rotations(words["packed_rotation"]),
        log_scales=_within(
            _bits(words["packed_scale"], (11, 10, 11)), chunks, ("scale_x", "scale_y", "scale_z"), of_chunk
        ),
        opacity_logits=logits(color[:, 3]),
        colors=_within(color[:, :3], chunks, ("r", "g", "b"), of_chunk)
        if has_colors
        else color[:, :3].astype(np.float32),
        harmonics=_harmonics(elements.get("sh"), count),
    )
    degree = degree_of(elements["sh"]) if "sh" in elements else 0
    return repaired(raw, mode_of(ply.comments), degree)


def _words(vertices: Element) -> dict[str, NDArray[np.uint32]]:
    for name in WORDS:
        if name not in vertices.fields or vertices.rows[name].dtype.newbyteorder("=") != UNSIGNED:
            raise SplatFileError(f"expected {name} of 32 bits, got {' '.join(vertices.fields)}")
    return {name: vertices.rows[name].astype(UNSIGNED) for name in WORDS}


def _bits(words: NDArray[np.uint32], widths: tuple[int, ...]) -> NDArray[np.float64]:
    """(N, parts) of a word from the top bit down, each from 0 to 1."""
    shifts = 32 - np.cumsum(widths)
    masks = [(1 << width) - 1 for width in widths]
    parts = [(words >> UNSIGNED(shift)) & UNSIGNED(mask) for shift, mask in zip(shifts, masks, strict=True)]
    return np.stack([part / mask for part, mask in zip(parts, masks, strict=True)], axis=1)


def _within(
    shares: NDArray[np.float64], chunks: Element, names: tuple[str, ...], of_chunk: NDArray[np.int64]
) -> NDArray[np.float32]:
    ends = [[f"{end}_{name}" for name in names] for end in ("min", "max")]
    missing = [name for name in (*ends[0], *ends[1]) if name not in chunks.fields]
    if missing:
        raise SplatFileError(f"expected the bounds of chunks, got none named {', '.join(missing)}")
    low, high = (columns(chunks, end).astype(np.float64)[of_chunk] for end in ends)
    with np.errstate(invalid="ignore", over="ignore"):
        return np.asarray(low + shares * (high - low), dtype=np.float32)


def _rotations(words: NDArray[np.uint32]) -> NDArray[np.float32]:
    given = (_bits(words, (2, 10, 10, 10))[:, 1:] - 0.5) * np.sqrt(2)
    largest = (words >> UNSIGNED(30)).astype(np.int64)
    return smallest_three(given, largest)


def smallest_three(given: NDArray[np.float64], largest: NDArray[np.int64]) -> NDArray[np.float32]:
    """Unit quaternions (N, 4) from three parts (N, 3) in order and the place of the one left out."""
    quats = np.empty((len(given), 4))
    rows = np.arange(len(given))
    for place in range(3):
        quats[rows, place + (place >= largest)] = given[:, place]
    quats[rows, largest] = np.sqrt(np.maximum(1 - (given**2).sum(axis=1), 0))
    return quats.astype(np.float32)


def without_largest(quats: NDArray[np.float32]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """What `smallest_three` takes; of no rotation (all 0) that of none (1, 0, 0, 0 in any order of parts)."""
    rows = np.arange(len(quats))
    largest = np.abs(quats).argmax(axis=1)
    units = quats.astype(np.float64)
    units[(units == 0).all(axis=1), 0] = 1
    units /= np.linalg.norm(units, axis=1, keepdims=True)
    units *= np.where(units[rows, largest] < 0, -1, 1)[:, None]
    return np.stack([units[rows, step + (step >= largest)] for step in range(3)], axis=1), largest


def _harmonics(element: Element | None, count: int) -> NDArray[np.float32]:
    if element is None:
        return np.zeros((count, 0, 3), np.float32)
    if len(element.rows) != count:
        raise SplatFileError(f"expected harmonics of {count} splats, got {len(element.rows)}")
    levels = harmonics_of(element)
    middle = np.where((levels == 0) | (levels == 255), levels / 255, (levels + 0.5) / 256)
    return np.asarray((middle - 0.5) * 8, np.float32)
