"""DV/BV from original to enhanced frames: of frames, and of renders of a few seeds, beside the paper."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import product
from typing import Final

import numpy as np

from app.report.bench import Bench, Clock
from app.report.dvbv import STATISTICS, PixelSets, Ratios, Rise, published, rises, spread, verdict
from app.report.runs import Trained
from app.report.schedule import SEEDS, schedule
from app.report.section import Cell, Column, Table
from app.runs.run_clip import enhanced_clip
from app.runs.run_folder import Input
from app.runs.train_run import RECONSTRUCTION_PARAMS, Measured, pooled
from app.scenes.cpu_rendering import Drawn
from renderer.clip import Clip
from renderer.near_plane import near_plane
from renderer.rasterize.cpu import render
from renderer.train.config import Method
from renderer.train.trainer import TrainingError

PHOTOS: Final = "frames"
Kind = tuple[Input, Measured]
"""Of photos that are trained on."""
KINDS: Final[tuple[Kind, ...]] = (
    ("original", "tissue"),
    *(("enhanced", statistics) for statistics in STATISTICS),
)
HEADS: Final = (
    *(Column(name="images"), Column(name="pixels"), Column(name="statistics of the enhancement")),
    *(Column(name="original", form=".3f"), Column(name="enhanced", form=".3f")),
    *(Column(name="times", form=".3f"), Column(name="± SD of seeds", form=".3f"), Column(name="seeds")),
    *(Column(name="the rise"), Column(name="the paper's renders")),
)
NOTE: Final = (
    "DV/BV of held-out frames, mean of the frames' ratios. Pixels: all (a render is black where nothing "
    "is), gt_masks (all but tools) or masks (all but tools and pixels without stereo "
    "depth). Statistics: level, "
    "saturation mean and deviations (Eqs 2, 9 and 12) over the whole image, as in the paper, or over "
    "tissue, as in training here; pooled over the clip. A rise holds where its mean over the seeds lies "
    "more than two of their standard deviations above 1. Frames have no seed. The "
    "paper does not state which pixels."
)


def measured_rises(
    bench: Bench, clock: Clock, methods: Mapping[Method, str], missing: list[str]
) -> Iterator[Rise]:
    """Of the photos, then of each method's renders."""
    sets = PixelSets.of(bench.clip_path, bench.clip)
    if sets.tools_only is None:
        missing.append("DV/BV over gt_masks: the clip has none")
    yield from _of_photos(sets)
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
    photos, statistics = kind
    return "original frames" if photos == "original" else f"enhanced with statistics of {statistics}"


def table(found: list[Rise], clip: Clip) -> Table:
    """A row for each."""
    return Table(title="DV/BV by pixels and statistics", columns=HEADS, note=NOTE,
                 rows=tuple(_row(one, clip) for one in found))  # fmt: skip


def _row(one: Rise, clip: Clip) -> tuple[Cell, ...]:
    is_photo = one.what == PHOTOS
    gains = one.gains
    return (
        *(one.what, one.pixels, one.statistics),
        *(float(np.mean(one.original)), float(np.mean(one.enhanced))),
        float(np.mean(gains)) if gains else None,
        spread(gains),
        None if is_photo else len(gains),
        None if is_photo else verdict(gains),
        published(one.what, clip) or None,
    )


def _of_photos(sets: PixelSets) -> Iterator[Rise]:
    clip, indices = sets.clip, sets.clip.test_indices or sets.clip.train_indices
    enhanced = {
        statistics: enhanced_clip(clip, pooled(clip, RECONSTRUCTION_PARAMS, statistics))
        for statistics in STATISTICS
    }
    after = {name: {0: _of_clip(sets, other, indices)} for name, other in enhanced.items()}
    yield from rises(PHOTOS, {0: _of_clip(sets, clip, indices)}, after)


def _of_clip(sets: PixelSets, clip: Clip, indices: tuple[int, ...]) -> Ratios:
    return sets.ratios((index, clip.read_image(index)) for index in indices)


def _of_renders(sets: PixelSets, trained: Trained) -> Ratios:
    model, mode = trained.finished.model, trained.folder.record().config.render_mode
    clip = sets.clip

    def drawn(index: int) -> Drawn:
        camera = clip.cameras[index]
        got = render(model.at(clip.times[index]), camera, near=near_plane(model, camera), mode=mode)
        return Drawn(got.image, got.depth, got.alpha)

    indices = clip.test_indices or clip.train_indices
    return sets.ratios((index, drawn(index).bytes) for index in indices)
