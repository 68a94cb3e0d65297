"""The 3D view drawn by the numba rasteriser, as background work."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from time import perf_counter

from app.scenes.cpu_rendering import draw_on_cpu
from app.scenes.view_kinds import Scale
from app.scenes.view_request import ViewRequest
from renderer.clip import ByteImage


@dataclass(frozen=True, eq=False)
class View:
    """The 3D picture on screen, with the request it was made from."""

    request: ViewRequest
    image: ByteImage
    """(H, W, 3)."""
    milliseconds: float
    scale: Scale | None = None
    """What its colours mean, where they are values."""


def draw_view(request: ViewRequest) -> Iterator[View]:
    """Answers a ViewRequest with the numba rasteriser."""
    start = perf_counter()
    picture = request.picture(draw_on_cpu)
    yield View(request, picture.image, 1000 * (perf_counter() - start), picture.scale)
