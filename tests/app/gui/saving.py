"""A picture of frame, enhanced frame and 3D view, as the window asks for it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from app.enhancement.frame_enhancer import PictureRequest
from app.exports.exporting import ExportRequest, export
from app.exports.panes import pane_record
from app.exports.records import FrameRecord, PanesPicture
from app.exports.sources import Opened
from app.scenes.cpu_rendering import ON_CPU
from app.scenes.view_request import ViewRequest, view_record


def asked(folder: Path, wanted: PictureRequest | None, view: ViewRequest | None = None) -> ExportRequest:
    record = PanesPicture(views=() if view is None else (view_record(view, ON_CPU),))
    if wanted is not None:
        original = replace(wanted, params=None)
        panes = (pane_record("Original", original),)
        if wanted.params is not None:
            panes += (pane_record("Enhanced", original, wanted.params),)
        frame = FrameRecord(index=wanted.frame_index, label=wanted.clip.labels[wanted.frame_index])
        record = replace(record, frame=frame, panes=panes)
    stem = wanted.clip.path.stem if wanted is not None else "view"
    opened = Opened(() if view is None else (view,), wanted.clip if wanted is not None else None)
    return ExportRequest(folder, stem, ".png", record, opened)


def saved(folder: Path, wanted: PictureRequest | None, view: ViewRequest | None = None) -> Path:
    *_, last = export(asked(folder, wanted, view))
    assert last.path is not None
    return last.path
