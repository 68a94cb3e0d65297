"""The page that lies in a file of arrays: what each is, in words."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from app.files.provenance import NOTICE, version
from app.scenes.scene import Scene

WIDTH: Final = 100
WINDOWS: Final = (
    " The model is in windows, each with Gaussians of its own, under window_1 and so on; where two overlap, "
    "one fades into the next, by its opacities."
)


@dataclass(frozen=True)
class Described:
    """An array of the file."""

    name: str
    shape: tuple[int, ...]
    dtype: str
    text: str


def readme(scene: Scene, arrays: Sequence[Described]) -> str:
    """Of a file with these arrays."""
    guessed = "Depth was estimated: lengths have no scale. " if scene.is_guessed else ""
    head = (
        f"Gaussians over time of {scene.name}, a reconstruction by VesselSplat {version()}. {NOTICE}",
        f"Lengths are in {scene.unit}. {guessed}The world is that of the clip's poses, "
        "without poses the axes of its camera: x right, y down, z forward (OpenCV).",
        "T moments come first in every shape. An array whose first length is 1 while others have T is "
        "the same at all moments. N Gaussians keep their places: row n is the same Gaussian at every moment."
        + (WINDOWS if scene.split_by_time else ""),
        "A Gaussian is exp(-d' C^-1 d / 2) of its opacity, d being the way from its centre, and "
        "C = R diag(s^2) R' with R its rotation and s its scales. "
        + (
            "On the screen, 0.3 squared pixels are added to C, and opacities multiplied by "
            "sqrt(det C / det(C + 0.3 I)), as it was trained."
            if scene.mode == "mip"
            else "On the screen, 0.3 squared pixels are added to C."
        ),
    )
    paragraphs = [textwrap.fill(part, WIDTH) for part in head]
    rows = [
        textwrap.fill(
            f"{one.name} {_told(one.shape)} {one.dtype}: {one.text}", WIDTH, subsequent_indent="    "
        )
        for one in arrays
    ]
    own = "provenance: what the file was made from, by what version; `vesselsplat replay` reproduces it."
    return "\n\n".join([*paragraphs, "\n".join(rows), own]) + "\n"


def _told(shape: tuple[int, ...]) -> str:
    return f"({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''})"
