"""`vesselsplat metrics IMAGE...`: visibility in numbers, alone or against the originals."""

from __future__ import annotations

import argparse
import sys
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from app.errors import UserError
from app.pictures import ArrayImage, read_image
from app.provenance import provenance, source, strict_json
from enhance import ImageError
from enhance.metrics import dvbv_local, dvbv_otsu, saturated_share
from renderer.metrics import psnr, ssim

ALONE = ("dv", "bv", "dv_bv", "saturated_share")
AGAINST = ("dv_local", "bv_local", "dv_bv_local", "psnr", "ssim")
DEFINITIONS = {
    "dv_bv": "inferred definition: variances of grey above and below the picture's own Otsu threshold",
    "dv_bv_local": "mean 5x5 variance of grey where the original has detail, and elsewhere",
    "saturated_share": "share of pixels whose largest channel is 250 of 255 or more",
}


def add_flags(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("images", metavar="IMAGE", nargs="+", type=Path, help="pictures to measure")
    parser.add_argument(
        "--against", metavar="ORIGINAL", nargs="+", type=Path, help="the original of each picture, in order"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object on stdout")


def run(flags: argparse.Namespace) -> None:
    paths: list[Path] = flags.images
    originals: list[Path] = flags.against or []
    if originals and len(originals) != len(paths):
        raise UserError(f"expected one original for each of {len(paths)} pictures, got {len(originals)}")
    pairs = zip_longest(paths, originals)
    measured = [measure_picture(path, original) for path, original in pairs]
    names = ALONE + (AGAINST if originals else ())
    mean = {name: float(np.mean([picture[name] for picture in measured])) for name in names}
    if flags.json:
        sys.stdout.write(strict_json(provenance(mean=mean, images=measured, definitions=DEFINITIONS)) + "\n")
    else:
        _print(measured, mean, names)


def measure_picture(path: Path, original_path: Path | None) -> dict[str, Any]:
    """All measures of one picture, by name. Raises UserError when the pictures cannot be compared."""
    image = read_image(path)
    measured = {"image": source(path)} | _alone(image, path)
    if original_path is None:
        return measured
    original = read_image(original_path)
    truth = source(original_path) | _alone(original, original_path)
    return measured | {"original": truth} | _against(image, original, path)


def _alone(image: ArrayImage, path: Path) -> dict[str, float]:
    try:
        dvbv, saturated = dvbv_otsu(image), saturated_share(image)
    except ImageError as error:
        raise UserError(f"{error}: {path}") from error
    return {"dv": dvbv.dv, "bv": dvbv.bv, "dv_bv": dvbv.ratio, "saturated_share": saturated}


def _against(image: ArrayImage, original: ArrayImage, path: Path) -> dict[str, float]:
    if image.shape[:2] != original.shape[:2]:
        sizes = [f"{shape[1]}x{shape[0]}" for shape in (original.shape, image.shape)]
        raise UserError(f"expected a picture of its original's size {sizes[0]}, got {sizes[1]}: {path}")
    local = dvbv_local(image, original)
    pair = (_unit(image), _unit(original), np.ones(image.shape[:2], dtype=bool))
    return {
        "dv_local": local.dv,
        "bv_local": local.bv,
        "dv_bv_local": local.ratio,
        "psnr": psnr(*pair),
        "ssim": ssim(*pair),
    }


def _unit(image: ArrayImage) -> NDArray[np.float64]:
    """(H, W, 3) in [0, 1], without alpha."""
    full = np.iinfo(image.dtype).max if image.dtype.kind == "u" else 1.0
    colors = np.repeat(image[..., None], 3, axis=2) if image.ndim == 2 else image[..., :3]
    unit: NDArray[np.float64] = colors.astype(np.float64) / full
    return unit


def _print(measured: list[dict[str, Any]], mean: dict[str, float], names: tuple[str, ...]) -> None:
    table = Table("image", *names)
    for picture in measured:
        table.add_row(picture["image"]["name"], *(f"{picture[name]:.4g}" for name in names))
    table.add_section()
    table.add_row("mean", *(f"{mean[name]:.4g}" for name in names))
    console = Console(width=max(Console().width, 140))
    console.print(table)
    console.print("dv, bv, dv_bv: inferred definition. Visibility only, neither detection nor diagnosis.")
