"""A procedural endoscopic scene whose depth, motion, tools and vessels are known exactly."""

from __future__ import annotations

import math
import shutil
from collections.abc import Iterator
from dataclasses import dataclass as plain_dataclass
from pathlib import Path
from typing import Annotated, Literal

import cv2
import numpy as np
from annotated_types import Interval, Unit
from numpy.typing import NDArray
from PIL import Image
from pydantic import ConfigDict
from pydantic.dataclasses import dataclass

from renderer.atomic_files import patiently
from renderer.camera import Camera, FloatArray
from renderer.clip import BoolImage, ByteImage, ClipError, Frame
from renderer.leftovers import clear, temporary_name
from renderer.phantom.surface import DISTANCE, Surface, grow_surface
from renderer.phantom.tissue import Tissue, paint_tissue, sample
from renderer.phantom.tools import Capsule, ToolHits, hit_tools, instrument
from renderer.readers.data_sets.endonerf import write_endonerf
from renderer.readers.data_sets.scared import write_scared

_FOCAL = 0.89  # Of the longer side: the da Vinci endoscope.
_BREATH = 20  # Frames, about.
_EXPOSURE = 1.05
_GLOSS = 90.0
_OPTICAL_BLUR = 0.7  # px
_PUMPING = 1  # Told apart from the noise of a frame.
_READ_SHARE = 0.36  # Of the noise variance at full brightness; the rest is shot noise.


@dataclass(
    frozen=True,
    kw_only=True,
    config=ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True),
)
class PhantomParams:
    """What the phantom shows. Equal parameters give equal frames.

    Raises:
        pydantic.ValidationError: (a ValueError) a value out of its range.

    Example:
        >>> from renderer import PhantomParams
        >>> PhantomParams(tissue="static", tools=0).width
        320
    """

    n_frames: Annotated[int, Interval(ge=1, le=5000)] = 24
    """Length of the clip."""
    width: Annotated[int, Interval(ge=16, le=4096), Unit("px")] = 320
    """Width of the frames."""
    height: Annotated[int, Interval(ge=16, le=4096), Unit("px")] = 256
    """Height of the frames."""
    seed: Annotated[int, Interval(ge=0, le=2**31 - 1)] = 0
    """Random seed of shape, vessels and noise."""
    camera: Literal["fixed", "moving"] = "fixed"
    """A fixed endoscope, or one that circles around a fixed point of view."""
    tissue: Literal["moving", "static"] = "moving"
    """Breathing and a local pull, or no motion."""
    tools: Annotated[int, Interval(ge=0, le=2)] = 2
    """Number of instruments; the first one pulls."""
    noise: Annotated[float, Interval(ge=0, le=50), Unit("grey levels")] = 0.5
    """Standard deviation of the sensor noise at full brightness."""
    pumping: Annotated[float, Interval(ge=0, le=0.5)] = 0
    """How far the brightness of single frames is off, to either side, as a share of it: of a camera whose
    automatic exposure does not come to rest."""


@plain_dataclass(frozen=True, eq=False)
class View:
    """One frame and the truth about it."""

    frame: Frame
    """Depth is exact (float32) on tissue and 0 on tools; both masks leave out the tools."""
    vessel_mask: BoolImage
    """(H, W), True = the pixel centre is on a vessel."""
    material: FloatArray
    """(H, W, 2) which tissue point in mm is seen: constant along a trajectory."""


