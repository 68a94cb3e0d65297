"""Masks of which every value but 0 is set, noise aside."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from renderer.clip import BoolImage, ClipError
from renderer.readers.image_files.pictures import read_stored, stored_kind
from renderer.readers.masks.tool_masks import is_lossy, levels, marked_pixels


def read_nonzero(path: Path, size: tuple[int, int]) -> BoolImage:
    """(H, W) for `size` (width, height), True where the file is not 0, or if it is lossy, where it is bright;
    alpha does not count.

    A mask of the same shape and another size is resampled by its nearest pixel. Raises ClipError
    when the file is no picture or of another shape, or when its alpha alone marks something.
    """
    stored = read_mask(path)
    _require_shape((stored.shape[1], stored.shape[0]), size, path)
    marked = marked_pixels(stored) if is_lossy(path) else levels(stored) != 0
    resized = cv2.resize(marked.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST_EXACT)
    return np.asarray(resized > 0)


def read_mask(path: Path) -> NDArray[Any]:
    """As `read_stored`. Raises ClipError, too: a mask that marks something in its alpha alone."""
    stored = read_stored(path)
    has_alpha = stored.ndim == 3 and stored.shape[2] in (2, 4)
    if has_alpha and not levels(stored).any() and np.ptp(stored[..., -1]):
        got = "got one in the alpha alone"
        raise ClipError(f"expected a mask that is not black where it marks, {got}: {path}")
    return stored


def require_shapes(paths: Iterable[Path], size: tuple[int, int]) -> None:
    """By their headers. Raises ClipError: a file that `read_nonzero` would refuse."""
    for path in paths:
        _require_shape(stored_kind(path)[1], size, path)


def _require_shape(found: tuple[int, int], size: tuple[int, int], path: Path) -> None:
    (width, height), (wide, high) = found, size
    if abs(width * high - height * wide) > 0.005 * width * high:
        wanted = f"a mask of the shape of the images, {wide}x{high}"
        raise ClipError(f"expected {wanted}, got {width}x{height}: {path}")
