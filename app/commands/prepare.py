"""`vesselsplat prepare`: compile once what would otherwise be compiled at first use."""

from __future__ import annotations

import argparse
import sys
import time

from app.kernels.stamp import is_prepared


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--again", action="store_true", help="look at every step although all are done")


def run(flags: argparse.Namespace) -> None:
    if is_prepared() and not flags.again:
        sys.stdout.write("already prepared\n")
        return
    from app.kernels.progress import worded
    from app.kernels.steps import prepare

    began = time.monotonic()
    for now in prepare():
        if not now.is_ready:
            sys.stderr.write(f"{worded(now)}: {now.name}\n")
    sys.stdout.write(f"prepared in {time.monotonic() - began:.0f} s\n")
