"""Masks that mark the tissue in place of the tools are said to."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from renderer.camera import Camera
from renderer.clip import BoolImage, Clip, ClipError, Frame
from renderer.tools.mask_files import MaskFiles, masks_in, write_mask
from renderer.tools.polarity import with_doubt

LABELS = tuple(f"{index}.png" for index in range(6))


def tool() -> BoolImage:
    mask = np.zeros((24, 32), bool)
    mask[:10, :12] = True
    return mask


def clip() -> Clip:
    camera, keep = Camera.from_fov(60, 32, 24), np.ones((24, 32), bool)
    image = np.where(tool()[..., None], np.uint8([90, 95, 100]), np.uint8([170, 70, 60]))
    return Clip(
        name="flat", path=Path("flat"), format="images", cameras=(camera,) * len(LABELS), labels=LABELS,
        read_frame=lambda index: Frame(index, index / len(LABELS), image, camera, keep, keep),
        read_image=lambda index: image, has_depth=False, unit="mm",
    )  # fmt: skip


def masks(folder: Path, mask: BoolImage, names: tuple[str, ...]) -> MaskFiles:
    folder.mkdir()
    for name in names:
        write_mask(folder / name, mask, "by hand")
    return masks_in(folder, LABELS)


@pytest.mark.parametrize("names", [LABELS, LABELS[2:3]])
def test_masks_of_the_tissue_are_said_to_look_inverted(names: tuple[str, ...], tmp_path: Path) -> None:
    found = masks(tmp_path / "given", ~tool(), names)
    doubted = with_doubt(found, clip())
    assert doubted.files == found.files
    assert len(doubted.notices) == 1
    assert doubted.notices[0].startswith(
        "masks in given/ look inverted: not black = tool is expected, and 84 %"
    )


@pytest.mark.parametrize("mask", [tool(), np.zeros_like(tool())])
def test_of_masks_of_tools_nothing_is_said(mask: BoolImage, tmp_path: Path) -> None:
    found = masks(tmp_path / "given", mask, LABELS)
    assert with_doubt(found, clip()) is found


def test_a_frame_that_cannot_be_read_leaves_the_masks_as_they_are(tmp_path: Path) -> None:
    found = masks(tmp_path / "given", ~tool(), LABELS)

    def read_frame(index: int) -> Frame:
        if index == len(LABELS) - 1:
            raise ClipError("expected an image, got a damaged one: 5.png")
        return clip().read_frame(index)

    assert with_doubt(found, replace(clip(), read_frame=read_frame)) is found
