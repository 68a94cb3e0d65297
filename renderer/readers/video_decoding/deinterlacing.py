"""Interlaced video: whole pictures from the two fields of each frame, by FFmpeg's bwdif filter."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from av import VideoFrame
    from av.filter import Graph

TIME_BASE = Fraction(1, 1000)
"""Of frames that are numbered 0, 1, 2: any will do."""


def deinterlaced(
    before: VideoFrame | None, frame: VideoFrame, after: VideoFrame | None, *, field: int | None
) -> VideoFrame:
    """`frame` with the lines of one field made from its neighbours in space and time.

    The same three frames give the same picture, whatever was read before them.

    Args:
        before, after: the neighbours in time; None at the ends of a video.
        field: 0 for the moment of the first field, 1 for that of the second; None: one picture for both.
    """
    neighbours = [one for one in (before, frame, after) if one is not None]
    stamps = [one.pts for one in neighbours]
    try:
        for number, one in enumerate(neighbours):
            one.pts = number
        made = _filtered(neighbours, "send_frame" if field is None else "send_field")
    finally:
        for one, stamp in zip(neighbours, stamps, strict=True):
            one.pts = stamp
    place = 0 if before is None else 1
    return made[place] if field is None else made[2 * place + field]


def _filtered(frames: list[VideoFrame], mode: str) -> list[VideoFrame]:
    import av

    graph = _graph(frames[0], mode)
    for frame in frames:
        graph.vpush(frame)
    graph.vpush(None)
    made = []
    while True:
        try:
            made.append(graph.vpull())
        except (av.error.EOFError, av.error.BlockingIOError):
            return made


def _graph(like: VideoFrame, mode: str) -> Graph:
    from av.filter import Graph

    graph = Graph()
    source = graph.add_buffer(width=like.width, height=like.height, format=like.format, time_base=TIME_BASE)
    filters = (source, graph.add("bwdif", f"mode={mode}:deint=all"), graph.add("buffersink"))
    for one, following in pairwise(filters):
        one.link_to(following)
    graph.configure()
    return graph
