"""`vesselsplat render RUN|SPLATFILE --out DIR`: images of a model, each with its provenance."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from app.commands import view_flags
from app.console.progress import progress
from app.errors import UserError
from app.files.atomic import filled
from app.files.image_files import write_image
from app.files.provenance import repeatable, write_png
from app.scenes import view_selection
from app.scenes.color_bar import with_bar
from app.scenes.cpu_rendering import Drawn, colored_depth
from app.scenes.renderers import drawer
from app.scenes.view_kinds import SHAPES, has_scale
from app.scenes.view_request import view_facts
from app.scenes.view_selection import Moment


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder to write into")
    view_selection.add_flags(parser)
    parser.add_argument(
        "--transparent",
        action="store_true",
        help="transparent background: straight alpha in the PNG, not premultiplied",
    )
    view_flags.add_flag(parser)
    parser.add_argument(
        "--depth", action="store_true", help="also write expected depth, as float32 and in colours"
    )


def run(flags: argparse.Namespace) -> None:
    if flags.transparent and has_scale(flags.view):
        raise UserError(f"--transparent: expected a --view without a scale, got {flags.view}")
    if flags.depth and SHAPES[flags.view] != "soft":
        raise UserError(f"--depth: expected a --view of unaltered Gaussians, got {flags.view}")
    scene, wanted = view_selection.chosen(flags)
    draw, name = drawer(flags.renderer)
    views = view_flags.asked_for(flags, scene, wanted)
    behind = {"background": None} if flags.transparent else {}
    with filled(flags.out) as staging, progress("render", len(wanted)) as report:
        for done, (moment, view) in enumerate(zip(wanted, views, strict=True), start=1):
            drawn = view.drawn(draw)
            shown = drawn.straight if flags.transparent else with_bar(view.composed(drawn))
            facts = view_facts(view, name) | moment.facts | behind
            write_png(staging / f"{moment.name}.png", shown, repeatable(kind="render", **facts))
            if flags.depth:
                _write_depth(staging, moment, drawn, facts)
            report(done, moment.name)
    sys.stdout.write(f"{flags.out}: {len(wanted)} images rendered with {name}\n")


def _write_depth(folder: Path, moment: Moment, drawn: Drawn, facts: dict[str, Any]) -> None:
    picture, (nearest, farthest) = colored_depth(drawn.depth)
    shown = {"shows": "expected depth", "nearest": nearest, "farthest": farthest}
    depth_facts = repeatable(kind="depth", **facts, holds="expected depth in scene units, 0 where nothing is")
    write_image(folder / f"{moment.name}-depth.npy", drawn.depth, depth_facts)
    write_png(folder / f"{moment.name}-depth.png", picture, repeatable(kind="depth", **facts, **shown))
