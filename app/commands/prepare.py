"""`vesselsplat prepare`: compile once what would otherwise be compiled at first use."""

from __future__ import annotations

import argparse
import sys
import time
from typing import Final

from app.kernels.progress import Kind
from app.kernels.stamp import is_prepared

BESIDE: Final[tuple[Kind, ...]] = ("training", "3D view")
"""Kinds of steps that use no kernels of enhancement, so that two processes compile nothing twice."""


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--again", action="store_true", help="look at every step although all are done")


def run(flags: argparse.Namespace) -> None:
    if is_prepared() and not flags.again:
        sys.stdout.write("already prepared\n")
        return
    from app.kernels.preparer import taken_beside
    from app.kernels.progress import worded
    from app.kernels.steps import prepare

    began = time.monotonic()
    with taken_beside(BESIDE) as wait:
        for now in prepare():
            if now.is_ready:
                break
            sys.stderr.write(f"{worded(now)}: {now.name}\n")
            if now.tasks[now.done].kind in BESIDE:
                wait()
    sys.stdout.write(f"prepared in {time.monotonic() - began:.0f} s\n")
