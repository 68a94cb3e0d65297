"""Contrast of vessels against noise, both over the original's: `vessel` at its settings, all others mixed.

python -m tests.benchmarks.visibility_front [--data ../shared/data] [--half chosen|other]

`vesselsplat report` has the same of one clip. A point of `vessel` is on the front where no other method has
as much contrast with no more noise. Vessels are annotated (retina), with thin ones apart, or the strongest
dark ridges of the original: on mesentery, sinus and laparoscopy most of these are creases, edges of tools and
of highlights, and a box of text.

`vessel` is not mixed with the original, as the others are. All its strengths are taken in the three ways of
`app.report.visibility_front.WAYS`: settings of the window and the command, with the same for all images. Its
front is the most contrast of any of them with no more noise, or that of the original.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from app.report.visibility import Sample
from app.report.visibility_front import (
    ORIGINAL,
    Seen,
    Setting,
    above_vessel,
    averaged,
    best_other,
    is_ahead,
    seen,
)
from renderer.clip import ByteImage
from tests.benchmarks.enhance_methods import annotated, every, fetoscopy, files, in_field, laparoscopy, read


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
            tell(averaged([seen(one) for one in samples]))


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


def tell(found: Seen) -> None:
    """Each setting of `vessel`, the others as they are, and where another is above it at any noise."""
    print(f"{'':33s}  noise contrast thin    CNR  color    AUC  halo at highlights, edges   best other")
    for setting in found:
        if setting.is_vessel or setting.method == ORIGINAL or setting.is_default:
            print(line(setting, found))
    print("noise: most contrast of vessel, of any other with no more noise")
    for noise in levels(found):
        own, other = (most_contrast(found, noise, own=own) for own in (True, False))
        print(f"{noise:5.1f}: {own:5.2f} {other:5.2f}")
    for setting in above_vessel(found):
        one = found[setting]
        print(f"above vessel: {setting.method} {setting.amount}, {one.contrast:.2f} at {one.noise:.2f}")


def levels(found: Seen) -> list[float]:
    """Of noise: every 0.2 from 1 to the most of any other method."""
    most = max(one.noise for setting, one in found.items() if not setting.is_vessel)
    return np.arange(1.0, most + 0.2, 0.2).tolist()


def most_contrast(found: Seen, noise: float, *, own: bool) -> float:
    """Of `vessel`, or of all others, with no more noise; that of the original at least."""
    fits = [each for setting, each in found.items() if setting.is_vessel == own and each.noise <= noise]
    return max([1.0, *(each.contrast for each in fits if math.isfinite(each.contrast))])


def line(setting: Setting, found: Seen) -> str:
    one, other = found[setting], best_other(setting, found)
    gains = "".join(f"{gain:7.2f}" for gain in (one.noise, one.contrast, one.thin, one.cnr, one.color))
    halos = f"{one.highlight_halo:8.2f} {one.edge_halo:7.2f}"
    rival = "none" if other is None else f"{other.method} {other.amount} {found[other].contrast:.2f}"
    place = "front" if is_ahead(setting, found) else "BELOW"
    return f"{setting.method:20s}{setting.amount:13s}{gains} {one.auc:7.3f} {halos}   {place}: {rival}"


if __name__ == "__main__":
    main()
