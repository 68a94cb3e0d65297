"""A live picture as an OpenIGTLink IMAGE message.

3D Slicer puts the first axis of the message (columns, rightwards) towards the patient's left and the second
(rows, downwards) towards posterior, a pixel to a millimetre, the first pixel at the origin: the axial slice,
which Slicer looks at from the feet, then shows the picture upright and not mirrored.
"""

from __future__ import annotations

import time
from importlib.util import find_spec
from typing import Final

import numpy as np

from app.errors import UserError
from app.live.picture import LivePicture

DEVICE: Final = "VesselSplat"
"""Name of the node in Slicer."""
TO_RAS: Final = np.diag((-1.0, -1.0, 1.0, 1.0))
"""From column, row and slice to right, anterior and superior."""
NO_PYIGTL: Final = "sending by OpenIGTLink needs pyigtl: pip install 'vesselsplat[igtl]'"
NOT_COMPILED: Final = (
    "sending by OpenIGTLink needs crcmod with its compiled part: install a C compiler, then "
    "pip install --force-reinstall --no-cache-dir crcmod"
)


def require_pyigtl() -> None:
    """Raises UserError: the package is not there, or its checksums would take a second a frame."""
    if find_spec("pyigtl") is None:
        raise UserError(NO_PYIGTL)
    if find_spec("crcmod._crcfunext") is None:
        raise UserError(NOT_COMPILED)


def message_of(picture: LivePicture) -> bytes:
    """The frame as shown, RGB, 8 bit, with the time at which it arrived."""
    from pyigtl import ImageMessage

    image = picture.original if picture.enhanced is None else picture.enhanced
    arrived = time.time() - (time.perf_counter() - picture.arrived)
    message = ImageMessage(
        image[np.newaxis],  # (1, H, W, 3): slices, rows, columns, components.
        ijk_to_world_matrix=TO_RAS,
        world_coordinate_system="ras",
        timestamp=arrived,
        device_name=DEVICE,
    )
    return bytes(message.pack())
