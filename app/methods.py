"""The methods of `vesselsplat enhance`, under the names of --method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from app.errors import UserError
from app.pictures import ArrayImage
from enhance import EnhanceParams, Enhancer, Statistics
from enhance.baselines import BASELINES
from enhance.result import Omission
from enhance.vessel import VesselParams, enhance_vessels

PAPER: Final = "paper"
VESSEL: Final = "vessel"
METHODS: Final = (PAPER, VESSEL, *BASELINES)

Params = EnhanceParams | VesselParams | None
"""Of the paper's method, of the preset `vessel`, or of a method without parameters."""


@dataclass(frozen=True, eq=False)
class Enhanced:
    """An enhanced picture and what was used for it."""

    image: ArrayImage
    statistics: Statistics | None
    omitted: tuple[Omission, ...]


def apply(
    method: str, params: Params, image: ArrayImage, statistics: Statistics | None, enhancer: Enhancer
) -> Enhanced:
    """Enhance one picture; `enhancer` keeps its memory from one to the next.

    Raises:
        ImageError: a picture that the paper's method or `vessel` cannot use.
        UserError: anything but 8-bit RGB for one of the other methods.
    """
    if isinstance(params, EnhanceParams):
        enhancer.show(image)
        result = enhancer.enhance(params, statistics=statistics)
        return Enhanced(result.image, result.statistics, result.omitted)
    if isinstance(params, VesselParams):
        result = enhance_vessels(image, params, statistics=statistics)
        return Enhanced(result.image, result.statistics, result.omitted)
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3:
        raise UserError(
            f"--method {method} takes 8-bit RGB pictures, got {image.dtype} of shape {image.shape}"
        )
    return Enhanced(BASELINES[method](image), None, ())
