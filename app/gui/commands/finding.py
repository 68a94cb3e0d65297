"""Commands found by words."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from app.files.legible import legible
from app.gui.commands.command import Command, Section
from app.gui.state.app_state import AppState


@dataclass(frozen=True)
class Found:
    """A command and the menu it stands in."""

    command: Command
    where: str
    applies: bool

    @property
    def name(self) -> str:
        """What is read: without the mark that tells equal names apart."""
        return self.command.label.split("##")[0]


def find(sections: Iterable[Section], words: str, state: AppState) -> list[Found]:
    """Commands in which every word occurs, those that apply first, then those that a word names.

    Without words: all commands.
    """
    wanted = words.casefold().split()
    found = [
        Found(command, " / ".join(filter(None, (section.menu, section.submenu))), command.applies(state))
        for section in sections
        for command in section.commands
    ]
    kept = [one for one in found if all(word in _text(one) for word in wanted)]
    return sorted(kept, key=lambda one: (not one.applies, -_named(one, wanted)))


def _text(found: Found) -> str:
    command = found.command
    return legible(" ".join((found.where, found.name, command.text, *command.keys))).casefold()


def _named(found: Found, wanted: list[str]) -> int:
    """How many of the words begin a word of the name."""
    begins = found.name.casefold().split()
    return sum(any(part.startswith(word) for part in begins) for word in wanted)
