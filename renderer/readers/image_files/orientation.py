"""Which way up a stored image is, by its EXIF."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

UPRIGHT: Final = 1
TURNS: Final[Mapping[int, Callable[[NDArray[Any]], NDArray[Any]]]] = {
    2: np.fliplr,
    3: lambda picture: np.rot90(picture, 2),
    4: np.flipud,
    5: lambda picture: np.swapaxes(picture, 0, 1),
    6: lambda picture: np.rot90(picture, -1),
    7: lambda picture: np.swapaxes(np.rot90(picture, 2), 0, 1),
    8: np.rot90,
}
"""What makes a picture upright, by its orientation; of others it is."""


def upright(stored: NDArray[Any], orientation: int) -> NDArray[Any]:
    """(H, W) or (H, W, channels) turned as its orientation says, C-contiguous."""
    return np.ascontiguousarray(TURNS[orientation](stored)) if orientation in TURNS else stored
