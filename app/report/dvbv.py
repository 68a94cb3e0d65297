"""DV/BV over the pixels and with the statistics that it can be taken by, from original to enhanced frames:
of frames, and of renders of a few seeds; whether a rise of it holds, and what the paper prints.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Final, Literal

import numpy as np

from app.evaluation.mean import mean_of_finite
from app.report.bench import Bench, Clock, measured_frames
from app.report.paper_rows import PAPER
from app.report.runs import SEEDS, Trained, schedule
from app.report.section import Cell, Column, Table
from app.runs.run_folder import Input
from app.runs.train_run import RECONSTRUCTION_PARAMS, Measured, pooled
from app.runs.trained_clip import enhanced_clip
from app.scenes.cpu_rendering import DrawOptions, draw_on_cpu
from enhance.metrics import dvbv_otsu
from renderer.clip import BoolImage, ByteImage, Clip, ClipError
from renderer.near_plane import near_plane
from renderer.readers.clip_options import ClipOptions
from renderer.sources import open_clip
from renderer.train.config import Method
from renderer.train.trainer import TrainingError

Pixels = Literal["whole image", "gt_masks", "masks"]
PIXELS: Final[tuple[Pixels, ...]] = ("whole image", "gt_masks", "masks")
STATISTICS: Final[tuple[Measured, ...]] = ("whole image", "tissue")
SPREAD: Final = 2.0
"""Standard deviations over the seeds that a mean must lie away from 1."""
Ratios = dict[Pixels, float]
FRAMES: Final = "frames"
Kind = tuple[Input, Measured]
"""Of frames that are trained on."""
KINDS: Final[tuple[Kind, ...]] = (
    ("original", "tissue"),
    *(("enhanced", statistics) for statistics in STATISTICS),
)
HEADS: Final = (
    *(Column("images"), Column("pixels"), Column("statistics of the enhancement"), Column("original", ".3f")),
    *(Column("enhanced", ".3f"), Column("times", ".3f"), Column("± SD of seeds", ".3f"), Column("seeds")),
    *(Column("the rise"), Column("the paper's renders")),
)
NOTE: Final = (
    "Mean of the frames' ratios. Pixels: all (a render is black where nothing is), gt_masks (all but tools) "
    "or masks (all but tools and pixels without stereo depth). Statistics: level, saturation mean and "
    "deviations (Eqs 2, 9 and 12) over the whole image, as in the paper, or over tissue, as in training "
    "here; pooled over the clip. A rise holds where its mean over the seeds lies more than two of their "
    "standard deviations above 1. Frames have no seed. The paper does not state which pixels."
)


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
    """From original to enhanced frames, of one kind of picture."""

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
    return "; ".join(
        f"{before.clip} {before.dv_bv:.2f} to {after.dv_bv:.2f}: {after.dv_bv / before.dv_bv:.2f}"
        for before, after in own or pairs
    )


def measured_rises(
    bench: Bench, clock: Clock, methods: Mapping[Method, str], missing: list[str]
) -> Iterator[Rise]:
    """Of the frames, then of each method's renders."""
    sets = PixelSets.of(bench.clip_path, bench.clip)
    if sets.tools_only is None:
        missing.append("DV/BV over gt_masks: the clip has none")
    yield from _of_frames(sets)
    if bench.why_untrained is not None:
        missing.append(f"DV/BV of renders: {bench.why_untrained}")
        return
    found: dict[Method, dict[Kind, dict[int, Ratios]]] = {
        method: {kind: {} for kind in KINDS} for method in methods
    }
    for seed, method, kind in product(range(SEEDS), methods, KINDS):
        what = f"DV/BV of renders by {methods[method]}, {_named(kind)}, seed {seed}"
        if clock.is_out:
            missing.append(f"{what} and those after it: no time left")
            break
        try:
            config = replace(schedule(bench.clip, method), seed=seed)
            found[method][kind][seed] = _of_renders(sets, bench.runs.trained(config, *kind))
        except TrainingError as error:
            missing.append(f"{what}: {error}")
    for method, name in methods.items():
        enhanced = {kind[1]: found[method][kind] for kind in KINDS[1:]}
        yield from rises(name, found[method][KINDS[0]], enhanced)


def _named(kind: Kind) -> str:
    source, statistics = kind
    return "original frames" if source == "original" else f"enhanced with statistics of {statistics}"


def table(found: list[Rise], clip: Clip) -> Table:
    """A row for each."""
    return Table(title="DV/BV by pixels and statistics", columns=HEADS,
                 note=f"DV/BV of {measured_frames(clip)}. {NOTE}",
                 rows=tuple(_row(one, clip) for one in found))  # fmt: skip


def _row(one: Rise, clip: Clip) -> tuple[Cell, ...]:
    is_frame = one.what == FRAMES
    gains = one.gains
    return (
        *(one.what, one.pixels, one.statistics),
        *(float(np.mean(one.original)), float(np.mean(one.enhanced))),
        float(np.mean(gains)) if gains else None,
        spread(gains),
        None if is_frame else len(gains),
        None if is_frame else verdict(gains),
        published(one.what, clip) or None,
    )


def _of_frames(sets: PixelSets) -> Iterator[Rise]:
    clip, indices = sets.clip, sets.clip.test_indices or sets.clip.train_indices
    enhanced = {
        statistics: enhanced_clip(clip, pooled(clip, RECONSTRUCTION_PARAMS, statistics))
        for statistics in STATISTICS
    }
    after = {name: {0: _of_clip(sets, other, indices)} for name, other in enhanced.items()}
    yield from rises(FRAMES, {0: _of_clip(sets, clip, indices)}, after)


def _of_clip(sets: PixelSets, clip: Clip, indices: tuple[int, ...]) -> Ratios:
    return sets.ratios((index, clip.read_image(index)) for index in indices)


def _of_renders(sets: PixelSets, trained: Trained) -> Ratios:
    model, mode = trained.finished.model, trained.folder.record().config.render_mode
    clip = sets.clip

    def drawn(index: int) -> ByteImage:
        camera = clip.cameras[index]
        return draw_on_cpu(
            model.at(clip.times[index]), camera, DrawOptions(near_plane(model, camera), mode)
        ).bytes

    return sets.ratios((index, drawn(index)) for index in clip.test_indices or clip.train_indices)
