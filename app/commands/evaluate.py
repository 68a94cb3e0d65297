"""`vesselsplat evaluate RUN`: the numbers of a finished run on its held-out frames."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table

from app.console.progress import LABEL, fitting, progress, wide_terminal
from app.errors import UserError
from app.evaluation.evaluate import LPIPS, Evaluation, FrameMeasures, lpips_folder, no_lpips, open_evaluation
from app.files.provenance import provenance, strict_json
from app.report.paper_rows import PAPER
from app.runs.run_folder import ClipRecord
from app.runs.wall_clock import in_all
from renderer.lpips import WEIGHT_FILES
from renderer.readers.clip_options import ClipOptions

COLUMNS = {
    "psnr": ("PSNR\ndB", ".2f"),
    "psnr_masked": ("masked\ndB", ".2f"),
    "ssim": ("SSIM\n", ".4f"),
    "lpips": ("LPIPS\n", ".4f"),
    "depth_rmse_mm": ("depth\nmm", ".3f"),
    "abs_rel": ("depth\nrel %", ".2%"),
    "dv": ("DV\ngrey²", ".1f"),
    "bv": ("BV\ngrey²", ".1f"),
    "dv_bv": ("DV/BV\n", ".3f"),
    "ms_per_frame": ("time\nms", ".1f"),
}
"""Heading with unit, and format, of each column."""
COMPARED = ("lpips", "dv", "bv", "dv_bv", "psnr", "ssim", "depth_rmse_mm")


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", metavar="RUN", type=Path, help="folder of a finished run")
    parser.add_argument(
        "--against",
        type=Path,
        metavar="RUN",
        help="another run of the same clip to compare with, such as one from original frames",
    )
    parser.add_argument("--edited", action="store_true", help="measure the edited model, not the trained one")
    parser.add_argument("--lpips-weights", type=Path, metavar="DIR", help=f"folder with {WEIGHT_FILES}")
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")


def run(flags: argparse.Namespace) -> None:
    paths = [flags.run] if flags.against is None else [flags.run, flags.against]
    evaluations = [open_evaluation(path, flags.lpips_weights, edited=flags.edited) for path in paths]
    clips = [evaluation.record.clip for evaluation in evaluations]
    if _reading(evaluations[0]) != _reading(evaluations[-1]):
        raise UserError("--against: expected a run on frames that were read in the same way, got others")
    # Each run keeps its own copies of masks: where they lie is no part.
    if clips[0].part.of_anywhere != clips[-1].part.of_anywhere:
        raise UserError("--against: expected a run on the same frames and mask, got one on another part")
    if clips[0].sha256 != clips[-1].sha256:
        raise UserError(f"--against: expected a run on the clip {clips[0].name}, got one on {clips[-1].name}")
    if not _over_the_same_pixels(evaluations[0], evaluations[-1]):
        first, second = (_masks(clip.options) for clip in clips)
        raise UserError(
            f"--against: expected a run evaluated over the pixels of {first}, got one of {second}"
        )
    report, *others = [evaluation.report(measured(evaluation)) for evaluation in evaluations]
    for other in others:
        report |= {"against": other, "compared": compared(report, other, clips[0])}
    if flags.json:
        sys.stdout.write(strict_json(provenance(**report)) + "\n")
    elif others:
        _print_compared(report)
    else:
        _print(report)


def _reading(evaluation: Evaluation) -> tuple[object, ...]:
    """What says which frames there are, how they look, and which of them are held out."""
    options = evaluation.record.clip.options
    of_video = (options.deinterlacing, options.stereo) if evaluation.clip.format == "video" else ()
    return options.frame_step, options.split, options.calibration, evaluation.clip.bits, *of_video


def _over_the_same_pixels(one: Evaluation, other: Evaluation) -> bool:
    """Whether the masks of all measured frames are equal, however they were asked for."""
    if one.record.clip.options == other.record.clip.options:
        return True
    return all(
        np.array_equal(
            one.clip.read_frame(index).evaluation_mask, other.clip.read_frame(index).evaluation_mask
        )
        for index in one.indices
    )


def _masks(options: ClipOptions) -> str:
    return f"--evaluation-masks {options.evaluation_masks} --mask-polarity {options.mask_polarity}"


def measured(evaluation: Evaluation) -> list[FrameMeasures]:
    """Every frame's measures, with progress on stderr."""
    frames = []
    with progress("evaluate", len(evaluation.indices)) as report:
        for frame in evaluation.frames():
            frames.append(frame)
            report(len(frames), f"PSNR {frame.psnr:.2f} dB")
    return frames


def compared(report: dict[str, Any], other: dict[str, Any], clip: ClipRecord) -> dict[str, Any]:
    """How the DV/BV of two runs of one clip relate, and what the paper prints for that clip."""
    pairs = {
        "render": (report["mean"], other["mean"]),
        "whole_picture": (report["whole_picture"], other["whole_picture"]),
        "input_photo": (report["input_photo"], other["input_photo"]),
    }
    paper = [row for row in PAPER if row.clip in clip.name and row.frames == clip.frames]
    return {
        "dv_bv_gain": {name: _gain(*(group["dv_bv"] for group in pair)) for name, pair in pairs.items()},
        "paper": paper,
        "paper_dv_bv_gain": {
            f"Table {after.table}, {after.method}": _gain(after.dv_bv, before.dv_bv)
            for before, after in zip(paper[::2], paper[1::2], strict=True)
        },
        "definition": "dv_bv_gain: mean DV/BV of this run divided by that of the run it is compared with; "
        "the paper's: enhanced over original",
    }


