"""The commands of the Help menu."""

from __future__ import annotations

from functools import partial

from imgui_bundle import imgui

from app.gui.actions import about_actions, actions, floating_windows, guide_actions
from app.gui.commands.command import Command, Section, menu
from app.gui.state.app_state import AppState


def help_sections() -> tuple[Section, ...]:
    guide = (
        Command("Guide", open_guide, ("F1",), synonyms=("help", "manual", "tutorial", "documentation", "how"),
                text="from the first image to an export; F1: the page of the panel under the pointer",
                ticked=lambda s: s.guide.shown),
        Command("Next page of the guide", partial(guide_actions.turn, pages=1), ("PageDown",),
                applies=lambda s: s.guide.shown and s.guide.page < guide_actions.COUNT - 1),
        Command("Previous page of the guide", partial(guide_actions.turn, pages=-1), ("PageUp",),
                applies=lambda s: s.guide.shown and s.guide.page > 0),
    )  # fmt: skip
    found = (
        Command("Find a command…", lambda s: s.window.palette.open(), ("Ctrl+Shift+P",), while_typing=True,
                text="find a command by its name", synonyms=("search", "palette")),
        Command("Keys and mouse", toggle_help, ("?",), text="every key and gesture",
                synonyms=("shortcuts", "hotkeys", "keyboard", "help", "bindings", "rotate", "pan",
                          "orbit", "zoom", "scroll")),
    )  # fmt: skip
    about = (
        Command("Open log folder", about_actions.open_log_folder, synonyms=("bug", "errors", "support"),
                text="errors of this and earlier sessions, for bug reports"),
        Command("About VesselSplat", lambda s: floating_windows.toggle(s.about),
                text="version, licences, and what to copy into a bug report",
                synonyms=("version", "licence", "license", "bug", "system", "credits", "update", "upgrade",
                          "gpu", "cite", "citation", "paper")),
    )  # fmt: skip
    return menu("Help", guide, found, about)


def open_guide(state: AppState) -> None:
    """By the mouse from the menu where it was left; by key at what is under the pointer."""
    guide_actions.open_about(state, panel_under_pointer())


def panel_under_pointer() -> str:
    """The title of the panel under the pointer; empty for none."""
    context = imgui.get_current_context()
    window: imgui.internal.Window | None = context.hovered_window
    return "" if window is None else str(window.root_window.name).split("###")[0]


def toggle_help(state: AppState) -> None:
    actions.show_help(state, not state.window.help_open)
