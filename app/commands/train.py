"""`vesselsplat train CLIP --run RUN`: a clip becomes dynamic 3D Gaussians in a run folder."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Generator, Sequence
from contextlib import ExitStack, closing
from functools import partial
from pathlib import Path
from typing import Any, get_args

from app.commands.reading_flags import require_heeded
from app.commands.train_flags import requested
from app.console.ending import noted
from app.console.flags import add_fields
from app.console.progress import SECONDS_BETWEEN_STAGE_LINES, Stages
from app.files.provenance import provenance, strict_json
from app.runs.device import Asked, Device
from app.runs.memory import told
from app.runs.run_folder import Input, RunFolder
from app.runs.train_run import PRESETS, TrainRequest, device_of, run_training
from app.runs.wall_clock import STEPS, WALL, in_all
from renderer.readers.clip_options import EVERY_OPTION, ClipOptions
from renderer.train.config import TrainConfig
from renderer.train.events import (
    Evaluated,
    Finished,
    Finishing,
    Omission,
    Planned,
    Preparing,
    Progress,
    Started,
    TrainEvent,
    Warned,
)


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "clip",
        metavar="CLIP",
        type=Path,
        help="folder of a clip, or a video: `vesselsplat info CLIP` says as what it is read",
    )
    parser.add_argument("--run", type=Path, required=True, metavar="RUN", help="folder of the run to write")
    add_fields(parser, TrainConfig, ("method",))
    parser.add_argument(
        "--input",
        choices=get_args(Input),
        help="reconstruct the original or the enhanced frames (default original)",
    )
    parser.add_argument(
        "--preset",
        choices=tuple(PRESETS),
        default=argparse.SUPPRESS,
        help="with --input enhanced: the paper's method (default), or VesselSplat's preset `vessel`",
    )
    add_fields(parser, TrainConfig, ("iterations", "seed", "window_frames", "sh_degree", "keep", "leave_out"))
    add_fields(parser, ClipOptions, EVERY_OPTION)
    parser.add_argument(
        "--frames",
        nargs="+",
        metavar="I|A:B",
        help="train on these frames only, from 0: 10:59, or numbers that follow one another",
    )
    parser.add_argument(
        "--text-box",
        type=float,
        nargs=4,
        metavar=("LEFT", "TOP", "RIGHT", "BOTTOM"),
        help="pixels to leave out, such as burned-in text",
    )
    parser.add_argument(
        "--view-circle",
        type=float,
        nargs=3,
        metavar=("X", "Y", "RADIUS"),
        help="pixels outside are left out, such as the surround of a round view",
    )
    parser.add_argument(
        "--tool-masks",
        type=Path,
        metavar="DIR",
        help="images that mask tools, not black = tool, named or numbered as the frames; the run keeps "
        "copies, frames without one are searched (vesselsplat masks writes such a folder); "
        "with --calibration those of undistorted frames",
    )
    parser.add_argument(
        "--device",
        choices=get_args(Asked),
        default="auto",
        help="what to train on: auto uses an NVIDIA GPU where gsplat can, else the CPU (default auto)",
    )
    parser.add_argument(
        "--resume",
        action="store_true",
        help="resume the run in RUN from its last checkpoint, with its settings",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")


def run(flags: argparse.Namespace) -> None:
    run_folder = RunFolder(flags.run)
    is_done = flags.resume and run_folder.is_finished
    request = requested(flags)
    require_heeded(flags, flags.clip, request.clip_options)
    device = device_of(request)
    try:
        finished = follow(request, device.device)
    except KeyboardInterrupt as interrupt:
        raise KeyboardInterrupt(f"interrupted; {_kept(run_folder)}") from interrupt
    if is_done:
        sys.stderr.write(f"the run is finished already, there is nothing left to train: {flags.run}\n")
    summary: dict[str, Any] = {
        "run": flags.run.absolute().name,
        "iterations": finished.iteration,
        "train_seconds": finished.seconds,
        "wall_seconds": finished.wall_seconds,
        "n_gaussians": len(finished.model),
        "device": device.device,
        "enhancement": run_folder.record().enhancement,
        "omitted": run_folder.omitted(),
        "definitions": {"train_seconds": STEPS, "wall_seconds": WALL},
    }
    if flags.json:
        facts = provenance(config=request.config, input=request.input, **summary)
        sys.stdout.write(strict_json(facts) + "\n")
    else:
        took = in_all(finished.wall_seconds, finished.seconds)
        done = f"{finished.iteration} iterations on {device.device} ({device.why}), {took}"
        sys.stdout.write(f"{flags.run}: {len(finished.model)} Gaussians, {done}\n")
        sys.stdout.write(_table(summary["omitted"]))


def _table(omissions: Sequence[Omission]) -> str:
    """What was left out, why, and what that saves, in columns; empty when nothing was."""
    if not omissions:
        return ""
    rows = [("left out", "why", "saves"), *((each.what, each.why, each.saves) for each in omissions)]
    first, second, _ = (max(len(cell) for cell in column) for column in zip(*rows, strict=True))
    return "".join(f"{what:{first}}  {why:{second}}  {saves}\n" for what, why, saves in rows)


def _kept(folder: RunFolder) -> str:
    """What an interruption leaves, and what to do with it."""
    if folder.has_checkpoint:
        return f"the last checkpoint in {folder.path} is kept, --resume continues from it"
    if folder.is_run:
        return f"there is no checkpoint in {folder.path} yet, --resume starts over"
    return "nothing is kept yet, the same command starts over"


def _to_a_whole_step(events: Generator[TrainEvent, None, None]) -> Generator[TrainEvent, None, None]:
    """The same events. A signal that comes while steps are taken ends them after the present one, and those
    that are done are kept; a second one ends them at once."""

    def none_has() -> bool:
        return False

    has_come: Callable[[], bool] = none_has
    with ExitStack() as steps, closing(events):
        for event in events:
            if isinstance(event, Started):
                has_come = steps.enter_context(noted(most=1))
            elif isinstance(event, Finishing):
                steps.close()
                has_come = none_has
            yield event
            if has_come():
                return


def follow(request: TrainRequest, device: Device) -> Finished:
    """Train with progress on stderr, of what comes before it too."""
    finished: Finished | None = None
    done = 0
    with Stages() as shown:
        title = f"train {request.input} on {device}"
        training = partial(shown.of, title, request.config.iterations)
        for event in _to_a_whole_step(run_training(request)):
            match event:
                case Preparing():
                    report = shown.of(event.stage, event.total, SECONDS_BETWEEN_STAGE_LINES)
                    report(event.done, "" if event.total else f"{event.seconds:.0f} s so far")
                case Planned():
                    sys.stderr.write(f"{told(event)}\n")
                case Started():
                    training = partial(shown.of, title, event.iterations)
                    training()
                case Progress():
                    done = event.iteration
                    training()(event.iteration, f"loss {event.loss:.4f} PSNR {event.psnr:.2f} dB")
                case Evaluated():
                    training()(event.iteration, f"held-out PSNR {event.psnr:.2f} dB")
                case Finishing():
                    training()(done, event.stage)
                case Warned():
                    sys.stderr.write(f"{event.message}\n")
                case Finished():
                    finished = event
    assert finished is not None
    return finished
