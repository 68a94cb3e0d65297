"""`vesselsplat [gui] [PATH]`: the app."""

from __future__ import annotations

import argparse
from pathlib import Path

from app.display import has_display
from app.errors import UserError


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("path", metavar="CLIP|IMAGE|VIDEO|RUN", nargs="?", type=Path, help="what to open")


def run(flags: argparse.Namespace) -> None:
    if flags.path is not None and not flags.path.exists():
        raise UserError(f"expected a clip, image, video or run, got no such file or folder: {flags.path}")
    if not has_display():
        raise UserError("the app needs a display: neither DISPLAY nor WAYLAND_DISPLAY is set")
    from app.gui.window import run_app

    run_app(flags.path)
