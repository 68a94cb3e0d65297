"""Camera poses that a clip lacks: found where its camera moves and it has depth, else left out, and said."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, replace

from app.runs.clip_selection import ClipPart
from app.runs.dark_surround import lit_part
from app.runs.preparing import told_meanwhile
from app.runs.run_folder import PosesRecord
from renderer.camera_motion import POSES_MISSING, camera_motion, contradicted
from renderer.clip import Clip
from renderer.depth.clip_depth import why_not_by_motion
from renderer.listing import count
from renderer.poses.search import FoundPoses, PosesError, find_poses
from renderer.poses.told_apart import TISSUE
from renderer.readers.lenses.calibration import Calibration
from renderer.train.config import TrainConfig
from renderer.train.events import Omission, Preparing

STAGE = "estimating camera poses"
_NAMED = 3
"""Frames without a pose that are named, of more."""
FIXED = Omission(
    "camera poses",
    "no motion of the camera was found",
    "following features through all frames and looking for a zoom",
    "poses",
)
REFUSED = replace(FIXED, why="as requested", part=None)


@dataclass(frozen=True, eq=False)
class Posed:
    """A clip that is ready for training as far as its cameras go."""

    clip: Clip
    """The part that has poses; the very same clip where none were estimated."""
    poses: PosesRecord | None = None
    part: tuple[int, int] | None = None
    """First and last frame of the clip that it was made of; None: all of them."""
    notices: tuple[str, ...] = ()
    omitted: tuple[Omission, ...] = ()
    lens: Calibration | None = None
    """That was found with the poses, and by which the clip is undistorted."""


def posed(clip: Clip, config: TrainConfig, start: int = 0) -> Generator[Preparing, None, Posed]:
    """Looks for a motion of the camera, and follows it where there is one and depth says how far it goes.
    What is said counts frames from `start` on: of the clip on disk, so many come before those of `clip`.

    Raises ClipError: a frame cannot be read.
    """
    bare = yield from unposed(clip, config)
    if bare.omitted or not may_be_posed(clip):
        return bare
    try:
        found = yield from told_meanwhile(STAGE, lambda tell: find_poses(lit_part(clip), tell))
    except PosesError as error:
        return Posed(clip, notices=(f"{bare.notices[0] if bare.notices else POSES_MISSING}: {error}",))
    return through_found(clip, found, start)


def unposed(clip: Clip, config: TrainConfig) -> Generator[Preparing, None, Posed]:
    """The clip with the cameras that it has, and what is said of them. Raises ClipError as `posed`."""
    moves = yield from told_meanwhile("checking for camera motion", lambda _: camera_motion(clip))
    said = () if moves is None else (f"{contradicted(moves)}{_way_to_poses(clip)}",)
    return Posed(clip, notices=said, omitted=left_out(clip, config, moves))


def _way_to_poses(clip: Clip) -> str:
    """What a person may do, as the end of a sentence; empty where nothing helps, or they are looked for."""
    if may_be_posed(clip) or why_not_by_motion(clip):
        return ""
    return "; depth from motion finds them (--depth motion)"


def left_out(clip: Clip, config: TrainConfig, moves: str | None) -> tuple[Omission, ...]:
    """The search for poses, where the clip needs none or it is refused; nothing of clips that allow none."""
    if not may_be_posed(clip):
        return ()
    if "poses" in config.leave_out:
        return (REFUSED,)
    return () if moves or "poses" in config.keep else (FIXED,)


def may_be_posed(clip: Clip) -> bool:
    """It lacks poses and has depth; a guess of that differs in scale from frame to frame."""
    return (
        clip.camera_is_fixed
        and len(clip) > 1
        and clip.has_depth
        and (clip.depth_origin not in ("monocular", "brightness"))
    )


def through_found(clip: Clip, found: FoundPoses, start: int) -> Posed:
    """The part of the clip that has poses, as seen from these; `start`: see `posed`."""
    bridged = tuple(at for at, residual in enumerate(found.residuals) if residual is None)
    record = PosesRecord(
        residuals=found.residuals, points=found.points, lost=found.lost, bridged=bridged, tissue=found.tissue
    )
    whole = (found.first, found.last) == (0, len(clip) - 1)
    held = clip if whole else clip.between(found.first, found.last)
    part = None if whole else (found.first, found.last)
    seen = replace(held.through(found.cameras), passed_over=frozenset(bridged))
    return Posed(seen, record, part, tuple(_notices(clip, found, start)))


def _notices(clip: Clip, found: FoundPoses, start: int) -> list[str]:
    residuals = sorted(each for each in found.residuals if each is not None)
    typical, most = residuals[len(residuals) // 2], residuals[-1]
    said = [
        f"camera poses are estimated: points lie {typical:.1f} px (median) from where they are expected, "
        f"{most:.1f} px in the worst frame; {TISSUE[found.tissue]}"
    ]
    if found.zoom.grown > 0:
        small, large = (clip.labels[frame] for frame in found.zoom.ends)
        said.append(
            f"the lens zooms: by {100 * found.zoom.grown:.0f} % from frame {small} to frame {large}; "
            "the focal length of each frame is estimated with its pose"
        )
    if found.closed:
        one, other = (clip.labels[frame] for frame in found.closed[0])
        said.append(
            f"frames {one} and {other} show the same place: the path of the camera is closed there, "
            f"by {count(len(found.closed), 'pair')} of frames"
        )
    if len(found.cameras) < len(clip):
        held = f"frames {start + found.first + 1} to {start + found.last + 1}"
        said.append(f"only {held} are reconstructed, the longest part with camera poses")
    if found.lost:
        named = "; ".join(f"{clip.labels[each.frame]} ({each.why})" for each in found.lost[:_NAMED])
        more = f" and {len(found.lost) - _NAMED} more" if len(found.lost) > _NAMED else ""
        said.append(
            f"frames without a camera pose of their own are neither trained on nor measured: {named}{more}"
        )
    return said


def within_whole(asked: ClipPart, part: tuple[int, int] | None) -> ClipPart:
    """What was asked for, narrowed to a part of that."""
    if part is None:
        return asked
    start = asked.first or 0
    return replace(asked, trim=(start + part[0], start + part[1]))
