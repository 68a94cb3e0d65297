"""What a shown model was made of, kept with it: what is opened beside it later does not matter."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.errors import UserError
from app.run_folder import RunFolder
from app.scene import run_facts


@dataclass(frozen=True, eq=False)
class Origin:
    """The run or the file of a model."""

    facts: dict[str, Any]
    """What an export says of it, as `vesselsplat render` does."""
    path: Path
    """The run folder or the file."""


def origin_of(folder: RunFolder) -> Origin | None:
    """What the run folder says; None when it cannot be read."""
    try:
        return Origin(run_facts(folder, folder.record(), folder.path.name), folder.path)
    except (OSError, UserError):
        return None
