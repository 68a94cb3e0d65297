"""`vesselsplat replay FILE`: an exported file reproduced from its provenance and compared."""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from app.errors import UserError
from app.exports.replay.again import replay
from app.files.atomic import filled
from app.files.provenance import provenance, strict_json


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file", metavar="FILE", type=Path, help="image, video or splat file written by VesselSplat"
    )
    parser.add_argument(
        "--source",
        type=Path,
        nargs="+",
        default=[],
        metavar="PATH",
        help="its source, or a folder with it (default: looked for beside FILE and in the current folder, "
        "runs also among those of the window)",
    )
    parser.add_argument("--out", type=Path, metavar="FILE", help="keep the reproduced file, by a new name")
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")


def run(flags: argparse.Namespace) -> None:
    for path in flags.source:
        if not path.exists():
            raise UserError(f"--source: expected a file or folder, got no such path: {path}")
    with _target(flags) as target:
        replayed = replay(flags.file, tuple(flags.source), target)
    if flags.json:
        found = {"file": flags.file.name, "identical": replayed.difference.is_none, "replayed": replayed}
        sys.stdout.write(strict_json(provenance(**found, sentence=replayed.sentence)) + "\n")
    if not replayed.difference.is_none:
        raise UserError(f"{flags.file}: {replayed.sentence}")
    if not flags.json:
        sys.stdout.write(f"{flags.file}: identical\n")


@contextmanager
def _target(flags: argparse.Namespace) -> Iterator[Path]:
    """Where the file is made again: in the place asked for, or in a folder that vanishes."""
    out: Path | None = flags.out
    if out is None:
        with tempfile.TemporaryDirectory(prefix="vesselsplat-") as folder:
            yield Path(folder) / flags.file.name
        return
    if out.suffix.lower() != flags.file.suffix.lower():
        raise UserError(f"--out: expected a new file named *{flags.file.suffix}, got {out}")
    _require_new(out)
    with filled(out.parent) as staging:
        yield staging / out.name
        for written in staging.iterdir():  # Some kinds write more than one file, such as their provenance.
            _require_new(out.parent / written.name)


def _require_new(path: Path) -> None:
    if os.path.lexists(path):
        raise UserError(f"--out: expected a new file, got one that exists: {path}")
