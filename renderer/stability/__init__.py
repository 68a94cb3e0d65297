"""Stiff and extreme cases of every equation and kernel of reconstruction and drawing, against a bar each."""

from __future__ import annotations

from collections.abc import Iterator

from renderer.stability import blending, harmonics, learning, motion, projection, runs
from renderer.stability.blending import Draw
from renderer.stability.row import Row
from renderer.torch_presence import has_torch


def stability(draw: Draw | None = None) -> Iterator[Row]:
    """All rows; `draw` is a second rasteriser, such as OpenGL's, that is held to the same pictures.

    Without torch there is no float64 oracle for pictures, depths and gradients: those rows are left out.
    """
    yield from projection.rows()
    yield from blending.rows()
    if draw is not None and has_torch():
        yield from blending.pictures("OpenGL: picture", draw)
    for part in (harmonics, motion, learning, runs):
        yield from part.rows()
