"""The lens in a text model of COLMAP: cameras.txt."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, NamedTuple

from renderer.readers.lenses.calibration import Calibration, LensCalibration, Model

CENTER: Final = 0.5
"""COLMAP counts pixels from the corner of the first one, OpenCV from its centre."""


class _Form(NamedTuple):
    """Places of fx, fy, cx, cy, and of OpenCV's coefficients, None: 0."""

    lens: tuple[int, int, int, int]
    distortion: tuple[int | None, ...] = ()
    model: Model = "pinhole"

    @property
    def parameters(self) -> int:
        places = (*self.lens, *(each for each in self.distortion if each is not None))
        return 1 + max(places)


_ONE_FOCAL, _TWO_FOCAL = (0, 0, 1, 2), (0, 1, 2, 3)
FORMS: Final[Mapping[str, _Form]] = {
    "SIMPLE_PINHOLE": _Form(_ONE_FOCAL),
    "PINHOLE": _Form(_TWO_FOCAL),
    "SIMPLE_RADIAL": _Form(_ONE_FOCAL, (3, None, None, None)),
    "RADIAL": _Form(_ONE_FOCAL, (3, 4, None, None)),
    "OPENCV": _Form(_TWO_FOCAL, (4, 5, 6, 7)),
    "FULL_OPENCV": _Form(_TWO_FOCAL, (4, 5, 6, 7, 8, 9, 10, 11)),
    "SIMPLE_RADIAL_FISHEYE": _Form(_ONE_FOCAL, (3, None, None, None), "fisheye"),
    "RADIAL_FISHEYE": _Form(_ONE_FOCAL, (3, 4, None, None), "fisheye"),
    "OPENCV_FISHEYE": _Form(_TWO_FOCAL, (4, 5, 6, 7), "fisheye"),
}
"""Parameters as COLMAP's documentation of camera models lists them."""


def colmap_lens(text: str) -> Calibration:
    """The one lens of cameras.txt. Raises ValueError: none, several, or one of another model."""
    lines = [line.split() for line in text.splitlines()]
    lenses = {tuple(words[1:]) for words in lines if words and not words[0].startswith("#")}
    if len(lenses) != 1:
        raise ValueError(f"expected one lens of COLMAP's cameras.txt, got {len(lenses)}")
    (words,) = lenses
    if words[:1] == () or words[0] not in FORMS:
        raise ValueError(f"expected a lens of {', '.join(FORMS)}, got {' '.join(words)[:40] or 'none'}")
    form, numbers = FORMS[words[0]], words[3:]
    if len(numbers) != form.parameters:
        raise ValueError(f"expected {form.parameters} parameters of {words[0]}, got {len(numbers)}")
    try:
        size, values = (int(words[1]), int(words[2])), [float(each) for each in numbers]
    except ValueError as error:
        said = " ".join(words[1:])
        raise ValueError(
            f"expected whole pixels of a size, and numbers, after {words[0]}, got {said}"
        ) from error
    return _calibration(form, size, values)


def _calibration(form: _Form, size: tuple[int, int], values: list[float]) -> Calibration:
    fx, fy, cx, cy = (values[place] for place in form.lens)
    bent = tuple(0.0 if place is None else values[place] for place in form.distortion)
    return Calibration(
        lens=LensCalibration(
            fx=fx, fy=fy, cx=cx - CENTER, cy=cy - CENTER, model=form.model, distortion=bent, size=size
        )
    )
