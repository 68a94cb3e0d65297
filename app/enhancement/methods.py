"""The methods of `vesselsplat enhance`, under the names of --method."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from itertools import tee
from typing import Annotated, Any, Final, Literal

import numpy as np
from pydantic import BeforeValidator, Discriminator, Tag

from app.errors import UserError
from app.files.image_files import ArrayImage
from enhance import EnhanceParams, Enhancer, EnhanceResult, LiveStatistics, Pool, Statistics, measure
from enhance.baselines import BASELINES
from enhance.image import BoolImage
from enhance.shown import Pixels
from enhance.vessel import VesselEnhancer, VesselParams

PAPER: Final = "paper"
VESSEL: Final = "vessel"
METHODS: Final = (PAPER, VESSEL, *BASELINES)

EnhancementSettings = EnhanceParams | VesselParams
"""Of the paper's method, or of the own preset; the type says which."""
Preset = Literal["paper", "vessel"]
"""What says so in words."""
Params = EnhancementSettings | None
"""None: of a method without parameters."""


def preset_of(look: EnhancementSettings) -> Preset:
    """The name of the method that these parameters are of."""
    return PAPER if isinstance(look, EnhanceParams) else VESSEL


def _preset(given: Any) -> Preset:
    """Which method's parameters these are; as JSON, by names that the other does not have. Strength alone is
    that of `vessel`."""
    if isinstance(given, dict):
        paper, vessel = ({one.name for one in fields(kind)} for kind in (EnhanceParams, VesselParams))
        strong = "strength" in given and not given.keys() & (paper - vessel)
        return VESSEL if strong or given.keys() & (vessel - paper) else PAPER
    return preset_of(given)


def _of_before(given: Any) -> Any:
    """Before 0.9.0, underexposed images were left dark; before 0.10.0, vessels were reddened in all; before
    0.13.0, coarse noise of colour was left; before 0.14.0, what is grey was darkened like vessels."""
    off = {"most_exposure": 1.0, "least_redness": 0.0, "color_smoothing": 0.0, "spare_grey": 0.0}
    return off | given if isinstance(given, dict) else given


RecordedSettings = Annotated[
    Annotated[EnhanceParams, Tag(PAPER)] | Annotated[VesselParams, BeforeValidator(_of_before), Tag(VESSEL)],
    Discriminator(_preset),
]


class MethodEnhancer:
    """Show it a picture, then enhance that as often as the parameters change, by either method.

    The memory of both methods stays from picture to picture. Not to be used from two threads at once.
    """

    def __init__(self, live: LiveStatistics | None = None) -> None:
        """live: smooth the statistics from picture to picture of a stream, as long as the method stays."""
        self._live = live
        self._paper, self._vessel = Enhancer(live), VesselEnhancer(live)
        self._shown: tuple[ArrayImage, BoolImage | None, Pixels] | None = None
        self._seen: frozenset[Preset] = frozenset()
        self._seen_before: frozenset[Preset] = frozenset()

    def show(
        self, image: ArrayImage, tissue_mask: BoolImage | None = None, pixels: Pixels = "automatic"
    ) -> None:
        """Take the next picture; it must not change while it is in use."""
        self._seen_before = self._seen or self._seen_before
        self._shown, self._seen = (image, tissue_mask, pixels), frozenset()

    def enhance(self, look: EnhancementSettings, *, statistics: Statistics | None = None) -> EnhanceResult:
        """The picture that is shown, enhanced; see `enhance.enhance` and `enhance.vessel.enhance_vessels`.

        Raises:
            ImageError: as these.
        """
        preset = preset_of(look)
        if self._shown is not None and preset not in self._seen:
            if self._live is not None and preset not in self._seen_before:
                self._forget(preset)
            image, tissue_mask, pixels = self._shown
            (self._paper if preset == PAPER else self._vessel).show(image, tissue_mask, pixels=pixels)
            self._seen |= {preset}
        if isinstance(look, EnhanceParams):
            return self._paper.enhance(look, statistics=statistics)
        return self._vessel.enhance(look, statistics=statistics)

    def _forget(self, preset: Preset) -> None:
        """What the method knows of the stream: the scene may have changed while the other one was in use."""
        if preset == PAPER:
            self._paper = Enhancer(self._live)
        else:
            self._vessel = VesselEnhancer(self._live)


def load_kernels(look: EnhancementSettings, image: ArrayImage) -> None:
    """From disk, or compile them, for pictures of this kind: which is no time of one enhanced thereafter."""
    enhancer = MethodEnhancer()
    blank = np.zeros_like(image[:64, :64])
    if blank.ndim == 3:
        blank[..., 3:] = 1  # Of an image that is transparent all over, nothing can be measured.
    enhancer.show(blank)
    enhancer.enhance(look)


def measure_for(
    look: EnhancementSettings,
    pictures: Iterable[tuple[ArrayImage, BoolImage | None]],
    pixels: Pixels = "automatic",
) -> Statistics:
    """The statistics of a clip as this method uses them, of pictures with the pixels that count (None: all);
    see `enhance.measure`."""
    # `measure` walks both in step: each picture is made once and let go.
    images, masks = tee(pictures)
    paper = _measured_by(look)
    return measure((image for image, _ in images), paper, (mask for _, mask in masks), pixels=pixels)


def pool_for(look: EnhancementSettings, pixels: Pixels) -> Pool:
    """The same of pictures that come one by one."""
    return Pool(_measured_by(look), pixels)


def _measured_by(look: EnhancementSettings) -> EnhanceParams:
    return look if isinstance(look, EnhanceParams) else EnhanceParams()


def by_baseline(method: str, image: ArrayImage) -> ArrayImage:
    """By one of the other methods, which take no settings. Raises UserError: anything but 8-bit RGB."""
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3:
        raise UserError(f"--method {method} takes 8-bit RGB images, got {image.dtype} of shape {image.shape}")
    return BASELINES[method](image)
