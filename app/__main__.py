"""`vesselsplat`: exit code 0 on success, 2 with one line on bad input; 130, 143 or 129 when interrupted."""

from __future__ import annotations

import errno
import io
import os
import stat
import sys
import warnings
from collections.abc import Sequence
from contextlib import suppress
from typing import TextIO

from app.cli import run
from app.console.ending import EndingSignals
from app.console.startup import require_one_place, require_threads, rest_while_waiting
from app.console.unread import unread
from app.errors import UserError

# A damaged file is one line of ours, none of the decoders'. OpenCV reads these once, when it loads.
QUIET_DECODERS = {"OPENCV_LOG_LEVEL": "SILENT", "OPENCV_FFMPEG_LOGLEVEL": "-8"}

NO_PLACE = "no locator available"
"""In numba's words, where neither the program's own folder nor the user's cache folder can be written."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command. A mistake of the user is one line on stderr; a bug keeps its traceback."""
    keep_quiet()
    rest_while_waiting()
    # A shell may have closed them (`>&-`), and a program without a console has none.
    sys.stdout = sys.stdout or _nowhere()
    sys.stderr = sys.stderr or _nowhere()
    unread()
    if isinstance(sys.stdout, io.TextIOWrapper):
        # As stderr does: a file may have any name. Programs read UTF-8, whatever a terminal has.
        encoding = None if sys.stdout.isatty() else "utf-8"
        sys.stdout.reconfigure(encoding=encoding, errors="backslashreplace")
    signals = EndingSignals()
    try:
        with signals:
            require_one_place()
            require_threads()
            run(sys.argv[1:] if arguments is None else arguments)
            sys.stdout.flush()
    except KeyboardInterrupt as interrupt:
        return _fail(str(interrupt) or "interrupted", signals.code)
    except UserError as error:
        return _fail(str(error), 2)
    except MemoryError:
        return _fail("out of memory: try a smaller image, clip or size", 2)
    except OSError as error:
        if _reader_left(error):
            # A second flush at exit must not complain.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 0
        return _fail(f"{error.strerror or error}: {error.filename or _unnamed(error)}", 2)
    except (ValueError, RuntimeError) as error:
        line = mistake(error)
        if line is None:
            raise
        return _fail(line, 2)
    return 0


def _reader_left(error: OSError) -> bool:
    """Of stdout (`| head`), for which Windows has no error of its own."""
    as_on_windows = sys.platform == "win32" and error.errno == errno.EINVAL and not error.filename
    if not as_on_windows:
        return isinstance(error, BrokenPipeError)
    with suppress(OSError, ValueError):
        return stat.S_ISFIFO(os.fstat(sys.stdout.fileno()).st_mode)
    return False


def _unnamed(error: OSError) -> str:
    """What an error is of that names no file: of a full disk what is printed, where that is a file, since
    our own files are named; of nothing there the current folder, where that is gone."""
    from app.files.atomic import NO_SPACE

    if error.errno == errno.ENOENT and not _has_current_folder():
        return "the current folder"
    try:
        kept = not (sys.stdout.isatty() or stat.S_ISFIFO(os.fstat(sys.stdout.fileno()).st_mode))
    except (OSError, ValueError):
        kept = False
    return "standard output" if kept and error.errno in NO_SPACE else "no file named"


def _has_current_folder() -> bool:
    try:
        return bool(os.getcwd())
    except OSError:
        return False


def keep_quiet() -> None:
    """Libraries do not speak past our own lines, unless Python is asked to (-W)."""
    os.environ.update(QUIET_DECODERS)
    if not sys.warnoptions:
        warnings.simplefilter("ignore")


def _nowhere() -> TextIO:
    return open(os.devnull, "w", encoding="utf-8")


def mistake(error: ValueError | RuntimeError) -> str | None:
    """The line for a mistake of the user, or None for a bug."""
    from pydantic import ValidationError

    from app.console.flags import problem
    from enhance import ImageError
    from renderer.budget import OverBudget
    from renderer.clip import ClipError

    if isinstance(error, ValidationError):
        return problem(error)
    if NO_PLACE in str(error):
        wanted = "expected a folder that can be written, for compiled kernels"
        return f"{wanted}, got none: name one by the environment variable NUMBA_CACHE_DIR"
    if isinstance(cause := error.__context__, OSError) and cause.errno == errno.ELOOP:
        return f"expected a file or folder, got links that lead to each other: {cause.filename}"
    return str(error) if isinstance(error, ClipError | ImageError | OverBudget) else None


def _fail(line: str, code: int) -> int:
    sys.stderr.write(f"vesselsplat: {' '.join(line.split())}\n")
    return code


if __name__ == "__main__":
    sys.exit(main())
