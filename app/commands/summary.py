"""`vesselsplat summary PAGE.html IMAGE ...`: saved images with their measures and notes, to print."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from datetime import date
from pathlib import Path

from app.errors import UserError
from app.exports.exporting import UNTITLED, Summary
from app.exports.make import make
from app.exports.sources import Opened
from app.files.atomic import filled
from app.files.stepping import run_to_end


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("page", metavar="PAGE.html", type=Path, help="the file to write, for any browser")
    parser.add_argument(
        "images", metavar="IMAGE", type=Path, nargs="+", help="PNG or JPEG files that VesselSplat saved"
    )
    parser.add_argument("--title", default=UNTITLED, help=f"the heading (default: {UNTITLED})")
    parser.add_argument("--notes", default="", metavar="TEXT", help="above the images")
    parser.add_argument(
        "--note",
        action="append",
        default=[],
        metavar="TEXT",
        help="below an image; repeat it for each, in their order",
    )


def run(flags: argparse.Namespace) -> None:
    if flags.page.suffix.lower() != ".html":
        raise UserError(f"expected the name of an .html file, got {flags.page.name or flags.page}")
    notes: Sequence[str] = flags.note
    if len(notes) > len(flags.images):
        raise UserError(f"expected at most a --note per image, got {len(notes)} for {len(flags.images)}")
    paths: Sequence[Path] = flags.images
    if missing := next((path for path in paths if not path.exists()), None):
        raise UserError(f"expected an image that VesselSplat saved, got no such file: {missing}")
    pictures = tuple(zip(paths, (*notes, *[""] * (len(paths) - len(notes))), strict=True))
    wanted = Summary(flags.title, date.today().isoformat(), flags.notes, pictures)
    with filled(flags.page.parent) as staging:
        run_to_end(make(wanted.record(), Opened(files=wanted.files), staging / flags.page.name))
    sys.stdout.write(f"{flags.page}\n")
