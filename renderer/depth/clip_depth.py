"""Where the depth of a clip comes from: its files, its right pictures, or a guess that was asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from renderer.clip import Clip, ClipError, Frame
from renderer.depth.depth_prior import brightness_guess, with_guessed_depth
from renderer.depth.monocular import FOLDERS, map_files, monocular_guess, monocular_maps
from renderer.depth.stereo_depth import with_stereo_depth
from renderer.depth.stereo_pairs import right_eye, right_files
from renderer.poses.parts import SHORTEST
from renderer.readers.clip_options import ClipOptions, DepthSource

BY_BRIGHTNESS: Final = (
    "depth is estimated from brightness (a lamp at the camera): shapes are coarse and lengths have no scale"
)
BY_MOTION: Final = "depth is from the camera's motion, at sparse points: lengths have no scale"
BY_MAPS: Final = "depth is taken from monocular maps: lengths have no scale"


def with_depth(clip: Clip, options: ClipOptions) -> Clip:
    """The clip as opened, with depth from where `options.depth` says; frames are worked out when read.

    "auto" keeps depth that the files have, else matches stereo pairs where there are any and they
    are rectified; it never guesses. Every other source replaces what the files have. A guess is in
    "scene units" and says so in a notice.

    Raises:
        ClipError: the source asked for is not there or does not fit; one line that names the path.
    """
    return _SOURCES[options.depth](clip, options)


def depth_files(path: Path, names: Sequence[str]) -> tuple[Path, ...]:
    """The files that any source takes for pictures of these names of a clip in the folder `path`."""
    return (*right_files(path, names), *map_files(path, names))


def _auto(clip: Clip, options: ClipOptions) -> Clip:
    if clip.has_depth:
        return clip
    try:
        right = right_eye(clip)
        return with_stereo_depth(clip, right, options.baseline) if right is not None else clip
    except ClipError as error:
        why = f"no stereo depth: {error}"
        return replace(clip, notices=(*clip.notices, why), why_no_depth=why)


def _measured(clip: Clip, options: ClipOptions) -> Clip:
    if not clip.has_depth:
        why = f" ({clip.why_no_depth})" if clip.why_no_depth else ""
        raise ClipError(f"expected measured depth, got a clip without{why}: {clip.path}")
    return clip


def _stereo(clip: Clip, options: ClipOptions) -> Clip:
    right = right_eye(clip)
    if right is None:
        raise ClipError(f"expected right images beside the left ones, got none: {clip.path}")
    return with_stereo_depth(clip, right, options.baseline)


def _monocular(clip: Clip, options: ClipOptions) -> Clip:
    maps = monocular_maps(clip)
    if not maps:
        raise ClipError(f"expected a folder {' or '.join(FOLDERS)} beside the images, got none: {clip.path}")
    guessed = with_guessed_depth(clip, monocular_guess(clip, maps), BY_MAPS)
    return replace(guessed, depth_origin="monocular")


def _brightness(clip: Clip, options: ClipOptions) -> Clip:
    guessed = with_guessed_depth(clip, brightness_guess(clip), BY_BRIGHTNESS)
    return replace(guessed, depth_origin="brightness")


def _motion(clip: Clip, options: ClipOptions) -> Clip:
    """Points and poses are still to be found (renderer.poses.from_motion): that takes all frames."""
    if why := why_not_by_motion(clip):
        raise ClipError(f"{why}: {clip.path}")
    notices = (*clip.notices, BY_MOTION)
    return replace(
        _off(clip, options), depth_origin="motion", unit="scene units", points=None, notices=notices
    )


def why_not_by_motion(clip: Clip) -> str:
    """Without a look at its frames; empty where depth may follow from the motion of the camera."""
    if not clip.camera_is_fixed:
        return "expected a clip without camera poses for depth from motion, got one that has them"
    if len(clip) < SHORTEST:
        return f"expected at least {SHORTEST} frames for depth from motion, got {len(clip)}"
    return ""


def _off(clip: Clip, options: ClipOptions) -> Clip:
    def read_frame(index: int) -> Frame:
        return replace(clip.read_frame(index), depth=None, depth_is_guess=False)

    return replace(clip, read_frame=read_frame, has_depth=False) if clip.has_depth else clip


_SOURCES: Final[dict[DepthSource, Callable[[Clip, ClipOptions], Clip]]] = {
    "auto": _auto,
    "measured": _measured,
    "stereo": _stereo,
    "monocular": _monocular,
    "brightness": _brightness,
    "motion": _motion,
    "off": _off,
}
