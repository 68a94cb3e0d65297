"""What tables and bars are printed on."""

from __future__ import annotations

from rich.console import Console


class Terminal(Console):
    """A console that prints names as they are, and leaves a closed pipe to `main`, like all other output."""

    def __init__(self, *, stderr: bool = False, width: int | None = None) -> None:
        super().__init__(stderr=stderr, width=width, markup=False, emoji=False, highlight=False)

    def on_broken_pipe(self) -> None:
        """Called while the BrokenPipeError is handled."""
        raise


def table_terminal() -> Terminal:
    """On stdout, wide enough for a table of measures also where the width is unknown."""
    return Terminal(width=max(Terminal().width, 140))
