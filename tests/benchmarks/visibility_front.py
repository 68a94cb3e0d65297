"""Contrast of vessels against noise, both over the original's: `vessel` at every strength, all others mixed.

python -m tests.benchmarks.visibility_front [--data ../shared/data] [--half chosen|other]

`vesselsplat report` has the same of one clip. A point of `vessel` is on the front where no other method has
as much contrast with no more noise. Vessels are annotated (retina), with thin ones apart, or the strongest
dark ridges of the original.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

from app.report.visibility import Sample
from app.report.visibility_front import (
    ORIGINAL,
    VESSEL,
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
    """Each strength of `vessel`, the others as they are, and where another is above it at any noise."""
    print(f"{'':27s}  noise contrast thin    CNR  color    AUC  halo at highlights, edges   best other")
    for setting in found:
        if setting.method in (VESSEL, ORIGINAL) or setting.is_default:
            print(line(setting, found))
    for setting in above_vessel(found):
        one = found[setting]
        print(f"above vessel: {setting.method} {setting.amount}, {one.contrast:.2f} at {one.noise:.2f}")


def line(setting: Setting, found: Seen) -> str:
    one, other = found[setting], best_other(setting, found)
    gains = "".join(f"{gain:7.2f}" for gain in (one.noise, one.contrast, one.thin, one.cnr, one.color))
    halos = f"{one.highlight_halo:8.2f} {one.edge_halo:7.2f}"
    rival = "none" if other is None else f"{other.method} {other.amount} {found[other].contrast:.2f}"
    place = "front" if is_ahead(setting, found) else "BELOW"
    return f"{setting.method:14s}{setting.amount:13s}{gains} {one.auc:7.3f} {halos}   {place}: {rival}"


if __name__ == "__main__":
    main()
