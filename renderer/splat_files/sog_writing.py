"""SOG of version 2 in one `.sog` file; see sog.py for what the pictures hold.

Splats are ordered along a curve that keeps neighbours together (Morton), which viewers rely on.
"""

from __future__ import annotations

import io
import json
import math
import zipfile
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from renderer.harmonics import BANDS
from renderer.raw_gaussians import RawGaussians, sigmoid
from renderer.sog_list import LIST
from renderer.splat_files.grouping import grouped
from renderer.splat_files.morton import WHOLE, morton_order
from renderer.splat_files.packed_ply import without_largest
from renderer.splat_files.sog import LARGEST, LEVELS, VERSION
from renderer.splat_files.sog_pictures import MOST_ROWS, SIDE_BY_SIDE
from renderer.splat_files.splat_file import coefficients_of
from renderer.splats import RenderMode

REFINED: Final = 20
"""Steps after which a code book no longer changes much."""
Values = NDArray[np.float64]
Bytes = NDArray[np.uint8]
Files = dict[str, bytes]


def sog_bytes(raw: RawGaussians, mode: RenderMode = "default") -> bytes:
    """What `read_sog` gives back, in another order: 16 bits of each position's logarithm, 8 of all else.

    Of more kinds of colour by direction than the format takes, 65,536, those that are most alike become one.
    """
    raw = raw.rows(morton_order(raw.means))
    files: Files = {}
    said: dict[str, Any] = {
        "version": VERSION,
        "asset": {"generator": "VesselSplat"},
        "count": len(raw),
        "antialias": mode == "mip",
        "means": _means(raw, files),
        "scales": _coded("scales.webp", raw.log_scales.astype(np.float64), (), files),
        "quats": _rotations(raw, files),
        "sh0": _coded(
            "sh0.webp", coefficients_of(raw.colors), (_rounded(255.0 * sigmoid(raw.opacity_logits)),), files
        ),
    }
    if raw.harmonics.shape[1]:
        said["shN"] = _palette(raw.harmonics, files)
    files[LIST] = json.dumps(said).encode()
    return _archive(files)


def _means(raw: RawGaussians, files: Files) -> dict[str, Any]:
    exact = raw.means.astype(np.float64)
    bent = np.sign(exact) * np.log1p(np.abs(exact))
    low, high = (bent.min(axis=0), bent.max(axis=0)) if len(raw) else (np.zeros(3), np.zeros(3))
    whole = np.rint((bent - low) / np.where(high > low, high - low, 1) * WHOLE).astype(np.int64)
    files["means_l.webp"] = _picture((whole & 255).astype(np.uint8))
    files["means_u.webp"] = _picture((whole >> 8).astype(np.uint8))
    return {"mins": low.tolist(), "maxs": high.tolist(), "files": ["means_l.webp", "means_u.webp"]}


def _rotations(raw: RawGaussians, files: Files) -> dict[str, Any]:
    given, largest = without_largest(raw.quats)
    pixels = _rounded(127.5 * (given * math.sqrt(2) + 1))
    named = (LARGEST + largest).astype(np.uint8)
    files["quats.webp"] = _picture(np.concatenate([pixels, named[:, None]], axis=1))
    return {"files": ["quats.webp"]}


def _coded(name: str, values: Values, more: tuple[Bytes, ...], files: Files) -> dict[str, Any]:
    codes = _code_book(values)
    files[name] = _picture(np.concatenate([_places(codes, values), *(one[:, None] for one in more)], axis=1))
    return {"codebook": codes.tolist(), "files": [name]}


