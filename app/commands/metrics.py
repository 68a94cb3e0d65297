"""`vesselsplat metrics IMAGE...`: visibility in numbers, alone or against the originals."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, zip_longest
from pathlib import Path, PurePath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.console.progress import measured_text, print_measures, progress
from app.enhancement.recording import is_recording
from app.errors import UserError
from app.evaluation.mean import mean_of_finite
from app.files.image_files import ArrayImage
from app.files.image_series import open_series
from app.files.provenance import plain, provenance, strict_json
from enhance import ImageError
from enhance.color_difference import vessel_color_difference
from enhance.image import BoolImage, full_scale, read_picture
from enhance.measured_pixels import kept
from enhance.metrics import (
    blackened_share,
    dvbv_local,
    dvbv_otsu,
    flicker,
    line_scale,
    saturated_share,
    vessel_cnr,
    vessel_contrast,
)
from enhance.noise import chroma_noise_gain, flat_tissue, noise_gain
from enhance.ridges import field_of_view, vessel_mask
from renderer.metrics import psnr_masked, ssim_masked
from renderer.readers.image_files.transparency import SAID
from renderer.readers.image_files.used_bits import said_of_bits
from renderer.readers.masks.tool_masks import is_lossy, levels, marked_pixels

DEFINITIONS = {
    "pixels": "the field of view of the original, or of an image without one, as far as nothing there is "
    "transparent; psnr and ssim: all that is not transparent",
    "dv_bv": "inferred definition: variances of grey above and below the image's own Otsu threshold",
    "dv_bv_whole": "the same over the whole image, a black surround included",
    "dv_bv_local": "mean 5x5 variance of grey where the original has detail, and elsewhere",
    "saturated_share": "share of the pixels whose largest channel is 250 of 255 or more",
    "vessel_contrast": "Weber contrast in green of the vessel mask against a ring around it; the mask is the "
    "one given, or the strongest dark ridges of the original",
    "vessel_cnr": "the same difference over the standard deviation of the ring",
    "color_difference": "CIEDE2000 between the mask and its ring, mean over blocks of 64 pixels, of fewer in "
    "images below 640; 1 is just noticeable",
    "chroma_noise_gain": "as noise_gain, of R - G and B - G, averaged over blocks large enough for the "
    "original's to exceed rounding",
    "noise_gain": "high-frequency noise over that of the original, where the original is flat, without "
    "clipped pixels",
    "blackened_share": "share of the vessel mask that is near-black and was not in the original",
    "luma_step": "mean step of the mean luma from image to image of one recording, a video or a folder of "
    "images that look alike one after another, in the order given, in grey levels",
    "flicker": "luma_step minus that of the originals: 0 or less is as steady as they are",
    "null": "infinite, as the PSNR of equal images, or undefined, as DV/BV of a blank one; left out of means",
}


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "images",
        metavar="IMAGE",
        nargs="+",
        type=Path,
        help="images to measure, a folder of them or a video",
    )
    parser.add_argument(
        "--against",
        metavar="ORIGINAL",
        nargs="+",
        type=Path,
        help="the original of each image, in order; of folders by name, where the names are the same; of "
        "videos frame by frame, where they have as many",
    )
    parser.add_argument(
        "--vessels",
        metavar="MASK",
        nargs="+",
        type=Path,
        help="vessel masks, if known: not black where vessels are, in JPEG and video bright; paired as "
        "originals are",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")


@dataclass(frozen=True, eq=False)
class Given:
    """One picture of those that were named."""

    name: str
    """Without suffix."""
    origin: dict[str, Any]
    """Name and digest of its file, of a video the number of the frame, and where another file of this name is
    measured, too, the end of its path."""
    path: Path
    sequence: Path
    """The folder or video whose pictures follow each other."""
    is_video: bool
    read: Callable[[], ArrayImage]

    @property
    def label(self) -> str:
        file = "path" if "path" in self.origin else "name"
        return " ".join(str(self.origin[key]) for key in (file, "frame") if key in self.origin)


def run(flags: argparse.Namespace) -> None:
    images = [_given(path, SAID) for path in flags.images]
    pictures = _told_apart(list(chain(*images)))
    originals = _one_each([_given(path, SAID) for path in flags.against or []], images, "original")
    masks = _one_each([_given(path) for path in flags.vessels or []], images, "vessel mask")
    measured = []
    with progress("measure", len(pictures)) as report:
        for triple in zip_longest(pictures, originals, masks):
            measured.append(measure_picture(*triple))
            report(len(measured), triple[0].label)
    names = [name for name in measured[0] if name not in ("image", "original")]
    mean = {name: mean_of_finite(picture[name] for picture in measured) for name in names}
    sequence = measure_sequence(pictures, originals)
    if flags.json:
        facts = {"mean": mean, "sequence": sequence, "images": measured, "definitions": DEFINITIONS}
        sys.stdout.write(strict_json(provenance(**facts)) + "\n")
    else:
        _print([picture.label for picture in pictures], measured, mean)
        for name, value in (sequence or {}).items():
            sys.stdout.write(f"{name}: {value:.4g} grey levels per image\n")


def _given(path: Path, *noted: str) -> list[Given]:
    """Every picture of a file, folder or video, in order. `noted`: notices that are passed on, beside that of
    bits. Raises UserError or ClipError."""
    found, series = [], open_series(path)
    said = (*said_of_bits(len(series), series.bits), *(one for one in series.notices if one in noted))
    sys.stderr.writelines(f"{notice}: {path}\n" for notice in said)
    origins = map(plain, series.origins())
    for index, (name, source, origin) in enumerate(zip(series.names, series.sources, origins, strict=True)):
        number = series.frame(index)
        origin |= {} if number is None else {"frame": number}
        sequence = source.parent if number is None else source
        found.append(Given(name, origin, source, sequence, series.is_video, partial(series.read, index)))
    return found


def _told_apart(pictures: list[Given]) -> list[Given]:
    """Those of files of one name with as much of their paths as differs."""
    named: dict[str, set[Path]] = {}
    for one in pictures:
        named.setdefault(one.path.name, set()).add(one.path)
    ends = {path: end for alike in named.values() if len(alike) > 1 for path, end in _ends(alike).items()}
    return [
        replace(one, origin=one.origin | {"path": ends[one.path]}) if one.path in ends else one
        for one in pictures
    ]


def _ends(paths: Collection[Path]) -> dict[Path, str]:
    """Of different paths, the last parts: the fewest that differ."""
    counts = range(1, max(len(path.parts) for path in paths) + 1)
    found = ({path: PurePath(*path.parts[-count:]).as_posix() for path in paths} for count in counts)
    return next(ends for ends in found if len(set(ends.values())) == len(paths))


def _one_each(given: list[list[Given]], images: list[list[Given]], what: str) -> list[Given]:
    """One for every picture, folder by folder where there are as many of both; none where none is given.

    Raises UserError where they cannot be paired.
    """
    if not given:
        return []
    if len(given) != len(images):
        return _paired(list(chain(*given)), list(chain(*images)), what)
    pairs = zip(given, images, strict=True)
    return list(chain(*(_paired(those, pictures, what) for those, pictures in pairs)))


def _paired(given: list[Given], pictures: list[Given], what: str) -> list[Given]:
    """By name where names are the same, however many there are; in order where none is."""
    _check_lengths(given, pictures, what)
    named = {one.name: one for one in given}
    strange = [picture for picture in pictures if picture.name not in named]
    if len(named) == len(given) and not strange:
        return [named[picture.name] for picture in pictures]
    if len(given) != len(pictures):
        raise UserError(f"expected one {what} for each of {len(pictures)} images, got {len(given)}")
    if len(named) == len(given) and len(strange) < len(pictures):
        raise UserError(
            f"expected one {what} for each image by its name, got none for {strange[0].label}, "
            f"though there is one for {len(pictures) - len(strange)} of {len(pictures)}"
        )
    return given


def _check_lengths(given: list[Given], pictures: list[Given], what: str) -> None:
    """A frame of a video has its number for a name: of a part or at another rate, the same number is of
    another moment. Raises UserError."""
    ours, theirs = (
        set(Counter(one.sequence for one in those if one.is_video).values()) for those in (pictures, given)
    )
    if ours and theirs and len(ours | theirs) > 1:
        frames, others = (", ".join(map(str, sorted(each))) for each in (ours, theirs))
        raise UserError(
            f"expected a video with one {what} for each frame of a video, got {frames} frames and {others}"
        )


def measure_sequence(pictures: list[Given], originals: list[Given]) -> dict[str, float] | None:
    """How steady a sequence is; None where the pictures are none: one alone, of several folders, or each of a
    subject of its own."""
    if len(pictures) < 2 or len({picture.sequence for picture in pictures}) > 1:
        return None
    is_clip = "frame" in pictures[0].origin
    if not is_clip and not is_recording(len(pictures), lambda index: pictures[index].read()):
        return None
    step = _luma_step(pictures)
    return {"luma_step": step} | ({"flicker": step - _luma_step(originals)} if originals else {})


def _luma_step(pictures: list[Given]) -> float:
    """The flicker beside a clip that stands still."""
    still = [np.zeros((1, 1), np.uint8)] * len(pictures)
    return flicker((picture.read() for picture in pictures), still)


def measure_picture(given: Given, original: Given | None, mask: Given | None) -> dict[str, Any]:
    """All measures of one picture, by name. Raises UserError when the pictures cannot be compared."""
    image = _read(given)
    before = image if original is None else _read(original)
    _check_size(image, before, "an image of its original's", given.path)
    shown = kept(image) & kept(before)
    tissue = field_of_view(before) & shown
    measured = {"image": given.origin} | _alone(image, tissue)
    vessel = None if mask is None else _mask(mask, image)
    if original is None:
        return measured if vessel is None else measured | _contrast(image, vessel, tissue)
    vessel = vessel_mask(before, tissue_mask=tissue, scale=line_scale(before)) if vessel is None else vessel
    truth = original.origin | _alone(before, tissue) | _contrast(before, vessel, tissue)
    compared = _contrast(image, vessel, tissue) | _against(image, before, vessel, tissue, shown)
    return measured | {"original": truth} | compared


def _read(given: Given) -> ArrayImage:
    """Black where nothing is visible, so that no measure depends on what is stored there."""
    image = given.read()
    try:
        alpha = read_picture(image).alpha
    except ImageError as error:
        raise UserError(f"{error}: {given.path}") from error
    return image if alpha is None else np.where(alpha[..., None] > 0, image, image.dtype.type(0))


def _mask(given: Given, image: ArrayImage) -> BoolImage:
    stored = given.read()
    if stored.ndim not in (2, 3) or not stored.size:
        raise UserError(f"expected a vessel mask of shape (H, W), got {stored.shape}: {given.path}")
    _check_size(stored, image, "a vessel mask of its image's", given.path)
    has_noise = given.is_video or is_lossy(given.path)
    return marked_pixels(stored) if has_noise else np.asarray(levels(stored) > 0)


def _check_size(image: ArrayImage, other: ArrayImage, wanted: str, path: Path) -> None:
    if image.shape[:2] != other.shape[:2]:
        sizes = [f"{shape[1]}x{shape[0]}" for shape in (other.shape, image.shape)]
        raise UserError(f"expected {wanted} size {sizes[0]}, got {sizes[1]}: {path}")


def _alone(image: ArrayImage, tissue: BoolImage) -> dict[str, float]:
    dvbv = dvbv_otsu(image, tissue_mask=tissue)
    return {
        "dv": dvbv.dv,
        "bv": dvbv.bv,
        "dv_bv": dvbv.ratio,
        "dv_bv_whole": dvbv_otsu(image).ratio,
        "saturated_share": saturated_share(image, tissue_mask=tissue),
    }


def _contrast(image: ArrayImage, vessel: BoolImage, tissue: BoolImage) -> dict[str, float]:
    scale = line_scale(image)
    return {
        "vessel_contrast": vessel_contrast(image, vessel, tissue_mask=tissue, scale=scale),
        "vessel_cnr": vessel_cnr(image, vessel, tissue_mask=tissue, scale=scale),
        "color_difference": vessel_color_difference(image, vessel, tissue_mask=tissue, scale=scale),
    }


def _against(
    image: ArrayImage, original: ArrayImage, vessel: BoolImage, tissue: BoolImage, shown: BoolImage
) -> dict[str, float]:
    local = dvbv_local(image, original, tissue_mask=tissue)
    after, before = _rgb(image), _rgb(original)
    flat = flat_tissue(before, tissue)
    scaled = _unit(after), _unit(before), shown
    return {
        "dv_local": local.dv,
        "bv_local": local.bv,
        "dv_bv_local": local.ratio,
        "noise_gain": noise_gain(after, before, tissue_mask=tissue, flat=flat),
        "chroma_noise_gain": chroma_noise_gain(after, before, tissue_mask=tissue, flat=flat),
        "blackened_share": blackened_share(after, before, vessel),
        "psnr": psnr_masked(*scaled),
        "ssim": ssim_masked(*scaled),
    }


def _rgb(image: ArrayImage) -> ArrayImage:
    """(H, W, 3), without alpha."""
    return np.repeat(image[..., None], 3, axis=2) if image.ndim == 2 else image[..., :3]


def _unit(image: ArrayImage) -> NDArray[np.float64]:
    unit = image.astype(np.float64)
    unit /= full_scale(image.dtype)
    return unit


def _print(labels: list[str], measured: list[dict[str, Any]], mean: dict[str, float | None]) -> None:
    rows = [
        (label, *(measured_text(picture[name]) for name in mean))
        for label, picture in zip(labels, measured, strict=True)
    ]
    print_measures(("image", *mean), rows, ("mean", *map(measured_text, mean.values())))
