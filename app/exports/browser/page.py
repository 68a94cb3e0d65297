"""The file: what it shows, as JSON; the numbers, compressed; and the viewer's own code."""

from __future__ import annotations

import base64
import gzip
import re
from collections.abc import Mapping
from html import escape
from importlib.resources import files
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from app.errors import UserError
from app.exports.browser.tracks import Tracks
from app.files.provenance import NOTICE, ascii_json
from renderer.camera import Camera
from renderer.json_files import parsed
from renderer.splats import RenderMode

LEVEL: Final = 9
"""Of the compression."""
_PART = r'<script type="{kind}" id="{name}">(.*?)</script>'


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
        "SCENE": _in_script(scene),
        "PROVENANCE": _in_script(facts),
        "CONTENT": content,
        "CODE": _own("viewer.js"),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda hit: parts[hit[1]], _own("viewer.html")).encode()


def read_page(text: str) -> tuple[dict[str, Any], dict[str, Any], NDArray[np.uint8]]:
    """Provenance, scene and content of a page. Raises UserError: it is none of ours, or damaged."""
    try:
        facts, scene = (_found(text, "application/json", name) for name in ("provenance", "scene"))
        packed = base64.b64decode(_found(text, "application/octet-stream", "content"), validate=True)
        return parsed(facts), parsed(scene), np.frombuffer(gzip.decompress(packed), np.uint8)
    except (ValueError, OSError, EOFError) as error:
        raise UserError(f"expected an HTML file written by VesselSplat ({error})") from error


def _found(text: str, kind: str, name: str) -> str:
    hit = re.search(_PART.format(kind=re.escape(kind), name=name), text, re.DOTALL)
    if hit is None:
        raise ValueError(f"no {name} in it")
    return hit[1]


def _own(name: str) -> str:
    return files("app.exports.browser").joinpath(name).read_text(encoding="utf-8")


def _in_script(value: object) -> str:
    """JSON that cannot end the element it stands in."""
    return ascii_json(value).replace("<", "\\u003c")
