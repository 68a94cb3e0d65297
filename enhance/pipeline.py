"""The 2D vascular enhancement of an image: the stages in the order of Eqs 1-12, in float32."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import zip_longest

from enhance import brightness, detail, guided_filter, saturation
from enhance.image import AnyImage, BoolImage, Float32Image, ImageError, Picture, read_mask, read_picture
from enhance.params import DEFAULTS, EnhanceParams
from enhance.result import EnhanceResult, Omission
from enhance.saturation import Saturation
from enhance.statistics import Statistics, Tally, tally


@dataclass(frozen=True, eq=False)
class Layers:
    """What the equations need of a picture before its global statistics are known."""

    value: Float32Image
    """(H, W) V."""
    saturation: Saturation | None
    """None for grey pictures."""
    filtered: tuple[Float32Image, ...]
    """(H, W) Q of each scale."""


def enhance(
    image: AnyImage,
    params: EnhanceParams = DEFAULTS,
    *,
    tissue_mask: AnyImage | None = None,
    statistics: Statistics | None = None,
) -> EnhanceResult:
    """Make vessels visible: brightness, local detail and saturation (section 3.1 of the paper, Eqs 1-12).

    Args:
        image: (H, W), (H, W, 3) or (H, W, 4) with alpha last; uint8, uint16 or float in [0, 1]. Any order
            of the colours. Grey images have no saturation stage; alpha passes through, and pixels of alpha
            0 stay out of the statistics.
        params: z and P given there win over those of `statistics`.
        tissue_mask: (H, W), non-zero = keep: the statistics are those of the kept pixels. All pixels are
            enhanced.
        statistics: of a clip (`measure`), so that colours agree between its frames; None: of this image.

    Returns:
        image of the same shape and type, the statistics that were used and the stages left out.

    Raises:
        ImageError: an image, mask or statistics that cannot be used; the text says why.
    """
    picture = read_picture(image)
    layers = separate(picture, params)
    keep = read_mask(tissue_mask, picture)
    if statistics is None:
        used = tally_layers(layers, keep).statistics(params, "image")
    else:
        used = statistics.resolved(params)
    colors = combine(picture, layers, used, params)
    return EnhanceResult(picture.with_colors(colors), used, _omitted(layers, params))


def measure(
    images: Iterable[AnyImage],
    params: EnhanceParams = DEFAULTS,
    tissue_masks: Iterable[AnyImage | None] | None = None,
) -> Statistics:
    """Statistics of a whole clip: histograms, saturations and variances pooled over all kept pixels.

    Args:
        images: as `enhance` takes them; sizes may differ. Read one at a time.
        tissue_masks: one an image.

    Raises:
        ImageError: as `enhance`, with the position in the clip; no image; fewer or more masks than images.
    """
    total: Tally | None = None
    for index, (image, mask) in enumerate(_pairs(images, tissue_masks)):
        try:
            picture = read_picture(image)
            one = tally_layers(separate(picture, params), read_mask(mask, picture))
        except ImageError as error:
            raise ImageError(f"image {index} of the clip: {error}") from error
        total = one if total is None else total + one
    if total is None:
        raise ImageError("expected at least one image to measure, got none")
    return total.statistics(params, "clip")


def separate(picture: Picture, params: EnhanceParams) -> Layers:
    """Split a picture into V, S and the guided-filtered V of each scale (Eqs 3-6)."""
    colors, step = picture.colors, params.subsample
    value = brightness.value(colors)
    low = guided_filter.shrink(value, step)
    models = (
        guided_filter.coefficients(low, guided_filter.shrunk_radius(radius, step), params.eps)
        for radius in params.radii
    )
    return Layers(
        value=value,
        saturation=saturation.saturation(colors, value) if colors.ndim == 3 else None,
        filtered=tuple(guided_filter.apply(value, model, step) for model in models),
    )


def tally_layers(layers: Layers, keep: BoolImage) -> Tally:
    """Sums over the kept pixels, from which the global statistics follow."""
    chroma = None if layers.saturation is None else layers.saturation.chroma
    return tally(layers.value, chroma, layers.filtered, keep)


def enhanced_value(layers: Layers, statistics: Statistics) -> Float32Image:
    """V* of Eqs 1 and 7-10, (H, W)."""
    brightened = brightness.brighten(layers.value, statistics.z)
    return detail.mean_over_scales(
        detail.detailed(brightened, detail.surround_ratio(layers.value, filtered, p))
        for filtered, p in zip(layers.filtered, statistics.p, strict=True)
    )


def combine(picture: Picture, layers: Layers, statistics: Statistics, params: EnhanceParams) -> Float32Image:
    """The enhanced colours, of the shape of `picture.colors`: V* with S* of Eqs 11 and 12 and the old hue."""
    enhanced = enhanced_value(layers, statistics)
    if layers.saturation is not None:
        stretched = saturation.stretch(layers.saturation, statistics.saturation_mean, params.d_factor)
        enhanced = saturation.recolor(picture.colors, layers.value, layers.saturation, enhanced, stretched)
    return brightness.fade_black(picture.colors, enhanced, layers.value) if params.keep_black else enhanced


def _omitted(layers: Layers, params: EnhanceParams) -> tuple[Omission, ...]:
    if layers.saturation is None:
        return (Omission("saturation", "the image is grey", 0.0),)
    if params.d_factor == 0:
        return (Omission("saturation", "d_factor is 0", 0.0),)
    return ()


def _pairs(
    images: Iterable[AnyImage], masks: Iterable[AnyImage | None] | None
) -> Iterator[tuple[AnyImage, AnyImage | None]]:
    if masks is None:
        yield from ((image, None) for image in images)
        return
    for image, mask in zip_longest(images, masks, fillvalue=...):
        if image is ... or mask is ...:
            raise ImageError("expected as many tissue_masks as images, got more of one than of the other")
        yield image, mask
