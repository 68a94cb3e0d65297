"""`vesselsplat phantom OUT`: a synthetic clip with exact ground truth."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from app.console.flags import parameters
from renderer.phantom import PhantomParams, write_phantom

SPELLED = {"n_frames": "--frames", "width": "--size", "height": "--size"}


def add_flags(parser: argparse.ArgumentParser) -> None:
    suppressed = argparse.SUPPRESS
    parser.add_argument("out", metavar="OUT", type=Path, help="new folder for the clip")
    parser.add_argument("--frames", dest="n_frames", metavar="N", default=suppressed, help="default 24")
    parser.add_argument("--size", nargs=2, metavar=("W", "H"), help="pixels, default 320 256")
    parser.add_argument("--seed", metavar="S", default=suppressed, help="default 0")
    parser.add_argument("--camera", metavar="fixed|moving", default=suppressed, help="default fixed")
    parser.add_argument("--tissue", metavar="moving|static", default=suppressed, help="default moving")
    parser.add_argument(
        "--format", choices=("endonerf", "scared"), default="endonerf", help="layout, default endonerf"
    )


def run(flags: argparse.Namespace) -> None:
    if flags.size:
        flags.width, flags.height = flags.size
    params = parameters(PhantomParams, flags, SPELLED)
    write_phantom(flags.out, params, flags.format)
    size = f"{params.width}x{params.height}"
    sys.stdout.write(f"{flags.out}: {params.n_frames} frames, {size}, {flags.format} layout\n")
