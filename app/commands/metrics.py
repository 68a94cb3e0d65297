"""`vesselsplat metrics IMAGE...`: visibility in numbers, alone or against the originals."""

from __future__ import annotations

import argparse
import sys
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from app.errors import UserError
from app.mean import mean_of_finite
from app.pictures import ArrayImage, read_image
from app.provenance import provenance, source, strict_json
from app.terminal import table_terminal
from enhance import ImageError
from enhance.image import BoolImage
from enhance.metrics import (
    blackened_share,
    dvbv_local,
    dvbv_otsu,
    noise_gain,
    saturated_share,
    vessel_cnr,
    vessel_contrast,
)
from enhance.vesselness import field_of_view, vessel_mask
from renderer.metrics import psnr, ssim

ALONE = ("dv", "bv", "dv_bv", "saturated_share")
CONTRAST = ("vessel_contrast", "vessel_cnr")
AGAINST = ("dv_local", "bv_local", "dv_bv_local", "noise_gain", "blackened_share", "psnr", "ssim")
DEFINITIONS = {
    "dv_bv": "inferred definition: variances of grey above and below the picture's own Otsu threshold",
    "dv_bv_local": "mean 5x5 variance of grey where the original has detail, and elsewhere",
    "saturated_share": "share of pixels whose largest channel is 250 of 255 or more",
    "vessel_contrast": "Weber contrast in green of the vessel mask against a ring around it; the mask is the "
    "one given, or the strongest dark ridges of the original",
    "vessel_cnr": "the same difference over the standard deviation of the ring",
    "noise_gain": "high-frequency noise over that of the original, where the original is flat",
    "blackened_share": "share of the vessel mask that is near-black and was not in the original",
    "null": "infinite, as the PSNR of equal pictures, or undefined, as DV/BV of a blank one; not in means",
}


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("images", metavar="IMAGE", nargs="+", type=Path, help="pictures to measure")
    parser.add_argument(
        "--against", metavar="ORIGINAL", nargs="+", type=Path, help="the original of each picture, in order"
    )
    parser.add_argument(
        "--vessels",
        metavar="MASK",
        nargs="+",
        type=Path,
        help="where vessels are (non-zero), in order, if known",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")


def run(flags: argparse.Namespace) -> None:
    paths: list[Path] = flags.images
    originals = _one_each(flags.against, paths, "original")
    masks = _one_each(flags.vessels, paths, "vessel mask")
    triples = zip_longest(paths, originals, masks)
    measured = [measure_picture(path, original, mask) for path, original, mask in triples]
    names = ALONE + (CONTRAST if originals or masks else ()) + (AGAINST if originals else ())
    mean = {name: mean_of_finite(picture[name] for picture in measured) for name in names}
    if flags.json:
        sys.stdout.write(strict_json(provenance(mean=mean, images=measured, definitions=DEFINITIONS)) + "\n")
    else:
        _print(measured, mean, names)


def _one_each(given: list[Path] | None, paths: list[Path], what: str) -> list[Path]:
    if given and len(given) != len(paths):
        raise UserError(f"expected one {what} for each of {len(paths)} pictures, got {len(given)}")
    return given or []


def measure_picture(path: Path, original_path: Path | None, mask_path: Path | None) -> dict[str, Any]:
    """All measures of one picture, by name. Raises UserError when the pictures cannot be compared."""
    image = read_image(path)
    measured = {"image": source(path)} | _alone(image, path)
    vessel = None if mask_path is None else _mask(mask_path, image)
    if original_path is None:
        return measured if vessel is None else measured | _contrast(image, vessel, None)
    original = read_image(original_path)
    truth = source(original_path) | _alone(original, original_path)
    _check_size(image, original, path)
    tissue = field_of_view(original)
    vessel = vessel_mask(original, tissue_mask=tissue) if vessel is None else vessel
    truth |= _contrast(original, vessel, tissue)
    compared = _contrast(image, vessel, tissue) | _against(image, original, vessel, tissue)
    return measured | {"original": truth} | compared


def _mask(path: Path, image: ArrayImage) -> BoolImage:
    stored = read_image(path)
    mask = stored if stored.ndim == 2 else stored[..., :3].max(axis=2)
    _check_size(mask, image, path)
    return np.asarray(mask > 0)


def _check_size(image: ArrayImage, original: ArrayImage, path: Path) -> None:
    if image.shape[:2] != original.shape[:2]:
        sizes = [f"{shape[1]}x{shape[0]}" for shape in (original.shape, image.shape)]
        raise UserError(f"expected a picture of its original's size {sizes[0]}, got {sizes[1]}: {path}")


def _alone(image: ArrayImage, path: Path) -> dict[str, float]:
    try:
        dvbv, saturated = dvbv_otsu(image), saturated_share(image)
    except ImageError as error:
        raise UserError(f"{error}: {path}") from error
    return {"dv": dvbv.dv, "bv": dvbv.bv, "dv_bv": dvbv.ratio, "saturated_share": saturated}


def _contrast(image: ArrayImage, vessel: BoolImage, tissue: BoolImage | None) -> dict[str, float]:
    return {
        "vessel_contrast": vessel_contrast(image, vessel, tissue_mask=tissue),
        "vessel_cnr": vessel_cnr(image, vessel, tissue_mask=tissue),
    }


def _against(
    image: ArrayImage, original: ArrayImage, vessel: BoolImage, tissue: BoolImage
) -> dict[str, float]:
    local = dvbv_local(image, original)
    after, before = _unit(image), _unit(original)
    everywhere = np.ones(image.shape[:2], dtype=bool)
    return {
        "dv_local": local.dv,
        "bv_local": local.bv,
        "dv_bv_local": local.ratio,
        "noise_gain": noise_gain(after, before, tissue_mask=tissue),
        "blackened_share": blackened_share(after, before, vessel),
        "psnr": psnr(after, before, everywhere),
        "ssim": ssim(after, before, everywhere),
    }


def _unit(image: ArrayImage) -> NDArray[np.float64]:
    """(H, W, 3) in [0, 1], without alpha."""
    full = np.iinfo(image.dtype).max if image.dtype.kind == "u" else 1.0
    colors = np.repeat(image[..., None], 3, axis=2) if image.ndim == 2 else image[..., :3]
    unit: NDArray[np.float64] = colors.astype(np.float64) / full
    return unit


def _print(measured: list[dict[str, Any]], mean: dict[str, float | None], names: tuple[str, ...]) -> None:
    table = Table("image", *names)
    for picture in measured:
        table.add_row(picture["image"]["name"], *(f"{picture[name]:.4g}" for name in names))
    table.add_section()
    table.add_row("mean", *("none" if (value := mean[name]) is None else f"{value:.4g}" for name in names))
    console = table_terminal()
    console.print(table)
    console.print("dv, bv, dv_bv: inferred definition. Visibility only, neither detection nor diagnosis.")
