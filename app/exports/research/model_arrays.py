"""A model at chosen moments, with the depth that cameras see, as named arrays: one `.npz` file whose README
says what each is."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from app.errors import UserError
from app.exports.records import ModelArrays
from app.exports.research.clock import frames_of, span_of
from app.exports.research.npz import PROVENANCE, Archive
from app.exports.research.readme import Described, readme
from app.files.atomic import replaced
from app.files.provenance import ascii_json
from app.scenes.drawer import Drawer
from app.scenes.records import MomentRecord
from app.scenes.scene import Scene
from app.scenes.view_request import ViewRequest
from renderer.model_windows import ModelWindow, windows_of
from renderer.picking import SOLID
from renderer.raw_gaussians import RawGaussians
from renderer.rotations import unit_quats
from renderer.splats import Float32Array

README: Final = "README"
BELOW: Final = "/"
"""Between a window and its arrays, in their names."""
FLOAT: Final = np.dtype(np.float32)


@dataclass(frozen=True)
class _OfGaussians:
    """One array of the Gaussians; `field`: of the raw values that it follows from."""

    name: str
    field: str
    text: str
    values: Callable[[RawGaussians], Float32Array]


OF_GAUSSIANS: Final = (
    _OfGaussians("positions", "means", "centres, x y z, in {unit}", lambda raw: raw.means),
    _OfGaussians(
        "rotations",
        "quats",
        "unit quaternions, w x y z, from the axes of the Gaussian to those of the world",
        lambda raw: unit_quats(raw.quats),
    ),
    _OfGaussians(
        "scales",
        "log_scales",
        "standard deviations along the axes of the Gaussian, in {unit}",
        lambda raw: raw.splats().scales,
    ),
    _OfGaussians(
        "opacities", "opacity_logits", "in [0, 1], at the centre", lambda raw: raw.splats().opacities
    ),
    _OfGaussians(
        "colors",
        "colors",
        "R G B, display-referred (sRGB), nominally in [0, 1]; the part that does not depend on the direction",
        lambda raw: raw.colors,
    ),
    _OfGaussians(
        "harmonics",
        "harmonics",
        "B = 3, 8 or 15 spherical harmonics of degree 1 to 3 of R G B, in the order and with the signs of "
        "3D Gaussian Splatting; added to colors, by the direction from the camera to the centre",
        lambda raw: raw.harmonics,
    ),
)


def write_model_arrays(
    record: ModelArrays, scene: Scene, drawer: Drawer, target: Path
) -> Generator[int, None, None]:
    """Yields at how many moments depth has been drawn.

    Raises:
        UserError: no moment, cameras of several sizes, or Gaussians that are others at every moment.
    """
    moments = record.moments
    scene.require_same_tissue()
    if not moments:
        raise UserError(f"expected a moment at least, got none: {scene.name}")
    sizes = {(one.camera.height, one.camera.width) for one in moments}
    if len(sizes) > 1:
        raise UserError(f"expected cameras of one size, got {len(sizes)} sizes: set one with --size")
    said = record.signed | {"renderer": drawer.name}
    with replaced(target) as temporary, zipfile.ZipFile(temporary, "w") as file:
        archive = Archive(file)
        described = [*_write_cameras(archive, scene, moments), *_write_gaussians(archive, scene, moments)]
        shape = (len(moments), *sizes.pop())
        depths = (_depth(scene, moment, drawer) for moment in moments)
        yield from archive.rows("depth", shape, FLOAT, depths)
        described.append(
            Described(
                "depth",
                shape,
                "float32",
                f"expected depth along the camera's z, in {scene.unit}; 0 where alpha is at most {SOLID}",
            )
        )
        archive.text(README, readme(scene, described))
        archive.text(PROVENANCE, ascii_json(said))


def _write_cameras(archive: Archive, scene: Scene, moments: tuple[MomentRecord, ...]) -> list[Described]:
    cameras = [one.camera for one in moments]
    arrays: dict[str, tuple[np.ndarray[Any, Any], str]] = {
        "times": (
            np.array([one.time for one in moments]),
            f"of each moment, in [0, 1] over {span_of(scene)}",
        ),
        "frame_numbers": (
            np.array([-1 if one.frame is None else one.frame for one in moments], np.int64),
            f"{frames_of(scene)}; -1: a moment that is none of its frames",
        ),
        "intrinsics": (
            np.array([one.lens for one in cameras]),
            "fx fy cx cy in pixels; the middle of the first pixel is at (0.5, 0.5)",
        ),
        "camera_from_world": (
            np.stack([one.camera_from_world for one in cameras]),
            "takes points of the world to the camera's axes: x right, y down, z forward",
        ),
    }
    for name, (values, _) in arrays.items():
        archive.array(name, values)
    return [Described(name, one.shape, str(one.dtype), text) for name, (one, text) in arrays.items()]


def _write_gaussians(archive: Archive, scene: Scene, moments: tuple[MomentRecord, ...]) -> list[Described]:
    """Of a model in windows those of each, at the moments at which it is there."""
    windows = windows_of(scene.model)
    if len(windows) == 1:
        return _write_window(archive, scene, windows[0], [one.time for one in moments], "")
    described = []
    for window in windows:
        there = [index for index, one in enumerate(moments) if window.fade(one.time) > 0]
        if not there:
            continue
        begin, named = f"window_{window.index + 1}{BELOW}", np.array(there, np.int64)
        archive.array(f"{begin}moments", named)
        text = "at which of the T moments it is there; in its other arrays these come first"
        described.append(Described(f"{begin}moments", named.shape, "int64", text))
        times = [moments[index].time for index in there]
        described += _write_window(archive, scene, window, times, begin)
    return described


def _write_window(
    archive: Archive, scene: Scene, window: ModelWindow, times: Sequence[float], begin: str
) -> list[Described]:
    """What does not move has one row for all moments. `begin`: of the names."""
    model, fades = window.model, any(window.fade(time) < 1 for time in times)
    described = []
    for one in OF_GAUSSIANS:
        if one.name == "harmonics" and not model.raw.harmonics.shape[1]:
            continue
        first = window.seen(model, times[0])
        moves = getattr(first, one.field) is not getattr(model.raw, one.field)
        moves |= fades and one.name == "opacities"
        rows = (one.values(window.seen(model, time)) for time in (times if moves else times[:1]))
        shape = (len(times) if moves else 1, *one.values(first).shape)
        for _ in archive.rows(begin + one.name, shape, FLOAT, rows):
            pass
        described.append(Described(begin + one.name, shape, "float32", one.text.format(unit=scene.unit)))
    return described


def _depth(scene: Scene, moment: MomentRecord, drawer: Drawer) -> Float32Array:
    """Of all Gaussians, which are beside it in the archive."""
    view = ViewRequest(scene, moment.time, moment.camera, near_plane=moment.near, unobserved=True)
    drawn = drawer.drawn(view)
    return np.where(drawn.alpha > SOLID, drawn.depth, np.float32(0))
