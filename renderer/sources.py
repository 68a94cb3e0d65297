"""Opens whatever a person points at as a Clip."""

from __future__ import annotations

from pathlib import Path

from renderer import endonerf, frames
from renderer.clip import Clip, ClipError
from renderer.clip_options import DEFAULTS, ClipOptions
from renderer.pictures import is_picture


def open_clip(path: Path, options: ClipOptions = DEFAULTS) -> Clip:
    """An EndoNeRF folder, a folder of pictures, one picture or a video file.

    Raises:
        ClipError: nothing there, or nothing that can be read; one line that names the path.
    """
    if not path.exists():
        raise ClipError(f"expected a clip, got no such file or folder: {path}")
    try:
        if path.is_dir():
            return _open_folder(path, options)
        return _open_file(path, options.field_of_view)
    except OSError as error:
        raise ClipError(f"cannot read the clip, {error.strerror or error}: {path}") from error


def _open_file(path: Path, field_of_view: float) -> Clip:
    opens = frames.open_image if is_picture(path) else frames.open_video
    return opens(path, field_of_view)


def _open_folder(path: Path, options: ClipOptions) -> Clip:
    if endonerf.is_endonerf(path):
        return endonerf.open_endonerf(path, options)
    pictures = path / "images"
    return frames.open_images(pictures if pictures.is_dir() else path, options.field_of_view)