class Phantom:
    """The scene for one set of parameters; any frame can be drawn in any order.

    Example:
        >>> from renderer import Phantom, PhantomParams
        >>> view = Phantom(PhantomParams(width=64, height=48)).view(index=5)
        >>> view.frame.depth.shape, view.vessel_mask.shape, view.material.shape
        ((48, 64), (48, 64), (48, 64, 2))
    """

    def __init__(self, params: PhantomParams) -> None:
        rng = np.random.default_rng(params.seed)
        cycles = max(1, round(params.n_frames / _BREATH))
        self.params = params
        self.surface: Surface = grow_surface(rng, params.tissue == "moving", cycles)
        focal = _FOCAL * max(params.width, params.height)
        self._lens = Camera(focal, focal, params.width / 2, params.height / 2, params.width, params.height)
        self._tissue: Tissue = paint_tissue(rng).blurred(0.4 * DISTANCE / focal)

    def camera(self, index: int) -> Camera:
        """The camera of a frame; the first is the identity."""
        if self.params.camera == "fixed":
            return self._lens
        turn = 2 * math.pi * index / self.params.n_frames
        centre = np.array([9 * math.sin(turn), 5 * (math.cos(turn) - 1), 4 * math.sin(turn)])
        forward = np.array([0, 0, DISTANCE]) - centre
        forward /= np.linalg.norm(forward)
        right = np.cross([0.0, 1.0, 0.0], forward)
        right /= np.linalg.norm(right)
        rotation = np.stack([right, np.cross(forward, right), forward])
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = rotation, -rotation @ centre
        return self._lens.moved(matrix)

    def gain(self, index: int) -> float:
        """By which the brightness of a frame is off: 1 without pumping."""
        off = np.random.default_rng([self.params.seed, index, _PUMPING]).uniform(-1, 1)
        return 1 + self.params.pumping * float(off)

    def view(self, index: int) -> View:
        """Frame `index` in [0, n_frames). Raises IndexError: another."""
        if not 0 <= index < self.params.n_frames:
            raise IndexError(f"expected a frame from 0 to {self.params.n_frames - 1}, got {index}")
        camera, time = self.camera(index), index / self.params.n_frames
        shape = (camera.height, camera.width)
        rays = (camera.unproject(np.ones(shape)) - camera.position).reshape(-1, 3)
        directions = rays / np.linalg.norm(rays, axis=1, keepdims=True)
        u, v = self.surface.hit(camera.position, directions, time)
        position, along_u, along_v = self.surface.evaluate(u, v, time)
        tools = hit_tools(camera.position, directions, self._tools(time))
        distance = np.linalg.norm(position - camera.position, axis=1)
        on_tool = (tools.distance < distance).reshape(shape)
        _, depth = camera.project(position)
        material = np.stack([u, v], axis=1).reshape(*shape, 2)
        where = material[:, :, 0], material[:, :, 1]
        albedo = sample(self._tissue.albedo, *where).reshape(-1, 3)
        tilt = sample(self._tissue.relief, *where).reshape(-1, 2)
        tissue = _shade_tissue(directions, distance, albedo, tilt, along_u, along_v)
        metal = _shade_tools(directions, tools)
        light = np.where(on_tool[:, :, None], metal.reshape(*shape, 3), tissue.reshape(*shape, 3))
        image = self._expose(light * _beam(camera)[:, :, None], index)
        seen = np.where(on_tool, 0, depth.reshape(shape)).astype(np.float32)
        on_vessel = (sample(self._tissue.vessels, *where) > 0.5) & ~on_tool
        frame = Frame(index, time, image, camera, ~on_tool, ~on_tool, seen)
        return View(frame, on_vessel, material)

    def _tools(self, time: float) -> list[Capsule]:
        pull = self.surface.pull
        held = self.surface.evaluate(pull[:1], pull[1:], time)[0][0]
        swing = math.sin(2 * math.pi * time)
        reach = 14 * (1 - math.sin(math.pi * min(1.0, 2 * time)) ** 0.5) if time < 0.25 else 0.0
        towards = np.array([0.80, 0.42, -0.43]) / math.sqrt(0.80**2 + 0.42**2 + 0.43**2)
        first = instrument(held + [0, 0, -0.5] + reach * towards, towards, 0.15 + 0.04 * reach)
        away = np.array([-0.86, 0.25, -0.44]) / math.sqrt(0.86**2 + 0.25**2 + 0.44**2)
        tip = np.array([-17.0 + 6 * swing, 9.0 - 7 * math.cos(2 * math.pi * time), DISTANCE - 13 + 3 * swing])
        second = instrument(tip, away, 0.5 + 0.3 * swing)
        return (first + second)[: 4 * self.params.tools]

    def _expose(self, light: FloatArray, index: int) -> ByteImage:
        """Linear light (H, W, 3) to the 8-bit picture: blur, tone curve, read and shot noise."""
        rng = np.random.default_rng([self.params.seed, index])
        blurred = np.asarray(cv2.GaussianBlur(np.minimum(light, 4.0), (0, 0), _OPTICAL_BLUR))
        tone = np.minimum(self.gain(index) * np.maximum(_EXPOSURE * blurred, 0) ** (1 / 2.2), 1)
        spread = self.params.noise * np.sqrt(_READ_SHARE + (1 - _READ_SHARE) * tone)
        noisy = 255 * tone + spread * rng.standard_normal(tone.shape)
        return np.asarray(np.clip(np.rint(noisy), 0, 255), dtype=np.uint8)


