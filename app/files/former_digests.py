"""What the digest of a clip was of before `renderer.layouts` told it: so that records of then still hold."""

from __future__ import annotations

from pathlib import Path

from renderer.depth.stereo_pairs import eye_folders
from renderer.layouts import layout_of
from renderer.readers.clip_files import files_in, numbered_pictures, pictures_of, those_there
from renderer.readers.endonerf import is_endonerf
from renderer.readers.picture_kinds import frame_folder, map_folders
from renderer.readers.pictures import is_picture

ENDONERF = ("images", "depth", "depth_fine", "masks", "gt_masks")


def former_files(folder: Path) -> list[Path]:
    """The files of a clip in the manifest of runs, sessions and exports of 0.1.0 before it was released.

    They left out right pictures and monocular maps of EndoNeRF folders, the calibration of Hamlyn folders
    with depth/, and arrays beside pictures; of other data sets they were all files, runs among them. It is
    only for comparing: nothing records a digest of these any more, and so the list never changes.
    """
    if is_endonerf(folder):
        return [*pictures_of(folder, ENDONERF), *those_there(folder, ["poses_bounds.npy"])]
    if layout_of(folder).is_data_set:
        return [path for path in folder.rglob("[!.]*") if path.is_file()]
    maps = map_folders(folder)
    places = [place for place in eye_folders(folder) or (frame_folder(folder),) if place not in maps]
    found = [path for place in places for path in numbered_pictures(place)]
    found += [path for place in maps for path in files_in(place) if is_picture(path) or path.suffix == ".npy"]
    return found or list(files_in(folder))
