"""The distortion of a lens that nobody has calibrated: what is found and said of it."""

from __future__ import annotations

import json
from typing import Final

from renderer.clip import Clip
from renderer.poses.distortion import RIGID, Distortion
from renderer.readers.lenses.calibration import Calibration, FoundLens, LensCalibration
from renderer.readers.lenses.straightening import straightening

UNBENT: Final = (
    "the lens is treated as free of distortion: where it bends straight lines, shapes along the view and the "
    "path of the camera may be off by some percent, and a field of view that is estimated by more "
    "(--calibration undistorts the images)"
)
"""As tests/benchmarks/lens_distortion.py measures it."""


def found_lens(clip: Clip, told: Distortion | None) -> Calibration | None:
    """By which the clip's frames can be undistorted; None: that is not certain, or would fold them."""
    if told is None or not (told.is_certain and _straightens(clip, told)):
        return None
    return Calibration(lens=lens_of(clip, told), found=FoundLens(deviation=round(told.deviation, 4)))


def lens_notice(clip: Clip, told: Distortion | None) -> str:
    """What the motion of the camera tells of the lens of a clip that stays bent, and how to use it."""
    if told is None:
        return UNBENT
    if told.rigid < RIGID:
        return (
            f"{UNBENT}; the motion of the camera does not tell how much, as "
            f"{100 * (1 - told.rigid):.0f} % of the features do not agree with it"
        )
    measured = f"k1 = {told.k1:.3f}, standard deviation {told.deviation:.3f}"
    if found_lens(clip, told) is None:
        return f"{UNBENT}; the motion of the camera shows no distortion that is certain ({measured})"
    lens = lens_of(clip, told)
    return (
        f"the lens bends straight lines, by the motion of the camera: {measured}, at a focal length of "
        f"{lens.fx:g} px, which poses and shapes are found without; --calibration lens.json undistorts the "
        f"images, where lens.json holds {_as_json(lens)}"
    )


def lens_of(clip: Clip, told: Distortion) -> LensCalibration:
    """The lens that was found, as the calibration of the clip's frames."""
    camera, (width, height) = clip.cameras[0], clip.size
    return LensCalibration(
        fx=round(told.lens.fx * width / told.lens.width, 2),
        fy=round(told.lens.fy * height / told.lens.height, 2),
        cx=camera.cx - 0.5,
        cy=camera.cy - 0.5,
        distortion=(round(told.k1, 4), 0.0, 0.0, 0.0),
    )


def _straightens(clip: Clip, told: Distortion) -> bool:
    """Whether the distortion holds to the border of the images."""
    try:
        straightening(lens_of(clip, told), clip.size, clip.pixel_aspect)
    except ValueError:
        return False
    return True


def _as_json(lens: LensCalibration) -> str:
    """As OpenCV names a matrix and its coefficients."""
    return json.dumps({"K": lens.matrix.ravel().tolist(), "D": lens.distortion})
