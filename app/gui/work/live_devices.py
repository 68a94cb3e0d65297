"""The capture devices of this machine, each with a picture of what it sees."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Final

import cv2
import numpy as np

from app.live.address import Device
from app.live.sources.device import DeviceSource, devices
from app.live.sources.source import Source, SourceLost, Wish
from renderer.clip import ByteImage

SIDE: Final = 240
"""Pixels across a preview."""
SETTLING: Final = 3
"""Frames that a camera gets to find its exposure."""


@dataclass(frozen=True)
class DevicesRequest:
    """A wish to see them; the number tells a later one from the first."""

    looks: int


@dataclass(frozen=True, eq=False)
class Found:
    """What there is."""

    devices: tuple[Device, ...]
    previews: dict[str, ByteImage] = field(default_factory=dict)
    """(H, W, 3) by where the device is; none of one that cannot be read now."""


def find_devices(
    request: DevicesRequest,
    listed: Callable[[], tuple[Device, ...]] = devices,
    opened: Callable[[Device], Source] = lambda one: DeviceSource(one.where, one.name, Wish()),
) -> Iterator[Found]:
    """First by name, then with what they see."""
    known = listed()
    yield Found(known)
    previews = {}
    for one in known:
        with suppress(SourceLost):
            previews[one.where] = _preview(opened(one))
    if previews:
        yield Found(known, previews)


def _preview(source: Source) -> ByteImage:
    try:
        taken = [source.read() for _ in range(SETTLING)][-1]
        if taken is None:
            raise SourceLost("no frame")
        image = taken.read()
    finally:
        source.close()
    height = max(1, round(SIDE * image.shape[0] / image.shape[1]))
    return np.asarray(cv2.resize(image, (SIDE, height), interpolation=cv2.INTER_AREA), np.uint8)
