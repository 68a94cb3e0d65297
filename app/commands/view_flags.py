"""The flag --view, and the views that it asks for, one a moment."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace

from app.commands.view_selection import Moment
from app.errors import UserError
from app.runs.run_folder import RunFolder
from app.runs.trained_clip import input_clip, run_clip
from app.scenes.backgrounds import BACKGROUNDS
from app.scenes.scene import Scene
from app.scenes.view_kinds import BY_PROCESSOR, EXPLAINED, has_scale
from app.scenes.view_request import FrameRequest, ViewRequest
from renderer.clip import Clip
from renderer.near_plane import near_plane
from renderer.splat_files import is_named_as_splats


def add_flag(parser: argparse.ArgumentParser) -> None:
    """Which kind of view is drawn, and over what."""
    parser.add_argument(
        "--background",
        choices=BACKGROUNDS,
        default="grey",
        help="what stands where nothing was observed; smooth: the colours of the surroundings, hatched "
        "(default grey)",
    )
    parser.add_argument(
        "--unobserved",
        action="store_true",
        help="also draw what no frame shows: Gaussians behind tissue in all frames, and what lies beyond the "
        "frames of a camera at rest",
    )
    parser.add_argument(
        "--view",
        choices=EXPLAINED,
        default="color",
        help="what images and videos show; a quantity gets a colour bar, the same for a whole video; "
        "difference: to the frames the run was trained on (default color)",
    )


def asked_for(flags: argparse.Namespace, scene: Scene, wanted: Sequence[Moment]) -> list[ViewRequest]:
    """One a moment. Raises UserError for a difference where there are no frames, or what does not draw it."""
    if flags.view in BY_PROCESSOR and flags.renderer != "cpu":
        raise UserError(f"--with: expected cpu for --view {flags.view}, got {flags.renderer}")
    if has_scale(flags.view) and flags.background != "grey":
        raise UserError(
            f"--background {flags.background}: expected a --view without a scale, got {flags.view}"
        )
    if flags.view in ("motion", "surface") and scene.is_series:
        raise UserError(f"--view {flags.view}: expected a model that moves, got {scene.split_by_time}")
    clip = _references(flags) if flags.view == "difference" else None
    finer, views = flags.supersampling, []
    for moment in wanted:
        reference = None if clip is None or moment.frame is None else FrameRequest(clip, moment.frame)
        near = near_plane(scene.model, moment.camera)
        view = ViewRequest(scene, moment.time, moment.camera, near_plane=near, supersampling=finer)
        background = BACKGROUNDS[flags.background]
        view = replace(view, background=background, unobserved=flags.unobserved)
        views.append(view.of_kind(flags.view, reference))
    return views


def _references(flags: argparse.Namespace) -> Clip:
    """What each frame of a run should look like. Raises UserError where there is none."""
    if flags.window is not None:
        raise UserError("--view difference: expected all windows, with --frames for some, got --window")
    if is_named_as_splats(flags.scene) or flags.camera or flags.path or flags.time is not None:
        raise UserError("--view difference: expected frames of a run from its own cameras")
    record = RunFolder(flags.scene).record()
    camera = record.cameras[0]
    if flags.size and not camera.has_shape(*flags.size):
        raise UserError(
            "--view difference: expected a --size of the shape of the frames, "
            f"{camera.width} {camera.height}, got {flags.size[0]} {flags.size[1]}"
        )
    return input_clip(run_clip(record), record)
