"""Progress of long work on stderr: a bar with time left on a terminal, now and then a line elsewhere."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from app.terminal import Terminal

SECONDS_BETWEEN_LINES = 10.0

Report = Callable[[int, str], None]
"""Called with the number of units done so far and a short text, such as the loss."""


@contextmanager
def progress(title: str, total: int) -> Iterator[Report]:
    """Show `title` and how much of `total` units is done until the block ends.

    The first report says where the work begins: what was done before it does not count for the time left.
    """
    console = Terminal(stderr=True)
    if not console.is_terminal:
        yield _lines(console, title, total)
        return
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[note]}", markup=False),
    )
    with Progress(*columns, console=console) as bar:
        yield _bar(bar, title, total)


def _bar(bar: Progress, title: str, total: int) -> Report:
    task = bar.add_task(title, total=total, note="", start=False)

    def report(done: int, note: str) -> None:
        if bar.tasks[0].started:
            bar.update(task, completed=done, note=note)
        else:
            bar.reset(task, completed=done, note=note)

    return report


def _lines(console: Terminal, title: str, total: int) -> Report:
    began: tuple[int, float] | None = None
    said = time.monotonic()

    def report(done: int, note: str) -> None:
        nonlocal began, said
        now = time.monotonic()
        began = began or (done, now)
        if now - said >= SECONDS_BETWEEN_LINES and done > began[0]:
            left = (now - began[1]) / (done - began[0]) * (total - done)
            console.print(f"{title} {done}/{total}, {left:.0f} s left {note}".rstrip())
            said = now

    return report
