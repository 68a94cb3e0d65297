"""One gain a frame where the brightness of a clip pumps, found before training; else left out, and said."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from app.runs.exposure_record import MOST, ExposureRecord
from app.runs.posing import Posed
from renderer.camera import FloatArray
from renderer.clip import Clip, Frame
from renderer.frame_gains import jitter, log_gain_beside, log_gains
from renderer.train.config import TrainConfig
from renderer.train.events import Omission
from renderer.train.needs import OWN
from renderer.train.trainer import split

STAGE: Final = "comparing the brightness of frames"
STEADY: Final = 0.01
"""Jitter that no gains are made for, see `renderer.frame_gains.jitter`: real clips of steady
light have 0.1 to 0.7 %, phantoms that pump by 2 % have 1.1 %."""
BESIDE: Final = 4
"""Frames that the gain of one which is not trained on is found by."""
SAVES: Final = "a gain of each frame"


def found_exposure(
    clip: Clip, config: TrainConfig, told: Callable[[int, int], None]
) -> ExposureRecord | None:
    """Of the clip as it is trained on; None: not sought, or trained on one frame. Raises ClipError: a frame
    cannot be read."""
    fit, _ = split(clip, config)
    if not _is_sought(config) or len(fit) < 2:
        return None

    def read(place: int) -> Frame:
        told(place, len(fit))
        return clip.read_frame(fit[place])

    found = log_gains(map(read, range(len(fit))))
    changes = round(jitter(found), 6)
    if not _is_used(changes, config):
        return ExposureRecord(jitter=changes)
    gains = np.exp(_of_all(clip, fit, found)).clip(1 / MOST, MOST)
    return ExposureRecord(jitter=changes, gains=tuple(round(float(gain), 5) for gain in gains))


def exposure_left_out(found: ExposureRecord | None, config: TrainConfig) -> tuple[Omission, ...]:
    """The gains, where brightness changes by too little from frame to frame, or they are refused; None: it
    is not known by how much, as of runs of earlier versions."""
    if config.method in OWN and "exposure" in config.leave_out:
        return (Omission("exposure", "as requested", SAVES, None),)
    if found is None or not _is_sought(config) or _is_used(found.jitter, config):
        return ()
    return (Omission("exposure", found.said, SAVES, "exposure"),)


def in_exposure(posed: Posed, found: ExposureRecord | None, config: TrainConfig) -> Posed:
    """With the notices and omissions of what was found."""
    told: tuple[str, ...] = ()
    if found is not None and found.gains:
        told = (f"{found.said}: each has a gain, and the model shows all of them in steady light",)
    return replace(
        posed,
        notices=(*posed.notices, *told),
        omitted=(*posed.omitted, *exposure_left_out(found, config)),
    )


def _is_sought(config: TrainConfig) -> bool:
    """Methods of others' publications are trained on the frames as they are, unless gains are asked for."""
    return "exposure" in config.keep or (config.method in OWN and "exposure" not in config.leave_out)


def _is_used(changes: float, config: TrainConfig) -> bool:
    return changes > STEADY or "exposure" in config.keep


def _of_all(clip: Clip, fit: Sequence[int], found: FloatArray) -> FloatArray:
    """Logarithms of the gains of all frames: of those that are neither fitted nor passed over, from the
    nearest that are fitted."""
    gains = np.zeros(len(clip))
    gains[list(fit)] = found
    for index in sorted(set(range(len(clip))) - set(fit) - clip.passed_over):
        near = np.argsort(np.abs(np.array(fit) - index), kind="stable")[:BESIDE]
        others = [(clip.read_frame(fit[place]), float(found[place])) for place in near]
        gains[index] = log_gain_beside(clip.read_frame(index), others)
    return gains
