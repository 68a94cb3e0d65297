"""How well tools are found where nobody has masked them, against masks that others made.

python -m tests.benchmarks.tool_masks [DATA]

IoU and precision of what is found, and recall of the tool without the margin that its masks have, on the
clips' test frames and on the others: by colour, and learned from one, two and three of the masks, which are
not of test frames; the share of the pixels that is taken for a tool on clips without any. What stands still
is judged by frames that are not test frames, as training does. The mesentery's masks take its burned-in
panel for tissue: what is found of it counts against precision.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import cv2
import numpy as np

from app.runs import dark_surround
from enhance.field_search import find_field
from renderer.clip import BoolImage, ByteImage, held_out_frames
from renderer.readers.clip_files import numbered_pictures
from renderer.readers.image_files.pictures import read_rgb
from renderer.tools.learning import Example, LearnedTools
from renderer.tools.search import find_tools, tools_alone
from renderer.tools.shrinking import shrunk
from renderer.tools.still import StillArea, still_areas

MASKED = {
    "pulling": ("endonerf/pulling_soft_tissues/images", "endonerf/pulling_soft_tissues/gt_masks", 255),
    "mesentery": ("clips/mesentery_stereo/img_left", "clips/mesentery_stereo/tool_mask", 0),
}
"""Images, masks, and the value of a tool."""
BARE = {
    "wall": "clips/wall_stereo_moving_camera/left",
    "sinus": "clips/sinus_moving_camera",
    "fetoscopy": "clips/fetoscopy_470x470/input",
    "retina": "retina",
    "scared": "scared/d1k1_rectified_pair",
}
GIVEN_MARGIN = 12
"""px that the given masks reach beyond the tools, about."""


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("data", type=Path, nargs="?", default=Path("../shared/data"))
    data = parser.parse_args().data
    for name, (images, masks, tool) in MASKED.items():
        pairs = list(zip(numbered_pictures(data / images), numbered_pictures(data / masks), strict=True))
        held_out = set(held_out_frames(len(pairs), "field", ()))
        read = [(read_rgb(image), read_rgb(mask)[:, :, 0] == tool) for image, mask in pairs]
        still = still_in([image for index, (image, _) in enumerate(read) if index not in held_out])
        rows = [agreement(found(image, still), truth) for image, truth in read]
        print_splits(name, "by colour", dict(enumerate(rows)), held_out)
        for count in (1, 2, 3):
            taught = spread(count, len(read), held_out)
            began = time.perf_counter()
            learned = LearnedTools.of([Example.of(*read[index], whole(read[index][0])) for index in taught])
            taken = time.perf_counter() - began
            others = {
                index: agreement(learned.find(image, whole(image)), truth)
                for index, (image, truth) in enumerate(read)
                if index not in taught
            }
            print_splits(name, f"{count} masked, {taken:.1f} s", others, held_out)
    for name, images in BARE.items():
        shares = [found(read_rgb(path)).mean() for path in numbered_pictures(data / images)]
        print(f"{name:10} taken for a tool: {np.mean(shares):.4f} of the pixels, at most {max(shares):.4f}")


def print_splits(
    name: str, how: str, rows: dict[int, tuple[float, float, float]], held_out: set[int]
) -> None:
    for split, is_test in (("test frames", True), ("other frames", False)):
        chosen = [row for index, row in rows.items() if (index in held_out) == is_test]
        iou, precision, recall = np.mean(chosen, axis=0)
        said = f"IoU {iou:.3f}  precision {precision:.3f}  recall {recall:.3f}"
        print(f"{name:10} {how:16} {split:12} {said}")


def spread(count: int, frames: int, held_out: set[int]) -> list[int]:
    """So many frames, evenly, none of them held out."""
    middles = [round((place + 0.5) * frames / count) for place in range(count)]
    return [index + 1 if index in held_out else index for index in middles]


def whole(image: ByteImage) -> BoolImage:
    return np.ones(image.shape[:2], bool)


def still_in(images: list[ByteImage]) -> tuple[StillArea, ...]:
    looked_at = dark_surround.spread(range(len(images)))
    small = [shrunk(images[index]) for index in looked_at]
    alone = [tools_alone(each, seen(images[index])) for each, index in zip(small, looked_at, strict=True)]
    return still_areas(small, alone)


def found(image: ByteImage, still: tuple[StillArea, ...] = ()) -> BoolImage:
    return find_tools(image, seen(image), still)


def seen(image: ByteImage) -> BoolImage:
    field = find_field(image)
    return whole(image) if field is None else field.mask()


def agreement(mask: BoolImage, truth: BoolImage) -> tuple[float, float, float]:
    """IoU, precision, recall."""
    both = np.count_nonzero(mask & truth)
    side = 2 * GIVEN_MARGIN + 1
    core = cv2.erode(truth.astype(np.uint8), np.ones((side, side), np.uint8)) > 0
    union = max(np.count_nonzero(mask | truth), 1)
    return (
        both / union,
        both / max(np.count_nonzero(mask), 1),
        float(mask[core].mean()) if core.any() else 1.0,
    )


if __name__ == "__main__":
    main()
