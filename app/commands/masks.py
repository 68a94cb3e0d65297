"""`vesselsplat masks CLIP --out DIR`: masks of the tools in a clip, to look at, to mend and to train with."""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict
from pathlib import Path

from app.console.flags import add_fields, parameters
from app.console.progress import progress
from app.files.atomic import filled
from app.files.provenance import provenance, strict_json
from app.runs.making_masks import MaskReport, drawn_in, make_masks
from renderer.readers.clip_options import ClipOptions
from renderer.sources import open_bare

SHOWN = 5
"""Frames that should be looked at, of those that are named."""


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("clip", metavar="CLIP", type=Path, help="folder of a clip, or a video, see README")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder to write into")
    parser.add_argument(
        "--given",
        type=Path,
        metavar="DIR",
        help="masks of some frames, drawn by hand, not black = tool: those of all other frames are learned "
        "from them (default: tools are found by their colour)",
    )
    add_fields(parser, ClipOptions, ("frame_step", "deinterlacing", "stereo"))
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")


def run(flags: argparse.Namespace) -> None:
    clip = open_bare(flags.clip, parameters(ClipOptions, flags))
    by_hand = {} if flags.given is None else drawn_in(clip, flags.given)
    told: MaskReport | None = None
    with filled(flags.out) as staging, progress("masks", len(clip)) as report:
        for told in make_masks(clip, staging, by_hand):
            report(told.done, "")
    assert told is not None
    if flags.json:
        found = {name: value for name, value in asdict(told).items() if name != "done"}
        sys.stdout.write(strict_json(provenance(clip=clip.name, **found)) + "\n")
    else:
        sys.stdout.write(f"{flags.out}: {_said(told)}\n")


def _said(told: MaskReport) -> str:
    parts = [f"{told.done} masks, tools in {told.with_tools}, {told.share:.0%} of the pixels"]
    if told.given:
        parts.append(f"{told.given} by hand, the others learned from them")
    if told.held_out is not None:
        parts.append(f"IoU {told.held_out:.2f} on masks by hand that were left out of the learning")
    if told.agreement is not None:
        parts.append(f"neighbours agree to IoU {told.agreement:.2f}")
    if told.weak:
        more = f" and {len(told.weak) - SHOWN} more" if len(told.weak) > SHOWN else ""
        parts.append(f"look at {', '.join(told.weak[:SHOWN])}{more}")
    return "; ".join(parts)
