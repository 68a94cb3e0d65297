"""A model through the clip as USD: a ParticleField3DGaussianSplat, its values sampled at every frame; of a
model in windows one for each of them, which is visible while its window is there.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from app.errors import UserError
from app.exports.records import MovingSplats
from app.exports.usd_file import defined, new_stage, require_usd
from app.scenes.scene import Scene
from renderer.harmonics import BANDS
from renderer.model_windows import ModelWindow, windows_of
from renderer.raw_gaussians import RawGaussians
from renderer.rotations import unit_quats
from renderer.splat_files.splat_file import coefficients_of
from renderer.splat_files.y_up import y_up
from renderer.splats import Float32Array

SPLATS: Final = "/splats"
REACH: Final = 3.0
"""Standard deviations that the bounds hold."""
VALUES: Final[Mapping[str, tuple[tuple[str, ...], Callable[[RawGaussians], Float32Array]]]] = {
    "positions": (("means",), lambda raw: raw.means),
    # In memory, the real part of a quaternion of USD comes last.
    "orientations": (("quats",), lambda raw: unit_quats(raw.quats)[:, [1, 2, 3, 0]]),
    "scales": (("log_scales",), lambda raw: raw.splats().scales),
    "opacities": (("opacity_logits",), lambda raw: raw.splats().opacities),
    "radiance:sphericalHarmonicsCoefficients": (("colors", "harmonics"), lambda raw: _radiance(raw)),
    "extent": (("means", "log_scales"), lambda raw: _bounds(raw)),
}
"""By attribute: the raw values that it follows from, and how."""


def write_usd(record: MovingSplats, scene: Scene, target: Path) -> Generator[int, None, None]:
    """What does not move has one value, all else one a frame; yields frames done.

    Raises:
        UserError: no usd-core or one of before 26.3, or Gaussians that are others at every moment.
    """
    require_splats_in_usd()
    from pxr import UsdVol

    scene.require_same_tissue()
    frames, windows, done = len(scene.cameras), windows_of(scene.model), 0
    with new_stage(target, scene.unit, frames, record.seconds, record.signed) as stage:
        shown = [window.seen_frames(frames) for window in windows]
        for window in windows:
            field = defined(stage, UsdVol.ParticleField3DGaussianSplat, SPLATS, shown, window.index)
            for frame in _write_field(field, window, scene):
                done = max(done, frame + 1)
                yield done
            del field
        del stage


def _write_field(field: Any, window: ModelWindow, scene: Scene) -> Iterator[int]:
    """Its frames, as they are done."""
    from pxr import Usd

    model, there = window.model, window.seen_frames(len(scene.cameras))
    field.CreateRadianceSphericalHarmonicsDegreeAttr(BANDS.index(model.raw.harmonics.shape[1]))
    field.CreateSortingModeHintAttr("zDepth")
    field.CreateProjectionModeHintAttr("perspective")
    fades = [window.fade(scene.time(frame)) < 1 for frame in there]
    for place, frame in enumerate(there):
        moved = window.seen(model, scene.time(frame))
        # Programs interpolate between samples, so what fades begins and ends in one that does not.
        near_fade = any(fades[max(place - 1, 0) : place + 2])
        for name, (of, values) in VALUES.items():
            moves = any(getattr(moved, one) is not getattr(model.raw, one) for one in of)
            if moves or (name == "opacities" and near_fade):
                _set(field, name, values(y_up(moved)), Usd.TimeCode(frame))
            elif place == 0:
                _set(field, name, values(y_up(moved)), Usd.TimeCode.Default())
        yield frame


def require_splats_in_usd() -> None:
    """Raises UserError: no usd-core, or one of before 26.3."""
    require_usd()
    from pxr import UsdVol

    if not hasattr(UsdVol, "ParticleField3DGaussianSplat"):
        raise UserError("splats as USD need usd-core 26.3 or newer: pip install -U usd-core")


def _set(field: Any, name: str, values: Float32Array, code: Any) -> None:
    from pxr import Vt

    kinds = {"orientations": Vt.QuatfArray, "opacities": Vt.FloatArray}
    kind = kinds.get(name, Vt.Vec3fArray)
    if name == "extent":
        field.CreateExtentAttr()
    field.GetPrim().GetAttribute(name).Set(kind.FromNumpy(np.ascontiguousarray(values)), code)


def _radiance(raw: RawGaussians) -> Float32Array:
    """(N * (degree + 1)^2, 3) coefficients, those of a Gaussian one after the other."""
    constant = coefficients_of(raw.colors).astype(np.float32)
    return np.concatenate([constant[:, None], raw.harmonics], axis=1).reshape(-1, 3)


def _bounds(raw: RawGaussians) -> Float32Array:
    """(2, 3) the least and the largest that is seen."""
    if not len(raw):
        return np.zeros((2, 3), np.float32)
    reach = REACH * np.exp(raw.log_scales.max(axis=1, keepdims=True))
    return np.stack([(raw.means - reach).min(axis=0), (raw.means + reach).max(axis=0)])
