"""PlayCanvas' compressed PLY as it is written; see packed_ply.py for what its words hold.

Splats are ordered so that neighbours share a chunk, whose bounds are then narrow. Strays, in which bounds are
wide, come last; the least opaque splats fill up their chunk.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from renderer.raw_gaussians import RawGaussians, sigmoid
from renderer.splat_files.inria_ply import comment_lines
from renderer.splat_files.morton import morton_order
from renderer.splat_files.packed_ply import CHUNK, UNSIGNED, WORDS, without_largest
from renderer.splat_files.strays import strays, usual_span
from renderer.splats import RenderMode

THIRDS: Final = (11, 10, 11)
BYTES: Final = (8, 8, 8, 8)
AXES: Final = ("x", "y", "z")
SCALES: Final = ("scale_x", "scale_y", "scale_z")
COLORS: Final = ("r", "g", "b")
HARMONICS: Final = 4.0
"""The largest."""
COARSE: Final = 0.02
"""Share of what most values of a kind span: rounding that moves one by more is told."""
Words = NDArray[np.uint32]


def clipped(raw: RawGaussians) -> tuple[str, ...]:
    """What is beyond what the format holds, or is rounded coarsely by it, in words."""
    told = list[str]()
    if beyond := int((np.abs(raw.harmonics) > HARMONICS + 1 / 64).sum()):
        told.append(
            f"{beyond} of {raw.harmonics.size} values of colours by direction are beyond -{HARMONICS:g} to "
            f"{HARMONICS:g}, which compressed PLY does not hold: they are clipped"
        )
    if coarse := _coarse(raw):
        told.append(
            f"{coarse} of {len(raw)} splats are rounded by more than {100 * COARSE:.0f} % of the usual range "
            f"of positions, sizes or colours: compressed PLY rounds {CHUNK} together, and strays are among "
            "them"
        )
    return tuple(told)


def _coarse(raw: RawGaussians) -> int:
    """How many splats are in a chunk whose bounds are that wide."""
    ordered, of_chunk = raw.rows(_order(raw)), np.arange(len(raw)) // CHUNK
    coarse = np.zeros(-(-len(raw) // CHUNK), np.bool_)
    groups = ((ordered.means, THIRDS), (ordered.log_scales, THIRDS), (ordered.colors, BYTES[:3]))
    for values, widths in groups:
        _, (low, high) = _within_chunks(values.astype(np.float64))
        halves = (high.astype(np.float64) - low) / (2.0 ** np.array(widths) - 1) / 2
        if (span := usual_span(values)) > 0:
            coarse |= (halves > COARSE * span).any(axis=1)
    return int(coarse[of_chunk].sum())


def packed_ply_bytes(raw: RawGaussians, mode: RenderMode = "default", comments: Sequence[str] = ()) -> bytes:
    """What `packed_ply.splats_of` gives back in another order, to half a step of the bounds of each chunk:
    positions, log-scales and colours of 10 or 11 and of 8 bits, opacities to 1 / 510, harmonics from -4 to 4
    to 1 / 64. `clipped` says what is beyond.

    Raises:
        ValueError: a comment that other programs cannot read, see ply_comments.py.
    """
    raw = raw.rows(_order(raw))
    groups = {AXES: raw.means, SCALES: raw.log_scales, COLORS: raw.colors}
    shares, bounds = {}, {}
    for names, values in groups.items():
        shares[names], bounds[names] = _within_chunks(values.astype(np.float64))
    given, largest = without_largest(raw.quats)
    color = np.concatenate([shares[COLORS], sigmoid(raw.opacity_logits)[:, None]], axis=1)
    turns = largest.astype(UNSIGNED) << UNSIGNED(30) | _words(given / np.sqrt(2) + 0.5, (10, 10, 10))
    words = (_words(shares[AXES], THIRDS), turns, _words(shares[SCALES], THIRDS), _words(color, BYTES))
    named = [f"{end}_{name}" for names in groups for end in ("min", "max") for name in names]
    chunks = np.concatenate([part for names in groups for part in bounds[names]], axis=1)
    rest = 3 * raw.harmonics.shape[1]
    head = [
        "ply", "format binary_little_endian 1.0", *comment_lines(mode, comments),
        f"element chunk {len(chunks)}", *(f"property float {name}" for name in named),
        f"element vertex {len(raw)}", *(f"property uint {name}" for name in WORDS),
        *([f"element sh {len(raw)}"] if rest else []),
        *(f"property uchar f_rest_{place}" for place in range(rest)), "end_header", "",
    ]  # fmt: skip
    body = (chunks.astype("<f4"), np.stack(words, axis=1).astype("<u4"), _harmonics(raw.harmonics))
    return "\n".join(head).encode("ascii", "replace") + b"".join(part.tobytes() for part in body)


def _order(raw: RawGaussians) -> NDArray[np.int64]:
    order = morton_order(raw.means)
    apart = strays(raw.means) | strays(raw.log_scales) | strays(raw.colors)
    if not apart.any():
        return order
    count = int(apart.sum())
    clear = np.argsort(np.where(apart, -np.inf, raw.opacity_logits), kind="stable")
    last = np.zeros(len(raw), np.bool_)
    # What comes before them then fills chunks.
    last[clear[: count + (len(raw) - count) % CHUNK]] = True
    return order[np.argsort(last[order], kind="stable")]


def _within_chunks(
    values: NDArray[np.float64],
) -> tuple[NDArray[np.float64], tuple[NDArray[np.float32], NDArray[np.float32]]]:
    """(N, 3) between the least and the largest of their chunk, and these, (chunks, 3) each."""
    starts = np.arange(0, len(values), CHUNK)
    low, high = (
        np.asarray(end.reduceat(values, starts, axis=0) if len(values) else values, np.float32)
        for end in (np.minimum, np.maximum)
    )
    of_chunk = np.arange(len(values)) // CHUNK
    size = (high - low).astype(np.float64)[of_chunk]
    shares = np.divide(values - low[of_chunk], size, out=np.zeros_like(values), where=size > 0)
    return shares, (low, high)


def _words(shares: NDArray[Any], widths: tuple[int, ...]) -> Words:
    """Of (N, parts), each from 0 to 1, the first on top."""
    out = np.zeros(len(shares), UNSIGNED)
    for part, width in zip(shares.T, widths, strict=True):
        most = (1 << width) - 1
        out = out << UNSIGNED(width) | np.rint(np.clip(part, 0, 1) * most).astype(UNSIGNED)
    return out


def _harmonics(harmonics: NDArray[np.float32]) -> NDArray[np.uint8]:
    """All of red before green and blue."""
    levels = np.floor((harmonics.transpose(0, 2, 1).astype(np.float64) / 8 + 0.5) * 256)
    return np.asarray(np.clip(levels, 0, 255), np.uint8)
