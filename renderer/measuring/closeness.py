"""How close the image of a model is to the frame it is of, and how much of its tissue it covers."""

from __future__ import annotations

from dataclasses import dataclass

from renderer.clip import BoolImage, ByteImage, Frame
from renderer.frame_gains import exposed
from renderer.metrics import coverage, psnr, psnr_masked, ssim
from renderer.splats import Float32Array


@dataclass(frozen=True, kw_only=True)
class Closeness:
    """Of one frame; NaN where a measure is undefined."""

    psnr: float
    """dB: both images times the evaluation mask, over all pixels, as in published results."""
    psnr_masked: float
    """Over the evaluated pixels only."""
    psnr_tissue: float
    """Over all visible tissue, whether its depth is known or not."""
    psnr_seldom: float
    """Over tissue that few training frames show."""
    coverage: float
    """Share of the visible tissue where the model is nearly opaque, 0 to 1."""
    ssim: float


def closeness(render: ByteImage, alpha: Float32Array, frame: Frame, seldom: BoolImage | None) -> Closeness:
    """The render is shown in the exposure of its frame, see `Frame.gain`.

    seldom: (H, W), True where tissue was seldom seen; None: that is not known.
    """
    shown, image, mask = exposed(render, frame.gain) / 255.0, frame.image / 255.0, frame.evaluation_mask
    tissue = frame.tissue_mask
    return Closeness(
        psnr=psnr(shown, image, mask),
        psnr_masked=psnr_masked(shown, image, mask),
        psnr_tissue=psnr_masked(shown, image, tissue),
        psnr_seldom=float("nan") if seldom is None else psnr_masked(shown, image, tissue & seldom),
        coverage=coverage(alpha, tissue),
        ssim=ssim(shown, image, mask),
    )
