"""One scale of colours for all moments of a 3D view that shows a quantity, as its videos have."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from app.files.stepping import run_to_end
from app.scenes.cpu_rendering import draw_on_cpu
from app.scenes.scene import Scene
from app.scenes.view_kinds import Scale, ViewKind
from app.scenes.view_request import ViewRequest, steady

SCALED: Final[tuple[ViewKind, ...]] = ("depth", "motion")
"""Views whose scale would otherwise change from moment to moment."""
SIZE: Final = 0.4
"""Of the frames, at which moments are looked at: their percentiles hardly depend on it."""


@dataclass(frozen=True)
class ScaleRequest:
    """Of a model as the clip's cameras see it."""

    shown: Scene
    kind: ViewKind


@dataclass(frozen=True, eq=False)
class ClipScale:
    request: ScaleRequest
    scale: Scale | None


def find_scale(request: ScaleRequest) -> Iterator[ClipScale]:
    """Raises UserError: it cannot be drawn."""
    frames = range(len(request.shown.cameras))
    views = [ViewRequest.of_frame(request.shown, frame).of_kind(request.kind) for frame in frames]
    (first, *_) = run_to_end(steady([view.scaled(SIZE) for view in views], draw_on_cpu))
    yield ClipScale(request, first.scale)
