"""SOG files for tests, packed splat by splat in float64 by the words of the format alone."""

from __future__ import annotations

import io
import json
import math
import zipfile
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from renderer.raw_gaussians import RawGaussians

CODES = 256
DC = 0.28209479177387814
Files = dict[str, bytes]


def webp(pixels: NDArray[np.uint8], kind: str = "WEBP") -> bytes:
    file = io.BytesIO()
    options = {"lossless": True, "exact": True} if kind == "WEBP" else {}
    Image.fromarray(pixels).save(file, kind, **options)
    return file.getvalue()


def picture(rows: list[tuple[int, ...]], width: int, kind: str = "WEBP") -> bytes:
    """The first row's pixels from left to right, then the next, filled up with 0."""
    height = max(math.ceil(len(rows) / width), 1)
    pixels = np.zeros((height * width, len(rows[0]) if rows else 3), np.uint8)
    if rows:
        pixels[: len(rows)] = rows
    return webp(pixels.reshape(height, width, -1), kind)


def nearest(codes: list[float], value: float) -> int:
    return min(range(CODES), key=lambda place: abs(codes[place] - value))


def evenly(values: NDArray[np.floating[Any]]) -> list[float]:
    low, high = float(values.min(initial=0)), float(values.max(initial=0))
    return [low + (high - low) * place / (CODES - 1) for place in range(CODES)]


def log_of(value: float) -> float:
    return math.copysign(math.log1p(abs(value)), value)


def turned(quat: NDArray[np.float32]) -> tuple[int, ...]:
    parts = [float(part) / math.sqrt(sum(float(one) ** 2 for one in quat)) for part in quat]
    largest = max(range(4), key=lambda place: abs(parts[place]))
    sign = math.copysign(1, parts[largest])
    given = [sign * part for place, part in enumerate(parts) if place != largest]
    return (*(round((part * math.sqrt(2) + 1) / 2 * 255) for part in given), 252 + largest)


def sog(raw: RawGaussians, width: int = 5, kind: str = "WEBP", **said: Any) -> Files:
    """The files of a SOG, whose palette has a row for each splat."""
    logs = [[log_of(float(value)) for value in mean] for mean in raw.means]
    mins = [min((log[axis] for log in logs), default=0) for axis in range(3)]
    maxs = [max((log[axis] for log in logs), default=0) for axis in range(3)]
    whole = [
        [round((log[axis] - mins[axis]) / ((maxs[axis] - mins[axis]) or 1) * 65535) for axis in range(3)]
        for log in logs
    ]
    dc = (raw.colors.astype(np.float64) - 0.5) / DC
    scales, colors, rest = evenly(raw.log_scales), evenly(dc), evenly(raw.harmonics)
    alphas = [round(255 / (1 + math.exp(-float(logit)))) for logit in raw.opacity_logits]
    files = {
        "means_l.webp": picture([tuple(value & 255 for value in row) for row in whole], width, kind),
        "means_u.webp": picture([tuple(value >> 8 for value in row) for row in whole], width, kind),
        "scales.webp": picture(
            [tuple(nearest(scales, float(v)) for v in row) for row in raw.log_scales], width, kind
        ),
        "quats.webp": picture([turned(quat) for quat in raw.quats], width, kind),
        "sh0.webp": picture(
            [
                (*(nearest(colors, float(v)) for v in row), alpha)
                for row, alpha in zip(dc, alphas, strict=True)
            ],
            width,
            kind,
        ),
    }
    meta: dict[str, Any] = {
        "version": 2,
        "count": len(raw),
        "means": {"mins": mins, "maxs": maxs, "files": ["means_l.webp", "means_u.webp"]},
        "scales": {"codebook": scales, "files": ["scales.webp"]},
        "quats": {"files": ["quats.webp"]},
        "sh0": {"codebook": colors, "files": ["sh0.webp"]},
    }
    bands = raw.harmonics.shape[1]
    if bands:
        lines = math.ceil(len(raw) / 64)
        pixels = np.zeros((lines, 64 * bands, 3), np.uint8)
        for row, values in enumerate(raw.harmonics):
            for band in range(bands):
                place = row // 64, row % 64 * bands + band
                pixels[place] = [nearest(rest, float(value)) for value in values[band]]
        files["shN_centroids.webp"] = webp(pixels, kind)
        files["shN_labels.webp"] = picture([(row & 255, row >> 8, 0) for row in range(len(raw))], width, kind)
        meta["shN"] = {
            "count": len(raw),
            "bands": {3: 1, 8: 2, 15: 3}[bands],
            "codebook": rest,
            "files": ["shN_centroids.webp", "shN_labels.webp"],
        }
    return {**files, "meta.json": json.dumps(meta | said).encode()}


def bundled(files: Files, folder: str = "", packing: int = zipfile.ZIP_STORED) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", packing) as archive:
        for name, content in files.items():
            archive.writestr(folder + name, content)
    return file.getvalue()
