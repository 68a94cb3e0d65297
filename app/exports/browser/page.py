"""The file: what it shows, as JSON; the numbers, compressed; and the viewer's own code."""

from __future__ import annotations

import base64
import gzip
from collections.abc import Mapping
from html import escape
from importlib.resources import files
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.errors import UserError
from app.exports.browser.tracks import Tracks
from app.exports.html_file import facts_in, filled_in, found, in_script
from app.files.provenance import NOTICE
from renderer.camera import Camera
from renderer.json_files import parsed
from renderer.splats import RenderMode

LEVEL: Final = 9
"""Of the compression."""


def browser_page(
    tracks: Tracks,
    camera: Camera,
    near: float,
    mode: RenderMode,
    *,
    title: str,
    about: str,
    frames: int,
    seconds: float,
    facts: Mapping[str, Any],
) -> bytes:
    """The HTML of a model as `camera` sees it first; the same bytes for the same model and facts.

    Args:
        near: distance in scene units before which nothing is drawn.
        title: of the clip.
        about: what the model is a reconstruction of.
        frames: of the clip, by which the page numbers its moments.
        seconds: that the clip takes.
        facts: provenance.
    """
    scene = {
        "tracks": tracks.told(),
        "degree": tracks.degree,
        "camera": camera.to_json(),
        "near": near,
        "antialiased": mode == "mip",
        "frames": frames,
        "seconds": seconds,
    }
    content = base64.b64encode(gzip.compress(tracks.content, LEVEL, mtime=0)).decode()
    parts = {
        "TITLE": escape(title),
        "ABOUT": escape(about),
        "NOTICE": escape(NOTICE),
        "STYLE": _own("viewer.css"),
        "SCENE": in_script(scene),
        "PROVENANCE": in_script(facts),
        "CONTENT": content,
        "CODE": _own("viewer.js"),
    }
    return filled_in(_own("viewer.html"), parts)


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
