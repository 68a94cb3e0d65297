"""What a calibration says of the lenses of an endoscope, of one eye or of two, as OpenCV models them."""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Final, Literal

import numpy as np
from annotated_types import Gt, Interval
from pydantic import ConfigDict, ValidationError
from pydantic.dataclasses import dataclass

from renderer.camera import FloatArray

Model = Literal["pinhole", "fisheye"]
COUNTS: Final[dict[Model, tuple[int, ...]]] = {"pinhole": (0, 4, 5, 8, 12, 14), "fisheye": (4,)}
"""Coefficients of distortion that each model takes."""
MOST_COEFFICIENT: Final = 1e6
STRAIGHT: Final = 1e-3
"""By which a turn may differ from an exact one."""
SHORTEST, LONGEST = 1e-3, 1e3  # mm

Pixels = Annotated[int, Interval(ge=1, le=100_000)]
_STRICT = ConfigDict(extra="forbid", allow_inf_nan=False)


@dataclass(frozen=True, kw_only=True, config=_STRICT)
class LensCalibration:
    """One lens. Raises ValueError: a number that no lens has."""

    fx: Annotated[float, Gt(0)]
    fy: Annotated[float, Gt(0)]
    """px."""
    cx: float
    cy: float
    """px from the centre of the first pixel, as OpenCV counts."""
    model: Model = "pinhole"
    """With radial and tangential distortion, or OpenCV's fisheye model (Kannala and Brandt, 2006)."""
    distortion: tuple[Annotated[float, Interval(ge=-MOST_COEFFICIENT, le=MOST_COEFFICIENT)], ...] = ()
    """Coefficients in OpenCV's order."""
    size: tuple[Pixels, Pixels] | None = None
    """Width and height in px of the images that it was made with; None: those of the frames."""

    def __post_init__(self) -> None:
        counts = COUNTS[self.model]
        if len(self.distortion) not in counts:
            wanted = ", ".join(map(str, counts))
            raise ValueError(
                f"expected {wanted} coefficients of distortion ({self.model}), got {len(self.distortion)}"
            )

    @property
    def matrix(self) -> FloatArray:
        """(3, 3)."""
        return np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1]], dtype=np.float64)

    @property
    def coefficients(self) -> FloatArray:
        return np.array(self.distortion or (0, 0, 0, 0), dtype=np.float64)


@dataclass(frozen=True, kw_only=True, config=_STRICT)
class SecondEye:
    """The right lens, and where it is. Raises ValueError: no turn, or no distance that eyes are apart."""

    lens: LensCalibration
    turn: tuple[float, ...]
    """9, a rotation matrix in rows, from the left eye's axes to the right eye's."""
    shift: tuple[float, ...]
    """3, in mm, that belong to it: a point at x for the left eye is at turn x + shift for the right one."""

    def __post_init__(self) -> None:
        if len(self.turn) != 9 or len(self.shift) != 3:
            got = f"{len(self.turn)} and {len(self.shift)}"
            raise ValueError(f"expected 9 numbers of a rotation and 3 of a shift, got {got}")
        turn = self.rotation
        if np.abs(turn @ turn.T - np.eye(3)).max() > STRAIGHT or np.linalg.det(turn) < 0:
            raise ValueError("expected a rotation from the left to the right eye, got another matrix")
        if not SHORTEST < self.distance < LONGEST:
            raise ValueError(
                f"expected eyes more than 0 and less than 1000 mm apart, got {self.distance:.3g} mm"
            )

    @property
    def rotation(self) -> FloatArray:
        """(3, 3)."""
        return np.array(self.turn, dtype=np.float64).reshape(3, 3)

    @property
    def translation(self) -> FloatArray:
        """(3, 1) mm."""
        return np.array(self.shift, dtype=np.float64)[:, None]

    @property
    def distance(self) -> float:
        """mm."""
        return float(np.linalg.norm(self.shift))


def first_fault(error: ValidationError) -> str:
    """The first thing that is wrong with numbers from a file, in one line."""
    told = error.errors(include_url=False, include_context=False)[0]
    said = told["msg"].replace("Input should be", "expected").replace("Value error, ", "")
    place = ".".join(map(str, told["loc"]))
    return f"{place}: {said}, got {told['input']}" if place else said


@dataclass(frozen=True, kw_only=True, config=_STRICT)
class FoundLens:
    """How the program found a lens that nobody has calibrated."""

    by: Literal["camera motion"] = "camera motion"
    deviation: Annotated[float, Interval(ge=0, le=1)]
    """Standard deviation of k1, the first coefficient of its distortion."""


@dataclass(frozen=True, kw_only=True, config=_STRICT)
class Calibration:
    """Of an endoscope with one eye, or with two."""

    lens: LensCalibration
    """Of the left eye, or the only one."""
    right: SecondEye | None = None
    found: FoundLens | None = field(default=None, repr=False)
    """None: it was given."""
