"""Opens whatever a person points at as a Clip."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from renderer.budget import OverBudget
from renderer.camera import CameraError
from renderer.clip import Clip, ClipError
from renderer.depth.calibrated import with_calibration
from renderer.depth.clip_depth import with_depth
from renderer.layouts import layout_of
from renderer.readers.clip_options import DEFAULTS, ClipOptions
from renderer.readers.image_files.transparency import where_visible
from renderer.readers.image_folders.picture_kinds import frame_folder
from renderer.readers.image_folders.stills import images_in, open_stills
from renderer.readers.video import eyes_hint
from renderer.readers.video_decoding.stereo_layout import chosen_layout
from renderer.readers.video_header import first_frame, read_video_header


def open_clip(path: str | Path, options: ClipOptions = DEFAULTS) -> Clip:
    """A folder of any layout that has a reader, a folder of images, one image or a video file.

    Which frames are kept and which of them are held out is the same for every layout: the step and
    the split of `options`.

    Raises:
        ClipError: nothing there, or nothing that can be read; one line that names the path.
        TypeError: `options` of another class.

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
    if not isinstance(options, ClipOptions):
        raise TypeError(f"expected options to be ClipOptions, got {type(options).__name__}")
    return with_chosen_depth(open_bare(Path(path), options), options)


def open_bare(path: Path, options: ClipOptions = DEFAULTS) -> Clip:
    """The same with no depth but that of its own files. Raises ClipError."""
    if not path.exists():
        raise ClipError(f"expected a clip, got no such file or folder: {path}")
    with _in_one_line(path):
        layout = layout_of(path)
        clip = layout.open(path, options)
        if options.calibration is not None:
            clip = with_calibration(clip, options.calibration)
        clip = _thinned(clip, options.frame_step, layout.usual_step(path))
        return replace(clip, split=options.split)


def open_case(path: Path, options: ClipOptions = DEFAULTS) -> Clip:
    """The same to look at: of a folder also single images of several sizes, which cannot be trained on.

    Raises ClipError.
    """
    try:
        return open_bare(path, options)
    except ClipError:
        if not path.is_dir():
            raise
        with _in_one_line(path):
            if layout_of(path).is_data_set:
                raise
            folder = frame_folder(path)
            stills = open_stills(folder, options.view_angle, options.bits) if images_in(folder) else None
        if stills is None or stills.has_one_size:
            raise
        if options.alpha != "ignored":
            stills = where_visible(stills, [folder / label for label in stills.labels])
        return replace(stills, path=path, name=path.resolve().name)


def with_chosen_depth(bare: Clip, options: ClipOptions) -> Clip:
    """What `open_bare` gives, with depth from where the options say. Raises ClipError."""
    with _in_one_line(bare.path):
        return with_depth(bare, options)


@contextmanager
def _in_one_line(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise ClipError(f"cannot read the clip, {error.strerror or error}: {path}") from error
    except (CameraError, OverBudget) as error:
        raise ClipError(f"{error}: {path}") from error


def require_depth_source(path: Path, options: ClipOptions) -> None:
    """Refuses at once, by its header, a video of which no depth comes: opening a long one takes a while.

    Raises:
        ClipError: a file of that kind, or one that is no video.
    """
    if path.is_file() and layout_of(path).name == "video" and options.depth in ("auto", "measured", "stereo"):
        told = read_video_header(path).stereo
        if options.depth != "measured" and chosen_layout(options.stereo, told) is not None:
            return
        way = (
            "--depth brightness estimates it, --depth motion finds it where the camera moves, both without a "
            "scale"
        )
        hint = _eyes_hint(path) if options.stereo == "auto" and told is None else ""
        way = f"{hint}; else {way}" if hint else f"{way}; --stereo LAYOUT tells that it shows both eyes"
        raise ClipError(f"reconstruction expects depth, and a video has none ({way}): {path}")


def _eyes_hint(path: Path) -> str:
    first = first_frame(path)
    return "" if first is None else eyes_hint(first)


def _thinned(clip: Clip, step: int | None, usual: int) -> Clip:
    """One frame in `step`; None takes what is usual for the clip."""
    taken = usual if step is None else step
    if taken == 1:
        return clip
    kept = clip.every(taken)
    whose = ", as the field does here (--frame-step 1 keeps all)" if step is None else ""
    said = f"one frame in {taken} is kept, {len(kept)} of {len(clip)}{whose}"
    return replace(kept, notices=(*clip.notices, said))
