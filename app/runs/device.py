"""What trains: the CPU, or a GPU through gsplat. torch is loaded only where there may be a GPU."""

from __future__ import annotations

import ctypes
import sys
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING, Literal

from app.errors import UserError
from renderer.torch_presence import NO_TORCH, has_torch

if TYPE_CHECKING:
    from renderer.train.gradient_backend import GradientBackend

Asked = Literal["auto", "cpu", "cuda"]
Device = Literal["cpu", "cuda"]
CUDA_DRIVERS = {"win32": "nvcuda.dll"}


@dataclass(frozen=True)
class Choice:
    device: Device
    why: str


def choose(asked: Asked) -> Choice:
    """The device to train on.

    Raises:
        UserError: CUDA was asked for and something is missing: what, and where it comes from.
    """
    if asked == "cpu":
        return Choice("cpu", "as requested")
    lacks = missing() or _trouble()
    if not lacks:
        return Choice("cuda", "an NVIDIA GPU and gsplat are available")
    if asked == "cuda":
        raise UserError(f"--device cuda: {lacks} (or use --device cpu)")
    return Choice("cpu", lacks)


def pictures_on(device: Device) -> GradientBackend:
    """What draws and differentiates there."""
    if device == "cuda":
        from renderer.torch_train.gradient_backend import TorchBackend

        return TorchBackend("cuda")
    from renderer.train.gradient_backend import CpuBackend

    return CpuBackend()


def missing() -> str:
    """What the machine lacks for CUDA, as far as can be told without loading torch; empty: nothing."""
    lacks = []
    if not cuda_devices():
        lacks.append("the NVIDIA driver finds no GPU")
    if not has_torch():
        lacks.append(NO_TORCH)
    elif find_spec("gsplat") is None:
        lacks.append("gsplat is not installed (pip install gsplat)")
    return " and ".join(lacks)


def _trouble() -> str:
    from renderer.torch_train.card import trouble

    return trouble() or ""


def cuda_devices() -> int:
    """How many devices the CUDA driver sees; 0 without a driver."""
    try:
        driver = ctypes.CDLL(CUDA_DRIVERS.get(sys.platform, "libcuda.so.1"))
    except OSError:
        return 0
    count = ctypes.c_int(0)
    if driver.cuInit(0) != 0 or driver.cuDeviceGetCount(ctypes.byref(count)) != 0:
        return 0
    return count.value
