"""What the program is: version, purpose, notice, licences, and what a bug report needs."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final

from imgui_bundle import ImVec2, imgui, imgui_ctx
from imgui_bundle import icons_fontawesome_4 as icons

from app.gui.actions import about_actions
from app.gui.panels.overlays import LONG_NOTICE, floating_window
from app.gui.state.app_state import AppState
from app.gui.style import theme
from app.gui.style.widgets import beside, button, cell, em, in_table, muted, note
from app.gui.work.about import About

WIDTH: Final = 40.0
LIST: Final = 11.0
"""Text heights of the list of packages."""
TITLE: Final = "About VesselSplat"
COPY: Final = f"{icons.ICON_FA_COPY}  Copy for a bug report"
LOGS: Final = f"{icons.ICON_FA_FOLDER_OPEN}  Open log folder"
COPY_TEXT: Final = "Version, system and packages: no names of persons, files or this computer."
LOGS_TEXT: Final = (
    "Errors of this and earlier sessions. Lines may name your files: read them before you send them."
)


def draw_about(state: AppState, copy: Callable[[str], None]) -> None:
    """A window of its own."""
    about = state.about.facts
    if not state.about.shown or about is None:
        return
    with floating_window(state, state.about, TITLE, WIDTH, imgui.WindowFlags_.no_saved_settings) as drawn:
        if not drawn:
            return
        with imgui_ctx.push_font(None, 1.5 * theme.FONT_SIZE):
            imgui.text_unformatted(f"VesselSplat {about.version}")
        note(about.purpose, theme.now().text)
        note(LONG_NOTICE, theme.now().warning)
        imgui.spacing()
        _draw_facts(about)
        imgui.spacing()
        button(COPY, partial(copy, about.report), COPY_TEXT)
        beside(LOGS)
        button(LOGS, partial(about_actions.open_log_folder, state), LOGS_TEXT)
        imgui.separator_text("Licences")
        imgui.text_unformatted(f"VesselSplat: {about.licence}")
        muted("It uses these packages and fonts, each under a licence of its own:")
        _draw_packages(about)


def _draw_facts(about: About) -> None:
    for name, text in in_table("facts", (7.0, None), about.facts):
        cell(name)
        imgui.table_next_column()
        imgui.text_wrapped(text)


def _draw_packages(about: About) -> None:
    with imgui_ctx.begin_child("packages", ImVec2(0, em(LIST)), imgui.ChildFlags_.borders):
        for one in in_table("packages", (15.0, 6.0, None), about.packages, imgui.TableFlags_.row_bg):
            cell(one.name, theme.now().text)
            cell(one.version)
            imgui.table_next_column()
            imgui.text_wrapped(one.licence)
