"""The whole window as an image, as it was on the screen."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from app.exports.exporting import ExportRequest, Step, sourced
from app.exports.records import PanesPicture
from app.files.provenance import stamp, write_png
from renderer.clip import ByteImage


@dataclass(frozen=True, eq=False)
class WindowRequest:
    """What was read from the screen, to be written into `folder`."""

    folder: Path
    image: ByteImage
    """(H, W, 3)."""
    shown: ExportRequest | None
    """What was in it of panes and 3D view."""


def save_window(request: WindowRequest) -> Iterator[Step]:
    """Raises OSError or UserError."""
    shown, record, stem = request.shown, PanesPicture(), "vesselsplat"
    if shown is not None and isinstance(shown.record, PanesPicture):
        record, stem = sourced(shown.record, shown.sources), shown.stem
    path = request.folder / f"{stem}-window-{stamp()}.png"
    write_png(path, request.image, replace(record, kind="window").signed)
    yield Step(1, path)
