"""Whether there is room for what is planned, before hours go into it."""

from __future__ import annotations

import shutil
from pathlib import Path

from app.errors import UserError
from app.runs.memory import free_memory
from renderer.clip import Clip
from renderer.train.config import TrainConfig
from renderer.train.demand import demand
from renderer.train.events import Planned
from renderer.train.frame_store import nearest_folder


def planned_in(folder: Path, clip: Clip, config: TrainConfig) -> Planned:
    """What the training will need.

    Raises:
        UserError: there is less free memory than that, or less room on the disk that `folder` will lie on.
    """
    planned, (width, height) = demand(clip, config), clip.size
    what = f"{len(clip.train_indices)} frames of {width}x{height} and {config.n_gaussians} Gaussians"
    disk = shutil.disk_usage(nearest_folder(folder)).free
    for needed, free, where in ((planned.memory, free_memory(), "memory"), (planned.disk, disk, "disk")):
        if needed > free:
            expected = f"expected {amount(needed)} of free {where} to train on {what}"
            way = "take fewer frames (--frames, --frame-step)"
            raise UserError(f"{expected}, got {amount(free)} ({way}): {folder}")
    return planned


def told(planned: Planned) -> str:
    """In words."""
    return f"needs up to {amount(planned.memory)} of memory and {amount(planned.disk)} of disk"


def amount(size: int) -> str:
    return f"{size / 1e9:.1f} GB" if size >= 1e9 else f"{size / 1e6:.0f} MB"
