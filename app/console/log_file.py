"""A small log of errors in the user's own folder, for bug reports."""

from __future__ import annotations

import logging
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from logging.handlers import QueueHandler, QueueListener, RotatingFileHandler
from pathlib import Path
from queue import SimpleQueue
from typing import Final

NAME: Final = "vesselsplat.log"
SIZE: Final = 512 << 10
"""Bytes after which the file gives way to a new one."""
KEPT: Final = 3
"""Earlier files."""
FORM: Final = "%(asctime)s %(levelname)s %(threadName)s %(name)s: %(message)s"
LOG: Final = logging.getLogger("app")


@contextmanager
def logged(folder: Path, first: str) -> Iterator[None]:
    """Until the block ends, what the program logs goes there, after `first`; so do uncaught errors of threads
    and one that ends the block. Nobody waits for the disk; where it takes no file, there is no log."""
    handler = _handler(folder)
    if handler is None:
        yield
        return
    queue: SimpleQueue[logging.LogRecord] = SimpleQueue()
    queued, listener = QueueHandler(queue), QueueListener(queue, handler)
    level, hook = LOG.level, threading.excepthook
    LOG.addHandler(queued)
    LOG.setLevel(logging.INFO)
    threading.excepthook = lambda trouble: _note(trouble, hook)
    listener.start()
    try:
        LOG.info(first)
        yield
    except Exception:
        LOG.exception("ended by an error")
        raise
    finally:
        threading.excepthook = hook
        LOG.removeHandler(queued)
        LOG.setLevel(level)
        listener.stop()
        handler.close()


class _Log(RotatingFileHandler):
    """Goes on in one file where that cannot be renamed, as on Windows while another window has it open."""

    def doRollover(self) -> None:
        try:
            super().doRollover()
        except OSError:
            self.maxBytes = 0

    def handleError(self, record: logging.LogRecord) -> None:
        """A disk that takes no more lines, as a full one, is no news for the terminal: the window says so."""
        if not isinstance(sys.exception(), OSError):
            super().handleError(record)

    def close(self) -> None:
        with suppress(OSError):
            super().close()


def _handler(folder: Path) -> logging.Handler | None:
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        made = _Log(folder / NAME, maxBytes=SIZE, backupCount=KEPT, encoding="utf-8")
        made.setFormatter(logging.Formatter(FORM))
        return made
    return None


def _note(trouble: threading.ExceptHookArgs, then: Callable[[threading.ExceptHookArgs], object]) -> None:
    """Log an error that ended a thread, then do with it what was done before."""
    if trouble.exc_value is not None:
        told = (trouble.exc_type, trouble.exc_value, trouble.exc_traceback)
        LOG.error("uncaught in a thread", exc_info=told)
    then(trouble)
