"""Where tissue goes from one frame to others: optical flow, checked there and back and lifted by depth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.clip import BoolImage, ByteImage, Frame
from renderer.depth.filled_depth import filled_in, means_of_known

Plane = NDArray[np.float32]

LONGEST_SIDE = 320
"""Pixels of the images between which flow is estimated."""
SMALLEST = 32
"""Pixels of a side, below which there is no flow: OpenCV's search does not run on less than 16."""
REACH = 24
"""Frames before and after the first one that it is compared with."""
EVERY = 2
"""Pixels between tracks, across and down."""
MARGIN = 5
"""Side in pixels of the window that must be tissue of known depth: what is beside a tool may be tool."""
AGREES = 1.0
"""Pixels by which the way there and back may miss its start."""
INSIDE = np.float32(0.99)
FAR = 1e4
"""Pixels: flow outside the image, which never agrees."""


@dataclass(frozen=True, eq=False)
class Tracks:
    """Of the points that one frame shows, to another."""

    start: Plane
    """(T, 3) world positions."""
    shift: Plane
    """(T, 3) from there to where the other frame shows them."""


@dataclass(frozen=True, eq=False)
class View:
    """What flow and depth need of a frame."""

    camera: Camera
    grey: ByteImage
    """(h, w); where it is no tissue, what is around goes on."""
    depth: Plane
    """(h, w) along +z in the clip's unit."""
    known: BoolImage
    """(h, w) tissue of known depth, and so all around it."""

    def points(self) -> Plane:
        """(h, w, 3) world positions behind the pixels."""
        return self.camera.unproject(self.depth).astype(np.float32)


def view_of(frame: Frame) -> View:
    """A frame at the size at which flow is estimated."""
    height, width = frame.tissue_mask.shape
    factor = max(1.0, max(height, width) / LONGEST_SIDE)
    size = max(1, round(width / factor)), max(1, round(height / factor))
    known = cv2.erode(frame.depth_mask.astype(np.uint8), np.ones((MARGIN, MARGIN), np.uint8))
    depth = np.zeros(known.shape, np.float32) if frame.depth is None else frame.depth
    small = np.asarray(cv2.resize(depth, size, interpolation=cv2.INTER_NEAREST), np.float32)
    kept = np.asarray(cv2.resize(known, size, interpolation=cv2.INTER_NEAREST) > 0)
    return View(frame.camera.resized(*size), _grey(frame, size), small, kept)


def _grey(frame: Frame, size: tuple[int, int]) -> ByteImage:
    """What tools or the surround look like has no part in it, nor has their edge, which goes its own way."""
    tissue = frame.tissue_mask.astype(np.float32)
    grey = cv2.cvtColor(frame.image, cv2.COLOR_RGB2GRAY) * tissue
    return np.asarray(np.rint(filled_in(*means_of_known(grey, tissue, size))), np.uint8)


def tracks_from(views: Sequence[View], place: int) -> list[Tracks]:
    """From `views[place]` to each of the views, which are in the order of time; none to itself.

    Dense inverse search (Kroeger et al. 2016), each time from the flow to the frame before.
    """
    nothing = Tracks(np.empty((0, 3), np.float32), np.empty((0, 3), np.float32))
    found = [nothing] * len(views)
    if min(views[place].grey.shape) < SMALLEST or not views[place].known.any():
        return found
    points = views[place].points()
    search = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    for others in (range(place + 1, len(views)), range(place - 1, -1, -1)):
        there = back = np.zeros((*views[place].grey.shape, 2), np.float32)
        for other in others:
            pair = views[place].grey, views[other].grey
            there = np.asarray(search.calc(*pair, there.copy()), np.float32)
            back = np.asarray(search.calc(*pair[::-1], back.copy()), np.float32)
            found[other] = _lifted(views[place], points, views[other], there, back)
    return found


def _lifted(one: View, points: Plane, other: View, there: Plane, back: Plane) -> Tracks:
    """By the flow (h, w, 2) both ways: the tracks that come back, on tissue of known depth in both views."""
    height, width = one.grey.shape
    sparse = np.s_[EVERY // 2 : height : EVERY, EVERY // 2 : width : EVERY]
    y, x = np.mgrid[sparse].astype(np.float32)
    flow = there[sparse]
    place = x + flow[..., 0], y + flow[..., 1]
    returned = cv2.remap(
        back, *place, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=(FAR, FAR)
    )
    missed = flow + returned
    known = cv2.remap(other.known.astype(np.float32), *place, cv2.INTER_LINEAR)
    good = one.known[sparse] & (known > INSIDE) & ((missed * missed).sum(axis=-1) < AGREES * AGREES)
    start = points[sparse][good]
    end = cv2.remap(other.points(), *place, cv2.INTER_LINEAR)[good]
    return Tracks(start, np.asarray(end - start, np.float32))
