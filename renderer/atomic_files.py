"""Files that appear whole or not at all, and stay so when the power goes."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from renderer.leftovers import clear, sync_folder, temporary_name


@contextmanager
def written_atomically(path: Path) -> Iterator[Path]:
    """An empty file beside `path`; once it is written, `path` holds all of it, and its old content till then.

    It is of this process: another that writes the same file has its own. What killed processes have left
    beside `path` goes.

    Raises:
        OSError: it cannot be written; `path` is named, not the file beside it.
    """
    clear(path.parent)
    partial = path.with_name(temporary_name(path.name))
    try:
        # A link that somebody has laid under this name is not followed.
        partial.unlink(missing_ok=True)
        partial.open("xb").close()
        yield partial
        # Windows syncs no file that is open for reading alone.
        with partial.open("rb+") as file:
            os.fsync(file.fileno())
        rename(partial, path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        if error.filename in (None, str(partial)):
            error.filename = str(path)
        raise
    except BaseException:
        partial.unlink(missing_ok=True)
        raise


def rename(partial: Path, path: Path) -> None:
    """Put a synced file into its place, for good."""
    partial.replace(path)
    sync_folder(path.parent)
