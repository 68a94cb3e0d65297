"""A picture in the room of a line of a list."""

from __future__ import annotations

from collections.abc import Callable

from imgui_bundle import ImVec2, imgui

from app.gui.style import theme
from renderer.clip import ByteImage


def draw_small(
    image: ByteImage | None,
    icon: str,
    low: ImVec2,
    room: ImVec2,
    texture: Callable[[ByteImage], imgui.ImTextureRef],
) -> None:
    """In the middle of the room whose upper left corner is `low`; without a picture an icon there."""
    draw = imgui.get_window_draw_list()
    if image is None:
        size = imgui.calc_text_size(icon)
        draw.add_text(low + (room - size) * 0.5, imgui.get_color_u32(theme.now().muted), icon)
        return
    factor = min(room.x / image.shape[1], room.y / image.shape[0])
    size = ImVec2(factor * image.shape[1], factor * image.shape[0])
    corner = low + (room - size) * 0.5
    draw.add_image(texture(image), corner, corner + size)
