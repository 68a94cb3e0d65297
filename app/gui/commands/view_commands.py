"""The commands of the View menu: panels and how the window looks."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Final

from app.gui.actions import actions, notes_actions, path_actions, window_actions
from app.gui.commands.command import Asks, Command, Section, WindowServices, has_model, menu
from app.gui.commands.presenting_commands import presenting_commands, second_section
from app.gui.state.app_state import AppState
from app.gui.work.settings import TEXT_PERCENTS, Theme
from app.scenes.backgrounds import BACKGROUNDS, EXPLAINED, BackgroundName

PREFERENCES: Final = ("preferences", "options", "settings")
THEME_WORDS: Final[Mapping[Theme, tuple[str, ...]]] = {"dark": ("night", "black"), "light": ("day", "white")}


def view_sections(outside: WindowServices) -> tuple[Section, ...]:
    panels = (
        _panel("Log", "panel: messages of this session", outside),
        _panel("Notes", "panel: notes saved with the session", outside, ("comment", "annotation", "write")),
        _panel("Report", "panel: an opened report of measurements", outside),
    )
    whole = (
        Command("Images alone", window_actions.toggle_panels, ("Tab",),
                text="hide all panels but the images, or show them again",
                ticked=lambda s: s.window.bare, synonyms=("hide", "panels", "focus")),
        Command("Full screen", window_actions.toggle_full_screen, ("F11",),
                ticked=lambda s: s.window.full_screen, synonyms=("fullscreen", "maximise", "maximize")),
        *presenting_commands(),
    )  # fmt: skip
    path = (
        Command("Camera path", path_actions.toggle_path_shown, text="show the camera path in the 3D view",
                applies=lambda s: bool(s.scene.cameras.views.path.keyframes),
                ticked=lambda s: s.scene.cameras.path_shown),
    )  # fmt: skip
    backgrounds = tuple(_background(name) for name in BACKGROUNDS)
    layout = (
        Command("Standard layout", lambda s: outside.layout(),
                text="all panels back to their standard places",
                synonyms=("reset", "panels", "windows", "arrange", "dock")),
    )  # fmt: skip
    unseen = Command("Unobserved parts", actions.toggle_unobserved,
                     text="also draw what no frame shows, behind tissue or beyond the frames",
                     applies=has_model, ticked=lambda s: s.settings.unobserved,
                     synonyms=("edge", "border", "outside", "beyond", "hidden", "behind"))  # fmt: skip
    others = menu("View", panels, path, (_theme("dark"), _theme("light")), layout)
    unobserved = Section("View", (*backgrounds, unseen), "Where nothing was observed")
    text_size = Section("View", _text_size(), "Text size")
    return (
        Section("View", whole),
        second_section(),
        others[0],
        unobserved,
        *others[1:-1],
        text_size,
        others[-1],
    )


def _panel(name: str, text: str, outside: WindowServices, synonyms: tuple[str, ...] = ()) -> Command:
    toggle = partial(_toggle, outside=outside, name=name)
    return Command(name, toggle, text=text, ticked=lambda s: outside.panel_shown(name), synonyms=synonyms)


def _toggle(state: AppState, outside: WindowServices, name: str) -> None:
    outside.toggle_panel(name)
    if name == "Notes":
        notes_actions.begin_writing(state, outside.panel_shown(name))


def _background(name: BackgroundName) -> Command:
    choose = partial(actions.choose_background, name=name)
    words = ("background", "unseen", "fill", "empty", "observed")
    return Command(f"{name.capitalize()} background", choose, text=EXPLAINED[name], applies=has_model,
                   ticked=lambda s: s.settings.background == name, synonyms=words)  # fmt: skip


def _theme(theme: Theme) -> Command:
    choose = partial(actions.choose_theme, theme=theme)
    words = ("appearance", "colours", "colors", "mode", *PREFERENCES, *THEME_WORDS[theme])
    return Command(f"{theme.capitalize()} theme", choose, ticked=lambda s: s.settings.theme == theme,
                   synonyms=words)  # fmt: skip


def _text_size() -> tuple[Command, ...]:
    words = ("font", "size", "scale", "letters", "interface", *PREFERENCES)
    steps = (
        Command("Larger text", partial(actions.resize_text, steps=1), ("Ctrl+plus", "Ctrl+keypad plus"),
                applies=lambda s: s.settings.text_percent < TEXT_PERCENTS[-1],
                synonyms=(*words, "bigger", "zoom", "in")),
        Command("Smaller text", partial(actions.resize_text, steps=-1), ("Ctrl+minus", "Ctrl+keypad minus"),
                applies=lambda s: s.settings.text_percent > TEXT_PERCENTS[0], synonyms=words),
    )  # fmt: skip
    sizes = (
        Command(f"Text at {percent} %", partial(actions.choose_text_size, percent=percent),
                ("Ctrl+0",) if percent == 100 else (), ticked=_has_text_size(percent),
                synonyms=(*words, f"{percent}%"))
        for percent in TEXT_PERCENTS
    )  # fmt: skip
    return *steps, *sizes


def _has_text_size(percent: int) -> Asks:
    return lambda state: state.settings.text_percent == percent
