"""The file: what it shows, as JSON; the numbers, compressed; and the viewer's own code."""

from __future__ import annotations

import base64
import gzip
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.errors import UserError
from app.exports.browser.tracks import Tracks
from app.exports.html_file import facts_in, filled_in, found, in_script
from app.exports.records import BrowserModel
from app.files.provenance import NOTICE
from renderer.camera import BoolArray, Camera
from renderer.in_view import IMAGE_SIDES, InView
from renderer.json_files import parsed
from renderer.splats import RenderMode

LEVEL: Final = 9
"""Of the compression."""
CODE: Final = ("shaders.js", "controls.js", "viewer.js")
"""One after another a single script."""
LONGEST: Final = 500_000_000
"""Characters of its numbers; browsers hold texts of some 512 million."""


@dataclass(frozen=True, eq=False)
class PageWindow:
    """A model, or the part of one that is there at some of the clip's frames."""

    tracks: Tracks
    first: int
    last: int
    """Its frames. Where two windows overlap, one fades into the next."""
    shown: tuple[float, float] | None = None
    """Between which frames any of it is seen; None: at all of its own, as in models of before 0.14.0."""


def browser_page(
    windows: Sequence[PageWindow],
    record: BrowserModel,
    mode: RenderMode,
    *,
    about: str,
    cameras: Sequence[Camera] = (),
    within: InView | None = None,
    shown: BoolArray | None = None,
    closing: float | None = None,
) -> bytes:
    """The HTML of a record; the same bytes for the same model and record.

    Args:
        windows: in the order of time.
        about: what the model is a reconstruction of.
        cameras: of each frame; with them the page's camera goes, and zooms, where the record says so.
        within: beyond the sides of which nothing is drawn.
        shown: (N,) Gaussians of the one window that are drawn from elsewhere, too; None: all.
        closing: pixels of the record's camera over which gaps are closed in views from elsewhere; None: not.

    Raises:
        UserError: more than a browser can open.
    """
    parts_of_content = [one.tracks.content for one in windows]
    scene = {
        "windows": list(_told(windows, parts_of_content)),
        "camera": record.camera.to_json(),
        "near": record.near,
        "antialiased": mode == "mip",
        "frames": record.clip_frames,
        "seconds": record.seconds,
        **_optional(record, cameras, within, shown, closing),
    }
    content = base64.b64encode(gzip.compress(b"".join(parts_of_content), LEVEL, mtime=0)).decode()
    if len(content) > LONGEST:
        raise UserError(
            f"a page of {len(content) / 1e6:.0f} MB is more than browsers open ({LONGEST / 1e6:.0f} MB): "
            "export one window of the model after the other (--window)"
        )
    parts = {
        "TITLE": escape(record.title),
        "ABOUT": escape(about),
        "NOTICE": escape(NOTICE),
        "STYLE": _own("viewer.css"),
        "SCENE": in_script(scene),
        "PROVENANCE": in_script(record.signed),
        "CONTENT": content,
        "CODE": "\n".join(_own(name) for name in CODE),
    }
    return filled_in(_own("viewer.html"), parts)


def _optional(
    record: BrowserModel,
    cameras: Sequence[Camera],
    within: InView | None,
    shown: BoolArray | None,
    closing: float | None,
) -> dict[str, Any]:
    """What the page is told of some models and not of others; arguments as of `browser_page`."""
    told: dict[str, Any] = {}
    sides = [] if within is None else within.sides.tolist()
    field = sides[IMAGE_SIDES:]
    if record.start:
        told["start"] = record.start
    if shown is not None:
        told["hidden"] = np.flatnonzero(~shown).tolist()
    if closing is not None:
        told["closing"] = closing
    if shown is not None or field or closing is not None:
        told["free"] = not (record.moves or all(map(record.camera.has_pose_of, cameras)))
    if sides:
        told["sides"] = sides[:IMAGE_SIDES]
    if field:
        told["field"] = field
    if record.moves:
        told["poses"] = [np.asarray(one.camera_from_world)[:3].tolist() for one in cameras]
    if record.zooms:
        told["lenses"] = [one.lens for one in cameras]
    return told


def _told(windows: Sequence[PageWindow], contents: Sequence[bytes]) -> Iterator[dict[str, Any]]:
    start = 0
    for one, content in zip(windows, contents, strict=True):
        tracks = one.tracks.told(start)
        told = {"first": one.first, "last": one.last, "degree": one.tracks.degree, "tracks": tracks}
        yield told | ({} if one.shown is None else {"shown": one.shown})
        start += len(content)


def read_page(text: str) -> tuple[dict[str, Any], dict[str, Any], NDArray[np.uint8]]:
    """Provenance, scene and content of a page. Raises UserError: it is none of ours, or damaged."""
    try:
        scene = found(text, "application/json", "scene")
        packed = base64.b64decode(found(text, "application/octet-stream", "content"), validate=True)
        return facts_in(text), parsed(scene), np.frombuffer(gzip.decompress(packed), np.uint8)
    except (ValueError, OSError, EOFError) as error:
        raise UserError(f"expected an HTML file written by VesselSplat ({error})") from error


def _own(name: str) -> str:
    return files("app.exports.browser").joinpath(name).read_text(encoding="utf-8")
