"""Commands found by words."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from app.files.legible import legible
from app.gui.commands.command import Command, Section
from app.gui.state.app_state import AppState
from app.gui.views.key_words import with_keys

HELP = "help"
WHOLE_NAME = 100
"""More than any number of words that a person types."""


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
    """Commands in which every word occurs, those that apply first, then those that the words name best.

    Without words: all commands.
    """
    wanted = words.casefold().split()
    found = [
        Found(command, " / ".join(filter(None, (section.menu, section.submenu))), command.applies(state))
        for section in sections
        for command in section.commands
    ]
    kept = [one for one in found if all(word in _text(one) for word in wanted)]
    return sorted(kept, key=lambda one: (not one.applies, -_fit(one, wanted)))


def find_help(sections: Iterable[Section], state: AppState) -> list[Found]:
    """What helps on where no command has the words."""
    return [one for one in find(sections, HELP, state) if HELP in one.command.synonyms]


def _text(found: Found) -> str:
    command = found.command
    said = (found.where, found.name, command.text, *command.synonyms, *map(with_keys, command.keys))
    return legible(" ".join(said)).casefold()


def _fit(found: Found, wanted: list[str]) -> int:
    """How well the words name it: all of its name counts most, then a word of it, then a synonym, then what
    begins a word of it, then what begins a synonym; its first word a little more."""
    names, synonyms = found.name.casefold().rstrip("….").split(), found.command.synonyms
    return (
        (WHOLE_NAME if names == wanted else 0)
        + (names[:1] == wanted[:1])
        + sum(
            max(
                (
                    4 * (word in names),
                    3 * (word in synonyms),
                    2 * _begins(word, names),
                    _begins(word, synonyms),
                )
            )
            for word in wanted
        )
    )


def _begins(word: str, others: Iterable[str]) -> bool:
    return any(other.startswith(word) for other in others)
