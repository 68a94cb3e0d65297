"""`.splat`: 32 bytes a splat, without a header.

Position and standard deviations as floats, colour and opacity as bytes, rotation as bytes about 128, w first.
"""

from __future__ import annotations

import numpy as np

from renderer.raw_gaussians import RawGaussians, logits
from renderer.splat_files.splat_file import SplatFile, SplatFileError, repaired

RECORD = np.dtype([("mean", "<f4", 3), ("scale", "<f4", 3), ("color", "u1", 4), ("quat", "u1", 4)])


def read_records(content: bytes) -> SplatFile:
    """The Gaussians. Raises SplatFileError: the file is cut off."""
    if len(content) % RECORD.itemsize:
        raise SplatFileError(
            f"expected a multiple of {RECORD.itemsize} bytes, got {len(content)}: damaged or cut off"
        )
    rows = np.frombuffer(content, RECORD)
    with np.errstate(divide="ignore", invalid="ignore"):
        log_scales = np.log(rows["scale"])
    return repaired(
        RawGaussians(
            means=rows["mean"].astype(np.float32),
            quats=(rows["quat"] / 128 - 1).astype(np.float32),
            log_scales=log_scales.astype(np.float32),
            opacity_logits=logits(rows["color"][:, 3] / 255),
            colors=(rows["color"][:, :3] / 255).astype(np.float32),
            harmonics=np.zeros((len(rows), 0, 3), np.float32),
        )
    )
