"""What is printed: tables, and progress of long work, a bar on a terminal, now and then a line elsewhere."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager

from rich.cells import cell_len
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Column, Table

WIDTH = 140
"""Characters, where the width is unknown."""
LABEL = 32
"""Characters of the first column of a table at most; longer ones go on below."""
BETWEEN = 3
"""Characters beside those of a cell."""
SECONDS_BETWEEN_LINES = 10.0
SECONDS_BETWEEN_STAGE_LINES = 2.0
"""Of what comes before the work that was asked for, which says nothing else."""

Report = Callable[[int, str], None]
"""Called with the number of units done so far and a short text, such as the loss."""


class Terminal(Console):
    """A console that prints names as they are, and leaves a closed pipe to `main`, like all other output."""

    def __init__(self, *, stderr: bool = False, width: int | None = None) -> None:
        super().__init__(stderr=stderr, width=width, markup=False, emoji=False, highlight=False)

    def on_broken_pipe(self) -> None:
        """Let the BrokenPipeError go on, which rich would end the program for."""
        raise


def wide_terminal() -> Terminal:
    """stdout, wide enough where the width is unknown."""
    known = Terminal()
    return known if known.is_terminal else Terminal(width=max(known.width, WIDTH))


def print_measures(head: Sequence[str], rows: Sequence[Sequence[str]], last: Sequence[str] = ()) -> None:
    """A table on stdout, with what its ratios are: as several below each other where it is too wide, each
    with the first column. `last`: a row apart from the others."""
    console = wide_terminal()
    for columns in fitting([head, *rows, *filter(None, [last])], console.width):
        table = Table(Column(head[0], max_width=LABEL, overflow="fold"), *(head[place] for place in columns))
        for row in rows:
            table.add_row(row[0], *(row[place] for place in columns))
        if last:
            table.add_section()
            table.add_row(last[0], *(last[place] for place in columns))
        console.print(table)
    console.print("dv, bv, dv_bv: inferred definition. Visibility only, neither detection nor diagnosis.")


def measured_text(value: float | None) -> str:
    """A cell of such a table; NaN and None are what could not be measured."""
    return "none" if value is None or math.isnan(value) else f"{value:.4g}"


def fitting(rows: Sequence[Sequence[str]], width: int, between: int = BETWEEN) -> Iterator[list[int]]:
    """The columns after the first, as many together as fit beside it."""
    widths = [
        max(cell_len(line) for row in rows for line in row[place].split("\n")) + between
        for place in range(len(rows[0]))
    ]
    start = min(widths[0], LABEL + between) + 1
    columns, taken = list[int](), start
    for place, wide in enumerate(widths[1:], start=1):
        if columns and taken + wide > width:
            yield columns
            columns, taken = [], start
        columns.append(place)
        taken += wide
    yield columns


@contextmanager
def progress(title: str, total: int, every: float = SECONDS_BETWEEN_LINES) -> Iterator[Report]:
    """Show `title` and how much of `total` units is done until the block ends.

    The first report says where the work begins: what was done before it does not count for the time left.
    Where there is no terminal, a line comes at most so often; without a `total` the note alone tells.
    """
    console = Terminal(stderr=True)
    if not console.is_terminal:
        yield _lines(console, title, total, every)
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


class Stages:
    """One progress after another, each until the next stage begins."""

    def __init__(self) -> None:
        self._open = ExitStack()
        self._stage: tuple[str, int] | None = None
        self._report: Report = lambda done, note: None

    def __enter__(self) -> Stages:
        return self

    def __exit__(self, *_: object) -> None:
        self._open.close()

    def of(self, title: str, total: int, every: float = SECONDS_BETWEEN_LINES) -> Report:
        """Where this stage is told; the one before it has ended."""
        if self._stage != (title, total):
            self._open.close()
            self._stage = title, total
            self._report = self._open.enter_context(progress(title, total, every))
        return self._report


def _bar(bar: Progress, title: str, total: int) -> Report:
    task = bar.add_task(title, total=total or None, note="", start=False)

    def report(done: int, note: str) -> None:
        if bar.tasks[0].started:
            bar.update(task, completed=done, note=note)
        else:
            bar.reset(task, completed=done, note=note)

    return report


def _lines(console: Terminal, title: str, total: int, every: float) -> Report:
    began: tuple[int, float] | None = None
    said = time.monotonic()

    def report(done: int, note: str) -> None:
        nonlocal began, said
        now = time.monotonic()
        began = began or (done, now)
        if now - said < every or (total and done <= began[0]):
            return
        said = now
        if total:
            left = (now - began[1]) / (done - began[0]) * (total - done)
            console.print(f"{title} {done}/{total}, {left:.0f} s left {note}".rstrip())
        else:
            console.print(f"{title}, {note}")

    return report
