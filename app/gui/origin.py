"""What a shown model was made of, kept with it: what is opened beside it later does not matter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from app.errors import UserError
from app.provenance import digest
from app.run_folder import RunFolder, RunRecord


@dataclass(frozen=True)
class Origin:
    """The run of a model."""

    run: str
    """Name of its folder."""
    record: RunRecord
    model_sha256: str | None
    """Of the model's file; None while it is being trained."""

    @property
    def facts(self) -> dict[str, Any]:
        """What an export says of it, as `vesselsplat render` does."""
        return {
            "run": {"name": self.run, "model_sha256": self.model_sha256},
            "clip": {"name": self.record.clip.name, "sha256": self.record.clip.sha256},
            "input": self.record.input,
            "enhancement": self.record.enhancement,
            "config": self.record.config,
        }


def origin_of(folder: RunFolder) -> Origin | None:
    """What the run folder says; None when it cannot be read."""
    try:
        model_sha256 = digest(folder.model_path) if folder.is_finished else None
        return Origin(folder.path.name, folder.record(), model_sha256)
    except (OSError, UserError):
        return None
