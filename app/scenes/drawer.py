"""What draws views, by the name that files record; the 3D view drawn by the numba rasteriser, as background
work."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from time import perf_counter

from app.scenes.cpu_rendering import ON_CPU, Draw, draw_on_cpu
from app.scenes.view_kinds import Composed, Scale
from app.scenes.view_request import ViewRequest
from renderer.clip import ByteImage
from renderer.rasterize.rendered import Rendered
from renderer.unobserved import BLACK


@dataclass(eq=False)
class Drawer:
    """Remembers the last view that it has drawn, of which both a picture and its depth may be made."""

    draw: Draw = draw_on_cpu
    name: str = ON_CPU
    _last: tuple[ViewRequest, Rendered] | None = field(default=None, init=False)

    def drawn(self, view: ViewRequest) -> Rendered:
        """Raises UserError where it cannot be drawn."""
        wanted = replace(view, reference=None, frame_share=0.0, scale=None, background=BLACK)
        if self._last is None or self._last[0] != wanted:
            self._last = None
            self._last = wanted, wanted.drawn(self.draw)
        return self._last[1]

    def picture(self, view: ViewRequest) -> Composed:
        """Raises UserError where it cannot be drawn, ClipError for a frame."""
        return view.composed(self.drawn(view))


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
    if request.leaves_out:
        _ = request.scene.shown  # Once for all views of a scene: no part of how long one takes.
    start = perf_counter()
    picture = request.picture(draw_on_cpu)
    yield View(request, picture.image, 1000 * (perf_counter() - start), picture.scale)
