"""`vesselsplat evaluate RUN`: the numbers of a finished run on its held-out frames."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from rich.table import Table

from app.evaluate import AVERAGED, Evaluation, FrameMeasures, open_evaluation
from app.progress import progress
from app.provenance import provenance, strict_json
from app.terminal import table_terminal


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", metavar="RUN", type=Path, help="folder of a finished run")
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")


def run(flags: argparse.Namespace) -> None:
    evaluation = open_evaluation(flags.run)
    report = evaluation.report(measured(evaluation))
    if flags.json:
        sys.stdout.write(strict_json(provenance(**report)) + "\n")
    else:
        _print(report)


def measured(evaluation: Evaluation) -> list[FrameMeasures]:
    """Every frame's measures, with progress on stderr."""
    frames = []
    with progress("evaluate", len(evaluation.indices)) as report:
        for frame in evaluation.frames():
            frames.append(frame)
            report(len(frames), f"PSNR {frame.psnr:.2f} dB")
    return frames


def _print(report: dict[str, Any]) -> None:
    table = Table("frame", *AVERAGED, title=f"{report['run']}: {report['method']}, {report['input']} photos")
    for frame in report["frames"]:
        table.add_row(str(frame.index), *(_text(getattr(frame, name)) for name in AVERAGED))
    mean = report["mean"]
    table.add_section()
    table.add_row("mean", *(_text(mean[name]) for name in AVERAGED))
    console = table_terminal()
    console.print(table)
    console.print(f"{mean['n_gaussians']} Gaussians, trained in {_text(mean['train_seconds'])} s")
    if report["frames_are"] == "training":
        console.print("measured on training frames: the clip is too short to hold one out")
    console.print("dv, bv, dv_bv: inferred definition")


def _text(value: float | None) -> str:
    return "not measured" if value is None else f"{value:.4g}"
