"""The command palette as the state keeps it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Palette:
    """Whether it is shown, the words typed, and which found command is marked."""

    shown: bool = False
    words: str = ""
    marked: int = 0

    def open(self) -> None:
        self.shown, self.words, self.marked = True, "", 0

    def stay(self, shown: bool) -> None:
        """Open, or closed from now on."""
        self.shown = shown

    def type(self, words: str) -> None:
        """Other words find other commands: the first of them is marked."""
        if words != self.words:
            self.words, self.marked = words, 0

    def move(self, by: int, count: int) -> None:
        """Up or down in a list of `count`, from its end to its start and back."""
        self.marked = (self.marked + by) % max(count, 1)
