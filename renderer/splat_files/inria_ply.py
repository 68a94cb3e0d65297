"""Splats as 3D Gaussian Splatting writes them (Kerbl et al. 2023): the vertices of a PLY file.

Fields: x y z; f_dc_0..2, coefficients of degree 0; f_rest_*, those above it, all of red before green and
blue; opacity as a logit; scale_0..2 as natural logarithms; rot_0..3, w first. Viewers tell by the comment
`SplatRenderMode` how splats narrower than a pixel are drawn.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from renderer.harmonics import BANDS
from renderer.ply_comments import LONGEST, START
from renderer.ply_elements import Element, Ply
from renderer.raw_gaussians import RawGaussians
from renderer.splat_files.splat_file import (
    FUNCTIONS,
    SplatFile,
    SplatFileError,
    coefficients_of,
    colors_of,
    repaired,
)
from renderer.splats import RenderMode

MEANS = ("x", "y", "z")
DC = tuple(f"f_dc_{place}" for place in range(3))
SCALES = tuple(f"scale_{place}" for place in range(3))
QUATS = tuple(f"rot_{place}" for place in range(4))
NEEDED = (*MEANS, *DC, "opacity", *SCALES, *QUATS)
MODE = "SplatRenderMode:"


def splats_of(ply: Ply) -> SplatFile:
    """The Gaussians of the element `vertex`, whose fields may be of any type, in any order, among others.

    Raises:
        SplatFileError: fields are missing.
    """
    vertices = next((element for element in ply.elements if element.name == "vertex"), None)
    if vertices is None:
        given = ", ".join(element.name for element in ply.elements)[:60] or "none"
        raise SplatFileError(f"expected vertices of numbers before any element with lists, got {given}")
    missing = [name for name in NEEDED if name not in vertices.fields]
    if missing and {"opacity", "scale_0", "rot_0"} <= set(missing):
        given = ", ".join(vertices.fields)[:60] or "none"
        raise SplatFileError(f"expected Gaussians, got points without opacities, sizes and turns ({given})")
    if missing:
        raise SplatFileError(f"expected the fields of splats, got none named {', '.join(missing)}")
    raw = RawGaussians(
        means=columns(vertices, MEANS),
        quats=columns(vertices, QUATS),
        log_scales=columns(vertices, SCALES),
        opacity_logits=columns(vertices, ("opacity",))[:, 0],
        colors=colors_of(columns(vertices, DC)),
        harmonics=harmonics_of(vertices),
    )
    return repaired(raw, mode_of(ply.comments), degree_of(vertices))


def columns(element: Element, names: Sequence[str]) -> NDArray[np.float32]:
    """(N, names) of a row's fields."""
    out = np.empty((len(element.rows), len(names)), np.float32)
    with np.errstate(over="ignore"):
        for place, name in enumerate(names):
            out[:, place] = element.rows[name]
    return out


def degree_of(element: Element) -> int:
    """Of its harmonics. Raises SplatFileError where the number of fields is that of none."""
    names = [name for name in element.fields if name.startswith("f_rest_")]
    counts = [3 * functions for functions in FUNCTIONS]
    if len(names) not in counts or set(names) != set(_rest(len(names))):
        wanted = ", ".join(map(str, counts))
        raise SplatFileError(f"expected {wanted} fields f_rest_0 and on, got {len(names)}")
    return counts.index(len(names))


def harmonics_of(element: Element) -> NDArray[np.float32]:
    """(N, B, 3), without those above degree 3. Raises SplatFileError, see `degree_of`."""
    functions = FUNCTIONS[degree_of(element)]
    whole = columns(element, _rest(3 * functions)).reshape(len(element.rows), 3, functions)
    return np.ascontiguousarray(whole[:, :, : BANDS[-1]].transpose(0, 2, 1))


def _rest(count: int) -> tuple[str, ...]:
    return tuple(f"f_rest_{place}" for place in range(count))


def comment_lines(mode: RenderMode, comments: Sequence[str]) -> tuple[str, ...]:
    """Of a header, that for viewers first. Raises ValueError: one that other programs cannot read."""
    lines = [f"{START}{' '.join(comment.split())}" for comment in comments]
    if any(len(line) > LONGEST for line in lines):
        raise ValueError(f"expected comments of up to {LONGEST} bytes, got {max(map(len, lines))}")
    return f"{START}{MODE} {mode}", *lines


def mode_of(comments: Sequence[str]) -> RenderMode:
    said = [comment.removeprefix(MODE).strip() for comment in comments if comment.startswith(MODE)]
    return "mip" if "mip" in said or "antialiased 1" in comments else "default"


def ply_bytes(raw: RawGaussians, mode: RenderMode = "default", comments: Sequence[str] = ()) -> bytes:
    """A binary file that `splats_of` reads back: all values bit for bit, colours to 1e-7.

    Raises:
        ValueError: a comment that other programs cannot read, see ply_comments.py.
    """
    count = raw.harmonics.shape[1]
    rest = _rest(3 * count)
    names = (*MEANS, "nx", "ny", "nz", *DC, *rest, "opacity", *SCALES, *QUATS)
    head = [
        "ply", "format binary_little_endian 1.0", *comment_lines(mode, comments),
        f"element vertex {len(raw)}",
        *(f"property float {name}" for name in names), "end_header", "",
    ]  # fmt: skip
    rest_values = raw.harmonics.transpose(0, 2, 1).reshape(len(raw), len(rest))
    parts: list[NDArray[np.floating[Any]]] = [
        raw.means, np.zeros((len(raw), 3)), coefficients_of(raw.colors), rest_values,
        raw.opacity_logits[:, None], raw.log_scales, raw.quats,
    ]  # fmt: skip
    body = np.concatenate([part.astype("<f4") for part in parts], axis=1)
    return "\n".join(head).encode("ascii", "replace") + body.tobytes()
