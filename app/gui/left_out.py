"""What a reconstruction will leave out, looked up before it is started, off the window's thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from renderer.clip import Clip
from renderer.train.config import TrainConfig
from renderer.train.events import Omission


@dataclass(frozen=True)
class LeftOutRequest:
    """What it depends on: the photos as they are, and the settings but for the number of iterations."""

    clip: Clip
    config: TrainConfig


@dataclass(frozen=True, eq=False)
class LeftOut:
    """The answer; of a clip or settings that are no longer chosen, it is not shown."""

    request: LeftOutRequest
    omitted: tuple[Omission, ...]


def look(request: LeftOutRequest) -> Iterator[LeftOut]:
    """Decides as training does, from the same frames. Raises ClipError: frames cannot be read."""
    # Training's modules take a while to import; the window must not wait for them.
    from renderer.train.needs import decide
    from renderer.train.trainer import split

    fit, _ = split(request.clip, request.config)
    frames = [request.clip.read_frame(index) for index in fit]
    yield LeftOut(request, decide(request.clip, frames, request.config).omitted)