def _gain(ours: float | None, theirs: float | None) -> float | None:
    return ours / theirs if ours is not None and theirs else None


def _print(report: dict[str, Any]) -> None:
    frames = [
        [str(frame.index), *_texts(vars(frame) | (frame.depth or {}), COLUMNS)] for frame in report["frames"]
    ]
    mean = ["mean", *_texts(report["mean"] | report["depth"], COLUMNS)]
    title = f"{report['run']}: {report['method']}, measured against its {report['input']} frames"
    _say(_heading("frame", COLUMNS), [frames, [mean]], title, *_facts(report), *_cautions(report))


def _print_compared(report: dict[str, Any]) -> None:
    other, gain = report["against"], report["compared"]["dv_bv_gain"]
    frames = "training" if report["frames_are"] == "training" else "held-out"
    title = f"Means over the {frames} frames, each run against its own input frames"
    groups = [
        [[f"{each['run']}, {each['input']}", *_texts(each["mean"], COMPARED)] for each in (other, report)]
    ]
    for row in report["compared"]["paper"]:
        if row.input == "original":
            groups.append([])
        groups[-1].append([f"{row.method}, {row.input}", *_texts(vars(row), COMPARED)])
    gains = [
        f"DV/BV is {_text(gain['render'], '.2f')} times that of {other['run']}; "
        f"that of its input frames {_text(gain['input_photo'], '.2f')} times",
        f"over whole renders, including black, {_text(gain['whole_picture'], '.2f')} times: "
        + " to ".join(_text(each["whole_picture"]["dv_bv"], ".3f") for each in (other, report)),
    ]
    published = report["compared"]["paper_dv_bv_gain"].items()
    gains += [f"the paper's {where}: {_text(times, '.2f')} times" for where, times in published]
    seen = [f"{each['run']}: {_visibility(each['visibility'])}" for each in (other, report)]
    _say(_heading("run, frames", COMPARED), groups, title, *gains, *seen, *_cautions(report))


def _heading(first: str, names: Iterable[str]) -> list[str]:
    return [first, *(COLUMNS[name][0] for name in names)]


def _texts(values: Mapping[str, float | None], names: Iterable[str]) -> list[str]:
    # The unit is in the heading.
    return [_text(values.get(name), COLUMNS[name][1]).removesuffix(" %") for name in names]


def _text(value: float | None, form: str) -> str:
    return "-" if value is None or not math.isfinite(value) else format(value, form).replace("%", " %")


def _facts(report: dict[str, Any]) -> list[str]:
    mean, parts, memory = report["mean"], report["parts_ms"], report["peak_memory_mb"]
    timed = report["timed_with"]
    times = [f"{name.replace('_', ' + ')} {_text(ms, '.1f')}" for name, ms in parts.items()]
    return [
        f"{mean['n_gaussians']} Gaussians, trained in {in_all(mean['wall_seconds'], mean['train_seconds'])}",
        f"masked: over the evaluated pixels only, {_text(report['evaluated_share'], '.1%')} of the image",
        f"all tissue, with measured depth or without: {_text(mean['psnr_tissue'], '.2f')} dB, "
        f"{_text(mean['coverage'], '.1%')} covered,",
        f"  seldom seen: {_text(mean['psnr_seldom'], '.2f')} dB",
        "depth: RMS error, and mean of error divided by depth,",
        f"  over {_text(report['depth'].get('covered'), '.1%')} of the evaluated pixels that have depth",
        f"time: {', '.join(times)} ms,",
        f"  on {timed['threads']} threads of the CPU at a load of {_text(timed['load'], '.1f')}",
        f"peak memory: training {_text(memory['training'], '.0f')} MB, "
        f"this evaluation {_text(memory['evaluation'], '.0f')} MB",
        f"render: {_visibility(report['visibility'])}",
        f"frame: {_visibility(report['input_photo'])}, DV/BV {_text(report['input_photo']['dv_bv'], '.3f')}",
    ]


def _visibility(group: Mapping[str, float | None]) -> str:
    contrast = _text(group["vessel_contrast"], ".3f")
    return f"vessel contrast {contrast}, saturated {_text(group['saturated_share'], '.2%')}"


def _cautions(report: dict[str, Any]) -> list[str]:
    cautions = ["DV, BV: inferred definition. Visibility only, neither detection nor diagnosis."]
    if report["definitions"]["lpips"] != LPIPS:
        cautions.append(f"LPIPS: {no_lpips(lpips_folder())}")
    if report["gains"]:
        cautions.append("Brightness pumps: the render is measured in the exposure of each frame.")
    if report["edits"]:
        measured = "as edited" if report["edits"]["measured"] else "as trained, without its edits (--edited)"
        cautions.append(f"the model is measured {measured}")
    if report["frames_are"] == "training":
        cautions.append("measured on training frames: the clip is too short for held-out frames")
    return cautions


def _say(head: Sequence[str], groups: Sequence[Sequence[Sequence[str]]], title: str, *lines: str) -> None:
    """Rows in groups under the title; below each other where they are too wide, each with its name."""
    console = wide_terminal()
    for columns in fitting([head, *chain.from_iterable(groups)], console.width, between=2):
        table = Table(
            title=title, title_justify="left", title_style="", box=SIMPLE_HEAD, padding=(0, 1, 0, 0)
        )
        table.pad_edge = False
        table.add_column(head[0], max_width=LABEL, overflow="fold")
        for place in columns:
            table.add_column(head[place], justify="right", no_wrap=True)
        for group in groups:
            for row in group:
                table.add_row(row[0], *(row[place] for place in columns))
            table.add_section()
        console.print(table)
    for line in lines:
        console.print(line)
