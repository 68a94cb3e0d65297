"""Names older results in a folder of new ones: a program that reads the folder would mix them."""

from __future__ import annotations

import sys
from collections.abc import Collection
from pathlib import Path

from renderer.listing import count


def say_older(folder: Path, written: Collection[str]) -> None:
    """A line on stderr where files of the same endings lie beside those that are written now, by name."""
    endings = {Path(name).suffix for name in written}
    beside = [entry.name for entry in folder.iterdir() if entry.suffix in endings and entry.is_file()]
    older = len(set(beside) - set(written))
    if older:
        said = f"{count(older, 'file')} of {'these kinds' if len(endings) > 1 else 'this kind'}"
        sys.stderr.write(f"{folder} also holds {said} from before\n")
