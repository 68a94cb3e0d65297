"""Where the depth of the open clip may come from, and the clip read anew with another: off the window's
thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from renderer.clip import Clip
from renderer.depth.depth_ways import DepthWays, depth_ways
from renderer.readers.clip_options import ClipOptions
from renderer.readers.image_folders.frames import with_field_of_view
from renderer.sources import open_case, with_chosen_depth


@dataclass(frozen=True)
class WaysRequest:
    """Which ways a clip offers."""

    bare: Clip
    """With no depth but that of its own files."""
    options: ClipOptions


def find_ways(request: WaysRequest) -> Iterator[DepthWays]:
    yield depth_ways(request.bare, request.options)


@dataclass(frozen=True, eq=False)
class DepthRequest:
    """The clip with the depth, and where its files state none with the field of view, of other options. A
    second wish for the same is another request."""

    bare: Clip
    options: ClipOptions


def read_depth(request: DepthRequest) -> Iterator[Clip]:
    """Raises ClipError: there is no such depth."""
    if request.bare.depth_origin == "beside":
        # Disparities become depths as the clip is read, by these very options.
        seen = open_case(request.bare.path, request.options)
    else:
        seen = with_field_of_view(request.bare, request.options.view_angle)
    yield with_chosen_depth(seen, request.options)
