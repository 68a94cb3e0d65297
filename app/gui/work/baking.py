"""Keyframes of the shown model for the graphics card, made bit by bit beside the other background work."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from app.scenes.scene import Scene
from renderer.deformation.motion import Still
from renderer.draw.keyframes import Baker, Keyframes, Tolerance

SECONDS = 0.05
"""Of work at a time; pictures wait no longer than this for it."""
PIXELS = 0.02
"""How far a mean may be off at a keyframe, in pixels of the clip's camera at the middle of the tissue."""


@dataclass(frozen=True)
class BakeRequest:
    """Begin with a model, or go on with what `baker` has."""

    shown: Scene
    baker: Baker | None = None
    part: int = 0


@dataclass(frozen=True, eq=False)
class Baked:
    """The next of `request`: go on with `baker`, or the whole."""

    request: BakeRequest
    baker: Baker
    keyframes: Keyframes | None = None

    @property
    def said(self) -> str:
        """What the log says of it; empty when every frame is kept as it is."""
        frames, kept = len(self.request.shown.cameras), self.keyframes
        if kept is None or not kept.offsets or len(kept) == frames:
            return ""
        return (
            f"keeps {len(kept)} of {frames} moments, as many as fit into "
            f"{kept.n_bytes >> 20} MB; between them Gaussians are off by up to {kept.error:.3g} units"
        )


def can_bake(shown: Scene) -> bool:
    """A model that moves and stays as it is: previews of a training come and go, and Gaussians that are
    others at other times are uploaded as they come."""
    return not shown.live and not (isinstance(shown.model.motion, Still) or shown.split_by_time)


def bake(request: BakeRequest) -> Iterator[Baked]:
    """Answers with the next part of the work done."""
    shown = request.shown
    baker = request.baker
    if baker is None:
        tolerance = Tolerance(PIXELS * shown.distance / shown.cameras[0].fx)
        times = [index / len(shown.cameras) for index in range(len(shown.cameras))]
        baker = Baker(shown.model, times, tolerance)
    done = baker.advance(SECONDS)
    yield Baked(request, baker, baker.keyframes() if done else None)
