"""Short whole runs on clips that lack something, or with rates that are far too high.

A run that must train is measured by its pictures and depths against the clip's; one that must be refused, by
the line that refuses it. Anything else that ends a run is infinitely far from either.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Final, Literal, get_args

import numpy as np

from renderer.clip import Clip, Frame
from renderer.gaussians import DynamicGaussians
from renderer.measuring.stability.row import Row
from renderer.near_plane import NEAR_SHARE
from renderer.phantom import Phantom, PhantomParams
from renderer.rasterize.cpu import render
from renderer.train.config import Method, TrainConfig
from renderer.train.events import Evaluated, Finished
from renderer.train.initialize import NoTissue, scene_size
from renderer.train.trainer import TrainingError
from renderer.train.training import train

CONFIG: Final = TrainConfig(iterations=60, n_gaussians=300)
RATES: Final = (
    "mean_rate", "motion_rate", "color_rate", "color_motion_rate", "opacity_rate", "scale_rate", "quat_rate",
)  # fmt: skip
HAZARD: Final = "whole run"
METRES: Final = 1e-3
FAILED: Final = math.inf
"""Stands for the error of a run that ends as none should."""


CameraKind = Literal["fixed", "moving"]


@dataclass(frozen=True)
class Quality:
    """Root mean square errors on tissue of the frames that were fitted."""

    picture: float
    """Grey levels."""
    depth: float
    """Scene sizes."""


@dataclass(frozen=True)
class Refusal:
    """How a run must end that cannot train."""

    kind: type[Exception]
    text: str
    """A part of its line."""


NO_DEPTH: Final = Refusal(
    NoTissue, "reconstruction expects measured depth on the tissue, and this clip has none"
)
ALL_MASKED: Final = Refusal(
    NoTissue, "reconstruction expects measured depth on the tissue, and its masks leave out all of it"
)
DIVERGES: Final = Refusal(TrainingError, "the loss rises")


def of_method(method: Method) -> Iterator[Row]:
    """On every clip: how far pictures and depths are from the clip's."""
    for name, make in CLIPS.items():
        found, done = _trained(make(), replace(CONFIG, method=method))
        bar = EXPECTED[method][name]
        yield Row(HAZARD, f"{method}, {name}", found.picture, bar.picture, "grey levels", done)
        yield Row(HAZARD, f"{method}, {name}: depth", found.depth, bar.depth, "of the scene size", done)


def refused() -> Iterator[Row]:
    """Runs that cannot train say why."""
    quick: tuple[Method, ...] = ("vesselsplat", "static")
    for method in quick:
        faster = {rate: min(1.0, 100 * getattr(CONFIG, rate)) for rate in RATES}
        config = replace(CONFIG, method=method, iterations=120, **faster)
        yield _refused(f"{method}, learning rates x100", _whole(), config, DIVERGES)
    yield _refused("vesselsplat, depth all 0", _changed(_without_depth), CONFIG, NO_DEPTH)
    yield _refused("vesselsplat, every mask empty", _changed(_without_tissue), CONFIG, ALL_MASKED)


def units() -> Iterator[Row]:
    """One clip, in two units."""
    psnrs = [_psnr(clip) for clip in (_whole(), _in_metres())]
    yield Row(HAZARD, "millimetres and metres give the same image", abs(psnrs[0] - psnrs[1]), 0.02, "dB")


def _trained(clip: Clip, config: TrainConfig) -> tuple[Quality, str]:
    """What came out, and what ended the run if nothing did."""
    try:
        done = next(event for event in train(clip, config) if isinstance(event, Finished))
    except Exception as end:  # whatever ends a run that must train
        return Quality(FAILED, FAILED), f"not expected: {type(end).__name__}: {end}"
    return _quality(done.model, clip), ""


def _refused(case: str, clip: Clip, config: TrainConfig, expected: Refusal) -> Row:
    ended = "it trained"
    with warnings.catch_warnings():
        # Numbers that overflow are what is asked for.
        warnings.simplefilter("ignore", RuntimeWarning)
        try:
            for _ in train(clip, config):
                pass
        except Exception as refusal:  # whatever else it is must not pass for the one expected
            ended = f"{type(refusal).__name__}: {refusal}"
            if type(refusal) is expected.kind and expected.text in str(refusal):
                return Row(HAZARD, case, 0.0, 0, "other ends", f"refused: {expected.text}")
    return Row(HAZARD, case, 1.0, 0, "other ends", f"expected {expected.text!r}, got {ended}")


