"""The whole window as an image, as it was on the screen."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from app.exports.exporting import ExportRequest, Step, picture_record
from app.exports.records import PanesPicture
from app.files.provenance import write_png
from app.files.timestamp import stamp
from renderer.clip import ByteImage


@dataclass(frozen=True, eq=False)
class WindowRequest:
    """What was read from the screen, to be written into `folder`."""

    folder: Path
    image: ByteImage
    """(H, W, 3)."""
    shown: ExportRequest | None
    """What was in it of panes and 3D view."""

    @property
    def stem(self) -> str:
        return self.shown.stem if self.shown is not None else "vesselsplat"


def save_window(request: WindowRequest) -> Iterator[Step]:
    """Raises OSError or UserError."""
    path = request.folder / f"{request.stem}-window-{stamp()}.png"
    shown = picture_record(request.shown) if request.shown is not None else PanesPicture()
    write_png(path, request.image, replace(shown, kind="window").signed)
    yield Step(1, path)
