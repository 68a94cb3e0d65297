"""Which values of a mask mark: colours alone, and labels in every frame of a clip."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from renderer.clip import ClipError
from renderer.readers.masks.nonzero_masks import read_mask, read_nonzero
from renderer.readers.masks.tool_masks import MOST_LABELS, highest_label, marked_pixels

TOOL = np.zeros((40, 60), bool)
TOOL[10:20, 10:30] = True


@pytest.mark.parametrize("mode", ["L", "LA", "RGB", "RGBA"])
def test_alpha_marks_nothing(tmp_path, mode):
    picture = Image.fromarray(np.where(TOOL, 255, 0).astype(np.uint8)).convert(mode)
    picture.save(tmp_path / "mask.png")
    np.testing.assert_array_equal(read_nonzero(tmp_path / "mask.png", (60, 40)), TOOL)
    np.testing.assert_array_equal(marked_pixels(read_mask(tmp_path / "mask.png")), TOOL)


@pytest.mark.parametrize("mode", ["LA", "RGBA"])
def test_what_is_in_the_alpha_alone_is_refused(tmp_path, mode):
    picture = Image.new(mode, (60, 40))
    picture.putalpha(Image.fromarray(np.where(TOOL, 255, 0).astype(np.uint8)))
    picture.save(tmp_path / "mask.png")
    with pytest.raises(ClipError, match="in the alpha alone"):
        read_nonzero(tmp_path / "mask.png", (60, 40))


def labelled(*rights: int) -> list[np.ndarray]:
    """Masks with a tool 1 at the left, and one of these at the right, where it is not 0."""
    masks = []
    for right in rights:
        mask = np.zeros((40, 60), np.uint8)
        mask[:20, :20], mask[:20, 40:] = 1, right
        masks.append(mask)
    return masks


def test_small_values_that_count_are_labels():
    assert highest_label(labelled(0, 2, 3)) == MOST_LABELS
    assert highest_label(labelled(0)) == MOST_LABELS
    assert highest_label(labelled(0, 255)) == 1
    assert highest_label(labelled(3)) == 1
    assert highest_label([np.zeros((4, 4), np.uint8)]) == 1


@pytest.mark.parametrize("right", [0, 1, 2, 3])
def test_every_label_marks(right):
    (mask,) = labelled(right)
    np.testing.assert_array_equal(marked_pixels(mask, MOST_LABELS), mask > 0)


def test_noise_of_levels_is_no_label():
    (mask,) = labelled(255)
    np.testing.assert_array_equal(marked_pixels(mask, MOST_LABELS), mask == 255)
