"""All 2D methods on real pictures: visibility, what it costs, and time.

python -m tests.benchmarks.enhance_methods --out DIR [--data ../shared/data] [--step N] [--held-out]

DV, BV and DV/BV by the inferred Otsu definition inside the tissue mask, "whole" the same ratio over the whole
picture as in the paper, then dvbv_local. Tissue: the given tool masks and no status bar (pulling), the field
of view (fetoscopy, retina), all (SCARED). Vessels: annotated (retina), else the strongest dark ridges of the
original. The preset `vessel` was tuned on even frames of the first two clips, on the left SCARED picture and
on the odd children of the retina set: --held-out takes the rest. Its strength was then chosen on one or two
frames of every set; lift, gamma and d on the half that `visibility_front` calls chosen, so that vessels gain
at least a tenth of colour difference with the least noise; the shape of its contrast on mesentery and
fetoscopy of that half.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import cv2
import numpy as np

from app.enhancement.contact_sheet import Tile, sheet
from app.report.visibility import COLUMNS, Sample, measured, methods, pattern, sample
from enhance.baselines import TAO_STAND_INS
from enhance.color_difference import vessel_color_difference
from enhance.image import BoolImage
from enhance.metrics import flicker
from enhance.ridges import field_of_view
from renderer.clip import ByteImage

STATUS_BAR = 16
"""Rows at the bottom of the da Vinci clip."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="folder for the pictures")
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    parser.add_argument("--step", type=int, default=12, help="every n-th frame of a clip")
    parser.add_argument(
        "--each", action="store_true", help="a table for every picture, after that of its set"
    )
    parser.add_argument("--held-out", action="store_true", help="only what `vessel` was not tuned on")
    flags = parser.parse_args()
    flags.out.mkdir(parents=True, exist_ok=True)
    for name, samples in sets(flags.data, flags.step, flags.held_out).items():
        if not samples:
            print(f"\n{name}: no data under {flags.data}")
            continue
        print_table(name, samples)
        for place, one in enumerate(samples if flags.each else (), 1):
            print_table(f"{name} {place}", [one])
        write_pictures(flags.out, name, samples[0])
    print_flicker(flags.data)


def print_table(name: str, samples: Sequence[Sample]) -> None:
    print(f"\n{name}, {len(samples)} pictures: means\n{'':14s}" + "".join(f"{c:>9s}" for c in COLUMNS))
    rows = measured(methods(), samples)
    for label, values in rows.items():
        print(f"{label:14s}" + "".join(f"{x:9.3f}" if abs(x) < 100 else f"{x:9.1f}" for x in values))
    for column in ("DV/BV", "whole"):
        print_pattern(column, {label: float(values[COLUMNS.index(column)]) for label, values in rows.items()})
    print_least(samples)


def print_least(samples: Sequence[Sample]) -> None:
    """Colour difference of vessels over that of the original: the picture that gains least."""
    before = [vessel_color_difference(one.image, one.vessels, tissue_mask=one.tissue) for one in samples]
    for label, method in methods().items():
        after = [
            vessel_color_difference(method(one.image, one.tissue), one.vessels, tissue_mask=one.tissue)
            for one in samples
        ]
        gains = np.divide(after, before)
        print(f"{label:14s} colour difference times {gains.min():.2f} to {gains.max():.2f}")


def print_pattern(column: str, ratio: Mapping[str, float]) -> None:
    """Table 3 has the paper's method above the original, both above Wang, and Wang above Tao."""
    ranks, shown, below = pattern(ratio)
    print(f"by {column}: {ranks}")
    print(f"  Table 3: paper and original above wang2020: {'yes' if shown else 'no'}", end="; ")
    print(f"stand-ins for Tao below wang2020: {below} of {len(TAO_STAND_INS)}")