def _shade_tissue(
    directions: FloatArray,
    distance: FloatArray,
    albedo: NDArray[np.float32],
    tilt: NDArray[np.float32],
    along_u: FloatArray,
    along_v: FloatArray,
) -> FloatArray:
    """Linear RGB (N, 3) under a lamp at the camera: softened Lambert, 1/d^2, and a Blinn highlight.

    Lamp and eye coincide, so the half vector is the view direction. Highlights follow the wet
    relief, the diffuse light, scattered below the surface, mostly the shape.
    """
    smooth = _unit(np.cross(along_v, along_u))
    wet = _unit(smooth + tilt[:, :1] * _unit(along_u) + tilt[:, 1:] * _unit(along_v))
    facing = -(directions * _unit(smooth + 0.5 * (wet - smooth))).sum(axis=1)
    glint = np.clip(-(directions * wet).sum(axis=1), 0, 1) ** _GLOSS
    falloff = (DISTANCE / distance) ** 2
    diffuse = np.clip((facing + 0.2) / 1.2, 0, None) * falloff
    shine = 0.9 * _smooth_threshold(glint) * falloff
    return np.asarray(albedo * diffuse[:, None] + shine[:, None])


def _smooth_threshold(glint: FloatArray) -> FloatArray:
    """Sharpens the lobe into the crisp edge of a highlight on a film of fluid."""
    x = np.clip((glint - 0.55) / 0.4, 0, 1)
    return np.asarray(x * x * (3 - 2 * x))


def _shade_tools(directions: FloatArray, tools: ToolHits) -> FloatArray:
    """Linear bluish grey (N, 3) of brushed metal; black where no tool is met."""
    facing = np.clip(-(directions * tools.normal).sum(axis=1), 0, 1)
    met = np.isfinite(tools.distance)
    falloff = (DISTANCE / np.where(met, tools.distance, DISTANCE)) ** 2
    level = np.where(met, tools.shade * (0.15 + 0.5 * facing + 0.6 * facing**24) * falloff * 0.6, 0)
    return np.asarray(level[:, None] * np.array([0.88, 0.96, 1.0]))


def _beam(camera: Camera) -> FloatArray:
    """(H, W) light cone and vignetting: cos^4 of the angle off the axis, darker in the corners."""
    columns = (np.arange(camera.width) + 0.5 - camera.cx) / camera.fx
    rows = (np.arange(camera.height)[:, None] + 0.5 - camera.cy) / camera.fy
    off_axis = columns**2 + rows**2
    corner = np.clip((np.sqrt(off_axis) - 0.45) / 0.35, 0, 1)
    return np.asarray((1 - 0.75 * corner**2) / (1 + off_axis) ** 2)


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def write_phantom(
    out: str | Path, params: PhantomParams, layout: Literal["endonerf", "scared"] = "endonerf"
) -> None:
    """Writes the clip and vessel_masks/ (1 bit, set = vessel) to the new folder `out`.

    The folder appears when it is complete.

    Raises:
        ClipError: it exists already or cannot be written.
        TypeError: `params` of another class.
        ValueError: no such layout.

    Example:
        >>> from pathlib import Path
        >>> from tempfile import TemporaryDirectory
        >>> from renderer import PhantomParams, open_clip, write_phantom
        >>> with TemporaryDirectory() as folder:
        ...     write_phantom(Path(folder, "clip"), PhantomParams(n_frames=10, width=32, height=24))
        ...     clip = open_clip(Path(folder, "clip"))
        >>> len(clip), clip.size, clip.unit, clip.has_depth
        (10, (32, 24), 'mm', True)
    """
    if not isinstance(params, PhantomParams):
        raise TypeError(f"expected params to be PhantomParams, got {type(params).__name__}")
    out = Path(out)
    if out.exists():
        raise ClipError(f"expected a new folder for the phantom, got one that exists: {out}")
    writers = {"endonerf": write_endonerf, "scared": write_scared}
    if layout not in writers:
        raise ValueError(f"expected a layout among {', '.join(writers)}, got {layout!r}")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        clear(out.parent)
        partial = out.parent / temporary_name(out.name)
        try:
            (partial / "vessel_masks").mkdir(parents=True)
            writers[layout](partial, _drawn(Phantom(params), partial / "vessel_masks"))
            patiently(partial.rename, out)
        finally:
            shutil.rmtree(partial, ignore_errors=True)
    except OSError as error:
        raise ClipError(f"cannot write the phantom, {error.strerror or error}: {out}") from error


def _drawn(phantom: Phantom, vessel_masks: Path) -> Iterator[Frame]:
    for index in range(phantom.params.n_frames):
        view = phantom.view(index)
        Image.fromarray(view.vessel_mask).save(vessel_masks / f"frame-{index:06d}.vessels.png")
        yield view.frame
