"""The paper's Tables 1 to 3 on the clips that are there, beside the paper's rows, and which of them hold."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np

from app.evaluation.evaluate import LPIPS, find_lpips, no_lpips, open_evaluation
from app.evaluation.mean import mean_of_finite
from app.report.bench import Bench, Clock, measured_frames
from app.report.dvbv import FRAMES, Rise, measured_rises, verdict
from app.report.dvbv import table as table_of_rises
from app.report.measures.training import INPUTS
from app.report.paper_rows import PAPER, SCARED, TABLE_3
from app.report.runs import schedule
from app.report.section import Cell, Column, Section, Table
from app.report.visibility import COLUMNS, Sample, measured, methods, of_clip, of_phantom, pattern
from enhance.baselines import TAO_STAND_INS
from enhance.noise import noise_gain
from renderer.clip import ClipError
from renderer.train.config import Method
from renderer.train.trainer import TrainingError

METHODS: Final[dict[Method, str]] = {
    "endogaussian": "EndoGaussian",
    "deform3dgs": "Deform3DGS",
    "vesselsplat": "VesselSplat",
}
HEADS: Final = (
    *(Column("clip"), Column("table"), Column("method"), Column("frames"), Column("LPIPS", ".4f")),
    *(Column("DV", ".1f"), Column("BV", ".1f"), Column("DV/BV", ".3f"), Column("vessel contrast", ".3f")),
    *(Column("PSNR, dB", ".2f"), Column("SSIM", ".4f"), Column("saturated", ".2%")),
    Column("noise gain of its frames", ".2f"),
)
PICTURES: Final = 6
"""Of a clip, for Table 3."""
BORDERLINE: Final = 1.02
"""A ratio of single runs or pictures up to this far from 1 says nothing."""


def measure(bench: Bench, clock: Clock) -> Section:
    """See the file."""
    bench.say("the paper's tables 1 and 2")
    missing: list[str] = []
    ours = list(_renders(bench, clock, missing))
    bench.say("DV/BV by pixels and statistics")
    rises = list(measured_rises(bench, clock, METHODS, missing))
    bench.say("the paper's table 3")
    sets = {name: rows for name, rows in _sets(bench, missing).items() if rows}
    compared = {name: measured(methods(), samples) for name, samples in sets.items()}
    if find_lpips(None) is None:
        missing.append(f"LPIPS: {no_lpips('vesselsplat/lpips in the user cache folder')}")
    return Section(
        title="The paper's tables",
        sentences=(
            "DV and BV by the inferred definition: variances of grey above and below each image's own Otsu "
            "threshold; unless stated otherwise, over the evaluated pixels, of frames enhanced with "
            "statistics of tissue. Their ratio does not consider vessels: it falls where bright tissue is "
            "spread more than dark tissue, though vessels may stand out more, and it depends on the pixels "
            "and statistics used, which the paper does not state. Renders are of "
            f"{measured_frames(bench.clip)}, after fewer steps than published.",
            f"LPIPS: {LPIPS}.",
            *_reading_of_rises(rises),
            *_reading_of_renders(ours),
            *_reading_of_methods(compared),
        ),
        tables=(
            Table(
                title="Tables 1 and 2: renders from original and enhanced frames",
                columns=HEADS,
                rows=(*(tuple(one.values()) for one in ours), *_published()),
                note="The paper's rows are of its own clips. PSNR and SSIM are against the frames that a "
                "run was trained on. Visibility only, neither detection nor diagnosis.",
            ),
            table_of_rises(rises, bench.clip),
            *(_table_3(name, len(sets[name]), rows) for name, rows in compared.items()),
            Table(
                title="Table 3 as published",
                columns=tuple(Column(name) for name in ("dataset", "method", "DV", "BV", "DV/BV")),
                rows=TABLE_3,
            ),
        ),
        not_measured=tuple(missing),
    )  # fmt: skip


def _renders(bench: Bench, clock: Clock, missing: list[str]) -> Iterator[dict[str, Cell]]:
    if bench.why_untrained is not None:
        missing.append(f"renders of Tables 1 and 2: {bench.why_untrained}")
        return
    for method, name in METHODS.items():
        for kind in INPUTS:
            if clock.is_out:
                missing.append(f"{name}, {kind} frames: no time left")
                continue
            try:
                trained = bench.runs.trained(schedule(bench.clip, method), kind)
            except TrainingError as error:
                missing.append(f"{name}, {kind} frames: {error}")
                continue
            evaluation = open_evaluation(trained.folder.path)
            frames = list(evaluation.frames())
            found = evaluation.report(frames)
            mean, seen = found["mean"], found["visibility"]
            gain = _noise_gain(bench, trained.clip.read_image, evaluation.indices)
            yield {
                "clip": bench.clip.name, "table": "here", "method": name, "photos": kind,
                "lpips": mean["lpips"], "dv": mean["dv"], "bv": mean["bv"], "dv_bv": mean["dv_bv"],
                "contrast": seen["vessel_contrast"], "psnr": mean["psnr"], "ssim": mean["ssim"],
                "saturated": seen["saturated_share"], "noise": gain,
            }  # fmt: skip


def _noise_gain(bench: Bench, read: Any, indices: Sequence[int]) -> float | None:
    frames = map(bench.clip.read_frame, indices)
    return mean_of_finite(
        noise_gain(read(frame.index), bench.clip.read_image(frame.index), tissue_mask=frame.evaluation_mask)
        for frame in frames
    )


def _published() -> Iterator[tuple[Cell, ...]]:
    for one in (*PAPER, *SCARED):
        yield (
            *(one.clip, f"Table {one.table}", one.method, one.input),
            *(one.lpips, one.dv, one.bv, one.dv_bv, None, None, None, None, None),
        )


def _reading_of_renders(ours: Sequence[Mapping[str, Cell]]) -> Iterator[str]:
    """What of Tables 1 and 2 holds here, from the figures."""
    by = {(one["method"], one["photos"]): one for one in ours}
    for name in METHODS.values():
        before, after = by.get((name, "original")), by.get((name, "enhanced"))
        if before is None or after is None:
            continue
        contrast = _ratio(after["contrast"], before["contrast"])
        parts = f"DV {_ratio(after['dv'], before['dv']):.2f}, BV {_ratio(after['bv'], before['bv']):.2f}"
        moves = _by(contrast, "rises", "falls", "stays")
        seen = "" if math.isnan(contrast) else f" Vessel contrast is {contrast:.2f} times: it {moves}."
        noise = after["noise"]
        louder = f" Noise of the enhanced frames is {noise:.2f} times." if isinstance(noise, float) else ""
        yield (
            f"{name}, one seed, from enhanced instead of original frames, over the evaluated pixels: {parts} "
            f"times.{seen}{louder}"
        )


def _reading_of_rises(rises: Sequence[Rise]) -> Iterator[str]:
    """For each kind of picture, by pixels and statistics."""
    for what in dict.fromkeys(one.what for one in rises):
        told = [
            f"{np.mean(one.gains):.2f} over {one.pixels} with statistics of {one.statistics}"
            + ("" if what == FRAMES else f" ({verdict(one.gains)})")
            for one in rises
            if one.what == what and one.gains
        ]
        yield f"DV/BV of {what if what == FRAMES else f'renders by {what}'}, enhanced against original: " + (
            f"{'; '.join(told)}."
        )


def _reading_of_methods(compared: Mapping[str, Mapping[str, np.ndarray]]) -> Iterator[str]:
    for name, rows in compared.items():
        seen = {label: dict(zip(COLUMNS, values.tolist(), strict=True)) for label, values in rows.items()}
        _, shown, below = pattern({label: measures["DV/BV"] for label, measures in seen.items()})
        gain, dv, bv = (seen["paper"][one] / seen["original"][one] for one in ("DV/BV", "DV", "BV"))
        holds = _by(gain, "holds", "does not hold", "not distinguishable from none")
        yield (
            f"Table 3 on {name}: DV/BV of the paper's method is {gain:.2f} times the original's (DV "
            f"{dv:.2f}, BV {bv:.2f}): the rise {holds}. Paper and original above Wang, as printed: "
            f"{'yes' if shown else 'no'}. Stand-ins for Tao below Wang, as printed: {below} of "
            f"{len(TAO_STAND_INS)}. Vessel contrast is highest by "
            f"{max(seen, key=lambda label: seen[label]['Weber'])}."
        )


def _ratio(after: Cell, before: Cell) -> float:
    return float(after) / float(before) if after is not None and before else float("nan")


def _by(gain: float, more: str, less: str, same: str) -> str:
    """The word for a ratio."""
    return more if gain > BORDERLINE else less if gain < 1 / BORDERLINE else same


def _table_3(name: str, count: int, rows: Mapping[str, np.ndarray]) -> Table:
    heads = ("DV", "BV", "DV/BV", "DV/BV, whole image", "DV, local", "BV, local", "DV/BV, local",
             "vessel contrast", "CNR", "colour difference, CIEDE2000", "saturated %", "noise gain",
             "noise gain of colours", "blackened %", "ms")  # fmt: skip
    return Table(
        title=f"Table 3: methods of enhancement on {name}",
        columns=(Column("method"), *map(Column, heads)),
        # The original takes no time.
        rows=tuple(
            (label, *values[:-1].tolist(), None if label == "original" else float(values[-1]))
            for label, values in rows.items()
        ),
        note=f"Means over {count} images; the time is the median, the methods taking turns.",
    )


def _sets(bench: Bench, missing: list[str]) -> dict[str, list[Sample]]:
    sets: dict[str, list[Sample]] = {}
    if bench.given is None:
        sets["the phantom, whose vessels are known"] = list(of_phantom(PICTURES))
    else:
        sets[bench.clip.name] = list(of_clip(bench.given, PICTURES))
    for path, name in bench.scene_names.items():
        try:
            sets[name] = list(of_clip(path, PICTURES))
        except ClipError as error:
            missing.append(f"Table 3, {name}: {str(error).split(':')[0]}")
    return sets
