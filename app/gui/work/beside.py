"""Which of what was opened lately can be seen in a second 3D view: off the window's thread."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from app.runs.run_folder import RunFolder
from renderer.splat_files import is_named_as_splats
from renderer.splat_series import series_files


@dataclass(frozen=True)
class BesideRequest:
    """These paths; asked again when the run that is made has come further."""

    paths: tuple[str, ...]
    status: str


def find_models(request: BesideRequest) -> Iterator[tuple[Path, ...]]:
    """Those of them that hold a model, in their order, with links followed."""
    yield tuple(Path(path).resolve() for path in request.paths if _holds_model(Path(path)))


def _holds_model(path: Path) -> bool:
    try:
        if is_named_as_splats(path):
            return path.exists()
        run = RunFolder(path)
        if not run.is_run:
            return bool(series_files(path))
        return run.is_finished or run.has_checkpoint
    except OSError:
        return False
