"""What is turned where error is measured against run time of reconstruction."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Final, get_args

from renderer.train.config import Method, TrainConfig

KNOBS: Final[dict[str, tuple[dict[str, Any], ...]]] = {
    "method": tuple({"method": name} for name in get_args(Method)),
    "iterations": (
        *({"iterations": count} for count in (250, 500, 1000, 2000, 6000)),
        *({"method": "deform3dgs", "iterations": count} for count in (500, 1000, 2000)),
        *({"method": "endogaussian", "iterations": count} for count in (500, 1000)),
        *({"method": "static", "iterations": count} for count in (250, 1000)),
    ),
    "n_gaussians": tuple({"n_gaussians": count} for count in (7500, 15_000, 60_000)),
    "n_controls": tuple({"n_controls": count} for count in (4, 8, 32)),
    "half_resolution_share": tuple({"half_resolution_share": share} for share in (0.0, 2 / 3)),
    "leave_out": (
        *({"leave_out": ("tracks",), "iterations": count} for count in (250, 500, 1000, 2000)),
        *({"leave_out": (part,)} for part in ("tracks", "color_curves")),
    ),
}
"""What is turned, and what it is turned to; all else is the default."""


def settings() -> Iterator[tuple[str, TrainConfig]]:
    """Every knob with each of its settings; the first is the default."""
    for knob, changes in KNOBS.items():
        for change in changes:
            yield knob, replace(TrainConfig(), **change)
