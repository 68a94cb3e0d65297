"""`vesselsplat demo`: the whole product on the embedded phantom clip, and comparison sheets."""

from __future__ import annotations

import argparse
import shutil
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, get_args

import numpy as np

from app.commands.evaluate import measured
from app.commands.train import follow
from app.console.progress import progress
from app.console.startup import has_display, take_turns_where_needed
from app.enhancement.contact_sheet import Tile, sheet
from app.errors import UserError
from app.evaluation.evaluate import Evaluation, open_evaluation
from app.files.atomic import made, write_bytes
from app.files.provenance import NOTICE, provenance, strict_json, write_png
from app.files.records import Source
from app.runs.run_folder import Input, RunFolder
from app.runs.train_run import RECONSTRUCTION_PARAMS, TrainRequest, device_of, pooled
from app.runs.trained_clip import enhanced_clip
from app.scenes.cpu_rendering import colored_depth
from assets import phantom_path
from renderer.clip import ByteImage, Clip
from renderer.evenly import evenly
from renderer.rasterize.rendered import Rendered
from renderer.sources import open_clip
from renderer.train.config import TrainConfig

INPUTS: tuple[Input, ...] = get_args(Input)
CONFIG = TrainConfig(iterations=1000)
"""Enough to see what the method does within the minutes that a demo may take."""
STRIP_COLUMNS = 6
FOOT = f"Embedded phantom clip (synthetic). {NOTICE}"


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--headless", action="store_true", help="do not open the app when done")
    parser.add_argument(
        "--out", type=Path, default=Path("out/demo"), metavar="DIR", help="folder to write into (out/demo)"
    )


def run(flags: argparse.Namespace) -> None:
    out: Path = flags.out
    runs = {name: out / f"{name}-run" for name in INPUTS}
    with made(out):
        _clear(list(runs.values()))
        _make(out, runs)
    if has_display() and not flags.headless:
        _open(runs["enhanced"])


def _make(out: Path, runs: dict[Input, Path]) -> None:
    """All that is shown, in the folder `out`."""
    path = phantom_path()
    clip = open_clip(path)
    seconds: dict[str, float] = {}
    with _timed("enhance", seconds):
        _write_enhanced(out / "enhanced", clip)
    for name, run_path in runs.items():
        with _timed(f"train {name}", seconds):
            request = TrainRequest(clip_path=path, run_path=run_path, config=CONFIG, input=name)
            follow(request, device_of(request).device)
    evaluations = {name: open_evaluation(run_path) for name, run_path in runs.items()}
    with _timed("evaluate", seconds):
        reports = {name: evaluation.report(measured(evaluation)) for name, evaluation in evaluations.items()}
    with _timed("draw", seconds):
        facts = {"source": Source.of(path), "config": CONFIG, "params": RECONSTRUCTION_PARAMS}
        write_png(out / "compare.png", _compare(evaluations, reports), provenance(**facts))
        write_png(out / "strip.png", _strip(evaluations), provenance(**facts))
    report = provenance(**facts, seconds=seconds, total_seconds=sum(seconds.values()), runs=reports)
    write_bytes(out / "report.json", strict_json(report, indent=2).encode())
    sys.stdout.write(f"{out}: compare.png, strip.png, report.json in {sum(seconds.values()):.0f} s\n")


def _open(run: Path) -> None:
    """What has been made is there, also where no window can be."""
    from app.gui.window import run_app

    take_turns_where_needed()
    try:
        run_app((run,))
    except UserError as error:
        sys.stderr.write(f"{error}\n")


def _clear(runs: list[Path]) -> None:
    """Make room: the runs of an earlier demo go, anything else stays and is an error."""
    for path in runs:
        if RunFolder(path).is_run:
            shutil.rmtree(path)
        elif path.exists():
            raise UserError(f"expected a new folder or one of an earlier demo, got another: {path}")


@contextmanager
def _timed(name: str, seconds: dict[str, float]) -> Iterator[None]:
    began = time.perf_counter()
    yield
    seconds[name] = time.perf_counter() - began
    sys.stderr.write(f"{name}: {seconds[name]:.1f} s\n")


def _write_enhanced(folder: Path, clip: Clip) -> None:
    enhancement = pooled(clip, RECONSTRUCTION_PARAMS)
    clip = enhanced_clip(clip, enhancement)
    facts: dict[str, Any] = {"source": Source.of(clip.path), "enhancement": enhancement}
    with made(folder), progress("enhance", len(clip)) as report:
        for index in range(len(clip)):
            image, name = clip.read_image(index), f"frame-{index:06d}.png"
            write_png(folder / name, image, provenance(**facts, frame=index))
            report(index + 1, name)


def _compare(evaluations: dict[Input, Evaluation], reports: dict[Input, dict[str, Any]]) -> ByteImage:
    """A held-out frame, original and enhanced, the renders of both runs, depth."""
    original, enhanced = (evaluations[name] for name in INPUTS)
    index = original.indices[len(original.indices) // 2]
    drawn = {name: evaluation.drawn(index) for name, evaluation in evaluations.items()}
    depth, (near, far) = colored_depth(drawn["original"].depth)
    frames = {name: {one.index: one for one in report["frames"]} for name, report in reports.items()}
    psnr = {name: found[index].psnr for name, found in frames.items()}
    tiles = [
        Tile("Original", original.trained_clip.read_image(index)),
        Tile("Enhanced", enhanced.trained_clip.read_image(index)),
        Tile(f"Depth, {near:.0f} (yellow) to {far:.0f} {original.clip.unit}", depth),
        Tile(f"Render of original, PSNR {psnr['original']:.1f} dB", drawn["original"].bytes),
        Tile(f"Render of enhanced, PSNR {psnr['enhanced']:.1f} dB", drawn["enhanced"].bytes),
        Tile("Render against frame, difference x4", _difference(original, index, drawn["original"])),
    ]
    title = f"VesselSplat: held-out frame {index} after {CONFIG.iterations} iterations"
    return sheet(title, tiles, FOOT, columns=3, tile_width=480)


def _difference(evaluation: Evaluation, index: int, drawn: Rendered) -> ByteImage:
    """Absolute difference in grey levels times 4, black where a tool hides the tissue."""
    frame = evaluation.trained_clip.read_frame(index)
    apart = np.abs(drawn.bytes.astype(np.int16) - frame.image) * frame.evaluation_mask[..., None]
    return np.asarray(np.minimum(4 * apart, 255), dtype=np.uint8)


def _strip(evaluations: dict[Input, Evaluation]) -> ByteImage:
    """A few moments from left to right: frames above, renders of both runs below."""
    clip = evaluations["original"].clip
    indices = evenly(range(len(clip)), STRIP_COLUMNS)
    tiles = [Tile(f"Original, time {clip.times[index]:.2f}", clip.read_image(index)) for index in indices]
    for name, evaluation in evaluations.items():
        tiles += [Tile(f"Render of {name}", evaluation.drawn(index).bytes) for index in indices]
    title = "VesselSplat: the same tissue through time"
    return sheet(title, tiles, FOOT, columns=len(indices), tile_width=300)
