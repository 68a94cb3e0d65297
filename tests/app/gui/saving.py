"""A picture of photo, enhanced photo and 3D view, as the window asks for it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from app.enhancement.frame_enhancer import PictureRequest
from app.exports.exporting import ExportRequest, export
from app.exports.shots import Panes, Shot
from app.scenes.view_request import ViewRequest


def asked(folder: Path, wanted: PictureRequest | None, view: ViewRequest | None = None) -> ExportRequest:
    shots: tuple[Shot, ...] = ()
    if wanted is not None:
        photo = replace(wanted, params=None)
        shots = (Shot("Original", photo),)
        if wanted.params is not None:
            shots += (Shot("Enhanced", photo, wanted.params),)
    stem = wanted.clip.path.stem if wanted is not None else "view"
    return ExportRequest(folder, stem, "picture", Panes(shots), moments=() if view is None else ((view,),))


def saved(folder: Path, wanted: PictureRequest | None, view: ViewRequest | None = None) -> Path:
    *_, last = export(asked(folder, wanted, view))
    assert last.path is not None
    return last.path
