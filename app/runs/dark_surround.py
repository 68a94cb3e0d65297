"""The dark surround of an endoscope's image, which is no tissue: found in the frames to train on."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import chain
from typing import Final

import numpy as np

from enhance.field import FieldOfView, typical
from enhance.field_search import find_field
from renderer.clip import ByteImage, Clip, Frame
from renderer.evenly import evenly
from renderer.poses.burned_in import burned_in_borders, dark_bars
from renderer.readers.masks.lit_part import RIM
from renderer.train.config import TrainConfig
from renderer.train.events import Omission

LOOKED_AT: Final = 16
"""Frames, evenly spread."""
LEAST_TISSUE: Final = 0.5
"""Of the surround: where the clip's own masks call less of it tissue, they leave it out themselves."""


def spread(indices: Sequence[int]) -> list[int]:
    """A few of these frames that stand for all of them."""
    return evenly(indices, LOOKED_AT)


def lit_field(frames: Iterable[Frame]) -> FieldOfView | None:
    """What the endoscope sees in most of these frames.

    None where nothing surrounds it, where their masks leave the surround out, or where they differ in size.
    """
    found, tissue, count = list[FieldOfView](), np.zeros((0, 0)), 0
    for frame in frames:
        if count and tissue.shape != frame.tissue_mask.shape:
            return None
        tissue, count = tissue + frame.tissue_mask if count else frame.tissue_mask.astype(float), count + 1
        if (field := find_field(frame.image)) is not None:
            found.append(field)
    field = typical(found) if found else None
    if field is None or field.is_whole:
        return None
    return field if tissue[~field.mask()].mean() > LEAST_TISSUE * count else None


def lit_part(clip: Clip) -> Clip:
    """The same clip without the dark surround that its frames show: what is written or reflected there is no
    tissue, and stays where it is while a camera moves. Raises ClipError."""
    field = lit_field(map(clip.read_frame, spread(range(len(clip)))))
    return clip if field is None else clip.within(field.mask())


def without_rim(field: FieldOfView) -> FieldOfView:
    """The field without its dark rim, which stays in place while a moving camera sees other tissue."""
    return field.inset(RIM * field.width)


def without_borders(images: Sequence[ByteImage]) -> FieldOfView | None:
    """Images without bars at their border, which stay while a camera moves; None where there are none."""
    return _within(images[0].shape[1], images[0].shape[0], burned_in_borders(images))


def without_dark_bars(frames: Iterable[Frame]) -> FieldOfView | None:
    """Frames without the thin dark bars at their border; None where there are none."""
    every = iter(frames)
    first = next(every, None)
    if first is None:
        return None
    return _within(first.camera.width, first.camera.height, dark_bars(chain((first,), every)))


def _within(width: int, height: int, borders: tuple[int, int, int, int]) -> FieldOfView | None:
    left, top, right, bottom = borders
    if not any(borders):
        return None
    corners = ((left, top), (width - right, top), (width - right, height - bottom), (left, height - bottom))
    return FieldOfView(width=width, height=height, polygon=tuple((float(x), float(y)) for x, y in corners))


def percent(share: float) -> str:
    """Of a share in (0, 1], which is never nothing."""
    return f"{100 * share:.0f} %" if share >= 0.005 else "less than 1 %"


def omission_of(field: FieldOfView) -> Omission:
    """What leaving out all but this field is, in words and numbers."""
    return Omission(
        "dark surround",
        "the endoscope sees nothing there",
        f"{percent(1 - _lit_share(field))} of the pixels and Gaussians",
        "surround",
    )


def as_dense(config: TrainConfig, field: FieldOfView | None) -> TrainConfig:
    """With as many Gaussians per pixel of the field as the whole image would have: more of them learn no
    better in as many steps. On the phantom through a round view, 800 steps: 0.3 to 0.5 dB."""
    if field is None:
        return config
    return replace(config, n_gaussians=max(1, round(_lit_share(field) * config.n_gaussians)))


def _lit_share(field: FieldOfView) -> float:
    return float(field.mask().mean())
