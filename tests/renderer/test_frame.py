"""What a frame may hold."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from renderer.camera import Camera
from renderer.clip import Clip, ClipError, Frame

CAMERA = Camera.from_fov(60, 32, 24)
MASK = np.ones((24, 32), bool)
FRAME = Frame(7, 0.5, np.zeros((24, 32, 3), np.uint8), CAMERA, MASK, MASK, np.ones((24, 32), np.float32))


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        (
            "image",
            np.full((24, 32, 3), 0.5, np.float32),
            r"image as uint8 of shape \(24, 32, 3\), got float32 of shape \(24, 32, 3\): frame 7",
        ),
        ("image", np.zeros((24, 32, 4), np.uint8), r"image as uint8 of shape \(24, 32, 3\), got uint8 of"),
        ("image", np.zeros((24, 32), np.uint8), r"image as uint8 of shape \(24, 32, 3\), got uint8 of shape"),
        ("tissue_mask", np.ones((24, 32), np.uint8), r"tissue_mask as bool of shape \(24, 32\), got uint8"),
        (
            "evaluation_mask",
            np.ones((24, 31), bool),
            r"evaluation_mask as bool of shape \(24, 32\), got bool",
        ),
        (
            "camera",
            Camera.from_fov(60, 64, 48),
            r"image as uint8 of shape \(48, 64, 3\), got uint8 of shape \(24, 32, 3\): frame 7",
        ),
        ("depth", np.ones((24, 32), np.uint16), r"depth as float of shape \(24, 32\), got uint16"),
        ("depth", np.ones((12, 16), np.float32), r"depth as float of shape \(24, 32\), got float32 of shape"),
    ],
)
def test_other_types_and_sizes_are_refused(name: str, value: object, said: str) -> None:
    changes: dict[str, object] = {name: value}
    with pytest.raises(ClipError, match=f"^expected Frame.{said}"):
        replace(FRAME, **changes)  # type: ignore[arg-type]


def test_what_is_meant_is_taken() -> None:
    depth = np.ones((24, 32), np.float64)
    assert replace(FRAME, depth=depth).depth is depth
    assert replace(FRAME, depth=None).depth is None


def test_depth_is_in_the_byte_order_of_this_machine() -> None:
    """OpenCV reads no other, and says nothing."""
    depth = np.linspace(1, 2, 24 * 32, dtype=np.float32).reshape(24, 32)
    taken = replace(FRAME, depth=depth.astype(depth.dtype.newbyteorder())).depth
    assert taken is not None
    assert taken.dtype == np.float32
    assert taken.dtype.isnative
    assert np.array_equal(taken, depth)


def test_a_clip_looks_through_its_cameras_once() -> None:
    """Panels ask in every frame of the window, and a long clip has many."""
    camera, walks = Camera.from_fov(60, 32, 24), list[int]()

    class Walked(tuple[Camera, ...]):
        def __iter__(self) -> Iterator[Camera]:
            walks.append(len(self))
            return super().__iter__()

    clip = Clip(
        name="flat",
        path=Path("flat"),
        format="images",
        cameras=Walked((camera,) * 4),
        read_frame=lambda index: FRAME,
        read_image=lambda index: FRAME.image,
        labels=("0", "1", "2", "3"),
        has_depth=False,
        unit="scene units",
    )
    assert all(clip.has_one_size and clip.camera_is_fixed for _ in range(3))
    assert walks == [4, 4]
    other = clip.through((camera, camera, camera, replace(camera, width=30)))
    assert (other.has_one_size, other.camera_is_fixed) == (False, False)
