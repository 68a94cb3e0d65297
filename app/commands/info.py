"""`vesselsplat info [PATH]`: what a path is read as; or versions, devices and licences, quickly."""

from __future__ import annotations

import argparse
import os
import platform
import sys
from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed_version
from pathlib import Path
from typing import Any

from app.console.display import has_display
from app.files.provenance import NOTICE, strict_json, version
from app.runs.device import cuda_devices, missing
from renderer.draw.context import OpenGLUnavailable, renderer_name, standalone_context

PACKAGES = ("numpy", "numba", "opencv-contrib-python-headless", "torch", "gsplat", "moderngl", "imgui-bundle")
LICENSE = "VesselSplat: Apache-2.0; its dependencies carry their own licences, see LICENSE"


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "path",
        metavar="PATH",
        nargs="?",
        type=Path,
        help="clip, picture, video, run, splat file, session or exported file: what it is read as, what is "
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


def collect() -> dict[str, Any]:
    """All facts, by name."""
    return {
        "version": version(),
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
        "cores": os.cpu_count(),
        "packages": {name: _installed(name) for name in PACKAGES},
        "opengl": _opengl(),
        "cuda_devices": cuda_devices(),
        "display": has_display(),
        "training": f"numba on the CPU: {lacks}"
        if (lacks := missing())
        else "gsplat on CUDA, numba on the CPU",
        "licences": LICENSE,
        "notice": NOTICE,
    }


def _installed(package: str) -> str | None:
    try:
        return installed_version(package)
    except PackageNotFoundError:
        return None


def _opengl() -> str:
    try:
        context = standalone_context()
    except OpenGLUnavailable as error:
        return f"none: {error}"
    name = renderer_name(context)
    context.release()
    return name
