"""What a clip needs of a reconstruction, decided once from its data before training, and what it does not."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from renderer.clip import BoolImage, Clip, Frame
from renderer.deformation.motion import Motion, Still
from renderer.deformation.spline import MIN_CONTROLS, controls_for, most_controls
from renderer.deformation.spline_motion import SplineMotion
from renderer.harmonics import BANDS
from renderer.train import outlines
from renderer.train.config import Method, Part, TrainConfig
from renderer.train.events import Omission
from renderer.train.frames import tissue_tiles
from renderer.train.starting_motion import Followed
from renderer.train.stillness import Stillness, stillness

STILL, STILL_TO_A_MOVING_CAMERA = 0.5, 1.0
"""Displacements in pixels that no deformation is made for. A lamp that moves with the camera shifts shading
by up to 0.5, and tissue that moves shifts by 2 or more: 6 phantoms of each kind. The pulling clip: 2.4."""
SAME_COLOR = 0.5
"""Grey levels that no curve is made for. Phantoms with tissue and camera at rest: at most 0.3; others: 3."""
FRAMES_PER_CONTROL_AT_REST = 2
"""Colours of tissue at rest follow the lamp, which turns faster than tissue: on held-out training frames of
three phantoms 0.5 dB better than 3.7 frames, and better than with a deformation."""
OWN: Final[tuple[Method, ...]] = ("vesselsplat", "static")
"""Methods that are not of others' publications, which are trained on all tissue."""
BEGAN: Final = ", but the run began without"
"""As earlier versions measured it."""
RAW_NUMBERS = 14
"""Of a Gaussian without harmonics and motion."""


@dataclass(frozen=True, kw_only=True)
class Needs:
    """What is trained, and what is left out."""

    sh_degree: int
    """0 to 3."""
    moves: bool
    """Gaussians are displaced over time."""
    rests: bool
    """Positions come to rest: nothing moves them but steps from one frame and another."""
    recolors: bool
    """Colours follow curves in time, where the method has such."""
    n_controls: int
    """Control values of a curve."""
    has_depth: bool
    """There is depth to compare with."""
    has_masks: bool
    """Some pixel is not tissue."""
    apart: BoolImage | None = None
    """(H, W) where masks end at the tools' outline: what other frames show of the tissue beside it, which is
    not trained on there."""
    followed: Followed | None = None
    """Where tissue was seen to go, to start from; None: nobody looked."""
    omitted: tuple[Omission, ...] = ()


@dataclass(frozen=True)
class Begun:
    """What a training began with, and goes on with, whatever is measured by now."""

    moves: bool
    recolors: bool
    n_controls: int | None = None
    """None: it has no curves."""

    @classmethod
    def with_motion(cls, motion: Motion) -> Begun:
        """What a training with that motion has."""
        if isinstance(motion, SplineMotion):
            moves, recolors = (len(each) > 0 for each in (motion.position_controls, motion.color_controls))
            return cls(moves, recolors, motion.n_controls)
        return cls(not isinstance(motion, Still), recolors=False)


def decide(
    clip: Clip,
    frames: Sequence[Frame],
    config: TrainConfig,
    *,
    follow: Sequence[Frame] | None = None,
    begun: Begun | None = None,
) -> Needs:
    """From the frames to fit, in the order of time.

    follow: the same frames with all depth that there is, through which tissue is followed if it moves.
    begun: what a run that is resumed decided; None: nothing yet.
    """
    measured = Stillness(0.0, 0.0) if config.method == "static" else stillness(frames)
    moves = _moves(clip, measured, config) if begun is None else begun.moves
    recolors = _recolors(clip, measured, config) if begun is None else begun.recolors
    n_controls = None if begun is None else begun.n_controls
    followed = None
    if follow is not None and _begins_from_tracks(config, moves):
        followed = Followed.of(follow, config.node_columns)
    needs = Needs(
        sh_degree=_sh_degree(clip, recolors, config),
        moves=moves,
        rests=not moves and len(frames) > 1,
        recolors=recolors,
        n_controls=n_controls or _n_controls(clip, moves, config, followed),
        followed=followed,
        has_depth="depth" in config.keep or any(frame.depth_mask.any() for frame in frames),
        has_masks="masks" in config.keep or not all(frame.tissue_mask.all() for frame in frames),
        apart=_apart(clip, frames, config),
    )
    counted = followed is not None or n_controls is not None or not _tracks_count(config, moves)
    return replace(needs, omitted=tuple(_omitted(clip, frames, config, needs, measured, counted=counted)))


def _apart(clip: Clip, frames: Sequence[Frame], config: TrainConfig) -> BoolImage | None:
    """What frames of one camera show of tissue that is in part of the colour of tools in others."""
    if "beside_tools" in config.keep or config.method not in OWN or not clip.camera_is_fixed:
        return None
    return outlines.seen_apart(frames) if outlines.are_tight(frames) else None


def _begins_from_tracks(config: TrainConfig, moves: bool) -> bool:
    return moves and config.method == "vesselsplat" and "tracks" not in config.leave_out


def _tracks_count(config: TrainConfig, moves: bool) -> bool:
    """They say how many control values there are, as nobody else does."""
    asked = config.n_controls is not None or "controls" in config.keep
    return _begins_from_tracks(config, moves) and not asked


