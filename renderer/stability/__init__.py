"""Stiff and extreme cases of every equation and kernel of reconstruction and drawing, against a bar each."""

from __future__ import annotations

from collections.abc import Iterator

from renderer.stability import blending, harmonics, learning, motion, projection, runs
from renderer.stability.blending import Draw
from renderer.stability.row import Row


def stability(draw: Draw | None = None) -> Iterator[Row]:
    """All rows; `draw` is a second rasteriser, such as OpenGL's, that is held to the same pictures."""
    yield from projection.rows()
    yield from blending.rows()
    if draw is not None:
        yield from blending.pictures("OpenGL: picture", draw)
    for part in (harmonics, motion, learning, runs):
        yield from part.rows()
