"""An ImGui context without a window, with a mouse and a keyboard; what stands in for OpenGL."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from imgui_bundle import ImVec2, imgui, imgui_ctx, implot

from app.enhancement.frame_enhancer import Pictures
from app.gui.drawing.textures import PLAIN, Marks, OnPane
from app.gui.drawing.viewport import OnScreen
from app.gui.panels.compare import draw_compare
from app.gui.panels.view3d import draw_view3d
from app.gui.state.app_state import AppState
from app.gui.state.tags import Tag
from app.gui.views.picture_view import Placement
from renderer.clip import ByteImage

Draw = Callable[[], None]


class Ui:
    """One full-window panel, with a mouse and a keyboard."""

    def __init__(self) -> None:
        self._context = imgui.create_context()
        self._plots = implot.create_context()
        self.io = imgui.get_io()
        self.io.display_size, self.io.delta_time = ImVec2(900, 700), 1 / 60
        self.io.set_ini_filename("")
        self.io.backend_flags |= imgui.BackendFlags_.renderer_has_textures
        self.time = 0.0

    def frame(self, draw: Draw) -> None:
        imgui.new_frame()
        try:
            imgui.set_next_window_pos(ImVec2(0, 0))
            imgui.set_next_window_size(ImVec2(900, 700))
            with imgui_ctx.begin("panel", None, imgui.WindowFlags_.no_decoration):
                draw()
        finally:
            imgui.render()

    def press(self, draw: Draw, *keys: imgui.Key) -> None:
        for down in (True, False):
            for key in keys:
                self.io.add_key_event(key, down)
            self.frame(draw)

    def drag(self, draw: Draw, start: tuple[float, float], end: tuple[float, float], button: int = 0) -> None:
        self.io.add_mouse_pos_event(*start)
        self.frame(draw)
        self.io.add_mouse_button_event(button, True)
        self.frame(draw)
        self.io.add_mouse_pos_event(*end)
        self.frame(draw)
        self.io.add_mouse_button_event(button, False)
        self.frame(draw)

    def scroll(self, draw: Draw, at: tuple[float, float], wheel: float) -> None:
        self.io.add_mouse_pos_event(*at)
        self.frame(draw)
        self.io.add_mouse_wheel_event(0, wheel)
        self.frame(draw)
        self.frame(draw)

    def close(self) -> None:
        implot.destroy_context(self._plots)
        imgui.destroy_context(self._context)


class Shown:
    """Stands for the textures: remembers which image each slot showed last, and what was painted over it."""

    def __init__(self) -> None:
        self.images: dict[str, ByteImage] = {}
        self.marks: dict[str, Marks] = {}

    def whole(self, slot: str, image: ByteImage) -> imgui.ImTextureRef:
        self.images[slot] = image
        return imgui.ImTextureRef(1)

    def part(
        self, slot: str, image: ByteImage, place: Placement, pane: tuple[float, float], marks: Marks = PLAIN
    ) -> OnPane | None:
        self.images[slot], self.marks[slot] = image, marks
        return OnPane(imgui.ImTextureRef(1), 0, 0, 10, 10)

    def lay(self, shown: OnPane, low: ImVec2, high: ImVec2) -> None: ...


class StillViewport:
    """Shows the wanted view at once."""

    def show(self, state: AppState) -> OnScreen | None:
        request = state.view_request
        return None if request is None else OnScreen(imgui.ImTextureRef(1), (0, 0), (1, 1), request)

    def release(self) -> None: ...


class StillSecond(StillViewport):
    """The same of the second view."""

    def show(self, state: AppState) -> OnScreen | None:
        request = state.second_request
        return None if request is None else OnScreen(imgui.ImTextureRef(1), (0, 0), (1, 1), request)


def view3d(state: AppState, shown: Shown | None = None) -> None:
    draw_view3d(state, StillViewport(), StillSecond(), shown or Shown())


def pictures(state: AppState) -> Pictures:
    assert state.picture.pictures is not None
    return state.picture.pictures


def texts(tags: Iterable[Tag]) -> str:
    return " | ".join(one.text for one in tags)


def compare(state: AppState, shown: Shown) -> Draw:
    return lambda: draw_compare(state, shown)


def tooltip() -> Any:
    """The window of the one on screen."""
    found = imgui.internal.find_window_by_name("##Tooltip_00")
    return found if found is not None and found.active else None