def _palette(harmonics: NDArray[np.float32], files: Files) -> dict[str, Any]:
    """A row for each of those that differ after they are coded, or a group of them."""
    codes = _code_book(harmonics.astype(np.float64))
    bands = harmonics.shape[1]
    coded = _places(codes, harmonics.astype(np.float64)).reshape(len(harmonics), 3 * bands)
    rows, labels = np.unique(coded, axis=0, return_inverse=True)
    if len(rows) > MOST_ROWS:
        means, groups = grouped(codes.astype(np.float32)[rows], MOST_ROWS)
        rows, labels = _places(codes, means), groups[labels.reshape(-1)]
    lines = max(-(-len(rows) // SIDE_BY_SIDE), 1)
    pixels = np.zeros((lines * SIDE_BY_SIDE, bands, 3), np.uint8)
    pixels[: len(rows)] = rows.reshape(-1, bands, 3)
    files["shN_centroids.webp"] = _webp(pixels.reshape(lines, SIDE_BY_SIDE * bands, 3))
    named = labels.reshape(-1).astype(np.int64)
    split = np.stack([named & 255, named >> 8, np.zeros_like(named)], axis=1).astype(np.uint8)
    files["shN_labels.webp"] = _picture(split)
    return {
        "count": max(len(rows), 1),
        "bands": BANDS.index(bands),
        "codebook": codes.tolist(),
        "files": ["shN_centroids.webp", "shN_labels.webp"],
    }


def _code_book(values: Values) -> Values:
    """256 ascending numbers near all values: k-means in one dimension, from even steps, or where strays
    leave most of these without a value, from `_among_strays`."""
    ordered = np.sort(values, axis=None)
    if not len(ordered):
        return np.zeros(LEVELS)
    codes: Values = np.linspace(ordered[0], ordered[-1], LEVELS)
    distinct = np.unique(ordered)
    if len(distinct) <= LEVELS:
        codes[: len(distinct)] = distinct
        codes[len(distinct) :] = distinct[-1]
        return codes
    if (np.diff(_ends(ordered, codes)) > 0).sum() < LEVELS / 2:
        codes = _among_strays(distinct)
    sums = np.concatenate([[0.0], np.cumsum(ordered)])
    for _ in range(REFINED):
        ends = _ends(ordered, codes)
        held = np.diff(ends)
        codes = np.where(held > 0, np.diff(sums[ends]) / np.maximum(held, 1), codes)
    return codes


def _among_strays(distinct: Values) -> Values:
    """Half of the codes with evenly many values for each, half in even steps over all but 1 in 500 values."""
    few = len(distinct) // 1000
    even = np.linspace(distinct[few], distinct[~few], LEVELS // 2)
    places = np.linspace(0, len(distinct) - 1, LEVELS // 2).astype(np.int64)
    return np.sort(np.concatenate([distinct[places], even]))


def _ends(ordered: Values, codes: Values) -> NDArray[np.int64]:
    """(257,): where the values that are nearest to each code begin and end."""
    within = np.searchsorted(ordered, (codes[1:] + codes[:-1]) / 2)
    return np.concatenate([[0], within, [len(ordered)]])


def _places(codes: Values, values: Values) -> Bytes:
    """Of the nearest codes."""
    return np.searchsorted((codes[1:] + codes[:-1]) / 2, values).astype(np.uint8)


def _rounded(values: NDArray[Any]) -> Bytes:
    return np.asarray(np.clip(np.rint(values), 0, 255), np.uint8)


def _picture(rows: Bytes) -> bytes:
    """Of (N, channels), in about as many lines as columns."""
    width = 4 * max(math.ceil(math.sqrt(len(rows)) / 4), 1)
    height = 4 * max(math.ceil(len(rows) / width / 4), 1)
    pixels = np.zeros((width * height, rows.shape[1]), np.uint8)
    pixels[: len(rows)] = rows
    return _webp(pixels.reshape(height, width, -1))


def _webp(pixels: Bytes) -> bytes:
    """Pixels keep their colours where alpha is 0."""
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "WEBP", lossless=True, exact=True)
    return file.getvalue()


def _archive(files: Files) -> bytes:
    """Stored, without a time, so that one model gives one file."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, content in files.items():
            archive.writestr(zipfile.ZipInfo(name), content)
    return file.getvalue()
