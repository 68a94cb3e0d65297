"""DV/BV over the pixels and with the statistics that it can be taken by, and whether a rise of it holds."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import numpy as np

from app.evaluation.mean import mean_of_finite
from app.report.paper_rows import PAPER, PaperRow
from app.runs.train_run import Measured
from enhance.metrics import dvbv_otsu
from renderer.clip import BoolImage, ByteImage, Clip, ClipError
from renderer.readers.clip_options import ClipOptions
from renderer.sources import open_clip

Pixels = Literal["whole image", "gt_masks", "masks"]
PIXELS: Final[tuple[Pixels, ...]] = ("whole image", "gt_masks", "masks")
STATISTICS: Final[tuple[Measured, ...]] = ("whole image", "tissue")
SPREAD: Final = 2.0
"""Standard deviations over the seeds that a mean must lie away from 1."""
Ratios = dict[Pixels, float]


@dataclass(frozen=True, eq=False)
class PixelSets:
    """What of a frame DV and BV can be taken over."""

    clip: Clip
    tools_only: Clip | None
    """The clip with `gt_masks` for its evaluation; None where it has none."""

    @classmethod
    def of(cls, path: Path, clip: Clip) -> PixelSets:
        """Of the clip that was read from there."""
        try:
            tools_only = open_clip(path, ClipOptions(evaluation_masks="gt_masks"))
        except ClipError:
            tools_only = None
        return cls(clip, tools_only if clip.format == "endonerf" else None)

    def masks(self, index: int) -> dict[Pixels, BoolImage | None]:
        """(H, W), True = taken; None for all of them."""
        own = self.clip.read_frame(index).evaluation_mask
        masks: dict[Pixels, BoolImage | None] = {"whole image": None, "masks": own}
        if self.tools_only is not None:
            masks["gt_masks"] = self.tools_only.read_frame(index).evaluation_mask
        return masks

    def ratios(self, pictures: Iterable[tuple[int, ByteImage]]) -> Ratios:
        """Mean DV/BV of pictures, each with the index of its frame, over each set that the clip has."""
        found: dict[Pixels, list[float]] = {}
        for index, picture in pictures:
            for name, mask in self.masks(index).items():
                found.setdefault(name, []).append(dvbv_otsu(picture, tissue_mask=mask).ratio)
        means = {name: mean_of_finite(values) for name, values in found.items()}
        return {name: math.nan if mean is None else mean for name, mean in means.items()}


@dataclass(frozen=True)
class Rise:
    """From original to enhanced photos, of one kind of picture."""

    what: str
    """A method whose renders these are; or "frames"."""
    pixels: Pixels
    statistics: Measured
    original: tuple[float, ...]
    """DV/BV, one a seed."""
    enhanced: tuple[float, ...]

    @property
    def gains(self) -> tuple[float, ...]:
        """Of each seed; those that are not defined are left out."""
        pairs = zip(self.original, self.enhanced, strict=True)
        gains = (after / before if before else math.nan for before, after in pairs)
        return tuple(gain for gain in gains if math.isfinite(gain))


Seeds = Mapping[int, Ratios]
"""By the number of each."""


def rises(what: str, original: Seeds, enhanced: Mapping[Measured, Seeds]) -> Iterator[Rise]:
    """For every set of pixels and kind of statistics; seeds that only one side has do not count."""
    for pixels in PIXELS:
        for statistics in STATISTICS:
            after = enhanced.get(statistics, {})
            seeds = [seed for seed in original if seed in after and pixels in original[seed]]
            if seeds:
                yield Rise(
                    what=what,
                    pixels=pixels,
                    statistics=statistics,
                    original=tuple(original[seed][pixels] for seed in seeds),
                    enhanced=tuple(after[seed][pixels] for seed in seeds),
                )


def spread(gains: Sequence[float]) -> float | None:
    """Standard deviation over the seeds; None of fewer than two."""
    return float(np.std(gains, ddof=1)) if len(gains) > 1 else None


def verdict(gains: Sequence[float]) -> str:
    """Whether a rise holds, by how far its mean lies from 1 in standard deviations over the seeds."""
    deviation = spread(gains)
    if deviation is None:
        return "one seed: undetermined" if gains else "not measured"
    away = float(np.mean(gains)) - 1
    if abs(away) <= SPREAD * deviation:
        return "not distinguishable from none"
    return "holds" if away > 0 else "does not hold"


def published(method: str, clip: Clip) -> str:
    """What the paper prints of a method: of this clip where it is one of the paper's, else of its clips."""
    pairs = [pair for pair in zip(PAPER[::2], PAPER[1::2], strict=True) if pair[0].method == method]
    own = [pair for pair in pairs if pair[0].clip in clip.name and pair[0].frames == len(clip)]
    return "; ".join(_printed(*pair) for pair in own or pairs)


def _printed(before: PaperRow, after: PaperRow) -> str:
    return f"{before.clip} {before.dv_bv:.2f} to {after.dv_bv:.2f}: {after.dv_bv / before.dv_bv:.2f}"
