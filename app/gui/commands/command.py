"""What a command is: one thing to do, with its name, its keys, and when it applies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from app.files.legible import capital
from app.gui.state.app_state import AppState

Act = Callable[[AppState], object]
Asks = Callable[[AppState], bool]


NO_MODEL = "Reconstruct a clip first, or open a run or a splat file."


def always(state: AppState) -> bool:
    return True


def never(state: AppState) -> bool:
    return False


@dataclass(frozen=True)
class Needs:
    """When a command applies, as a question that can also say what is missing."""

    why_not: Callable[[AppState], str]
    """In a sentence; empty where nothing is missing."""

    def __call__(self, state: AppState) -> bool:
        return not self.why_not(state)


has_clip = Needs(lambda state: "" if state.source.clip is not None else "Open a clip first.")
has_model = Needs(lambda state: "" if state.scene.model is not None else NO_MODEL)
is_live = Needs(lambda state: "" if state.live.session is not None else "Open a live source first.")


@dataclass(frozen=True)
class Command:
    """Menus, keyboard, help and palette are all made from these."""

    label: str
    act: Act
    keys: tuple[str, ...] = ()
    """As a person reads them, "Ctrl+Shift+E"; menus and palette show the first."""
    text: str = ""
    """More than the label says: the tooltip, and the line in the help."""
    applies: Asks = always
    """Elsewhere its keys do nothing, and menus and palette show it greyed."""
    ticked: Asks = never
    while_typing: bool = False
    """Its keys count in a text field, too, where they mean nothing else."""
    repeats: bool = False
    """A held key counts again."""
    synonyms: tuple[str, ...] = ()
    """Other words that people look for it by, which the palette finds."""
    refuse: Act | None = None
    """What its keys do where it does not apply: they say what is missing."""

    @property
    def about(self) -> str:
        """What the help says."""
        return self.text or self.label

    def tooltip(self, state: AppState) -> str:
        """More than the label says, and where it does not apply what is missing; empty for nothing."""
        lack = self.applies.why_not(state) if isinstance(self.applies, Needs) else ""
        said = capital(self.text)
        return f"{said.rstrip('.')}. {lack}" if said and lack else said or lack


@dataclass(frozen=True)
class Section:
    """Commands that stand together, between two lines of a menu."""

    menu: str
    commands: tuple[Command, ...]
    submenu: str = ""


def menu(name: str, *groups: tuple[Command, ...]) -> tuple[Section, ...]:
    """The sections of a menu, or some of them."""
    return tuple(Section(name, commands) for commands in groups)


@dataclass(frozen=True)
class WindowServices:
    """What the runner alone can do."""

    layout: Callable[[], None]
    quit: Callable[[], None]
    toggle_panel: Callable[[str], None]
    panel_shown: Callable[[str], bool]
