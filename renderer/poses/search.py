"""The path of a camera that moves, from the frames of a clip with depth; where that fails, and why."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from renderer.camera import Camera
from renderer.clip import Clip
from renderer.poses.between import between
from renderer.poses.lost_frame import LostFrame
from renderer.poses.parts import SHORTEST, commonest, parts_of, pictures_of
from renderer.poses.pictures import small_lens
from renderer.poses.rigid_motion import in_unit, inverse, zoomed
from renderer.poses.settling import Settled, apart, settled
from renderer.poses.told_apart import TissueMotion
from renderer.poses.tracking import Tracker
from renderer.poses.zooming import ONE_LENS, Zoom, zoom_undone

_ELSEWHERE = "shows nothing that the others do"


@dataclass(frozen=True, eq=False)
class FoundPoses:
    """Of the longest part of a clip through which the camera was followed."""

    first: int
    """Frame of the clip at which the part begins; its camera is the identity."""
    cameras: tuple[Camera, ...]
    """One a frame of the part, each with its own focal length where the lens zooms."""
    residuals: tuple[float | None, ...]
    """Median distance in px between points as seen and as expected; None: between two others, see `lost`."""
    points: tuple[int, ...]
    """That agree with the pose."""
    lost: tuple[LostFrame, ...]
    """Of the whole clip."""
    tissue: TissueMotion = "not sought"
    zoom: Zoom = ONE_LENS
    closed: tuple[tuple[int, int], ...] = ()
    """Frames of the clip that show the same place long after each other, by which the path is closed, without
    depth; those that share most come first. With depth, points that come back into view are looked for."""

    @property
    def last(self) -> int:
        return self.first + len(self.cameras) - 1


class PosesError(Exception):
    """No part of the clip shows where its camera was: the text says why."""


def find_poses(clip: Clip, tell: Callable[[int, int], None] = lambda done, total: None) -> FoundPoses:
    """Poses of a clip whose one camera is of all frames, from features on the tissue and their depth.

    The world is the first camera of the part, in the clip's unit. What moves with the tissue as a
    whole, such as breathing that all of the view follows, is in the poses: nothing tells it apart. A
    zoom of the lens is told by depth. That of two eyes which zoom together changes along with the images,
    as if the camera moved along its view: there it is not looked for.
    `tell` is called with how many frames are done, of all. Each counts half when it is followed: what is
    found takes about as long to settle.

    Raises:
        PosesError: no part of SHORTEST frames.
        ClipError: a frame cannot be read.
    """
    if len(clip) < SHORTEST:
        raise PosesError(f"expected at least {SHORTEST} frames to follow the camera through, got {len(clip)}")
    lens = small_lens(clip.cameras[0])
    unit = _unit(clip)
    parts, lost = parts_of(pictures_of(clip, lens, unit, partial(_told_half, tell)), partial(Tracker, lens))
    whole = max(parts, key=len, default=None)
    if whole is None or whole.views[-1].frame - whole.views[0].frame + 1 < SHORTEST:
        why = commonest([each.why for each in lost])
        raise PosesError(f"the camera could not be followed through {SHORTEST} frames{why and ': ' + why}")
    zoom, rough = (ONE_LENS, whole.rough) if clip.depth_origin == "stereo" else zoom_undone(whole.rough)
    return found_poses(clip, settled(rough), unit, lost, zoom)


def _told_half(tell: Callable[[int, int], None], done: int, total: int) -> None:
    tell(done // 2, total)


def found_poses(
    clip: Clip, done: Settled, unit: float, lost: Sequence[LostFrame], zoom: Zoom = ONE_LENS
) -> FoundPoses:
    """What `done`, of the small frames without a zoom, lengths in `unit`, says of the clip's cameras."""
    assumed, shrink = clip.cameras[0], clip.cameras[0].width / done.lens.width
    longer = done.lens.fx / small_lens(assumed).fx
    camera = replace(assumed, fx=assumed.fx * longer, fy=assumed.fy * longer)
    back = inverse(done.views[0].pose)
    poses = {view.frame: in_unit(view.pose @ back, unit) for view in done.views}
    residuals, points = dict[int, float](), dict[int, int]()
    for view in done.views:
        off = np.linalg.norm(apart(done.lens, done.points, view)[:, :2], axis=1)
        residuals[view.frame] = shrink * math.exp(zoom.at(view.frame)) * float(np.median(off))
        points[view.frame] = int(view.inliers.sum())
    first, last = done.views[0].frame, done.views[-1].frame
    named = {each.frame for each in lost}
    nowhere = set(range(first, last + 1)) - poses.keys() - named
    elsewhere = [LostFrame(at, _ELSEWHERE) for at in nowhere]
    path = {at: poses[at] if at in poses else between(poses, at) for at in range(first, last + 1)}
    return FoundPoses(
        first=first,
        cameras=tuple(zoomed(camera, zoom.at(at)).moved(pose) for at, pose in path.items()),
        residuals=tuple(residuals.get(at) for at in range(first, last + 1)),
        points=tuple(points.get(at, 0) for at in range(first, last + 1)),
        lost=tuple(sorted((*lost, *elsewhere), key=lambda each: each.frame)),
        tissue=done.tissue,
        zoom=zoom,
    )


def _unit(clip: Clip) -> float:
    """Of lengths: the median depth of the first frame that has any."""
    frames = (clip.read_frame(index) for index in range(len(clip)))
    return next((median for frame in frames if (median := frame.median_depth) is not None), 1.0)
