"""`vesselsplat info [PATH]`: what a path is read as; or versions, devices and licences, quickly."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from app.files.provenance import strict_json
from app.runs.system_info import collect


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "path",
        metavar="PATH",
        nargs="?",
        type=Path,
        help="clip, image, video, run, splat file, session or exported file: what it is read as, what is "
        "missing, and what to do next (default: versions, devices and licences)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")


def run(flags: argparse.Namespace) -> None:
    if flags.path is not None:
        _describe(flags.path, as_json=flags.json)
        return
    facts = collect()
    if flags.json:
        sys.stdout.write(strict_json(facts) + "\n")
        return
    for name, value in facts.items():
        if isinstance(value, dict):
            text = ", ".join(f"{key} {item or 'not installed'}" for key, item in value.items())
        else:
            text = str(value)
        sys.stdout.write(f"{name.replace('_', ' '):<14}{text}\n")


def _describe(path: Path, *, as_json: bool) -> None:
    # Readers load OpenCV and more, which the versions alone do not need.
    from app.commands.described.fact import as_text, as_values
    from app.commands.described.paths import described

    facts = described(path)
    sys.stdout.write(strict_json(as_values(facts)) + "\n" if as_json else as_text(facts))
