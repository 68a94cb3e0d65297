"""What draws views, by the name that files record."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from app.scenes.cpu_rendering import ON_CPU, Draw, Drawn, draw_on_cpu
from app.scenes.view_kinds import Composed
from app.scenes.view_request import ViewRequest


@dataclass(eq=False)
class Drawer:
    """Remembers the last view that it has drawn, of which both a picture and its depth may be made."""

    draw: Draw = draw_on_cpu
    name: str = ON_CPU
    _last: tuple[ViewRequest, Drawn] | None = field(default=None, init=False)

    def drawn(self, view: ViewRequest) -> Drawn:
        """Raises UserError where it cannot be drawn."""
        wanted = replace(view, photo=None, scale=None)
        if self._last is None or self._last[0] != wanted:
            self._last = None
            self._last = wanted, wanted.drawn(self.draw)
        return self._last[1]

    def picture(self, view: ViewRequest) -> Composed:
        """Raises UserError where it cannot be drawn, ClipError for a photo."""
        return view.composed(self.drawn(view))
