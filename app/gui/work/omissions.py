"""What a reconstruction will leave out or is told to keep, looked up before it is started, off the window's
thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import get_args

from app.runs.clip_selection import WHOLE, ClipPart
from app.runs.exposure_record import ExposureRecord
from app.runs.left_out import BEFORE, left_out_of, with_found
from app.runs.posing import left_out, may_be_posed
from renderer.camera_motion import camera_motion
from renderer.clip import Clip, Frame
from renderer.frame_gains import jitter, log_gains
from renderer.train.config import Part, TrainConfig
from renderer.train.events import Omission


@dataclass(frozen=True)
class OmissionsRequest:
    """What it depends on: the frames as they are, and the settings but for the number of iterations."""

    clip: Clip
    config: TrainConfig
    part: ClipPart = WHOLE

    @property
    def unkept(self) -> OmissionsRequest:
        """The same with nothing that is kept."""
        return replace(self, config=replace(self.config, keep=()))


@dataclass(frozen=True)
class Looking:
    """How far it is: frames are read first, which takes longest."""

    request: OmissionsRequest
    frames: int
    count: int
    """Of the frames to read."""


@dataclass(frozen=True, eq=False)
class Omissions:
    """The answer; of a clip or settings that are no longer chosen, it is not shown."""

    request: OmissionsRequest
    omitted: tuple[Omission, ...]
    kept: tuple[Omission, ...] = ()
    """What would be left out if it were not kept."""

    @property
    def lines(self) -> tuple[Omission, ...]:
        """Both, in an order that does not change as one of them is kept; last what cannot be."""
        parts = get_args(Part)
        return tuple(
            sorted(
                (*self.omitted, *self.kept),
                key=lambda each: len(parts) if each.part is None else parts.index(each.part),
            )
        )


def find_omissions(request: OmissionsRequest) -> Iterator[Looking | Omissions]:
    """Decides as training does, from the same frames; the answer comes last. Raises ClipError: frames cannot
    be read."""
    # Training's modules take a while to import; the window must not wait for them.
    from app.runs.steadying import exposure_left_out
    from renderer.train import windows
    from renderer.train.frame_store import FrameStore
    from renderer.train.needs import decide
    from renderer.train.trainer import split

    config, clip = request.config, request.part.of(request.clip)
    fit, _ = split(clip, config)
    frames = FrameStore[Frame]()
    for done, index in enumerate(fit, 1):
        frames.append(clip.read_frame(index))
        yield Looking(request, done, len(fit))

    read = {index: place for place, index in enumerate(fit)}
    at_hand = replace(
        clip,
        read_frame=lambda index: frames[read[index]] if index in read else clip.read_frame(index),
        read_image=lambda index: frames[read[index]].image if index in read else clip.read_image(index),
    )
    moves = camera_motion(at_hand)
    cut = windows.windows_of(at_hand, config)

    @cache
    def seen(keep: tuple[Part, ...]) -> tuple[ClipPart, FrameStore[Frame]]:
        """What of the frames training sees, and the frames so."""
        is_sought = may_be_posed(clip) and not left_out(clip, replace(config, keep=keep), moves)
        is_followed = clip.depth_origin == "motion" or is_sought
        part = with_found(WHOLE, frames.__getitem__, range(len(frames)), keep, is_followed)
        return part, frames if part == WHOLE else FrameStore.of(map(part.cleared, frames))

    @cache
    def exposure(keep: tuple[Part, ...]) -> ExposureRecord:
        return ExposureRecord(jitter=jitter(log_gains(seen(keep)[1])))

    def omitted(keep: tuple[Part, ...]) -> tuple[Omission, ...]:
        earlier = tuple(each for each in keep if each in BEFORE)
        part, bare = seen(earlier)
        asked = replace(config, keep=keep)
        needed = decide(clip, bare, asked)
        steady = exposure_left_out(exposure(earlier), asked)
        before = (*left_out_of(part)[0], *left_out(clip, asked, moves), *steady)
        return (*before, *needed.omitted, *windows.left_out(cut, asked))

    kept = (
        each
        for part in config.keep
        for each in omitted(tuple(other for other in config.keep if other != part))
        if each.part == part
    )
    yield Omissions(request, omitted(config.keep), tuple(kept))
