"""Stiff and extreme cases of every equation and kernel of reconstruction and drawing, against a bar each."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Final, get_args

from renderer.measuring.stability import (
    blending,
    bumps,
    closing,
    cutting,
    exposure,
    harmonics,
    learning,
    losses,
    motion,
    planes,
    projection,
    runs,
    steps,
)
from renderer.measuring.stability.blending import Draw
from renderer.measuring.stability.row import Row
from renderer.torch_presence import has_torch
from renderer.train.config import Method

PARTS: Final[dict[str, Callable[[], Iterator[Row]]]] = {
    "projection": projection.rows,
    "exponential": blending.exponential,
    "pictures": blending.pictures_on_cpu,
    "depths": blending.depths,
    "gradients": blending.gradients,
    "overlap": blending.overlapping,
    "broken splat": blending.poisoned,
    "cut splats": cutting.rows,
    "shown": cutting.shown,
    "closed gaps": closing.rows,
    "harmonics": harmonics.rows,
    "splines": motion.splines,
    "nodes": motion.nodes,
    "bumps": bumps.rows,
    "planes": planes.features,
    "heads": planes.moves,
    "losses": losses.rows,
    "adam": learning.adam,
    "exposure": exposure.rows,
    "density": learning.density,
    "initialisation": learning.initialisation,
    "one step": steps.rows,
    "unseen": steps.unseen,
    **{f"whole run, {method}": partial(runs.of_method, method) for method in get_args(Method)},
    "whole run, refused": runs.refused,
    "whole run, units": runs.units,
}
"""Rows by what they are of."""
BY_TORCH: Final = ("pictures", "depths", "gradients", "broken splat", "one step")
"""Parts whose oracle takes torch."""


def stability(draw: Draw | None = None) -> Iterator[Row]:
    """All rows; `draw` is a second rasteriser, such as OpenGL's, that is held to the same pictures.

    Without torch there is no float64 oracle for pictures, depths and gradients: those rows are left out.
    """
    for name, part in PARTS.items():
        if name not in BY_TORCH or has_torch():
            yield from part()
    if draw is not None and has_torch():
        yield from blending.pictures("OpenGL: image", draw)
