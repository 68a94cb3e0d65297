"""Contrast of vessels against noise, both over the original's: `vessel` at every strength, all others mixed.

python -m tests.benchmarks.visibility_front [--data ../shared/data] [--half chosen|other]

Every other method is mixed with the original in five shares. A point of `vessel` is on the front where no
other method has as much contrast with no more noise. Vessels are annotated (retina), with thin ones (up to 3
pixels wide) apart, or the strongest dark ridges of the original. AUC is the area under the ROC curve of how
dark green is against its blur by 32 pixels, as a classifier of these vessels: no one tuned for it.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from app.report.visibility import BoolImage, ByteImage, Sample, methods
from enhance import VesselParams, enhance_vessels
from enhance.metrics import noise_gain, vessel_cnr, vessel_contrast
from tests.benchmarks.enhance_methods import annotated, every, fetoscopy, files, in_field, laparoscopy, read

SHARES = (0.2, 0.4, 0.6, 0.8, 1.0)
STRENGTHS = (0.5, 1.0, 1.7, 2.4, 3.2, 4.0)
THIN = 3
"""Pixels across."""


@dataclass(frozen=True)
class Point:
    """Geometric means over the pictures of a set, over the original's; AUC is a mean."""

    label: str
    noise: float
    contrast: float
    cnr: float
    auc: float
    thin: float
    """Contrast of thin annotated vessels."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    parser.add_argument(
        "--half", choices=("chosen", "other"), default="other", help="pictures tuned on, or not"
    )
    flags = parser.parse_args()
    for name, samples in sets(flags.data, other=flags.half == "other").items():
        if samples:
            print(f"\n{name}, {len(samples)} pictures")
            tell(*points(samples))


def sets(data: Path, *, other: bool) -> Mapping[str, Sequence[Sample]]:
    """Half of the pictures of each set, by turns."""
    retina = [annotated(path) for path in sorted((data / "retina").glob("*.jpg"))[other::2][:4]]
    frames: dict[str, list[ByteImage]] = {
        "fetoscopy": [read(path) for path in every(fetoscopy(data), 24, other)],
        "laparoscopy": list(laparoscopy(data))[other::2],
        "robotic": list(files("tool_clip_740x540/[0-9]*.jpg", 3 + 17 * other)(data)),
        "wall": list(files("wall_stereo_moving_camera/left/*", 90 * other)(data)),
        "mesentery": list(files("mesentery_stereo/img_left/*", 5 + 20 * other)(data)),
        "sinus": list(files("sinus_moving_camera/0*.jpg", 20 * other)(data)),
    }
    return {"retina": retina} | {name: [in_field(one) for one in found] for name, found in frames.items()}


def points(samples: Sequence[Sample]) -> tuple[list[Point], list[Point]]:
    """Those of `vessel`, and those of all others."""
    own = []
    for strength in STRENGTHS:
        look = replace(VesselParams(), strength=strength)
        results = [enhance_vessels(one.image, look, tissue_mask=one.tissue).image for one in samples]
        own.append(point(f"vessel {strength:g}", samples, results))
    return own, list(others(samples))


def others(samples: Sequence[Sample]) -> Iterator[Point]:
    for name, method in methods().items():
        if name in ("original", "vessel"):
            continue
        whole = [method(one.image, one.tissue).astype(np.float32) for one in samples]
        for share in SHARES:
            mixed = [
                np.rint(share * result + (1 - share) * one.image).astype(np.uint8)
                for result, one in zip(whole, samples, strict=True)
            ]
            yield point(f"{name} {share:.0%}", samples, mixed)


def point(label: str, samples: Sequence[Sample], results: Sequence[ByteImage]) -> Point:
    pairs = list(zip(samples, results, strict=True))
    noise = [noise_gain(result, one.image, tissue_mask=one.tissue) for one, result in pairs]
    contrast = [_gain(vessel_contrast, one, result, one.vessels) for one, result in pairs]
    cnr = [_gain(vessel_cnr, one, result, one.vessels) for one, result in pairs]
    thin = [_gain(vessel_contrast, one, result, thin_part(one.vessels)) for one, result in pairs]
    auc = [area_under_curve(result, one) for one, result in pairs]
    return Point(label, _mean(noise), _mean(contrast), _mean(cnr), float(np.mean(auc)), _mean(thin))


def _gain(measure: object, one: Sample, result: ByteImage, vessels: BoolImage) -> float:
    after, before = (measure(image, vessels, tissue_mask=one.tissue) for image in (result, one.image))  # type: ignore[operator]
    return float(after / before)


def _mean(gains: Sequence[float]) -> float:
    """Geometric; a method that turns vessels bright has none."""
    return math.exp(float(np.mean(np.log(gains)))) if min(gains) > 0 else math.nan


def thin_part(vessels: BoolImage) -> BoolImage:
    """What an opening by a disc wider than THIN takes away."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (THIN + 2, THIN + 2))
    wide = cv2.morphologyEx(vessels.astype(np.uint8), cv2.MORPH_OPEN, disc)
    near = cv2.dilate(wide, disc) > 0
    thin: BoolImage = vessels & ~near
    return thin if thin.sum() > 100 else vessels


def area_under_curve(image: ByteImage, one: Sample) -> float:
    """Of darkness of green against its surroundings, by ranks (Mann and Whitney)."""
    green = image[..., 1].astype(np.float32)
    dark: NDArray[np.float32] = np.asarray(cv2.GaussianBlur(green, (0, 0), 32)) - green
    inside, outside = dark[one.vessels & one.tissue], dark[~one.vessels & one.tissue]
    values, counts = np.unique(np.rint(np.concatenate((inside, outside)) * 4), return_counts=True)
    places = (np.cumsum(counts) - (counts - 1) / 2)[np.searchsorted(values, np.rint(inside * 4))]
    above = float(places.sum()) - len(inside) * (len(inside) + 1) / 2
    return above / (len(inside) * len(outside))


def tell(own: Sequence[Point], rest: Sequence[Point]) -> None:
    print(f"{'':16s}  noise  contrast  thin   CNR    AUC   best other with no more noise")
    for one in own:
        rivals = [other for other in rest if other.noise <= one.noise and other.contrast == other.contrast]
        best = max(rivals, key=lambda other: other.contrast, default=None)
        said = "none" if best is None else f"{best.label} {best.contrast:.2f}"
        on = "front" if best is None or best.contrast <= one.contrast else "BELOW"
        print(
            f"{one.label:16s} {one.noise:6.2f} {one.contrast:8.2f} {one.thin:6.2f} {one.cnr:6.2f} "
            f"{one.auc:6.3f}   {on}: {said}"
        )
    for rest_one in (other for other in rest if other.label.endswith("100%")):
        print(
            f"{rest_one.label:16s} {rest_one.noise:6.2f} {rest_one.contrast:8.2f} {rest_one.thin:6.2f} "
            f"{rest_one.cnr:6.2f} {rest_one.auc:6.3f}"
        )


if __name__ == "__main__":
    main()
