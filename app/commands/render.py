"""`vesselsplat render RUN|SPLATFILE --out DIR`: images of a model, each with its provenance."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import Final

from app.commands import view_flags, view_selection
from app.commands.outside import require_outside
from app.console.older_files import say_older
from app.console.progress import progress
from app.errors import UserError
from app.exports.make import make
from app.exports.records import Depth, Export, Render
from app.exports.sources import Opened
from app.files.atomic import filled
from app.files.records import extended
from app.files.stepping import run_to_end
from app.scenes.depth_steps import step_of
from app.scenes.renderers import drawer
from app.scenes.view_kinds import SHAPES, has_scale
from app.scenes.view_request import view_record
from renderer.listing import count

DEPTHS: Final = {"npy": "-depth.npy", "tiff": "-depth.tiff", "png16": "-depth16.png"}
"""How the files of depth end, by format."""


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder to write into")
    view_selection.add_flags(parser)
    parser.add_argument(
        "--transparent",
        action="store_true",
        help="transparent where nothing was observed: straight alpha in the PNG, not premultiplied",
    )
    view_flags.add_flag(parser)
    parser.add_argument(
        "--depth", action="store_true", help="also write expected depth, as numbers and in colours"
    )
    parser.add_argument(
        "--depth-format",
        choices=DEPTHS,
        help="of these numbers: float32, or png16: whole steps, the same for all frames and stated in each "
        "file (default npy)",
    )


def run(flags: argparse.Namespace) -> None:
    if flags.transparent and has_scale(flags.view):
        raise UserError(f"--transparent: expected a --view without a scale, got {flags.view}")
    if flags.depth and SHAPES[flags.view] != "soft":
        raise UserError(f"--depth: expected a --view of unaltered Gaussians, got {flags.view}")
    if flags.depth_format and not flags.depth:
        raise UserError(f"--depth-format {flags.depth_format}: expected --depth with it")
    if flags.transparent and flags.background != "grey":
        raise UserError(f"--background {flags.background}: expected none with --transparent")
    if flags.frames_per_second is not None and flags.path is None:
        raise UserError("--frames-per-second: expected --path with it, which images are rendered along")
    scene, wanted = view_selection.chosen(flags)
    require_outside("--out", flags.out, scene)
    form = flags.depth_format or "npy"
    pen = drawer(flags.renderer)
    views = view_flags.asked_for(flags, scene, wanted)
    sources = Opened(tuple(views), pen=pen)
    written: list[str] = []
    with filled(flags.out) as staging, progress("render", len(wanted)) as report:
        for done, (moment, view) in enumerate(zip(wanted, views, strict=True), start=1):
            said = replace(view_record(view, pen.name), frame=moment.frame)
            said = replace(said, background=None) if flags.transparent else said
            records: dict[str, Export] = {".png": extended(Render, said)}
            if flags.depth:
                step = step_of(scene.distance) if form == "png16" else None
                numbers = extended(Depth, said, step=step)
                records |= {DEPTHS[form]: numbers, "-depth.png": extended(Depth, said)}
            for ending, record in records.items():
                written.append(f"{moment.name}{ending}")
                run_to_end(make(record, sources, staging / written[-1]))
            report(done, moment.name)
    say_older(flags.out, written)
    sys.stdout.write(f"{flags.out}: {count(len(wanted), 'image')} rendered with {pen.name}\n")
