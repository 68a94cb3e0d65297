"""`vesselsplat [gui] [PATH ...]`: the app."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from app.console.flags import add_fields, parameters
from app.console.startup import has_display, take_turns_where_needed
from app.errors import UserError
from app.live.igtl.endpoint import PORT
from app.live.sources.device import ask_permission, devices_for
from app.live.start import LiveStart, start_of
from renderer.readers.clip_options import EVERY_OPTION, ClipOptions, Stereo


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "paths",
        metavar="CLIP|IMAGE|VIDEO|RUN|SPLATFILE",
        nargs="*",
        type=Path,
        help="what to open, the first of several",
    )
    parser.add_argument("--live", metavar="SOURCE", help="show a live source, as in `vesselsplat live`")
    parser.add_argument(
        "--right", metavar="SOURCE", help="with --live: source of the right eye, as in `vesselsplat live`"
    )
    parser.add_argument(
        "--igtl",
        metavar="PORT|HOST:PORT",
        nargs="?",
        const=str(PORT),
        help="send the live source to 3D Slicer, as in `vesselsplat live`",
    )
    add_fields(parser, ClipOptions, EVERY_OPTION)


def run(flags: argparse.Namespace) -> None:
    if missing := next((path for path in flags.paths if not path.exists()), None):
        raise UserError(
            f"expected a clip, image, video, run or splat file, got no such file or folder: {missing}"
        )
    if flags.paths and flags.live is not None:
        raise UserError(f"expected a path or --live, got both: {flags.paths[0]} and {flags.live}")
    options = parameters(ClipOptions, flags)
    live = _start(flags, options.stereo)
    if not has_display():
        raise UserError("the app needs a display: neither DISPLAY nor WAYLAND_DISPLAY is set")
    try:
        from app.gui.window import run_app
    except ImportError as error:
        if sys.platform == "win32" and "DLL load failed" in str(error):
            raise UserError(
                f"the app needs Microsoft's Visual C++ Redistributable, see README ({error})"
            ) from error
        raise
    take_turns_where_needed()
    run_app(tuple(map(_plain, flags.paths)), options, live)


def _plain(path: Path) -> Path:
    """Absolute and without `..`, which leads elsewhere behind a link; a link itself keeps its name."""
    return path.resolve() if ".." in path.parts else path.absolute()


def _start(flags: argparse.Namespace, stereo: Stereo) -> LiveStart | None:
    if flags.live is None:
        if flags.igtl is not None:
            raise UserError("--igtl sends a live source: expected --live SOURCE with it, got none")
        if flags.right is not None:
            raise UserError(
                f"expected --live with --right, got no source of the left eye beside {flags.right}"
            )
        return None
    known = devices_for(flags.live, flags.right)
    start = start_of(flags.live, flags.right, stereo, flags.igtl, known)
    ask_permission(start.source)
    return start
