"""The only way an exported file comes about: of its record, and of what that is of."""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path

from app.enhancement.records import EnhancedPicture, EnhancedVideo, TuningSheet
from app.errors import UserError
from app.exports import make_drawn, make_enhanced, make_panes
from app.exports.records import (
    Depth,
    Export,
    MeasuresTable,
    PanesPicture,
    PanesVideo,
    Render,
    RenderVideo,
    Splats,
    ViewVideo,
    WindowPicture,
)
from app.exports.scene_splats import write_splats
from app.exports.sources import Sources


def make(record: Export, sources: Sources, target: Path) -> Generator[int, None, None]:
    """Write the file that `record` is of, with the record and what was found out while it was made.

    Yields how many of its pictures are made; closed before its end, it leaves nothing behind.

    Raises:
        OSError, UserError, ClipError, ImageError: what cannot be read, made or written.
    """
    match record:
        case EnhancedPicture():
            make_enhanced.make_picture(record, sources, target)
        case EnhancedVideo():
            yield from make_enhanced.make_video(record, sources, target)
        case TuningSheet():
            make_enhanced.make_sheet(record, sources, target)
        case Render():
            make_drawn.make_render(record, sources, target)
        case Depth():
            make_drawn.make_depth(record, sources, target)
        case RenderVideo():
            yield from make_drawn.make_video(record, sources, target)
        case Splats():
            write_splats(target, sources.scene(record), record)
        case PanesPicture():
            make_panes.make_picture(record, sources, target)
        case PanesVideo():
            yield from make_panes.make_video(record, sources, target)
        case MeasuresTable():
            yield from make_panes.make_measures(record, sources, target)
        case ViewVideo():
            yield from make_drawn.make_view_video(record, sources, target)
        case WindowPicture():
            raise UserError(
                "expected panes or a 3D view, which can be reproduced from their sources, got a capture of "
                "the whole window as on screen"
            )