def sets(data: Path, step: int, held_out: bool) -> dict[str, list[Sample]]:
    retina = sorted((data / "retina").glob("*.jpg"))
    if held_out:
        retina = [path for path in retina if int(path.stem[6:8]) % 2 == 0]
    scared = [data / "scared/d1k1_rectified_pair" / f"{side}.png" for side in ("left", "right")]
    return {
        "pulling": [sample(image, tissue) for image, tissue in pulling(data, step, held_out)],
        "scared": [sample(read(path)) for path in scared[held_out:] if path.exists()],
        "fetoscopy": [in_field(image) for image in map(read, every(fetoscopy(data), step, held_out))],
        **{
            name: [sample(image, field_of_view(image)) for image in clip(data)]
            for name, clip in CLIPS.items()
        },
        "retina": [annotated(path) for path in (retina if held_out else retina[:: max(1, step // 4)])],
    }


def laparoscopy(data: Path) -> Iterator[ByteImage]:
    video = cv2.VideoCapture(str(data / "clips/laparoscopy_1280x720.mp4"))
    for place in (10, 120, 240):
        video.set(cv2.CAP_PROP_POS_FRAMES, place)
        found, image = video.read()
        if found:
            yield np.ascontiguousarray(image[..., ::-1], dtype=np.uint8)


def files(pattern: str, *places: int) -> Callable[[Path], Iterator[ByteImage]]:
    """Of a folder of pictures, those at these places."""

    def read_some(data: Path) -> Iterator[ByteImage]:
        paths = sorted((data / "clips").glob(pattern))
        return (read(paths[place]) for place in places if place < len(paths))

    return read_some


CLIPS = {
    "laparoscopy": laparoscopy,
    "robotic": files("tool_clip_740x540/[0-9]*.jpg", 3, 20),
    "wall": files("wall_stereo_moving_camera/left/*", 0, 90),
    "mesentery": files("mesentery_stereo/img_left/*", 5, 25),
    "sinus": files("sinus_moving_camera/0*.jpg", 0, 20),
}


def every(paths: Sequence[Path], step: int, odd: bool) -> Sequence[Path]:
    """Every n-th; with `odd`, those at odd positions alone."""
    return paths[1::2][:: max(1, step // 2)] if odd else paths[::step]


def pulling(data: Path, step: int, odd: bool) -> Iterator[tuple[ByteImage, BoolImage]]:
    clip = data / "endonerf/pulling_soft_tissues"
    images, tools = (sorted((clip / folder).glob("*.png")) for folder in ("images", "gt_masks"))
    for path, tool in zip(every(images, step, odd), every(tools, step, odd), strict=True):
        tissue = read(tool)[..., 0] < 128
        tissue[-STATUS_BAR:] = False
        yield read(path), tissue


def fetoscopy(data: Path) -> list[Path]:
    return sorted((data / "clips/fetoscopy_470x470/input").glob("*.png"))


def in_field(image: ByteImage) -> Sample:
    return sample(image, field_of_view(image))


def annotated(path: Path) -> Sample:
    image = read(path)
    vessels = read(path.with_name(f"{path.stem}_1stHO.png"))[..., 0] > 0
    return Sample(image, field_of_view(image), vessels)


def read(path: Path) -> ByteImage:
    stored = cv2.imread(str(path))
    assert stored is not None, path
    return np.ascontiguousarray(stored[..., ::-1], dtype=np.uint8)


def write_pictures(out: Path, name: str, one: Sample) -> None:
    tiles = [Tile(label, method(one.image, one.tissue)) for label, method in methods().items()]
    marked = one.image.copy()
    marked[one.vessels] = (0, 255, 255)
    tiles.append(Tile("vessel mask", marked))
    picture = sheet(name, tiles, "Visibility only. Research use only.", columns=4, tile_width=640)
    cv2.imwrite(str(out / f"methods-{name}.png"), picture[..., ::-1])


def print_flicker(data: Path) -> None:
    """Ten neighbouring frames of the fetoscopy clip, each enhanced on its own."""
    frames = [read(path) for path in fetoscopy(data)[:10]]
    if not frames:
        return
    print("\nflicker over 10 frames of fetoscopy, grey levels a frame beyond the original's")
    tissue = field_of_view(frames[0])
    for label, method in methods().items():
        print(f"{label:14s}{flicker([method(frame, tissue) for frame in frames], frames):9.3f}")


if __name__ == "__main__":
    main()
