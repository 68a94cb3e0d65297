"""Opens whatever a person points at as a Clip."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from renderer.budget import OverBudget
from renderer.camera import CameraError
from renderer.clip import Clip, ClipError
from renderer.depth.clip_depth import with_depth
from renderer.depth.maps_beside import with_maps
from renderer.depth.stereo_pairs import eye_folders, is_stereo_folder, open_stereo_folder
from renderer.readers import endonerf, frames, scared
from renderer.readers.clip_options import DEFAULTS, ClipOptions
from renderer.readers.converted_stereomis import is_converted_stereomis, open_converted_stereomis
from renderer.readers.hamlyn import is_hamlyn, open_hamlyn
from renderer.readers.picture_kinds import photo_folder
from renderer.readers.pictures import is_picture
from renderer.readers.stereomis import is_stereomis, open_stereomis
from renderer.readers.structure_from_motion import is_structure_from_motion, open_structure_from_motion
from renderer.readers.video import open_video
from renderer.readers.video_header import read_video_header
from renderer.regular_files import require_regular


def open_clip(path: Path, options: ClipOptions = DEFAULTS) -> Clip:
    """A folder of any layout that has a reader, a folder of pictures, one picture or a video file.

    Which frames are kept and which of them are held out is the same for every layout: the step and
    the split of `options`.

    Raises:
        ClipError: nothing there, or nothing that can be read; one line that names the path.

    Example:
        >>> from pathlib import Path
        >>> from tempfile import TemporaryDirectory
        >>> import numpy as np
        >>> from PIL import Image
        >>> from renderer import open_clip
        >>> with TemporaryDirectory() as folder:
        ...     for index in range(3):
        ...         Image.fromarray(np.zeros((24, 32, 3), np.uint8)).save(Path(folder, f"{index}.png"))
        ...     clip = open_clip(Path(folder))
        >>> clip.format, len(clip), clip.size, clip.has_depth
        ('images', 3, (32, 24), False)
    """
    if not path.exists():
        raise ClipError(f"expected a clip, got no such file or folder: {path}")
    try:
        clip = (_open_folder if path.is_dir() else _open_file)(path, options)
        return with_depth(replace(_thinned(clip, options.frame_step), split=options.split), options)
    except OSError as error:
        raise ClipError(f"cannot read the clip, {error.strerror or error}: {path}") from error
    except (CameraError, OverBudget) as error:
        raise ClipError(f"{error}: {path}") from error


def require_depth_source(path: Path, options: ClipOptions = DEFAULTS) -> None:
    """Refuses at once, by its header, a video of which no depth comes: opening a long one takes a while.

    Raises:
        ClipError: a file of that kind, or one that is no video.
    """
    if path.is_file() and not is_picture(path) and options.depth in ("auto", "measured", "stereo"):
        read_video_header(path)
        way = "--depth brightness guesses it, without a scale"
        raise ClipError(f"reconstruction expects depth, and a video has none ({way}): {path}")


def _open_file(path: Path, options: ClipOptions) -> Clip:
    require_regular(path)
    if is_picture(path):
        return frames.open_image(path, options.field_of_view)
    return open_video(path, options)


def _open_folder(path: Path, options: ClipOptions) -> Clip:
    if scared.is_scared(path):
        return scared.open_scared(path)
    if is_structure_from_motion(path):
        return open_structure_from_motion(path)
    if is_stereomis(path):
        return open_stereomis(path, options)
    if is_hamlyn(path):
        return open_hamlyn(path, options)
    if endonerf.is_endonerf(path):
        converted = is_converted_stereomis(path)
        return (open_converted_stereomis if converted else endonerf.open_endonerf)(path, options)
    if is_stereo_folder(path):
        left = next(iter(eye_folders(path)), path)
        return with_maps(open_stereo_folder(path, options.field_of_view), left, options)
    pictures = photo_folder(path)
    clip = frames.open_images(pictures, options.field_of_view)
    return with_maps(replace(clip, path=path, name=path.resolve().name), pictures, options)


def _thinned(clip: Clip, step: int | None) -> Clip:
    """One frame in `step`; None takes what is usual for the clip."""
    usual = scared.usual_step(clip.path) if clip.format == "scared" else 1
    taken = usual if step is None else step
    if taken == 1:
        return clip
    kept = clip.every(taken)
    whose = ", as the field does here (--frame-step 1 keeps all)" if step is None else ""
    said = f"one frame in {taken} is kept, {len(kept)} of {len(clip)}{whose}"
    return replace(kept, notices=(*clip.notices, said))
