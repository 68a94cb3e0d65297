"""An image as large as it fits into a place on the screen."""

from __future__ import annotations

from imgui_bundle import ImVec4, imgui

from app.gui.drawing.textures import ShowsPictures
from app.gui.style import theme
from app.gui.style.widgets import Area, text_within
from app.gui.views.picture_view import PictureView
from renderer.clip import ByteImage


def draw_small(
    textures: ShowsPictures,
    slot: str,
    image: ByteImage | None,
    area: Area,
    instead: str,
    ink: ImVec4 | None = None,
    pixel_aspect: float = 1.0,
) -> None:
    """In the middle of the area, its pixels `pixel_aspect` times as wide as high; without an image an icon or
    a word there."""
    if image is None:
        text_within(area, instead, ink or theme.now().muted)
        return
    height, width = image.shape[:2]
    place = PictureView(pixel_aspect=pixel_aspect).place((width, height), area.inside)
    low, high = area.corner + place.pane_at(0, 0), area.corner + place.pane_at(width, height)
    imgui.get_window_draw_list().add_image(textures.whole(slot, image), low, high)
