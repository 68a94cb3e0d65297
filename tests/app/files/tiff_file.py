"""TIFF of any layout, whose numbers lie in it as they are."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL.TiffImagePlugin import ImageFileDirectory_v2

HEAD = b"II*\0"
FORMATS = {"u": 1, "i": 2, "f": 3}


def tiff(image: NDArray[Any], photometric: int, *, extra: int | None = None, separate: bool = False) -> bytes:
    """Of (H, W) or (H, W, channels), uncompressed, in one strip or in one for each channel."""
    height, width, samples = np.atleast_3d(image).shape
    stored = np.ascontiguousarray(np.moveaxis(image, -1, 0) if separate else image)
    strips = samples if separate else 1
    size = stored.nbytes // strips
    told = ImageFileDirectory_v2(prefix=HEAD[:2])
    told[256], told[257], told[278] = width, height, height
    told[258], told[339] = (8 * image.dtype.itemsize,) * samples, (FORMATS[image.dtype.kind],) * samples
    told[259], told[262], told[277], told[284] = 1, photometric, samples, 2 if separate else 1
    # Pillow adds the end of the directory, after which they begin.
    told[273] = tuple(size * strip for strip in range(strips))
    told[279] = (size,) * strips
    if extra is not None:
        told[338] = (extra,)
    return HEAD + (8).to_bytes(4, "little") + told.tobytes(8) + stored.tobytes()