def _quality(model: DynamicGaussians, clip: Clip) -> Quality:
    """Over the tissue of all frames that were fitted; NaN where a picture has one."""
    frames = [clip.read_frame(index) for index in clip.train_indices]
    size, squares, depths = scene_size(frames), [], []
    for frame in frames:
        drawn = render(model.at(frame.time), frame.camera, near=NEAR_SHARE * size)
        apart = 255 * np.clip(drawn.image, 0, 1) - frame.image
        squares.append(np.square(apart[frame.tissue_mask], dtype=np.float64).ravel())
        if frame.depth is not None:
            away = (drawn.depth - frame.depth)[frame.depth_mask] / size
            depths.append(np.square(away, dtype=np.float64))
    return Quality(*(math.sqrt(np.concatenate(parts).mean()) for parts in (squares, depths)))


def _psnr(clip: Clip) -> float:
    """At the end, of the frames held out: what is told before comes by the clock, after no fixed steps.

    NaN where the run fails.
    """
    try:
        events = list(train(clip, replace(CONFIG, hold_out=True)))
    except Exception:  # as above
        return math.nan
    told = [event.psnr for event in events if isinstance(event, Evaluated)]
    return told[-1] if told else math.nan


def warm() -> None:
    """Make the phantoms that the clips are of."""
    for camera in get_args(CameraKind):
        _frames(camera)


@cache
def _frames(camera: CameraKind = "fixed") -> tuple[Frame, ...]:
    phantom = Phantom(PhantomParams(n_frames=10, width=96, height=72, camera=camera))
    return tuple(phantom.view(index).frame for index in range(10))


def _clip(frames: Sequence[Frame]) -> Clip:
    return Clip(
        name="phantom", path=Path("phantom"), format="endonerf",
        cameras=tuple(frame.camera for frame in frames),
        read_frame=lambda index: frames[index], read_image=lambda index: frames[index].image,
        labels=tuple(str(index) for index in range(len(frames))), has_depth=True, unit="mm",
    )  # fmt: skip


def _whole() -> Clip:
    return _clip(_frames())


def _changed(change: Callable[[Frame], Frame]) -> Clip:
    return _clip([change(frame) for frame in _frames()])


def _without_depth(frame: Frame) -> Frame:
    return replace(frame, depth=np.zeros(frame.tissue_mask.shape, np.float32))


def _without_tissue(frame: Frame) -> Frame:
    nothing = np.zeros_like(frame.tissue_mask)
    return replace(frame, tissue_mask=nothing, evaluation_mask=nothing)


def _one_changed(change: Callable[[Frame], Frame]) -> Clip:
    """In the third frame, which is fitted."""
    return _clip([change(frame) if frame.index == 2 else frame for frame in _frames()])


def _in_metres() -> Clip:
    def smaller(frame: Frame) -> Frame:
        assert frame.depth is not None
        matrix = frame.camera.camera_from_world.copy()
        matrix[:3, 3] *= METRES
        return replace(frame, depth=np.float32(METRES) * frame.depth, camera=frame.camera.moved(matrix))

    return _changed(smaller)


def _with_a_moving_camera() -> Clip:
    return _clip(_frames("moving"))


CLIPS: Final[dict[str, Callable[[], Clip]]] = {
    "one camera": _whole,
    "a camera that moves": _with_a_moving_camera,
    "one frame": lambda: _clip(_frames()[:1]),
    "one frame with an empty mask": lambda: _one_changed(_without_tissue),
    "one frame with depth all 0": lambda: _one_changed(_without_depth),
}
"""Made when they are asked for."""

EXPECTED: Final[dict[Method, dict[str, Quality]]] = {
    "vesselsplat": {
        "one camera": Quality(11.13, 0.02465),
        "a camera that moves": Quality(12.39, 0.02545),
        "one frame": Quality(7.488, 0.006512),
        "one frame with an empty mask": Quality(11.17, 0.02501),
        "one frame with depth all 0": Quality(11, 0.02524),
    },
    "deform3dgs": {
        "one camera": Quality(14.99, 0.03392),
        "a camera that moves": Quality(16.30, 0.03150),
        "one frame": Quality(14.08, 0.02713),
        "one frame with an empty mask": Quality(15.38, 0.03214),
        "one frame with depth all 0": Quality(14.93, 0.03171),
    },
    "endogaussian": {
        "one camera": Quality(13.85, 0.04750),
        "a camera that moves": Quality(15.70, 0.04764),
        "one frame": Quality(13.00, 0.02465),
        "one frame with an empty mask": Quality(14.03, 0.04664),
        "one frame with depth all 0": Quality(13.91, 0.04736),
    },
    "static": {
        "one camera": Quality(11.99, 0.03221),
        "a camera that moves": Quality(11.72, 0.03208),
        "one frame": Quality(7.488, 0.006513),
        "one frame with an empty mask": Quality(12.37, 0.03152),
        "one frame with depth all 0": Quality(12.15, 0.03208),
    },
}
"""After so few steps: half a percent above what they reach, of which another processor moves 1e-4."""