def _moves(clip: Clip, measured: Stillness, config: TrainConfig) -> bool:
    if config.method == "static" or "deformation" in config.leave_out:
        return False
    bound = STILL if clip.camera_is_fixed else STILL_TO_A_MOVING_CAMERA
    return "deformation" in config.keep or measured.displacement > bound


def _recolors(clip: Clip, measured: Stillness, config: TrainConfig) -> bool:
    if config.method != "vesselsplat" or "color_curves" in config.leave_out:
        return False
    return "color_curves" in config.keep or measured.recoloring > SAME_COLOR


def _sh_degree(clip: Clip, recolors: bool, config: TrainConfig) -> int:
    if config.sh_degree is not None:
        return config.sh_degree
    if "harmonics" in config.keep:
        return len(BANDS) - 1
    return 0 if clip.camera_is_fixed or recolors else len(BANDS) - 1


def _n_controls(clip: Clip, moves: bool, config: TrainConfig, followed: Followed | None) -> int:
    if config.n_controls is not None:
        return config.n_controls
    if "controls" in config.keep:
        return max(MIN_CONTROLS, len(clip))
    if followed is not None:
        return followed.controls_for(len(clip))
    return controls_for(len(clip)) if moves else max(MIN_CONTROLS, len(clip) // FRAMES_PER_CONTROL_AT_REST)


def _omitted(
    clip: Clip,
    frames: Sequence[Frame],
    config: TrainConfig,
    needs: Needs,
    measured: Stillness,
    *,
    counted: bool,
) -> Iterator[Omission]:
    """In words and numbers."""
    harmonics = 3 * (BANDS[-1] - BANDS[needs.sh_degree])
    if harmonics:
        saves = f"{harmonics} of {RAW_NUMBERS + 3 * BANDS[-1]} numbers per Gaussian"
        part: Part | None = "harmonics" if config.sh_degree is None else None
        yield Omission("harmonics", _why_no_harmonics(clip, config), saves, part)
    curve = f"{3 * needs.n_controls} numbers per Gaussian"
    if not needs.moves:
        asked = config.method == "static" or "deformation" in config.leave_out
        why, saves = _why_no_deformation(clip, config, measured), _motion_of(config, curve)
        yield Omission("deformation", why, saves, None if asked else "deformation")
    if not needs.recolors and config.method == "vesselsplat":
        asked = "color_curves" in config.leave_out
        why = f"colours differ by {measured.recoloring:.2f} grey levels"
        why = "as requested" if asked else why + (BEGAN if _recolors(clip, measured, config) else "")
        yield Omission("colour curves", why, curve, None if asked else "color_curves")
    if needs.moves and config.method == "vesselsplat" and "tracks" in config.leave_out:
        yield Omission("start from tracks", "as requested", "optical flow before the first step", None)
    if needs.recolors or (needs.moves and config.method == "vesselsplat"):
        yield from _of_curves(clip, config, needs, counted=counted)
    if not needs.has_depth:
        yield Omission("depth loss", "no depth is measured", "a term of the loss", "depth")
    if not needs.has_masks:
        yield Omission("masking", "no pixel is masked", "weights when halving frames", "masks")
    share = 1 - float(np.mean([tissue_tiles(frame.tissue_mask).mean() for frame in frames]))
    if share > 0 and "tiles" not in config.keep:
        yield Omission(
            "tiles without tissue", "no tissue to compare with", f"{100 * share:.0f} % of the tiles", "tiles"
        )
    if needs.apart is not None:
        yield from outlines.told(frames, needs.apart)


def _of_curves(clip: Clip, config: TrainConfig, needs: Needs, *, counted: bool) -> Iterator[Omission]:
    """Most numbers of a curve do not count at any one time; counted: how many there are is known."""
    counted = counted or most_controls(len(clip)) == needs.n_controls
    most = needs.n_controls if counted else most_controls(len(clip))
    fewer, least = len(clip) - most, "" if counted else "at least "
    if fewer > 0:
        per = f"{len(clip) / needs.n_controls:.1f}"
        why = f"a curve needs one per {per if counted else f'{len(clip) / most:.1f} to {per}'} frames"
        part: Part | None = "controls" if config.n_controls is None else None
        yield Omission("control values", why, f"{least}{fewer} of {len(clip)} per curve", part)
    if needs.n_controls > MIN_CONTROLS and "moments" not in config.keep:
        saves = f"{least}{needs.n_controls - MIN_CONTROLS} of {needs.n_controls} per curve and step"
        why = "a frame has no gradient for them"
        yield Omission("updates of control values at other times", why, saves, "moments")


def _why_no_harmonics(clip: Clip, config: TrainConfig) -> str:
    if config.sh_degree is not None:
        return f"degree {config.sh_degree} was requested"
    return "the camera is fixed" if clip.camera_is_fixed else "colour curves follow the lamp"


def _why_no_deformation(clip: Clip, config: TrainConfig, measured: Stillness) -> str:
    if config.method == "static":
        return "the method is static"
    if "deformation" in config.leave_out:
        return "as requested"
    moved = f"tissue moves by {measured.displacement:.2f} px"
    n_frames, *size = measured.compared
    moved += f" (all {n_frames} training frames compared, at {size[0]}x{size[1]})" if n_frames else ""
    return moved + (BEGAN if _moves(clip, measured, config) else "")


def _motion_of(config: TrainConfig, curve: str) -> str:
    """What the motion of a method consists of."""
    kinds = {"deform3dgs": "510 numbers per Gaussian", "endogaussian": "the planes and their heads"}
    return kinds.get(config.method, curve)
