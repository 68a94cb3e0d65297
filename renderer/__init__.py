"""Reconstruction of moving tissue as dynamic 3D Gaussians, and drawing: section 3.2 of the paper.

OpenCV axes (x right, y down, z forward), `camera_from_world`, pixel centres at +0.5, intrinsics in pixels;
lengths in the clip's unit, millimetres where the data has units; time in [0, 1]; images (H, W, 3) RGB;
depth (H, W) along z, 0 = not measured; masks (H, W), True = kept; quaternions wxyz.

- Clips: `open_clip`, `ClipOptions`, `Clip`, `Frame`, `Camera`, with `ClipError` and `CameraError`; a
  synthetic one with exact truth: `Phantom`, `PhantomParams`, `write_phantom`.
- Training: `train`, `TrainConfig`, `TrainingError`; it yields a `TrainEvent` at a time: `Started`,
  `Progress`, `Snapshot`, `Evaluated`, `Finishing`, `Warned`, `Finished`.
- Models: `DynamicGaussians` over time, `RawGaussians` at rest, `Splats` at one moment; splat files of this
  and other programs: `read_splats`, `write_splats`, `SplatFile`, `SplatFileError`.
- Drawing: `render` and `Rasterizer` on the CPU give `Rendered`; `rasterize` is differentiable and the one
  name that takes torch; `SplatView` and `render_offscreen` draw by OpenGL, in a window's context or in
  `standalone_context`, else `OpenGLUnavailable`.
- Measures: `psnr`, `psnr_masked`, `ssim`, `depth_rmse`.

Importing the package loads nothing; each name loads what it needs when it is first used: torch for
`rasterize` alone, OpenGL for `SplatView` and what goes with it. Nothing of the process is changed. The
kernels compute on several cores by OpenMP, whose threads spin while they wait: where other work shares the
cores, set OMP_WAIT_POLICY=PASSIVE in the environment before the first is used. A process that is forked once
they have run ends at the next one: take multiprocessing.get_context("spawn"). `train` and `rasterize` are
functions here, and folders as well: take what lies in these by `from renderer.train.guards import LossWatch`.
"""

import importlib as _importlib
import typing as _typing

if _typing.TYPE_CHECKING:
    from renderer.camera import Camera, CameraError
    from renderer.clip import Clip, ClipError, Frame
    from renderer.draw.context import OpenGLUnavailable, standalone_context
    from renderer.draw.offscreen import render_offscreen
    from renderer.draw.splat_view import SplatView
    from renderer.gaussians import DynamicGaussians
    from renderer.metrics import depth_rmse, psnr, psnr_masked, ssim
    from renderer.phantom import Phantom, PhantomParams, write_phantom
    from renderer.rasterize import rasterize
    from renderer.rasterize.cpu import Rasterizer, render
    from renderer.rasterize.rendered import Rendered
    from renderer.raw_gaussians import RawGaussians
    from renderer.readers.clip_options import ClipOptions
    from renderer.sources import open_clip
    from renderer.splat_files import SplatFile, SplatFileError, read_splats, write_splats
    from renderer.splats import Splats
    from renderer.train.config import TrainConfig
    from renderer.train.events import (
        Evaluated,
        Finished,
        Finishing,
        Progress,
        Snapshot,
        Started,
        TrainEvent,
        Warned,
    )
    from renderer.train.trainer import TrainingError
    from renderer.train.training import train

__all__ = [
    "Camera",
    "CameraError",
    "Clip",
    "ClipError",
    "ClipOptions",
    "DynamicGaussians",
    "Evaluated",
    "Finished",
    "Finishing",
    "Frame",
    "OpenGLUnavailable",
    "Phantom",
    "PhantomParams",
    "Progress",
    "Rasterizer",
    "RawGaussians",
    "Rendered",
    "Snapshot",
    "SplatFile",
    "SplatFileError",
    "SplatView",
    "Splats",
    "Started",
    "TrainConfig",
    "TrainEvent",
    "TrainingError",
    "Warned",
    "depth_rmse",
    "open_clip",
    "psnr",
    "psnr_masked",
    "rasterize",
    "read_splats",
    "render",
    "render_offscreen",
    "ssim",
    "standalone_context",
    "train",
    "write_phantom",
    "write_splats",
]

_MODULES = {
    "camera": "Camera CameraError",
    "clip": "Clip ClipError Frame",
    "draw.context": "OpenGLUnavailable standalone_context",
    "draw.offscreen": "render_offscreen",
    "draw.splat_view": "SplatView",
    "gaussians": "DynamicGaussians",
    "metrics": "depth_rmse psnr psnr_masked ssim",
    "phantom": "Phantom PhantomParams write_phantom",
    "rasterize": "rasterize",
    "rasterize.cpu": "Rasterizer render",
    "rasterize.rendered": "Rendered",
    "raw_gaussians": "RawGaussians",
    "readers.clip_options": "ClipOptions",
    "sources": "open_clip",
    "splat_files": "SplatFile SplatFileError read_splats write_splats",
    "splats": "Splats",
    "train.config": "TrainConfig",
    "train.events": "Evaluated Finished Finishing Progress Snapshot Started TrainEvent Warned",
    "train.trainer": "TrainingError",
    "train.training": "train",
}
_HOME = {name: f"renderer.{module}" for module, names in _MODULES.items() for name in names.split()}

# A folder takes its name here when it is first imported. These two, which hold next to nothing, are so now
# and give it back, so that the name is the function's whatever else is imported, and when.
for _folder in ("rasterize", "train"):
    _importlib.import_module(f"renderer.{_folder}")
    del globals()[_folder]


def __getattr__(name: str) -> _typing.Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(_importlib.import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return list(__all__)
