"""Calls in processes of their own that need not start anew.

On Linux each is a copy of a process that has loaded the program and done nothing: `python -m app` takes a
second or two to come so far.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from app.__main__ import main

FORKS = sys.platform == "linux"
CONTEXT: Any = get_context("forkserver" if FORKS else "spawn")
if FORKS:
    CONTEXT.set_forkserver_preload(["tests.app.preloaded"])


@dataclass(frozen=True)
class Call:
    """What a command did."""

    code: int
    out: str
    error: str


def command(*arguments: object, folder: Path, seconds: float = 300.0) -> Call:
    """What `python -m app` does in `folder`. Raises TimeoutError: it takes longer."""
    return called(_command, [str(argument) for argument in arguments], folder=folder, seconds=seconds)


def called(call: Callable[..., int], *arguments: object, folder: Path, seconds: float = 300.0) -> Call:
    """`call` with the arguments in `folder`; its answer is the exit code. Raises TimeoutError."""
    with tempfile.TemporaryDirectory() as scratch:
        streams = Path(scratch) / "out", Path(scratch) / "error"
        process = CONTEXT.Process(target=_work, args=(call, arguments, folder, dict(os.environ), streams))
        process.start()
        process.join(seconds)
        if process.is_alive():
            process.kill()
            process.join()
            raise TimeoutError(f"{arguments} took more than {seconds:.0f} s")
        assert process.exitcode is not None
        return Call(process.exitcode, *(path.read_text() for path in streams))


def _command(arguments: list[str]) -> int:
    return main(arguments)


def _work(
    call: Callable[..., int],
    arguments: tuple[object, ...],
    folder: Path,
    environment: dict[str, str],
    streams: tuple[Path, Path],
) -> None:
    """Streams are taken below Python, where decoders write too."""
    for number, path in enumerate(streams, start=1):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND), number)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    sys.exit(call(*arguments))
