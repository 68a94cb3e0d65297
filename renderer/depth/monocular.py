"""Maps of inverse depth that a network has made of single pictures, in a folder beside these."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np

from renderer.clip import BoolImage, Clip, ClipError, Frame
from renderer.depth.alignment import aligned
from renderer.depth.averaging import Float32Image
from renderer.depth.depth_prior import Guess
from renderer.readers.clip_files import files_in
from renderer.readers.geometry.depth_maps import is_map, plane_of
from renderer.readers.image_files.file_kinds import is_array
from renderer.readers.image_files.pictures import read_stored
from renderer.readers.numbered_files import beside, number_of

FOLDERS = ("monodepth", "depth_dam")

_STRIDE = 4  # Of the pixels that a map is aligned by.
_SMALLEST = 0.01
"""Of the median of the reference: smaller inverse depths tell nothing and are none."""


def monocular_maps(clip: Clip) -> tuple[Path, ...]:
    """One map a frame, by the last number in the names; empty without a folder of them.

    The folder lies in that of the clip or beside the pictures.

    Raises:
        ClipError: a folder that lacks maps for some frames.
    """
    folder = _map_folder(clip.path)
    if folder is None:
        return ()
    numbers = [number_of(Path(label)) for label in clip.labels]
    known = [number for number in numbers if number is not None]
    if len(known) < len(numbers):
        raise ClipError(f"expected images with numbers in their names for the maps, got others: {clip.path}")
    return beside(known, folder, is_map)


def map_files(path: Path, names: Sequence[str]) -> tuple[Path, ...]:
    """What `monocular_maps` takes for pictures of these names in the folder `path`, as far as it is there."""
    folder = _map_folder(path)
    numbers = {number_of(Path(name)) for name in names} - {None}
    maps = filter(is_map, files_in(folder)) if folder else ()
    return tuple(entry for entry in maps if number_of(entry) in numbers)


def _map_folder(path: Path) -> Path | None:
    places = (path, path.parent)
    return next((place / name for place in places for name in FOLDERS if (place / name).is_dir()), None)


def monocular_guess(clip: Clip, maps: tuple[Path, ...]) -> Guess:
    """Depth by the maps, one a frame: the inverse of each, aligned to that of the first training frame.

    monodepth/ holds pictures whose first channel is normalised disparity, depth_dam/ arrays (.npy) of
    it; 0 = none. Such maps are right up to a scale and a shift that differ between frames; tissue that
    stays in place tells both (`aligned`), so that the scene does not breathe.

    The guess raises ClipError for a file that is no map.
    """
    first = clip.train_indices[0]

    @lru_cache(1)
    def reference() -> tuple[Float32Image, BoolImage]:
        found = read_inverse_depth(maps[first], clip.size)
        known = clip.read_frame(first).tissue_mask & (found > 0)
        if not known.any():
            raise ClipError(f"expected inverse depth on the tissue, got none: {maps[first]}")
        return found, known

    def guess(frame: Frame) -> Float32Image:
        wanted, known = reference()
        found = read_inverse_depth(maps[frame.index], clip.size)
        fitted = _fitted(found, wanted, known & frame.tissue_mask & (found > 0))
        valid = (found > 0) & (fitted > _SMALLEST * np.median(wanted[known]))
        return np.where(valid, 1 / np.where(valid, fitted, 1), 0).astype(np.float32)

    return guess


def _fitted(found: Float32Image, wanted: Float32Image, both: BoolImage) -> Float32Image:
    some = (slice(None, None, _STRIDE), slice(None, None, _STRIDE))
    if not both[some].any():
        return found
    scale, shift = aligned(found[some], wanted[some], both[some])
    return np.asarray(scale * found + shift, dtype=np.float32)


def read_inverse_depth(path: Path, size: tuple[int, int]) -> Float32Image:
    """Inverse depth (H, W) of a .npy or picture file, resampled to `size` (width, height); 0 = none.

    Raises:
        ClipError: no map, or one that cannot be read.
    """
    stored = read_stored(path)
    has_channels = stored.ndim == 3 and not is_array(path)
    values = plane_of(stored[:, :, 0] if has_channels else stored, path)
    if values.shape == (size[1], size[0]):
        return values
    share = cv2.resize((values > 0).astype(np.float32), size, interpolation=cv2.INTER_LINEAR)
    resized = cv2.resize(values, size, interpolation=cv2.INTER_LINEAR)
    return np.where(share > 1 - 1e-3, resized, np.float32(0))
