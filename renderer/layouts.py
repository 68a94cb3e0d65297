"""Every layout of a clip that has a reader: how it is known, how it is opened, and from which files.

The one place that knows them all: opening, digests, batches and descriptions follow from LAYOUTS.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from renderer.clip import Clip, ClipError
from renderer.depth.clip_depth import depth_files
from renderer.depth.maps_beside import map_files, with_maps
from renderer.depth.stereo_pairs import eye_folders, is_stereo_folder, open_stereo_folder
from renderer.readers.clip_files import ClipFiles, numbered_pictures
from renderer.readers.clip_options import ClipOptions
from renderer.readers.coded_still import open_coded_still
from renderer.readers.data_sets import hamlyn, stereomis
from renderer.readers.data_sets.converted_stereomis import is_converted_stereomis, open_converted_stereomis
from renderer.readers.data_sets.endonerf import endonerf_files, is_endonerf, open_endonerf
from renderer.readers.data_sets.scared import is_scared, open_scared, scared_files, usual_step
from renderer.readers.data_sets.structure_from_motion import (
    is_structure_from_motion,
    open_structure_from_motion,
    structure_from_motion_files,
)
from renderer.readers.dicom.header import dicom_kind
from renderer.readers.image_files.coded_picture import CODED, is_coded_still
from renderer.readers.image_files.file_kinds import SUFFIXES, is_picture, is_unnamed
from renderer.readers.image_files.transparency import where_visible
from renderer.readers.image_files.used_bits import said_of_unread_bits, used_bits
from renderer.readers.image_folders.frames import frames_of, open_image, open_images
from renderer.readers.image_folders.picture_kinds import frame_folder
from renderer.readers.video import open_video
from renderer.regular_files import require_file_or_folder, require_regular


def every_frame(path: Path) -> int:
    """The usual step of most layouts."""
    return 1


@dataclass(frozen=True, kw_only=True)
class Layout:
    """One way in which a clip lies on disk."""

    name: str
    title: str
    """As a person calls it."""
    matches: Callable[[Path], bool]
    """Whether a path, which is there, is of this layout, if it is of none before it."""
    open: Callable[[Path, ClipOptions], Clip]
    """All frames, with the depth of its own files. Raises ClipError, CameraError, OverBudget or OSError."""
    own_files: Callable[[Path], ClipFiles]
    is_data_set: bool = False
    """Of folders that are one clip together, with poses, calibration or depth."""
    frames_are_files: bool = True
    """Whether its frames are picture files as they stand: else, the reader makes them of its files."""
    usual_step: Callable[[Path], int] = every_frame
    """The field keeps one frame in so many."""
    heeds: tuple[str, ...] = ()
    """Options that it heeds and not every layout does."""

    def files(self, path: Path) -> tuple[Path, ...]:
        """The files of which a clip depends under any options, each once; those of right pictures and of
        monocular maps may lie beside the folder `path`.

        What is missing or damaged is left to `open`, which says so. Raises OSError.
        """
        own = self.own_files(path)
        beside = depth_files(path, [frame.name for frame in own.frames]) if path.is_dir() else ()
        return tuple(dict.fromkeys((*own.frames, *own.others, *beside)))


def layout_of(path: Path) -> Layout:
    """The layout of a file or folder that is there. Raises OSError, which names it: a folder whose files may
    not be looked at."""
    if path.is_dir():
        require_file_or_folder(path)
    return next(layout for layout in LAYOUTS if layout.matches(path))


def _open_endonerf(path: Path, options: ClipOptions) -> Clip:
    return (open_converted_stereomis if is_converted_stereomis(path) else open_endonerf)(path, options)


def _open_stereo(path: Path, options: ClipOptions) -> Clip:
    left = next(iter(eye_folders(path)), path)
    clip = open_stereo_folder(path, options.view_angle, options.bits)
    if options.bits is None and left != path:
        files = [left / label for label in clip.labels]
        clip = replace(clip, notices=(*clip.notices, *said_of_unread_bits(len(files), used_bits(files))))
    return _where_visible(with_maps(clip, left, options), left, options)


def _stereo_files(path: Path) -> ClipFiles:
    left, *right = eye_folders(path) or (path,)
    own = _frames_and_maps(path, left)
    return replace(own, others=(*own.others, *(each for eye in right for each in numbered_pictures(eye))))


def _open_pictures(path: Path, options: ClipOptions) -> Clip:
    pictures = frame_folder(path)
    clip = open_images(pictures, options.view_angle, options.bits)
    clip = with_maps(replace(clip, path=path, name=path.resolve().name), pictures, options)
    return _where_visible(clip, pictures, options)


def _where_visible(clip: Clip, folder: Path, options: ClipOptions) -> Clip:
    if options.alpha == "ignored":
        return clip
    return where_visible(clip, [folder / label for label in clip.labels])


def _frames_and_maps(path: Path, folder: Path) -> ClipFiles:
    """The frames in `folder` and what lies beside them; numbered pictures that belong to no frame too."""
    told = numbered_pictures(folder)
    try:
        frames = frames_of(folder)
        return ClipFiles(frames, (*told, *map_files(path, folder, [frame.name for frame in frames])))
    except ClipError:
        return ClipFiles(told)  # A damaged picture, of which its reader says so.


def _is_still(path: Path) -> bool:
    """By its name; of DICOM, whose names tell nothing, by its header, and so without a suffix; of a coded
    still, whose name may be that of several, by its first bytes."""
    if path.is_dir():
        return False
    if (kind := dicom_kind(path)) is not None:
        return kind != "clip"
    is_named = is_picture(path) and path.suffix.lower() not in CODED
    return is_named or is_coded_still(path) or is_unnamed(path)


def _open_picture(path: Path, options: ClipOptions) -> Clip:
    require_regular(path)
    is_coded = path.suffix.lower() not in SUFFIXES and is_coded_still(path)
    if is_coded:
        return open_coded_still(path, options.view_angle)
    clip = open_image(path, options.view_angle, options.bits)
    return clip if options.alpha == "ignored" else where_visible(clip, (path,))


def _open_video(path: Path, options: ClipOptions) -> Clip:
    require_regular(path)
    return open_video(path, options)


def _itself(path: Path) -> ClipFiles:
    return ClipFiles((path,))


LAYOUTS: Final = (
    Layout(
        name="image",
        title="one image",
        matches=_is_still,
        open=_open_picture,
        own_files=_itself,
        heeds=("field_of_view", "bits", "alpha"),
    ),
    Layout(
        name="video",
        title="video",
        matches=lambda path: not path.is_dir(),
        open=_open_video,
        own_files=_itself,
        frames_are_files=False,
        heeds=("field_of_view", "deinterlacing", "stereo"),
    ),
    Layout(
        name="scared",
        title="SCARED",
        matches=is_scared,
        open=lambda path, options: open_scared(path),
        own_files=scared_files,
        is_data_set=True,
        frames_are_files=False,
        usual_step=usual_step,
    ),
    Layout(
        name="structure-from-motion",
        title="structure from motion",
        matches=is_structure_from_motion,
        open=lambda path, options: open_structure_from_motion(path),
        own_files=structure_from_motion_files,
        is_data_set=True,
        frames_are_files=False,
    ),
    Layout(
        name="stereomis",
        title="StereoMIS",
        matches=stereomis.is_stereomis,
        open=stereomis.open_stereomis,
        own_files=stereomis.stereomis_files,
        is_data_set=True,
        frames_are_files=False,
        heeds=("mask_polarity",),
    ),
    Layout(
        name="hamlyn",
        title="Hamlyn",
        matches=hamlyn.is_hamlyn,
        open=hamlyn.open_hamlyn,
        own_files=hamlyn.hamlyn_files,
        is_data_set=True,
        frames_are_files=False,
        heeds=("mask_polarity",),
    ),
    Layout(
        name="endonerf",
        title="EndoNeRF",
        matches=is_endonerf,
        open=_open_endonerf,
        own_files=endonerf_files,
        is_data_set=True,
        heeds=("pose_convention", "mask_polarity", "evaluation_masks", "bottom_rows"),
    ),
    Layout(
        name="stereo",
        title="left and right images",
        matches=is_stereo_folder,
        open=_open_stereo,
        own_files=_stereo_files,
        heeds=("mask_polarity", "field_of_view", "bits", "alpha"),
    ),
    Layout(
        name="images",
        title="images",
        matches=lambda path: True,
        open=_open_pictures,
        own_files=lambda path: _frames_and_maps(path, frame_folder(path)),
        heeds=("mask_polarity", "field_of_view", "bits", "alpha"),
    ),
)
"""In the order in which they are asked: a folder may look like several."""
