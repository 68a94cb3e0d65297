"""Cameras and shape of a clip without depth, found from the motion of its camera, or refused in one line."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from functools import partial

from app.runs.dark_surround import lit_part
from app.runs.lens_notice import found_lens, lens_notice
from app.runs.posing import Posed, through_found
from app.runs.preparing import told_meanwhile
from renderer.camera import Camera
from renderer.camera_motion import camera_motion
from renderer.clip import Clip, ClipError
from renderer.depth.calibrated import with_calibration
from renderer.poses.from_motion import FoundStructure, followed_features, structure_of
from renderer.poses.search import PosesError
from renderer.readers.clip_options import ClipOptions
from renderer.readers.image_folders.frames import is_seen_by_assumption
from renderer.readers.lenses.calibration import Calibration
from renderer.train.config import TrainConfig
from renderer.train.events import Omission, Preparing

FOLLOWING, PLACING = "following features", "finding camera and shape from motion"
NO_DEPTH = "no depth follows from the camera's motion"
DOUBTFUL = 0.05
"""Share of a point's depth by which it may be off before that is said. On a sinus 3 %, on a fetoscopy 7 %."""
DIGITS = 2
"""Of positions in run.json, in scene units of which the tissue is a hundred away."""


UNDISTORTED = Omission(
    "undistortion by a lens that is found", "as requested", "finding camera and shape once more", None
)


def structured(
    clip: Clip, config: TrainConfig, options: ClipOptions, start: int = 0, *, drawn_on: bool = False
) -> Generator[Preparing, None, Posed]:
    """The longest part that holds, its cameras, and the points that Gaussians start between, of images that
    are undistorted where the lens is found; `start`: as of `posed`. `drawn_on`: a person has masked the
    images as they are, and so they stay.

    Raises ClipError: a frame cannot be read; the camera does not move from its place, or nothing can be
    followed; or poses are refused.
    """
    if "poses" in config.leave_out:
        raise ClipError(f"expected poses to be found for depth from motion, got them left out: {clip.path}")
    moves = yield from told_meanwhile("checking for camera motion", lambda _: camera_motion(clip))
    is_assumed = is_seen_by_assumption(clip)
    is_known = not is_assumed or options.field_of_view is not None
    try:
        found = yield from _structure(clip, focal_is_known=is_known)
    except PosesError as error:
        way = "--depth brightness estimates it, without a scale"
        raise ClipError(f"{NO_DEPTH}: {error} ({way}): {clip.path}") from error
    lens, straight = found_lens(clip, found.distortion), None
    is_refused = "lens" in config.leave_out
    if lens is not None and not (is_refused or drawn_on):
        straight = yield from _undistorted(clip, lens, found)
    if straight is not None:
        told, (seen, found) = straight[0].notices[len(clip.notices) :], straight
    else:
        told, seen = (lens_notice(clip, found.distortion),) if is_assumed else (), clip
    through = through_found(seen, found.poses, start)
    assert through.poses is not None
    structure = tuple(found.points.positions.round(DIGITS).ravel().tolist())
    poses = replace(through.poses, structure=structure)
    said = (
        *through.notices,
        *_doubts(found, moves),
        *(() if is_known else (_focal(clip.cameras[0], found),)),
        *told,
    )
    return replace(
        through,
        clip=replace(through.clip, points=poses.sparse_points),
        poses=poses,
        notices=said,
        omitted=(UNDISTORTED,) if lens is not None and is_refused else (),
        lens=None if straight is None else lens,
    )


def _structure(clip: Clip, *, focal_is_known: bool) -> Generator[Preparing, None, FoundStructure]:
    """Raises PosesError: there is none, and why; ClipError: a frame cannot be read."""
    features = yield from told_meanwhile(FOLLOWING, lambda tell: followed_features(lit_part(clip), tell))
    place = partial(structure_of, clip, features, focal_is_known=focal_is_known)
    return (yield from told_meanwhile(PLACING, lambda tell: place(tell=tell)))


def _undistorted(
    clip: Clip, lens: Calibration, before: FoundStructure
) -> Generator[Preparing, None, tuple[Clip, FoundStructure] | None]:
    """The clip through that lens, and its structure; None: of fewer frames than before, or the clip is of two
    eyes."""
    try:
        straight = with_calibration(clip, lens)
    except ClipError:
        return None
    try:
        found = yield from _structure(straight, focal_is_known=True)
    except PosesError:
        return None
    return (straight, found) if len(found.poses.cameras) >= len(before.poses.cameras) else None


def _doubts(found: FoundStructure, moves: str | None) -> tuple[str, ...]:
    """That shapes are not to be relied on, where that is so; `moves`: by `camera_motion`."""
    said = []
    if moves is None:
        said.append(
            "the images hardly shift: the camera may be fixed and the tissue alone may move; then shapes "
            "along the view are wrong"
        )
    if found.depth_error > DOUBTFUL:
        said.append(
            f"distances are uncertain: a point's depth may be off by some {100 * found.depth_error:.0f} %, "
            "as the camera hardly moves sideways or the tissue moves too; lengths and shapes along the view "
            "may be wrong"
        )
    if found.focal_left:
        said.append(
            f"the field of view is uncertain: its estimate still changed by {100 * found.focal_left:.0f} % "
            "when the search for it ended; the path of the camera and shapes along the view may be wrong "
            "(--field-of-view states it, where it is known)"
        )
    return tuple(said)


def _focal(assumed: Camera, found: FoundStructure) -> str:
    before, now = assumed.field_of_view, found.poses.cameras[0].field_of_view
    return (
        f"the field of view is estimated along with the poses: {now:.0f} degrees, {before:.0f} were assumed "
        "(--field-of-view states it, where it is known)"
    )
