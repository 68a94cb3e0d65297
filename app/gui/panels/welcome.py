"""What to do first: open something, drop something, or try the phantom."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.files.legible import legible
from app.gui.actions import actions
from app.gui.commands.command import Act
from app.gui.commands.commands import open_file, open_folder
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.widgets import button, centered, em, explain

WIDTH = 17.0


def draw_welcome(state: AppState) -> None:
    """Shown in place of the pictures as long as there is no clip."""
    space = imgui.get_content_region_avail()
    imgui.dummy(ImVec2(0, max((space.y - em(18)) / 2.4, 0)))
    with imgui_ctx.push_font(None, 1.5 * theme.FONT_SIZE):
        centered("Make blood vessels visible", theme.now().text)
    centered("Open an endoscopic clip, or drop a folder, an image, a video or a splat file here.")
    imgui.spacing()
    choices: tuple[tuple[str, Act], ...] = (
        (f"{icons.ICON_FA_FOLDER_OPEN}   Open folder…", open_folder),
        (f"{icons.ICON_FA_FILM}   Open image or video…", open_file),
        (f"{icons.ICON_FA_MAGIC}   Open the built-in phantom###phantom", actions.open_phantom),
    )
    for label, choose in choices:
        imgui.set_cursor_pos_x((imgui.get_window_width() - em(WIDTH)) / 2)
        button(label, partial(choose, state), width=WIDTH)
    if state.source.opening is not None:
        centered(f"Opening {state.source.opening.path.name}…", theme.now().text)
    elif state.settings.recent:
        _draw_recent(state)


def _draw_recent(state: AppState) -> None:
    imgui.spacing()
    centered("Recent")
    for place, text in enumerate(state.settings.recent[:5]):
        name = legible(Path(text).name)
        imgui.set_cursor_pos_x((imgui.get_window_width() - imgui.calc_text_size(name).x) / 2)
        if imgui.text_link(f"{name}##{place}"):
            actions.open_path(state, Path(text))
        explain(text)
