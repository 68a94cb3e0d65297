"""Short whole runs on clips that lack something, or with rates that are far too high."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Final, get_args

import numpy as np

from renderer.clip import Clip, ClipError, Frame
from renderer.phantom import Phantom, PhantomParams
from renderer.stability.row import Row
from renderer.train.config import Method, TrainConfig
from renderer.train.events import Evaluated, Finished
from renderer.train.trainer import TrainingError, train

CONFIG: Final = TrainConfig(iterations=30, n_gaussians=300)
RATES: Final = (
    "mean_rate", "motion_rate", "color_rate", "color_motion_rate", "opacity_rate", "scale_rate", "quat_rate",
)  # fmt: skip
HAZARD: Final = "whole run"
METRES: Final = 1e-3


def rows() -> Iterator[Row]:
    """Every method on every clip: what of the model is no number."""
    for method in get_args(Method):
        for name, make in CLIPS.items():
            yield _run(f"{method}, {name}", make(), replace(CONFIG, method=method))
    quick: tuple[Method, ...] = ("vesselsplat", "static")
    for method in quick:
        faster = {rate: min(1.0, 100 * getattr(CONFIG, rate)) for rate in RATES}
        config = replace(CONFIG, method=method, iterations=120, **faster)
        yield _run(f"{method}, learning rates x100", _whole(), config)
    psnrs = [_psnr(clip) for clip in (_whole(), _in_metres())]
    yield Row(HAZARD, "millimetres and metres give the same picture", abs(psnrs[0] - psnrs[1]), 0.02, "dB")
    for name, change in (("depth all 0", _without_depth), ("every mask empty", _without_tissue)):
        yield _run(f"vesselsplat, {name}", _changed(change), CONFIG)


def _run(case: str, clip: Clip, config: TrainConfig) -> Row:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        try:
            done = next(event for event in train(clip, config) if isinstance(event, Finished))
        except (ClipError, TrainingError) as refusal:
            return Row(HAZARD, case, 0.0, 0, "broken values", f"refused: {str(refusal).split(':')[0]}")
    arrays = done.model.arrays().values()
    broken = sum(np.count_nonzero(~np.isfinite(value)) for value in arrays)
    return Row(HAZARD, case, float(broken), 0, "broken values")


def _psnr(clip: Clip) -> float:
    """At the end, of the frames held out: what is told before comes by the clock, after no fixed steps."""
    told = [
        event.psnr for event in train(clip, replace(CONFIG, hold_out=True)) if isinstance(event, Evaluated)
    ]
    return told[-1] if told else math.nan


@cache
def _frames() -> tuple[Frame, ...]:
    phantom = Phantom(PhantomParams(n_frames=10, width=96, height=72))
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
    phantom = Phantom(PhantomParams(n_frames=10, width=96, height=72, camera="moving"))
    return _clip([phantom.view(index).frame for index in range(10)])


CLIPS: Final[dict[str, Callable[[], Clip]]] = {
    "one camera": _whole,
    "a camera that moves": _with_a_moving_camera,
    "one frame": lambda: _clip(_frames()[:1]),
    "one frame with an empty mask": lambda: _one_changed(_without_tissue),
    "one frame with depth all 0": lambda: _one_changed(_without_depth),
}
"""Made when they are asked for."""
