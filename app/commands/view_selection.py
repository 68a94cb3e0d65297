"""When and from where a scene is drawn or exported, as the flags ask."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from app.console.frame_numbers import frame_numbers
from app.errors import UserError
from app.scenes.clip_speed import FRAMES_PER_SECOND
from app.scenes.scene import Scene, open_scene
from app.scenes.supersampling import FACTORS
from app.scenes.window_scene import scene_of_window
from renderer.camera import Camera
from renderer.camera_files import CameraFileError, NamedCamera, read_cameras
from renderer.view_files import read_views

LONGEST = 60
"""Characters of a camera's name in those of its files, which hold 255 bytes."""
MOST_PIXELS = 16384
"""Each way: the largest framebuffer of common graphics cards."""
LEAST_RATE, MOST_RATE = 1 / 3600, 1000
"""Frames a second that videos hold."""


@dataclass(frozen=True)
class Moment:
    """One picture."""

    name: str
    frame: int | None
    time: float
    camera: Camera


def add_flags(parser: argparse.ArgumentParser) -> None:
    """What is drawn, when, from where, and by what."""
    parser.add_argument(
        "scene",
        metavar="RUN|SPLATFILE",
        type=Path,
        help="finished run, or .ply, .splat, .ksplat, .spz, .sog or .glb file",
    )
    parser.add_argument("--as-trained", action="store_true", help="ignore edits made in the app")
    parser.add_argument(
        "--window",
        type=int,
        metavar="N",
        help="of a reconstruction in windows, only the one of this number, from 1 (default all)",
    )
    parser.add_argument(
        "--frames",
        nargs="+",
        metavar="all|test|I|A:B",
        help="frames to render, from 0, of a window from its first one (default all)",
    )
    parser.add_argument("--time", type=float, metavar="T", help="one time in [0, 1] instead of frames")
    parser.add_argument(
        "--camera",
        type=Path,
        metavar="FILE",
        help="camera to render from: JSON of one camera, or of several, one image each: cameras.json, "
        "transforms.json or a folder with COLMAP's images.txt",
    )
    parser.add_argument(
        "--path",
        type=Path,
        metavar="FILE",
        help="along a camera path saved in the window, with its poses and times, instead of frames",
    )
    parser.add_argument(
        "--frames-per-second",
        type=float,
        metavar="F",
        help=f"for exports through time (default the clip's, else {FRAMES_PER_SECOND:g}) and along paths "
        f"({FRAMES_PER_SECOND:g})",
    )
    parser.add_argument(
        "--size",
        type=int,
        nargs=2,
        metavar=("W", "H"),
        help="pixels (default the clip's); another shape shows more of the scene, without stretching",
    )
    parser.add_argument(
        "--supersampling",
        type=int,
        default=1,
        choices=FACTORS,
        help="render this many times the pixels along each axis and average them (default 1)",
    )
    parser.add_argument(
        "--with",
        dest="renderer",
        choices=("gl", "cpu", "reference"),
        default="cpu",
        help="OpenGL, the CPU, or the slow reference in float64 (default cpu)",
    )


def chosen(flags: argparse.Namespace) -> tuple[Scene, list[Moment]]:
    """The scene, what was repaired of it told on stderr. Raises UserError for what there is not."""
    said = flags.frames_per_second
    if said is not None and not LEAST_RATE <= said <= MOST_RATE:
        raise UserError(
            f"--frames-per-second: expected {LEAST_RATE:.3g} (a frame an hour) to 1000, got {said}"
        )
    scene = open_scene(flags.scene, as_trained=flags.as_trained)
    if flags.window is not None:
        scene = scene_of_window(scene, flags.window)
    asked = list(_moments(flags, scene))
    wanted = [replace(one, camera=_resized(one.camera, flags.size)) for one in asked]
    most = flags.supersampling * max(max(one.camera.width, one.camera.height) for one in wanted)
    if most > MOST_PIXELS:
        raise UserError(f"--supersampling: expected up to {MOST_PIXELS} pixels along each axis, got {most}")
    # A file of splats has no camera of its own, and a difference is refused in another shape.
    of_own = (scene.record.splats is None or flags.camera or flags.path) and flags.view != "difference"
    for notice in (*scene.notices, *(_reshaped(asked, wanted) if of_own else ())):
        sys.stderr.write(f"{notice}: {flags.scene}\n")
    return scene, wanted


