"""Opens whatever a person points at as a Clip."""

from __future__ import annotations

from pathlib import Path

from renderer import endonerf, frames
from renderer.clip import Clip, ClipError
from renderer.pictures import is_picture


def open_clip(path: Path, endonerf_options: endonerf.EndoNerfOptions = endonerf.DEFAULTS) -> Clip:
    """An EndoNeRF folder, a folder of pictures, one picture or a video file.

    Raises:
        ClipError: nothing there, or nothing that can be read; one line that names the path.
    """
    if not path.exists():
        raise ClipError(f"expected a clip, got no such file or folder: {path}")
    try:
        if path.is_dir():
            return _open_folder(path, endonerf_options)
        return frames.open_image(path) if is_picture(path) else frames.open_video(path)
    except OSError as error:
        raise ClipError(f"cannot read the clip, {error.strerror or error}: {path}") from error


def _open_folder(path: Path, options: endonerf.EndoNerfOptions) -> Clip:
    if endonerf.is_endonerf(path):
        return endonerf.open_endonerf(path, options)
    pictures = path / "images"
    return frames.open_images(pictures if pictures.is_dir() else path)
