"""Versions, devices and licences of the product where it runs."""

from __future__ import annotations

import os
import platform
from typing import Any

from app.console.startup import has_display
from app.files.provenance import NOTICE, installed, version
from app.runs.device import cuda_devices, missing
from renderer.draw.context import OpenGLUnavailable, renderer_name, standalone_context

PACKAGES = ("numpy", "numba", "opencv-contrib-python-headless", "torch", "gsplat", "moderngl", "imgui-bundle")
LICENSE = "VesselSplat: Apache-2.0; its dependencies carry their own licences, see LICENSE"


def basics() -> dict[str, Any]:
    """Those that need neither a graphics card nor a driver, by name."""
    return {
        "version": version(),
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
        "cores": os.cpu_count(),
        "packages": {name: installed(name) for name in PACKAGES},
    }


def collect() -> dict[str, Any]:
    """All facts, by name."""
    lacks = missing()
    return basics() | {
        "opengl": _opengl(),
        "cuda_devices": cuda_devices(),
        "display": has_display(),
        "training": f"numba on the CPU: {lacks}" if lacks else "gsplat on CUDA, numba on the CPU",
        "licences": LICENSE,
        "notice": NOTICE,
    }


def _opengl() -> str:
    try:
        context = standalone_context()
    except OpenGLUnavailable as error:
        return f"none: {error}"
    name = renderer_name(context)
    context.release()
    return name