def _moments(flags: argparse.Namespace, scene: Scene) -> Iterator[Moment]:
    """Raises UserError for what the scene does not have."""
    if flags.path:
        yield from _along(flags)
        return
    given = _read_cameras(flags.camera) if flags.camera else ()
    fixed = given[0].camera if len(given) == 1 else None
    if flags.time is not None and flags.frames:
        raise UserError("expected --time or --frames, got both")
    if flags.time is not None and not 0 <= flags.time <= 1:
        raise UserError(f"--time: expected 0 to 1, got {flags.time}")
    if len(given) > 1:
        yield from _views(given, flags)
        return
    if flags.time is not None:
        yield Moment(f"time-{flags.time:.4f}", None, flags.time, fixed or scene.camera_at(flags.time))
        return
    for index in _frame_indices(flags.frames or ["all"], scene):
        yield Moment(f"frame-{index:06d}", index, scene.time(index), fixed or scene.cameras[index])


def _frame_indices(frames: list[str], scene: Scene) -> Sequence[int]:
    """Of all, test or numbers. Raises UserError for others."""
    count = len(scene.cameras)
    if frames == ["all"]:
        return range(count)
    if frames == ["test"]:
        if not scene.test_indices:
            raise UserError(
                f"--frames test: expected held-out frames, got none in {scene.name}; use --frames all"
            )
        return scene.test_indices
    return frame_numbers(frames, count)


def _views(given: Sequence[NamedCamera], flags: argparse.Namespace) -> Iterator[Moment]:
    """One moment from several cameras. Raises UserError where frames are asked for, too."""
    if flags.frames:
        raise UserError(f"expected --time with {len(given)} cameras, got --frames {' '.join(flags.frames)}")
    for place, one in enumerate(given):
        # The end of a name that is a long path tells most.
        name = re.sub(r"[^\w.-]+", "-", one.name)[-LONGEST:] or "camera"
        yield Moment(f"{place:04d}-{name}", None, flags.time or 0.0, one.camera)


def _along(flags: argparse.Namespace) -> Iterator[Moment]:
    """Evenly along a path. Raises UserError for an empty path, or flags that say otherwise."""
    for name in ("frames", "time", "camera"):
        if getattr(flags, name) is not None:
            raise UserError(f"expected --path without --{name}, got both: the path sets times and poses")
    try:
        path = read_views(flags.path).path
    except CameraFileError as error:
        raise UserError(str(error)) from error
    if not path.keyframes:
        raise UserError(f"expected a path of at least one keyframe, got none: {flags.path}")
    for place, key in enumerate(path.moments(flags.frames_per_second or FRAMES_PER_SECOND)):
        yield Moment(f"path-{place:06d}", None, key.time, key.camera)


def _read_cameras(path: Path) -> tuple[NamedCamera, ...]:
    try:
        return read_cameras(path)
    except CameraFileError as error:
        raise UserError(str(error)) from error


def _resized(camera: Camera, size: list[int] | None) -> Camera:
    """Raises UserError for a size, of the flag or the camera file, that no renderer draws."""
    width, height = size or (camera.width, camera.height)
    if min(width, height) < 1 or max(width, height) > MOST_PIXELS:
        raise UserError(f"--size: expected 1 to {MOST_PIXELS} pixels along each axis, got {width} {height}")
    return camera.shaped(width, height) if size else camera


def _reshaped(asked: Sequence[Moment], wanted: Sequence[Moment]) -> Iterator[str]:
    """What a size of another shape than the camera's does; said once."""
    for before, after in zip(asked, wanted, strict=True):
        old, new = before.camera, after.camera
        if not old.has_shape(new.width, new.height):
            where = "beside" if new.width * old.height > old.width * new.height else "above and below"
            yield (
                f"--size {new.width} {new.height} has another shape than {old.width} {old.height}: "
                f"nothing is stretched, and what lies {where} the camera's view is in the image"
            )
            return
