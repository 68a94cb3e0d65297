"""What files of cameras hold, those of other programs among them."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from app.commands.described.fact import Fact, next_steps
from app.errors import UserError
from renderer.camera_files import CameraFileError, NamedCamera, read_cameras
from renderer.json_files import read_json
from renderer.listing import count

COLMAP: Final = "images.txt"
"""In the folder of a text model."""


def of_cameras(path: Path) -> tuple[Fact, ...]:
    """Of JSON, or the folder of a text model of COLMAP.

    Raises:
        UserError: it holds none, or a folder that is damaged.
    """
    try:
        cameras = read_cameras(path)
    except CameraFileError as error:
        if path.is_dir():
            raise UserError(str(error)) from error
        raise UserError(
            f"expected a report, a provenance or cameras, got another JSON file: {path}"
        ) from error
    form = _form(path)
    sizes = sorted({(one.camera.width, one.camera.height) for one in cameras})
    focal = sorted({round(one.camera.fx, 1) for one in cameras})
    lens = " to ".join(dict.fromkeys(f"{one:g}" for one in (focal[0], focal[-1])))
    times = ("--time", "0") if len(cameras) > 1 else ()
    return (
        Fact("what", f"cameras: {form}", {"kind": "cameras", "format": form}),
        Fact("cameras", _names(cameras), {"count": len(cameras)}),
        Fact("size", ", ".join(f"{width}x{height}" for width, height in sizes), [list(one) for one in sizes]),
        Fact("focal length", f"{lens} px", [focal[0], focal[-1]]),
        next_steps(path, ("render", "RUN", "--camera", "PATH", *times, "--out", "OUT")),
    )


def _names(cameras: tuple[NamedCamera, ...]) -> str:
    ends = " to ".join(dict.fromkeys((cameras[0].name, cameras[-1].name)))
    return f"{count(len(cameras), 'camera')}, {ends}"


def _form(path: Path) -> str:
    if path.is_dir():
        return "text model of COLMAP"
    content = read_json(path)
    if isinstance(content, list):
        return "cameras.json of 3D Gaussian Splatting"
    return "transforms.json of NeRF" if "frames" in content else "one camera"
