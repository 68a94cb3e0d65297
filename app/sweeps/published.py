"""What has been published for clips of EndoNeRF, as its sources quote it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True)
class Published:
    """One method on one clip: PSNR in dB over all pixels of masked images, SSIM, LPIPS (AlexNet)."""

    clip: str
    """A word in its name."""
    method: str
    psnr: float
    ssim: float
    lpips: float
    source: str


SAGS: Final = "SAGS, Table 2 (stereo depth, one RTX 4090)"
LOCAL: Final = "Local-EndoGS, Table 3 (monocular depth, one RTX 4090)"
ENDO_4DGS: Final = "Endo-4DGS paper"

PUBLISHED: Final = (
    Published("pulling", "EndoNeRF", 34.21, 0.938, 0.161, SAGS),
    Published("pulling", "EndoSurf", 35.00, 0.956, 0.120, SAGS),
    Published("pulling", "EndoGaussian", 37.21, 0.957, 0.061, SAGS),
    Published("pulling", "SAGS", 38.30, 0.964, 0.033, SAGS),
    Published("pulling", "EndoGaussian", 37.190, 0.955, 0.066, LOCAL),
    Published("pulling", "Deform3DGS", 37.987, 0.959, 0.070, LOCAL),
    Published("pulling", "EH-SurGS", 38.433, 0.961, 0.064, LOCAL),
    Published("pulling", "Local-EndoGS", 38.727, 0.964, 0.053, LOCAL),
    Published("pulling", "Endo-4DGS", 37.85, 0.959, 0.043, ENDO_4DGS),
    Published("cutting", "EndoNeRF", 34.19, 0.932, 0.151, SAGS),
    Published("cutting", "EndoSurf", 34.98, 0.953, 0.106, SAGS),
    Published("cutting", "EndoGaussian", 38.44, 0.968, 0.043, SAGS),
    Published("cutting", "SAGS", 39.51, 0.972, 0.022, SAGS),
    Published("cutting", "EndoGaussian", 38.040, 0.960, 0.052, LOCAL),
    Published("cutting", "Deform3DGS", 37.923, 0.961, 0.054, LOCAL),
    Published("cutting", "EH-SurGS", 39.457, 0.967, 0.039, LOCAL),
    Published("cutting", "Local-EndoGS", 39.647, 0.968, 0.037, LOCAL),
    Published("cutting", "Endo-4DGS", 36.56, 0.955, 0.032, ENDO_4DGS),
)


def of_clip(name: str) -> tuple[Published, ...]:
    """Those for a clip of this name."""
    return tuple(one for one in PUBLISHED if one.clip in name.lower())
