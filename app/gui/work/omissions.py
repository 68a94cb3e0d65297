"""What a reconstruction will leave out, looked up before it is started, off the window's thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from app.clip_part import WHOLE, ClipPart
from renderer.clip import Clip
from renderer.train.config import TrainConfig
from renderer.train.events import Omission


@dataclass(frozen=True)
class OmissionsRequest:
    """What it depends on: the photos as they are, and the settings but for the number of iterations."""

    clip: Clip
    config: TrainConfig
    part: ClipPart = WHOLE


@dataclass(frozen=True, eq=False)
class Omissions:
    """The answer; of a clip or settings that are no longer chosen, it is not shown."""

    request: OmissionsRequest
    omitted: tuple[Omission, ...]


def look(request: OmissionsRequest) -> Iterator[Omissions]:
    """Decides as training does, from the same frames. Raises ClipError: frames cannot be read."""
    # Training's modules take a while to import; the window must not wait for them.
    from renderer.train.needs import decide
    from renderer.train.trainer import split

    clip = request.part.of(request.clip)
    fit, _ = split(clip, request.config)
    frames = [clip.read_frame(index) for index in fit]
    yield Omissions(request, decide(clip, frames, request.config).omitted)
