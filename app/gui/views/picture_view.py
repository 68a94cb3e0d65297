"""Zoom and pan of an image in a pane. Two panes that share one view are linked by construction."""

from __future__ import annotations

from dataclasses import dataclass, replace

from app.enhancement.settable import MAX_ZOOM, MIN_ZOOM

Room = tuple[float, float]
"""Width and height of a pane, in pixels."""


@dataclass(frozen=True)
class Placement:
    """Where the picture lies in its pane: pane position = offset + zoom * picture position, in pixels."""

    zoom: float
    """Down; across it is `zoom_x`."""
    offset_x: float
    offset_y: float
    pixel_aspect: float = 1.0
    """Width of a picture's pixel by its height."""

    @property
    def zoom_x(self) -> float:
        return self.zoom * self.pixel_aspect

    def picture_at(self, x: float, y: float) -> tuple[float, float]:
        """Picture position under a pane position."""
        return (x - self.offset_x) / self.zoom_x, (y - self.offset_y) / self.zoom

    def pane_at(self, x: float, y: float) -> tuple[float, float]:
        """Pane position of a picture position."""
        return self.offset_x + self.zoom_x * x, self.offset_y + self.zoom * y


@dataclass(frozen=True)
class PictureView:
    """What the user looks at, independent of pane and picture sizes.

    `zoom` is pane pixels per picture pixel, None = the whole picture fits; `center` is the picture
    position in the middle of the pane, as fractions of the picture's width and height.
    """

    zoom: float | None = None
    center: tuple[float, float] = (0.5, 0.5)
    pixel_aspect: float = 1.0
    """Width of a picture's pixel by its height, which `zoom` counts."""

    def place(self, picture: tuple[int, int], pane: Room) -> Placement:
        """Placement of a picture of (width, height) pixels in a pane of (width, height) pixels."""
        width, height = picture[0] * self.pixel_aspect, picture[1]
        fit = min(pane[0] / width, pane[1] / height)
        zoom, center = (fit, (0.5, 0.5)) if self.zoom is None else (self.zoom, self.center)
        x, y = pane[0] / 2 - zoom * center[0] * width, pane[1] / 2 - zoom * center[1] * height
        return Placement(zoom, x, y, self.pixel_aspect)

    def zoomed(
        self, factor: float, at: tuple[float, float], picture: tuple[int, int], pane: Room
    ) -> PictureView:
        """Zoomed by `factor` so that the picture position under the pane position `at` stays there."""
        now = self.place(picture, pane)
        zoom = min(max(now.zoom * factor, MIN_ZOOM), MAX_ZOOM)
        fixed = now.picture_at(*at)
        across = (pane[0] / 2 - at[0]) / (zoom * self.pixel_aspect)
        middle = (fixed[0] + across, fixed[1] + (pane[1] / 2 - at[1]) / zoom)
        return replace(self, zoom=zoom, center=_inside(middle, picture))

    def panned(self, by: tuple[float, float], picture: tuple[int, int], pane: Room) -> PictureView:
        """Dragged by pane pixels; the middle of the pane stays on the picture.

        One that fits the pane only beyond the range of zooms is seen whole and stays where it is.
        """
        now = self.place(picture, pane)
        if not MIN_ZOOM <= now.zoom <= MAX_ZOOM:
            return self
        middle = now.picture_at(pane[0] / 2 - by[0], pane[1] / 2 - by[1])
        return replace(self, zoom=now.zoom, center=_inside(middle, picture))

    def scaled(self, scale: float) -> PictureView:
        """The same view of a pane counted in pixels `scale` times as fine."""
        return replace(self, zoom=None if self.zoom is None else self.zoom * scale)

    def fitted(self) -> PictureView:
        """The whole picture."""
        return replace(self, zoom=None, center=(0.5, 0.5))

    def one_to_one(self, zoom: float = 1.0) -> PictureView:
        """At `zoom` pane pixels a picture pixel, around the same centre."""
        return replace(self, zoom=zoom)


def _inside(position: tuple[float, float], picture: tuple[int, int]) -> tuple[float, float]:
    x, y = (min(max(value / size, 0.0), 1.0) for value, size in zip(position, picture, strict=True))
    return x, y
