"""`vesselsplat masks CLIP --out DIR`: masks of the tools in a clip, to look at, to mend and to train with."""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path

from app.commands.reading_flags import require_heeded
from app.console.flags import add_fields, parameters
from app.console.older_files import say_older
from app.console.progress import progress
from app.errors import UserError
from app.files.atomic import filled
from app.files.provenance import provenance, strict_json
from app.runs.making_masks import MaskReport, make_masks
from renderer.clip import Clip
from renderer.listing import count, listed
from renderer.readers.clip_options import ClipOptions
from renderer.sources import open_bare
from renderer.tools.mask_files import NONE, MaskFiles, mask_names, masks_in, origin_of, own_masks
from renderer.tools.onnx_model import VALUES, OnnxError, OnnxTools
from renderer.tools.polarity import with_doubt


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "clip",
        metavar="CLIP",
        type=Path,
        help="folder of a clip, or a video: `vesselsplat info CLIP` says as what it is read",
    )
    parser.add_argument(
        "--out",
        type=Path,
        required=True,
        metavar="DIR",
        help="folder to write into; masks in it that were drawn or mended by hand stay, unless --given has "
        "one for their frame",
    )
    parser.add_argument(
        "--given",
        type=Path,
        metavar="DIR",
        help="masks of some frames, drawn by hand, not black = tool: those of all other frames are learned "
        "from them (default: tools are found by their colour)",
    )
    parser.add_argument(
        "--onnx",
        type=Path,
        metavar="FILE",
        help="a segmentation network of yours that finds the tools in all other frames; needs onnxruntime",
    )
    parser.add_argument(
        "--onnx-values",
        choices=VALUES,
        help="what it takes: RGB normalised by ImageNet's mean and deviation, RGB in [0, 1], or in [0, 255] "
        "(default imagenet)",
    )
    parser.add_argument(
        "--onnx-tools",
        type=int,
        nargs="+",
        default=[],
        metavar="CLASS",
        help="those of its classes, counted from 0, that are tools (default: all but the first)",
    )
    add_fields(parser, ClipOptions, ("frame_step", "deinterlacing", "stereo", "calibration"))
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")


def run(flags: argparse.Namespace) -> None:
    _check_out(flags)
    _check_onnx(flags)
    options = parameters(ClipOptions, flags)
    require_heeded(flags, flags.clip, options)
    clip = open_bare(flags.clip, options)
    by_hand = NONE if flags.given is None else with_doubt(masks_in(flags.given, clip.labels), clip)
    try:
        model = _network(flags) if flags.onnx else None
        told = _made(flags.out, clip, by_hand, model)
        say_older(flags.out, mask_names(clip.labels))
    except OnnxError as error:
        raise UserError(str(error)) from error
    weak = [clip.labels[index] for index in told.weak]
    if flags.json:
        found = {name: value for name, value in asdict(told).items() if name != "done"} | {"weak": weak}
        sys.stdout.write(strict_json(provenance(clip=clip.name, **found)) + "\n")
    else:
        sys.stdout.write(f"{flags.out}: {_said(told, weak, learned=model is None)}\n")


def _check_out(flags: argparse.Namespace) -> None:
    """Raises UserError: masks would lie among the clip's own files, or among those that they are learned
    from."""
    out = flags.out.resolve()
    if flags.clip.is_dir() and out.is_relative_to(flags.clip.resolve()):
        raise UserError(f"--out: expected a folder outside of the clip {flags.clip}, got {flags.out}")
    if flags.given is not None and out == flags.given.resolve():
        raise UserError(f"--out: expected another folder than --given, got {flags.out}")


def _check_onnx(flags: argparse.Namespace) -> None:
    """Raises UserError: what a network takes and finds is told, and no network given."""
    told = [name for name, is_told in (("tools", flags.onnx_tools), ("values", flags.onnx_values)) if is_told]
    if told and flags.onnx is None:
        raise UserError(f"--onnx-{told[0]}: expected --onnx FILE with it")


def _network(flags: argparse.Namespace) -> OnnxTools:
    """Raises OnnxError."""
    return OnnxTools.open(flags.onnx, flags.onnx_values or "imagenet", flags.onnx_tools)


def _made(folder: Path, clip: Clip, by_hand: MaskFiles, model: OnnxTools | None) -> MaskReport:
    told: MaskReport | None = None
    with filled(folder) as staging, progress("masks", len(clip)) as report:
        kept = _keep_drawn(folder, staging, clip, by_hand)
        for told in make_masks(clip, staging, by_hand, model):
            report(told.done, "")
    assert told is not None
    return replace(told, notices=(*told.notices, *kept))


def _keep_drawn(folder: Path, staging: Path, clip: Clip, by_hand: MaskFiles) -> tuple[str, ...]:
    """Masks in `folder` that a hand has drawn or mended stay, where --given has none; a notice of them."""
    files = own_masks(folder, clip.labels).files
    drawn = [
        path for index, path in files.items() if index not in by_hand.files and origin_of(path) == "by hand"
    ]
    for path in drawn:
        shutil.copy2(path, staging / path.name)
    return (f"kept as drawn by hand in {folder}: {listed([path.name for path in drawn])}",) if drawn else ()


def _said(told: MaskReport, weak: Sequence[str], *, learned: bool) -> str:
    share = f"{100 * told.share:.0f} % of the pixels"
    parts = [f"{count(told.done, 'mask')}, tools in {told.with_tools}, {share}"]
    if told.given:
        parts.append(f"{told.given} by hand, the others {'learned from them' if learned else 'by the model'}")
    if told.held_out is not None:
        parts.append(f"IoU {told.held_out:.2f} on masks by hand that were left out of the learning")
    if told.agreement is not None:
        parts.append(f"neighbours agree to IoU {told.agreement:.2f}")
    if weak:
        parts.append(f"look at {listed(weak)}")
    parts.extend(told.notices)
    return "; ".join(parts)
