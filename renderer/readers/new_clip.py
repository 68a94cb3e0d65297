"""A clip of what a reader tells of its frames, numbered and timed as those of every clip are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from renderer.camera import Camera
from renderer.clip import BoolImage, ByteImage, Clip, Frame, numbered


@dataclass(frozen=True, eq=False)
class Known:
    """What is known of a frame beside its image, see Frame."""

    tissue: BoolImage | None = None
    """None: all of it."""
    evaluation: BoolImage | None = None
    """None: the tissue."""
    depth: NDArray[np.float32] | None = None


def new_clip(
    path: Path,
    format: str,
    *,
    cameras: tuple[Camera, ...],
    labels: tuple[str, ...],
    read_image: Callable[[int], ByteImage],
    known: Callable[[int], Known] = lambda index: Known(),
    has_depth: bool = False,
    unit: str = "scene units",
    notices: tuple[str, ...] = (),
) -> Clip:
    """A clip by the name of its file or folder. `read_image` and `known` are of a frame by its number."""

    def read_frame(index: int) -> Frame:
        index = numbered(index, len(cameras))
        camera, own = cameras[index], known(index)
        tissue = np.ones((camera.height, camera.width), bool) if own.tissue is None else own.tissue
        evaluation = tissue if own.evaluation is None else own.evaluation
        time = index / len(cameras)
        return Frame(index, time, read_image(index), camera, tissue, evaluation, own.depth)

    return Clip(
        name=path.resolve().stem if path.is_file() else path.resolve().name,
        path=path,
        format=format,
        cameras=cameras,
        read_frame=read_frame,
        read_image=lambda index: read_image(numbered(index, len(cameras))),
        labels=labels,
        has_depth=has_depth,
        unit=unit,
        notices=notices,
    )
