"""Progress of long work on stderr: a bar with time left on a terminal, now and then a line elsewhere."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

SECONDS_BETWEEN_LINES = 10.0

Report = Callable[[int, str], None]
"""Called with the number of units done so far and a short text, such as the loss."""


@contextmanager
def progress(title: str, total: int) -> Iterator[Report]:
    """Show `title` and how much of `total` units is done until the block ends."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield _lines(console, title, total)
        return
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[note]}"),
    )
    with Progress(*columns, console=console) as bar:
        task = bar.add_task(title, total=total, note="")
        yield lambda done, note: bar.update(task, completed=done, note=note)


def _lines(console: Console, title: str, total: int) -> Report:
    started = said = time.monotonic()

    def report(done: int, note: str) -> None:
        nonlocal said
        now = time.monotonic()
        if now - said >= SECONDS_BETWEEN_LINES and done > 0:
            left = (now - started) / done * (total - done)
            console.print(f"{title} {done}/{total}, {left:.0f} s left {note}".rstrip(), highlight=False)
            said = now

    return report
